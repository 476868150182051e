// One free-running record: track and motions, measured and modelled; the force of a channel that
// is chosen, along the measured motion. `base` and `overlays` are paths of the base and of
// candidates, as a diagnosis tells them before anything is added.

import { el, refill } from "./dom.js";
import { t } from "./words.js";
import { OVERLAYS } from "./runplots.js";
import { area, extent, frame, path } from "./linear.js";

const ORDER = ["psi", "r", "u", "v"];

export function recordPlots(root, history, { base = null, overlays = [], channel = "" } = {}) {
  const { x, y } = history.motion;
  const model = (name) => (base ? base[name] : history.motion[name].predicted);
  const paths = overlays.map((own, i) => ({ own, name: OVERLAYS[i] })).filter(({ own }) => own);
  const both = (name) => [...history.motion[name].measured, ...model(name), ...paths.flatMap(({ own }) => own[name])];
  const t0 = base ? base.t : history.t;
  const map = frame({
    width: 460, height: 400, x: extent(both("y")), y: extent(both("x")), equal: true,
    xLabel: `${t("transfer")} [L]`, yLabel: `${t("advance")} [L]`, label: t("track"),
  });
  map.root.append(
    path(map, y.measured, x.measured, "measured"), path(map, model("y"), model("x"), "model"),
    ...paths.map(({ own, name }) => path(map, own.y, own.x, name)));
  const over = (name) => {
    const own = history.motion[name];
    const low = own.measured.map((v, i) => v - own.uncertainty[i]);
    const high = own.measured.map((v, i) => v + own.uncertainty[i]);
    const plot = frame({ width: 460, height: 190, x: extent(history.t, 0), y: extent([...both(name), ...low, ...high]), xLabel: t("time_s"), yLabel: `${t(`motion_${name}`)} [${own.unit}]` });
    plot.root.append(
      area(plot, history.t, low, high), path(plot, history.t, own.measured, "measured"), path(plot, t0, model(name), "model"),
      ...paths.map((other) => path(plot, t0, other.own[name], other.name)));
    return el("div", { class: "plot" }, plot.root);
  };
  const force = history.forces[channel];
  refill(root, force ? forcePlot(history, channel, force) : null, el("div", { class: "pair" },
    el("div", { class: "plot" }, el("h3", {}, t("track")), map.root),
    el("div", { class: "stack" }, ORDER.slice(0, 2).map(over)),
    ORDER.slice(2).map(over)));
}

function forcePlot(history, channel, own) {
  const low = own.measured.map((v, i) => v - own.uncertainty[i]);
  const high = own.measured.map((v, i) => v + own.uncertainty[i]);
  const plot = frame({ width: 920, height: 210, x: extent(history.t, 0), y: extent([...low, ...high, ...own.predicted]), xLabel: t("time_s"), yLabel: `${t(`channel_${channel}`)} [${own.unit}]`, label: `${t(`channel_${channel}`)}, ${t("time_s")}` });
  plot.root.append(area(plot, history.t, low, high), path(plot, history.t, own.measured, "measured"), path(plot, history.t, own.predicted, "model"));
  return el("div", { class: "plot" }, plot.root);
}
