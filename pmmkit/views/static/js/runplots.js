// One run and channel: measured and model with their bands, the residual, over time, over the
// cycle, over the motion. The plots know each other: a cursor in one shows in all.

import { el, svg, refill } from "./dom.js";
import { t } from "./words.js";
import { num, unitOf, withUnit } from "./format.js";
import { colour } from "./colours.js";
import { area, dots, extent, frame, path, roomOf } from "./linear.js";
import { circle, halfBand, overPhase, summed } from "./harmonics.js";

const DEGREES = 180 / Math.PI;
export const OVERLAYS = ["overlay", "second"];
const DASH = { second: [6, 4] };

export function runPlots(root, history, channel, { overlays = [], compact = false } = {}) {
  const own = history.channels[channel];
  if (!own) return refill(root, el("p", { class: "soft" }, t("no_channel", { channel }))), null;
  const changes = overlays.map((runs, i) => ({ runs, values: runs?.[history.run]?.[channel], name: OVERLAYS[i] })).filter((change) => change.values);
  const force = `${channel} [${unitOf(own.unit)}]`;
  const shape = { history, own, channel, changes, force };
  const near = el("div", { class: "plot" });
  const time = el("div", { class: "plot" });
  const rest = el("div", { class: "plot" });
  const far = el("div", { class: "plot" });
  refill(
    root,
    el("div", { class: "stack" },
      compact ? el("div", { class: "pair" }, near, far) : null,
      compact ? null : time, rest,
      compact ? null : el("div", { class: "pair" }, near, far)),
  );
  const links = [];
  const follow = (place) => links.forEach((link) => link(place));
  if (!compact && history.t.length > 2) timePlot(time, shape, follow);
  else time.remove();
  residualPlot(rest, shape, follow, compact);
  if (history.steady) {
    far.remove();
    near.parentElement.classList.remove("pair");
    familyPlot(near, shape);
  } else {
    links.push(cyclePlot(near, shape), motionPlot(far, shape));
  }
  return shape;
}

// `effects`: names of those that are drawn over the run, two at most.
export function legend(effects = [], model = "model") {
  const item = (name, text) => el("span", {}, el("i", { class: `line c-${name}` }), text);
  return el("p", { class: "legend" },
    item("measured", t("measured")),
    item("model", t(model)),
    effects.map((effect, i) => item(OVERLAYS[i], t("with_effect", { effect }))),
    el("span", {}, el("i", { class: "b-band" }), t("band")));
}

// The model over time with a candidate.
function changed({ history, channel }, { values }) {
  const at = (i) => (history.steady ? values[0] : summed(history.labels, values, history.theta[i] ?? 0));
  return history.predicted[channel].map((x, i) => (x === null ? null : x + at(i)));
}

// The harmonics of the model with each candidate.
function changedHarmonics({ own, changes }) {
  return changes.map(({ values, name }) => ({ values: own.predicted.map((x, i) => x + (values[i] ?? 0)), name }));
}

function timePlot(root, shape, follow) {
  const { history, channel, own } = shape;
  const steady = history.steady;
  const half = steady ? history.t.map(() => own.uncertainty[0])
    : history.theta.map((angle) => halfBand(history.labels, own.uncertainty, angle));
  const mean = steady ? history.t.map(() => own.measured[0])
    : history.theta.map((angle) => summed(history.labels, own.measured, angle));
  const measured = history.measured[channel] ?? mean;
  lines(root, {
    title: t("over_time"), label: `${shape.force}, ${t("time")}`, x: history.t, xLabel: "", yLabel: shape.force,
    series: [
      { values: measured, colour: "measured", width: 1, alpha: 0.75 },
      { values: mean.map((x, i) => x + half[i]), colour: "band", hidden: true },
      { values: mean.map((x, i) => x - half[i]), colour: "band", hidden: true, bandWith: 1 },
      { values: history.predicted[channel], colour: "model", width: 2 },
      ...shape.changes.map((change) => ({ values: changed(shape, change), colour: change.name, width: 2 })),
    ],
    follow, height: 230,
  });
}

