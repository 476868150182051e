// Place 3: where the model fails. The list of runs is the map.

import { el, refill } from "./dom.js";
import { t, titleOf } from "./words.js";
import { fixed, unitOf, withUnit } from "./format.js";
import { SCALES, heat } from "./colours.js";
import { facts, legend, runPlots, statistic } from "./runplots.js";
import { recordPlots } from "./recordplots.js";

export async function showWhere(root, app, shown) {
  const misfit = await app.misfit();
  shown();
  if (!misfit) return void refill(root, el("p", { class: "soft" }, t("not_yet")));
  const detail = el("section", { class: "panel", "aria-live": "polite", "aria-label": t("selected_run") });
  const chosen = chosenCell(app, misfit);
  const marked = el("span", { class: "small right", role: "status" });
  const runs = map(misfit, chosen, (run, channel) => select(detail, app, misfit, run, channel));
  const said = sentences(misfit, app, (sentence, go) => {
    runs.mark(sentence);
    marked.textContent = sentence ? t("marked", { count: sentence.runs.length }) : "";
    if (sentence && go) runs.goTo(worstOf(misfit, sentence));
  });
  refill(
    root,
    el("section", { class: "panel", "aria-label": t("what_stands_out") },
      el("div", { class: "head" },
        el("h2", {}, t("what_stands_out")),
        el("span", { class: "soft small" }, t("within", { count: misfit.within, of: misfit.cells })),
        app.state.steps.length ? stepChoice(app, root) : null),
      said),
    el("div", { class: misfit.columns.length > 4 ? "two many" : "two" },
      el("section", { class: "panel", "aria-label": t("map") },
        el("div", { class: "head" }, el("h2", {}, t("map")), el("span", { class: "soft small" }, t(misfit.kind === "captive" ? "map_about" : "map_about_free")), marked),
        key(SCALES[misfit.kind]),
        runs.box,
        misfit.left_out ? el("p", { class: "soft small" }, t("runs_left_out", { count: misfit.left_out })) : null),
      detail),
  );
  if (chosen) await select(detail, app, misfit, chosen.run, chosen.channel);
}

// Each sentence leads to the worst of its cells and marks its runs in the map.
function sentences(misfit, app, show) {
  if (!misfit.sentences.length) return el("ul", { class: "sentences calm" }, el("li", {}, t("nothing_stands_out")));
  const buttons = new Map();
  const press = (sentence, go) => {
    app.marked = sentence?.text ?? null;
    for (const [own, button] of buttons) button.setAttribute("aria-pressed", own === sentence ? "true" : "false");
    show(sentence, go);
  };
  const item = (sentence) => {
    const button = el("button", { class: "link", title: t("show_cells"), "aria-pressed": "false", on: { click: () => press(app.marked === sentence.text ? null : sentence, true) } }, sentence.text);
    buttons.set(sentence, button);
    return el("li", {}, button);
  };
  const first = misfit.sentences.slice(0, 3).map(item);
  const rest = misfit.sentences.slice(3).map(item);
  const kept = misfit.sentences.find((sentence) => sentence.text === app.marked);
  press(kept ?? null, false);
  return el("div", { class: "stack" },
    el("ul", { class: "sentences" }, first),
    rest.length
      ? el("details", { open: misfit.sentences.indexOf(kept) > 2 }, el("summary", {}, t("more", { count: rest.length + misfit.more })), el("ul", { class: "sentences" }, rest))
      : null);
}

function stepChoice(app, root) {
  const names = [t("base"), ...app.state.steps.map((step) => `+ ${titleOf(step.effect)}`)];
  const choice = el("select", {
    "aria-label": t("model_after"), class: "right",
    on: { change: () => { app.count = Number(choice.value); app.redraw(); } },
  }, names.map((name, i) => el("option", { value: i, selected: i === (app.count ?? names.length - 1) }, name)));
  return choice;
}

function key(scale) {
  return el("p", { class: "legend" }, scale.words.map((word, i) => el("span", {}, el("i", { class: `h${i}` }), word)));
}

export function chosenCell(app, misfit) {
  const rows = misfit.groups.flatMap((group) => group.rows);
  const kept = app.selected && rows.find((row) => row.run === app.selected.run && row.cells[app.selected.channel]);
  return kept ? app.selected : worstOf(misfit);
}

// The worst cell, of a sentence or of all.
function worstOf(misfit, sentence = null) {
  let worst = null;
  for (const row of misfit.groups.flatMap((group) => group.rows)) {
    for (const [channel, cell] of Object.entries(row.cells)) {
      const size = SCALES[misfit.kind].of(cell) ?? 0;
      if (speaksOf(misfit, sentence, row.run, channel) && (!worst || size > worst.size)) worst = { run: row.run, channel, size };
    }
  }
  return worst && { run: worst.run, channel: worst.channel };
}

// A sentence on what is no column of the map, such as an overshoot, speaks of whole rows.
function speaksOf(misfit, sentence, run, channel) {
  if (!sentence) return true;
  const column = misfit.columns.some((own) => own.name === sentence.channel);
  return sentence.runs.includes(run) && (!column || sentence.channel === channel);
}

