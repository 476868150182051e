// Place 5: the ship, sailed while a slider moves.

import { el, refill } from "./dom.js";
import { t, titleOf } from "./words.js";
import { num } from "./format.js";
import { frozen, post } from "./api.js";
import { extent, frame, path, roomOf } from "./linear.js";
import { motionPanel } from "./motion.js";
import { judgement, metricTitle, trackPlot, turnPanel } from "./sailed.js";

const MANOEUVRES = ["turning", "zigzag", "spiral"];

export async function showShip(root, app, shown) {
  if (frozen) {
    shown();
    const panel = el("section", { class: "panel" });
    refill(root, panel);
    return turnPanel(panel, app);
  }
  const [range, trials, settings] = await Promise.all([app.range(), app.trials(), app.settings("simulate")]);
  shown();
  const speeds = range.speeds;
  const angle = settings.switch_deg.usual;
  const tested = Math.abs(trials.zigzag?.[0]?.rudder ?? 0);
  const asked = app.sailing ?? { manoeuvre: "turning", rudder_deg: settings.rudder_deg.usual[1], zigzag_deg: tested ? Math.min(Math.max(Math.round(tested), angle[0]), angle[1]) : 10, speed: speeds[Math.floor(speeds.length / 2)], wind_speed: settings.wind_speed.default, wind_direction_deg: settings.wind_direction_deg.default, depth: settings.depth.default };
  app.sailing = asked;
  const picture = el("section", { class: "panel", "aria-live": "polite", "aria-label": t("track") },
    el("p", { class: "soft", role: "status" }, t("computing")));
  const controls = el("section", { class: "panel", "aria-label": t("settings") });
  let waiting = null;

  const sail = async (band) => {
    waiting?.abort();
    waiting = new AbortController();
    try {
      const found = await post("sail", request(asked, band), waiting.signal);
      draw(picture, asked, found, trials[asked.manoeuvre] ?? []);
    } catch (problem) {
      if (problem.name !== "AbortError") refill(picture, el("p", { class: "soft" }, problem.message));
    }
  };
  const panel = () => {
    const low = Math.min(...speeds);
    const high = Math.max(...speeds);
    refill(controls,
      el("div", { class: "segments", role: "group", "aria-label": t("manoeuvre") }, MANOEUVRES.map((name) =>
        el("button", { "aria-pressed": asked.manoeuvre === name ? "true" : "false", on: { click: () => { asked.manoeuvre = name; panel(); sail(true); } } }, t(name)))),
      asked.manoeuvre === "turning" ? slider(asked, "rudder_deg", t("rudder"), settings.rudder_deg, sail) : null,
      asked.manoeuvre === "zigzag" ? slider(asked, "zigzag_deg", t("zigzag_angle"), settings.switch_deg, sail) : null,
      slider(asked, "speed", t("approach_speed"), { ...settings.speed, usual: [low, high > low ? high : low + 0.01, (high - low) / 100 || 0.01] }, sail),
      range.windy && asked.manoeuvre !== "spiral" ? slider(asked, "wind_speed", t("wind_speed"), settings.wind_speed, sail) : null,
      range.windy && asked.manoeuvre !== "spiral" ? slider(asked, "wind_direction_deg", t("wind_direction"), settings.wind_direction_deg, sail) : null,
      range.shallow && asked.manoeuvre !== "spiral" ? slider(asked, "depth", t("depth"), { ...settings.depth, usual: [1.1, 10, 0.05].map((x) => x * range.draught) }, sail) : null,
      range.windy ? null : el("p", { class: "soft small" }, t("no_wind")),
      range.shallow ? null : el("p", { class: "soft small" }, t("no_depth")),
      range.lenders.length ? lender(app, range) : null,
      el("p", { class: "soft small" }, range.scale));
  };
  panel();
  refill(root, el("div", { class: "two" }, controls, picture));
  // The ship at once, the ships around her when they have sailed too.
  await sail(false);
  sail(true);
}

function request(asked, band) {
  const own = { manoeuvre: asked.manoeuvre, speed: asked.speed };
  if (asked.manoeuvre === "spiral") return own;
  if (asked.manoeuvre === "turning") own.rudder_deg = asked.rudder_deg;
  else Object.assign(own, { rudder_deg: asked.zigzag_deg, switch_deg: asked.zigzag_deg });
  if (asked.wind_speed) Object.assign(own, { wind_speed: asked.wind_speed, wind_direction_deg: asked.wind_direction_deg });
  if (asked.depth) own.depth = asked.depth;
  return { ...own, band };
}

// A slider of a setting: what it offers, its unit and what is told of it are those of the action.
function slider(asked, name, label, setting, sail) {
  const [min, max, step] = setting.usual;
  const unit = setting.unit === "°" ? "°" : ` ${setting.unit}`;
  const shown = el("output", {}, `${num(asked[name] ?? max)}${unit}`);
  const input = el("input", {
    type: "range", min, max, step, value: asked[name] ?? max, "aria-label": label,
    on: {
      input: () => {
        const value = Number(input.value);
        asked[name] = name === "rudder_deg" && value === 0 ? 1 : value;
        shown.textContent = `${num(asked[name])}${unit}`;
        sail(false);
      },
      change: () => sail(true),
    },
  });
  return el("label", { class: "slider", title: setting.help }, el("span", {}, label), shown, input);
}

// Propeller and rudder of a base that was reduced from tests: another ship may lend them.
function lender(app, { parts, lenders }) {
  const choice = el("select", { disabled: app.busy(), "aria-describedby": "lent", on: { change: () => app.act("again", { parts: choice.value }) } },
    el("option", { value: "" }, t("lent_none")),
    [...new Set([...(parts ? [parts] : []), ...lenders])].map((name) => el("option", { value: name, selected: name === parts }, name)));
  return el("label", { class: "ask" }, el("span", {}, t("lent_by")), choice, el("small", { class: "said", id: "lent" }, t("lent_about")));
}