function residualPlot(root, shape, follow, compact) {
  const { history, channel } = shape;
  const measured = history.measured[channel];
  if (!measured || history.t.length < 3) {
    root.remove();
    return;
  }
  const less = (values) => values.map((x, i) => (x === null || measured[i] === null ? null : x - measured[i]));
  lines(root, {
    title: t("residual"), label: t("residual"), x: history.t, xLabel: t("time_s"), yLabel: `Δ${shape.force}`,
    series: [
      { values: less(history.predicted[channel]), colour: "model", width: 1.25 },
      ...shape.changes.map((change) => ({ values: less(changed(shape, change)), colour: change.name, width: 1.25 })),
    ],
    follow, height: compact ? 150 : 140, zero: true,
  });
}

// A plot over time by uPlot; all of them share their cursor and their zoom.
function lines(root, { title, label, x, xLabel, yLabel, series: shown, follow, height, zero = false }) {
  const axis = { stroke: colour("soft"), grid: { stroke: colour("line"), width: 1 }, ticks: { show: false }, font: "11.5px system-ui", labelFont: "11.5px system-ui" };
  const mount = el("div", { role: "img", "aria-label": label });
  root.append(el("h3", {}, title), mount);
  const fill = colour("band");
  const plot = new window.uPlot(
    {
      width: Math.max(root.clientWidth, 240), height, legend: { show: false },
      cursor: { sync: { key: "run" }, points: { size: 6 }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: zero ? { range: (_, low, high) => extent([low, high, 0]) } : {} },
      axes: [
        { ...axis, ...(xLabel ? { label: xLabel, labelSize: 18 } : {}), size: 30, values: (_, own) => own.map((v) => num(v)) },
        { ...axis, size: 56, space: 28, values: (_, own) => own.map((v) => num(v)), label: yLabel, labelSize: 18 },
      ],
      series: [
        {},
        ...shown.map((item) => ({
          stroke: item.hidden ? "transparent" : colour(item.colour), width: item.width ?? 0, alpha: item.alpha ?? 1, dash: DASH[item.colour],
          points: { show: false }, spanGaps: true,
        })),
      ],
      bands: shown.flatMap((item, i) => (item.bandWith ? [{ series: [i, i + 1], fill }] : [])),
      hooks: { setCursor: [(u) => follow(u.cursor.idx ?? null)] },
    },
    [x, ...shown.map((item) => item.values)],
    mount,
  );
  const watch = new ResizeObserver(() => {
    if (!mount.isConnected) return watch.disconnect(), plot.destroy();
    const width = Math.floor(root.clientWidth);
    if (width > 0 && width !== plot.width) plot.setSize({ width, height });
  });
  watch.observe(root);
}

function cyclePlot(root, shape) {
  const { history, channel, own } = shape;
  const phases = circle();
  const at = (values) => phases.map((angle) => summed(history.labels, values, angle));
  const half = phases.map((angle) => halfBand(history.labels, own.uncertainty, angle));
  const measured = at(own.measured);
  const model = at(own.predicted);
  const others = changedHarmonics(shape).map(({ values, name }) => ({ values: at(values), name }));
  const raw = history.measured[channel] ?? [];
  const degrees = phases.map((x) => x * DEGREES);
  const high = measured.map((x, i) => x + half[i]);
  const low = measured.map((x, i) => x - half[i]);
  const plot = frame({
    x: [0, 360], y: extent([...raw, ...high, ...low, ...model, ...others.flatMap((other) => other.values)]), xLabel: t("phase_deg"), yLabel: shape.force, label: t("over_cycle"),
  });
  plot.root.append(
    dots(plot, history.theta.map((x) => x * DEGREES), raw, "dots faint", 1.1),
    area(plot, degrees, low, high),
    path(plot, degrees, measured, "measured"),
    path(plot, degrees, model, "model"),
    ...others.map((other) => path(plot, degrees, other.values, other.name)),
  );
  const now = svg("circle", { class: "now", r: 4, visibility: "hidden" });
  plot.root.append(now);
  refill(root, el("h3", {}, t("over_cycle")), plot.root);
  return (i) => {
    const there = i !== null && history.theta[i] !== undefined && history.predicted[channel][i] !== null;
    now.setAttribute("visibility", there ? "visible" : "hidden");
    if (!there) return;
    now.setAttribute("cx", plot.px(history.theta[i] * DEGREES));
    now.setAttribute("cy", plot.py(summed(history.labels, own.predicted, history.theta[i])));
  };
}

