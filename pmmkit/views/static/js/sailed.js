// Tracks of a manoeuvre, before and after, with numbers and the IMO's verdict.

import { el, refill, svg } from "./dom.js";
import { t } from "./words.js";
import { num, unitOf } from "./format.js";
import { extent, frame, path } from "./linear.js";
import { motionPanel } from "./motion.js";

export async function turnPanel(root, app) {
  refill(root, el("h2", {}, t("turn")), el("p", { class: "soft" }, t("computing")));
  let turns;
  try {
    turns = await app.turns();
  } catch (problem) {
    return void refill(root, el("h2", {}, t("turn")), el("p", { class: "soft" }, problem.message));
  }
  if (!turns) return void root.remove();
  const after = turns.after ?? turns.before;
  refill(root,
    el("div", { class: "head" }, el("h2", {}, t("turn")),
      el("span", { class: "soft small" }, t("turn_about", { rudder: 35, speed: num(after.approach), Fn: num(after.Fn) }))),
    after.unsettled.map((text) => el("p", { class: "finding warning" }, text)),
    el("div", { class: "pair" },
      el("div", { class: "plot" }, trackPlot(turns.after ? [[turns.before, "measured dashed"], [turns.after, "model"]] : [[turns.before, "model"]])),
      el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": t("measures") }, measures(turns))),
    turns.after ? el("p", { class: "legend" },
      el("span", {}, el("i", { class: "line c-measured" }), t("before")), el("span", {}, el("i", { class: "line c-model" }), t("after_all"))) : null,
    motionPanel(after));
}

export function trackPlot(tracks, { height = 340 } = {}) {
  const xs = tracks.flatMap(([track]) => [...track.y, ...outline(track).map((point) => point[1])]);
  const ys = tracks.flatMap(([track]) => [...track.x, ...outline(track).map((point) => point[0])]);
  const plot = frame({ width: 460, height, x: extent([...xs, 0]), y: extent([...ys, 0]), equal: true, xLabel: `${t("transfer")} [L]`, yLabel: `${t("advance")} [L]`, label: t("track") });
  for (const [track, name] of tracks) {
    if (track.band?.inner?.length) {
      const text = (points) => points.map(([x, y]) => `${plot.px(y).toFixed(1)} ${plot.py(x).toFixed(1)}`).join("L");
      const own = name.startsWith("model") ? "area model-area" : "area";
      plot.root.append(svg("path", { class: own, d: `M${text(track.band.inner)}L${text([...track.band.outer].reverse())}Z` }));
    }
  }
  for (const [track, name] of tracks) plot.root.append(path(plot, track.y, track.x, name));
  return plot.root;
}

function outline(track) {
  return [...(track.band?.outer ?? []), ...(track.band?.inner ?? [])].filter((point) => point[0] !== null && point[1] !== null);
}

function measures(turns) {
  const columns = turns.after ? [turns.before, turns.after] : [turns.before];
  const last = columns.at(-1);
  const limits = Object.fromEntries(last.verdicts.map((item) => [item.metric, item]));
  const value = (page, row) => {
    const own = page.metrics.find((item) => item.name === row.name);
    const ends = page.band?.measures?.[row.name];
    return el("td", {}, num(own?.value), ends ? el("small", { class: "soft" }, ` ${num(ends[0])}–${num(ends[1])}`) : null);
  };
  const judged = (row) => {
    const item = limits[row.name];
    return el("td", {}, item ? judgement(item) : "");
  };
  return el("table", { class: "plain" },
    el("thead", {}, el("tr", {}, el("th", {}, el("span", { class: "sr" }, t("measure"))),
      turns.after ? el("th", { scope: "col" }, t("before")) : null, el("th", { scope: "col" }, turns.after ? t("after_all") : t("value")), el("th", { scope: "col" }, "IMO"))),
    el("tbody", {}, last.metrics.map((row) => el("tr", {}, el("th", { scope: "row" }, metricTitle(row)), columns.map((page) => value(page, row)), judged(row)))));
}

// What the IMO's limit says: nothing where the model is not usable, or its band holds the limit.
export function judgement({ passed, limit }, whose = "") {
  const [shade, mark] = passed === null ? ["soft", "?"] : passed ? ["met", "✓"] : ["unmet", "✗"];
  return el("span", { class: shade }, `${mark} ${whose}≤ ${num(limit)}`, passed === null ? el("br", {}) : null, passed === null ? t("not_settled") : null);
}

export function metricTitle(row) {
  const unit = unitOf(row.unit);
  const number = /_(\d+)(_|$)/.exec(row.name)?.[1];
  const title = number ? `${row.title} ${number}` : row.title;
  return unit ? `${title} [${unit}]` : title;
}