// The record that was steered most like it.
function nearest(asked, found, trials) {
  const rudder = asked.manoeuvre === "turning" ? asked.rudder_deg : asked.zigzag_deg;
  const away = (trial) => Math.abs(trial.rudder - rudder) / 35 + Math.abs(trial.Fn - found.Fn) / found.Fn;
  return trials.reduce((best, trial) => (best && away(best) <= away(trial) ? best : trial), null);
}

function draw(root, asked, found, trials) {
  if (asked.manoeuvre === "spiral") return spiral(root, found);
  const turning = asked.manoeuvre === "turning";
  const near = nearest(asked, found, trials);
  const until = found.t.at(-1);
  const others = trials.filter((trial) => trial !== near);
  const shown = (trial, name) => trial[name].filter((_, i) => trial.t[i] <= until);
  const time = frame({
    width: roomOf(root), height: turning ? 220 : 340, x: extent(found.t, 0),
    y: extent([...found.psi, ...found.delta, ...(near ? shown(near, "psi") : [])]), xLabel: t("time_s"), yLabel: `${t("heading")}, ${t("rudder")} [°]`,
  });
  time.root.append(path(time, found.t, found.delta, "rudder"));
  if (near) time.root.append(path(time, shown(near, "t"), shown(near, "delta"), "rudder dashed"), path(time, shown(near, "t"), shown(near, "psi"), "measured"));
  time.root.append(path(time, found.t, found.psi, "model"));
  const tracks = [...others.map((trial) => [trial, "measured faint"]), ...(near ? [[near, "measured"]] : []), [found, "model"]];
  const key = (name, text) => el("span", {}, el("i", { class: `line ${name}` }), text);
  const moving = root.querySelector(".motion");
  const held = moving?.contains(document.activeElement) ? document.activeElement.localName : null;
  refill(root,
    el("div", { class: "head" }, el("h2", {}, t(asked.manoeuvre)), el("span", { class: "soft small" }, `Fn ${num(found.Fn)}`),
      found.band ? el("span", { class: "soft small right" }, bandOf(found.band)) : null),
    found.unsettled.map((text) => el("p", { class: "finding warning" }, text)),
    near ? el("p", { class: "legend" }, key("c-model", t("model")),
      key("c-measured", t("measured_run", { run: near.run, rudder: num(Math.abs(near.rudder), 2), Fn: num(near.Fn) })),
      turning && others.length ? key("c-measured faint", t("other_runs", { count: others.length })) : null) : null,
    el("div", { class: turning ? "pair" : "" },
      turning ? el("div", { class: "plot" }, trackPlot(tracks, { height: 400 })) : null,
      el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": t("measures") }, measures(found, near))),
    el("div", { class: "plot" }, time.root),
    el("p", { class: "legend" }, key("c-model", t("heading")), key("c-rudder", t("rudder")), near ? key("c-measured", `${t("heading")}, ${t("measured")}`) : null,
      near ? key("c-rudder dashed", `${t("rudder")}, ${t("measured")}`) : null),
    motionPanel(found, moving),
    found.notes.map((text) => el("p", { class: "soft small" }, text)));
  if (held) root.querySelector(`.motion ${held}`)?.focus();
}

// Whose band it is: ships of the model, or of all sets that the tests accept.
function bandOf(band) {
  const sets = band.rivals.map((effects) => effects.map(titleOf).join(" + "));
  return sets.length ? t("band_rivals", { ships: band.ships, count: sets.length, sets: sets.join("; ") }) : t("band_ships", { ships: band.ships });
}

function measures(found, near) {
  const verdict = (row) => found.verdicts.find((item) => item.metric === row.name);
  const ends = (row) => found.band?.measures?.[row.name];
  const heads = ["model", "measured"].map((name) => el("th", { scope: "col" }, t(name)));
  return el("table", { class: "plain" },
    near ? el("thead", {}, el("tr", {}, el("th", {}, el("span", { class: "sr" }, t("measure"))), heads, found.verdicts.length ? el("th", { scope: "col" }, "IMO") : null)) : null,
    el("tbody", {}, found.metrics.slice(0, 12).map((row) => {
      const judged = verdict(row);
      return el("tr", {}, el("th", { scope: "row" }, metricTitle(row)),
        el("td", {}, num(row.value), ends(row) ? el("small", { class: "soft" }, ` ${num(ends(row)[0])}–${num(ends(row)[1])}`) : null),
        near ? el("td", {}, num(near.metrics[row.name])) : null,
        near && !found.verdicts.length ? null : el("td", {}, judged ? judgement(judged, near ? "" : "IMO ") : ""));
    })));
}

function spiral(root, found) {
  const plot = frame({ width: roomOf(root), height: 420, x: extent(found.rudder), y: extent(found.rate), xLabel: `${t("rudder")} [°]`, yLabel: `${t("yaw_rate")} [°/s]`, label: t("spiral") });
  const only = (stable) => found.rate.map((value, i) => (found.stable[i] === stable || found.stable[i + 1] === stable ? value : null));
  plot.root.append(path(plot, found.rudder, only(true), "model"), path(plot, found.rudder, only(false), "overlay dashed"));
  refill(root, el("h2", {}, t("spiral")), el("div", { class: "plot" }, plot.root),
    el("p", {}, found.width > 0 ? t("loop", { width: num(found.width), height: num(found.height) }) : t("stable_ship")));
}