function motionPlot(root, shape) {
  const { history, channel, own } = shape;
  const names = Object.keys(history.motion);
  if (!names.length) {
    root.remove();
    return () => {};
  }
  const name = names[0];
  const motion = history.motion[name];
  const phases = circle(73);
  const over = overPhase(history.theta, motion.values, phases);
  const at = (values) => phases.map((angle) => summed(history.labels, values, angle));
  const measured = at(own.measured);
  const model = at(own.predicted);
  const others = changedHarmonics(shape).map(({ values, name }) => ({ values: at(values), name }));
  const raw = history.measured[channel] ?? [];
  const plot = frame({
    x: extent(motion.values), y: extent([...raw, ...measured, ...model, ...others.flatMap((other) => other.values)]),
    xLabel: `${name} [${motion.unit}]`, yLabel: shape.force, label: t("over_motion"),
  });
  plot.root.append(
    dots(plot, motion.values, raw, "dots faint", 1.1),
    path(plot, over, measured, "measured"),
    path(plot, over, model, "model"),
    ...others.map((other) => path(plot, over, other.values, other.name)),
  );
  const now = svg("circle", { class: "now", r: 4, visibility: "hidden" });
  plot.root.append(now);
  refill(root, el("h3", {}, t("over_motion")), plot.root);
  return (i) => {
    const there = i !== null && motion.values[i] !== null && motion.values[i] !== undefined;
    now.setAttribute("visibility", there ? "visible" : "hidden");
    if (!there) return;
    now.setAttribute("cx", plot.px(motion.values[i]));
    now.setAttribute("cy", plot.py(summed(history.labels, own.predicted, history.theta[i])));
  };
}

function familyPlot(root, shape) {
  const { history, channel } = shape;
  const family = history.family;
  const own = family.channels?.[channel];
  if (!own) {
    root.remove();
    return;
  }
  const { measured, predicted, uncertainty } = own;
  const high = measured.map((x, i) => (x === null ? null : x + uncertainty[i]));
  const low = measured.map((x, i) => (x === null ? null : x - uncertainty[i]));
  const others = shape.changes.map(({ runs, name }) => ({
    values: family.runs.map((run, i) => (runs[run]?.[channel] ? predicted[i] + runs[run][channel][0] : null)), name,
  }));
  const plot = frame({
    width: roomOf(root), height: 290, x: extent(family.at), y: extent([...high, ...low, ...predicted, ...others.flatMap((other) => other.values)]),
    xLabel: `${t(`over_${family.over}`)} [${family.unit}]`, yLabel: shape.force, label: t("over_family"),
  });
  family.at.forEach((x, i) => {
    if (measured[i] === null) return;
    plot.root.append(svg("line", { class: "measured", x1: plot.px(x), x2: plot.px(x), y1: plot.py(low[i]), y2: plot.py(high[i]) }));
  });
  plot.root.append(path(plot, family.at, predicted, "model"), ...others.map((other) => path(plot, family.at, other.values, other.name)), dots(plot, family.at, measured, "dots", 3));
  const place = family.runs.indexOf(history.run);
  if (place >= 0 && measured[place] !== null) {
    plot.root.append(svg("circle", { class: "now", r: 4.5, cx: plot.px(family.at[place]), cy: plot.py(measured[place]) }));
  }
  refill(root, el("h3", {}, t("over_family")), plot.root);
}

// What is told of the error of a cell, as the comparison lists it.
export function facts(misfit, channel, cell, known) {
  if (!cell) return null;
  const { unit } = misfit.columns.find((column) => column.name === channel);
  const fact = (name, value, more) => el("div", {}, el("dt", {}, name), el("dd", {}, value, more ? el("small", {}, ` ${more}`) : null));
  return el("dl", { class: "facts" },
    misfit.statistics.map((item) => fact(statistic(item), withUnit(cell[item.name], unit), item.name === "uncertainty" ? (known ? "k = 2" : t("noise_unknown")) : null)),
    fact(t("ratio"), num(cell.ratio, 2), "×"));
}

// The name of a statistic in the language of the page, or as the comparison calls it.
export function statistic({ name, title }) {
  const said = t(`statistic_${name}`);
  return said === `statistic_${name}` ? title : said;
}