function map(misfit, chosen, choose) {
  const columns = misfit.columns.map((column) => column.name);
  const cells = [];
  let current = null;
  const pick = (cell) => {
    if (!cell || cell.node.classList.contains("none")) return;
    if (current) {
      current.node.setAttribute("aria-selected", "false");
      current.node.tabIndex = -1;
    }
    current = cell;
    cell.node.setAttribute("aria-selected", "true");
    cell.node.tabIndex = 0;
    choose(cell.run, cell.channel);
  };
  const bodies = misfit.groups.flatMap((group) => [
    el("tbody", { class: "group" }, el("tr", {}, el("th", { colspan: columns.length + 1, scope: "rowgroup" }, group.title))),
    el("tbody", {}, group.rows.map((row) => {
      const line = [];
      const nodes = columns.map((channel) => {
        const own = row.cells[channel];
        const cell = { run: row.run, channel, node: cellOf(row, channel, own, misfit) };
        if (chosen && own && chosen.run === row.run && chosen.channel === channel) {
          current = cell;
          cell.node.setAttribute("aria-selected", "true");
          cell.node.tabIndex = 0;
        }
        cell.node.addEventListener("click", () => { pick(cell); cell.node.focus(); });
        line.push(cell);
        return cell.node;
      });
      cells.push(line);
      return el("tr", {}, el("th", { scope: "row", title: row.run }, row.words), nodes);
    })),
  ]);
  const table = el("table", { role: "grid", "aria-label": t("map"), on: { keydown: (event) => walk(event, cells, () => current, pick) } },
    el("thead", {}, el("tr", {}, el("th", { scope: "col" }, t("run")),
      misfit.columns.map((column) => el("th", { scope: "col", title: unitOf(column.unit) }, t(`channel_${column.name}`))))),
    bodies);
  const box = el("div", { class: "map scroll" }, table);
  requestAnimationFrame(() => inView(box, current?.node));
  const mark = (sentence) => cells.flat().forEach((cell) =>
    cell.node.classList.toggle("marked", sentence !== null && !cell.node.classList.contains("none") && speaksOf(misfit, sentence, cell.run, cell.channel)));
  const goTo = (place) => {
    const cell = place && cells.flat().find((own) => own.run === place.run && own.channel === place.channel);
    if (!cell) return;
    pick(cell);
    inView(box, cell.node);
    cell.node.focus();
  };
  return { box, mark, goTo };
}

function cellOf(row, channel, own, misfit) {
  if (!own) return el("td", { class: "none" }, "·");
  const unit = misfit.columns.find((column) => column.name === channel).unit;
  const scale = SCALES[misfit.kind];
  const value = scale.of(own);
  const text = value === null ? "–" : fixed(value, value >= 10 ? 0 : 1);
  const words = t("cell", {
    channel: t(`channel_${channel}`), run: row.words, ratio: misfit.kind === "captive" ? `${text} ×` : `${text} %`,
    told: misfit.statistics.map((item) => `${statistic(item)} ${withUnit(own[item.name], unit)}`).join(", "),
  });
  return el("td", { class: `h${heat(scale, value ?? 0)}`, tabindex: -1, "aria-label": words, title: words, "aria-selected": "false" }, text);
}

function walk(event, cells, now, pick) {
  const moves = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1], PageUp: [-10, 0], PageDown: [10, 0], Home: [-1e6, 0], End: [1e6, 0] };
  const move = moves[event.key];
  const at = now();
  if (!move || !at) return;
  event.preventDefault();
  const row = cells.findIndex((line) => line.includes(at));
  const column = cells[row].indexOf(at);
  const clamp = (value, most) => Math.min(Math.max(value, 0), most);
  const next = cells[clamp(row + move[0], cells.length - 1)][clamp(column + move[1], cells[0].length - 1)];
  pick(next);
  next.node.focus({ preventScroll: true });
  inView(next.node.closest(".map"), next.node);
}

// Scrolls the map alone, not the page.
function inView(box, node) {
  if (!node) return;
  const [outer, inner] = [box.getBoundingClientRect(), node.getBoundingClientRect()];
  const margin = 44;
  if (inner.top < outer.top + margin) box.scrollTop -= outer.top + margin - inner.top;
  else if (inner.bottom > outer.bottom - margin) box.scrollTop += inner.bottom - outer.bottom + margin;
}

async function select(detail, app, misfit, run, channel) {
  app.selected = { run, channel };
  const asked = run + channel;
  detail.dataset.asked = asked;
  const history = await app.history(run);
  if (detail.dataset.asked !== asked) return;
  if (!history) return void refill(detail, el("p", { class: "soft" }, t("not_in_file")));
  const cell = misfit.groups.flatMap((group) => group.rows).find((row) => row.run === run)?.cells[channel];
  const plots = el("div");
  refill(
    detail,
    el("div", { class: "head" },
      el("h2", {}, `${t(`channel_${channel}`)} · ${history.title}, ${history.words}`),
      el("span", { class: "soft small right" }, run)),
    facts(misfit, channel, cell, history.channels?.[channel]?.known ?? true),
    legend(),
    plots);
  if (history.kind === "free") recordPlots(plots, history, { channel });
  else runPlots(plots, history, channel);
}
