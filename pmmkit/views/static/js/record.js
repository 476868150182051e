// One record in full: what counts of it, to be drawn anew with a reason.

import { el, refill, svg } from "./dom.js";
import { get, post } from "./api.js";
import { t } from "./words.js";
import { num, unitOf } from "./format.js";
import { extent, frame, path } from "./linear.js";

const HEIGHT = 132;
const NEAR = 0.04;

export function openRecord(app, run) {
  const inside = el("div", { class: "stack" }, el("p", { class: "soft", role: "status" }, t("reading_record", { run })));
  const dialog = el("dialog", { class: "record", "aria-label": `${t("record")}: ${run}` },
    el("div", { class: "head" }, el("h2", {}, run), el("button", { class: "right", on: { click: () => dialog.close() } }, t("close"))), inside);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  get("record", { run, ...app.mine() }).then(
    (page) => draw(inside, dialog, app, page),
    (problem) => refill(inside, el("p", { class: "message", role: "alert" }, problem.message)),
  );
}

function draw(root, dialog, app, page) {
  const about = [el("p", {}, el("b", {}, page.title), ` ${page.words}`), page.source ? el("p", { class: "soft small" }, page.source, page.samples ? ` · ${t("samples", { count: page.samples })}` : "") : null];
  const findings = page.findings.map((item) => el("p", { class: `finding small ${item.severity}` }, item.message));
  if (page.error || !page.channels.length) return void refill(root, ...about, page.error ? el("p", { class: "finding error" }, page.error) : page.kind === "history" ? null : el("p", {}, t("no_record")), findings);
  // Half a sample more at both ends: the samples there belong to it, however they are rounded.
  const half = page.samples > 1 ? page.seconds / (page.samples - 1) / 2 : 0;
  const now = { window: [...(page.window ?? [0, page.seconds])] };
  const shades = [];
  const width = Math.min(Math.max(root.clientWidth, 300), 1200);
  const plots = page.channels.filter((channel) => channel.values.length).map((channel) => {
    const plot = frame({ width, height: HEIGHT, x: [0, page.seconds || 1], y: extent(channel.values), xLabel: t("time_s"), yLabel: `${channel.name} [${unitOf(channel.unit) || "-"}]`, label: `${channel.name}, ${t("time_s")}` });
    const shade = svg("rect", { class: "shade", y: 18, height: HEIGHT - 56 });
    const cycles = svg("g", { class: "cycles" });
    for (const mark of page.marks.filter((own) => !own.channel || own.channel === channel.name)) {
      plot.root.append(svg("rect", { class: `mark ${mark.severity}`, x: plot.px(mark.from), y: 18, height: HEIGHT - 56, width: Math.max(plot.px(mark.to) - plot.px(mark.from), 2) }, svg("title", {}, mark.text)));
    }
    plot.root.prepend(shade);
    plot.root.append(cycles, path(plot, channel.t, channel.values, "measured"));
    shades.push({ plot, shade, cycles });
    plot.root.classList.add("draggable");
    plot.root.addEventListener("pointerdown", (event) => grab(event, plot, width));
    return el("div", { class: "plot" }, plot.root);
  });
  const step = page.seconds / 2000;
  const slider = (end) => el("input", { type: "range", min: 0, max: page.seconds, step: "any", value: now.window[end], "aria-label": t(end ? "window_to" : "window_from"), on: {
    input: (event) => move(end, Number(event.target.value)),
    keydown: (event) => {
      const by = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -20, PageUp: 20 }[event.key];
      if (by === undefined) return;
      event.preventDefault();
      move(end, now.window[end] + by * 2 * step);
    },
  } });
  const ends = [slider(0), slider(1)];
  const said = el("p", { class: "small", role: "status" });
  const wrong = el("div", { role: "alert" });
  const reason = el("input", { type: "text", maxlength: 300, "aria-label": t("window_reason"), placeholder: t("window_reason"), value: page.stated?.alone ? page.stated.reason : "" });
  const save = el("button", { class: "primary", disabled: true }, t("window_save"));

  function move(end, value) {
    const other = now.window[1 - end];
    const most = end ? page.seconds : other - step;
    const least = end ? other + step : 0;
    now.window[end] = Math.min(Math.max(value, least), most);
    now.moved = true;
    sketch();
  }

  function grab(event, plot) {
    const box = plot.root.getBoundingClientRect();
    const from = plot.px(0);
    const to = plot.px(page.seconds);
    const at = (moved) => (((moved.clientX - box.left) / box.width) * width - from) / (to - from) * page.seconds;
    const t0 = at(event);
    const end = Math.abs(t0 - now.window[0]) < Math.abs(t0 - now.window[1]) ? 0 : 1;
    if (Math.abs(t0 - now.window[end]) > NEAR * page.seconds && t0 > now.window[0] && t0 < now.window[1]) return;
    event.preventDefault();
    plot.root.setPointerCapture(event.pointerId);
    const drag = (moved) => move(end, at(moved));
    const over = () => {
      plot.root.removeEventListener("pointermove", drag);
      plot.root.removeEventListener("pointerup", over);
      plot.root.removeEventListener("pointercancel", over);
    };
    plot.root.addEventListener("pointermove", drag);
    plot.root.addEventListener("pointerup", over);
    plot.root.addEventListener("pointercancel", over);
    drag(event);
  }

  function sketch() {
    const [from, to] = now.window;
    // The last sample stands for one step more, as the count of cycles has it.
    const whole = page.period ? Math.floor((to - from + 3 * half) / page.period) : 0;
    const edges = page.period && now.moved ? Array.from({ length: whole + 1 }, (_, i) => from + i * page.period) : page.edges;
    for (const { plot, shade, cycles } of shades) {
      shade.setAttribute("x", plot.px(from));
      shade.setAttribute("width", Math.max(plot.px(to) - plot.px(from), 0));
      refill(cycles, edges.map((edge) => svg("line", { x1: plot.px(edge), x2: plot.px(edge), y1: 18, y2: HEIGHT - 38 })));
    }
    ends.forEach((end, i) => {
      end.value = now.window[i];
      end.setAttribute("aria-valuetext", `${num(page.begin + now.window[i], 4)} s`);
    });
    refill(said, t("window_is", { from: num(page.begin + from, 4), to: num(page.begin + to, 4) }), page.period ? ` · ${t("window_cycles", { count: whole })}` : "");
    ready();
  }

  function ready() {
    const again = page.stated?.alone && reason.value.trim() && reason.value.trim() !== page.stated.reason;
    save.disabled = !((now.moved || again) && reason.value.trim());
  }

  async function write(what, more) {
    refill(wrong);
    save.disabled = true;
    try {
      await post(what, { revision: app.state.revision, run: page.run, ...app.mine(), ...more });
      dialog.close();
      await app.refresh();
    } catch (problem) {
      refill(wrong, el("p", { class: "finding error" }, problem.message));
      ready();
    }
  }

  save.addEventListener("click", () => write("window", { t_start: page.begin + now.window[0] - half, t_end: page.begin + now.window[1] + half, reason: reason.value.trim() }));
  reason.addEventListener("input", ready);
  refill(root, ...about, ...findings,
    el("p", { class: "small" }, page.reason || (page.stated ? t("window_stated", { reason: page.stated.reason }) : "")),
    el("p", { class: "soft small" }, t("window_hint")),
    el("div", { class: "window-ends" }, el("label", {}, el("span", {}, t("window_from")), ends[0]), el("label", {}, el("span", {}, t("window_to")), ends[1])),
    said, el("div", { class: "line" }, reason, save,
      page.stated?.alone ? el("button", { on: { click: () => write("unwindow", {}) } }, t("window_find")) : null),
    wrong, plots,
    page.marks.length ? el("section", {}, el("h3", {}, t("marks")), el("ul", { class: "small" }, page.marks.map((mark) => el("li", {},
      `${mark.channel ? `${mark.channel}, ` : ""}${num(page.begin + mark.from, 5)}–${num(page.begin + mark.to, 5)} s: ${mark.text}`)))) : null);
  sketch();
}
