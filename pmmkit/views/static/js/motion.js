// A manoeuvre in motion: the ship on her path, and from above with the forces of each effect.

import { el, svg } from "./dom.js";
import { t, titleOf } from "./words.js";
import { num } from "./format.js";
import { extent, frame, path } from "./linear.js";

const HALF = [[-0.5, 0.052], [-0.47, 0.0725], [0.2, 0.0725], [0.38, 0.0435], [0.5, 0]];
const HULL = [...HALF, ...HALF.slice(0, -1).reverse().map(([ahead, aside]) => [ahead, -aside])];
// As in the animation that `Track.animate` writes: longest arrow and rudder [L], and the side force,
// over the largest force, below which its place N/Y fades to midship.
const [LONGEST, BLADE, SMALL] = [0.8, 0.09, 0.02];
const SECONDS = 10;
const KINDS = 4;

// Where a picture of the same manoeuvre stood `before`, it goes on from there.
export function motionPanel(track, before = null) {
  const inside = el("div", {});
  const slider = before?.querySelector("input");
  const since = slider ? Number(slider.value) / Number(slider.max) : 0;
  const goes = before?.querySelector("button")?.ariaPressed === "true";
  const fill = () => { if (panel.open && !inside.firstChild) inside.append(...scene(track, since, goes)); };
  const panel = el("details", { class: "motion", open: before?.open, on: { toggle: fill } }, el("summary", {}, t("in_motion")), inside);
  fill();
  return panel;
}

function scene(track, since, goes) {
  const pictures = [alongPath(track), ...(track.forces.length ? [fromAbove(track)] : [])];
  const last = track.t.length - 1;
  const told = el("output", { class: "small" });
  const slider = el("input", { type: "range", min: 0, max: last, step: 1, value: Math.round(since * last), "aria-label": t("instant"), on: { input: () => { stop(); show(); } } });
  const button = el("button", { "aria-pressed": "false", on: { click: () => (playing === null ? play() : stop()) } }, t("play"));
  let playing = null;
  const show = () => {
    const i = Number(slider.value);
    for (const picture of pictures) picture.show(i);
    told.textContent = `t ${num(track.t[i], 4)} s, U ${num(track.speed[i])} m/s, ψ ${num(track.psi[i])}°, δ ${num(track.delta[i])}°`;
  };
  const stop = () => {
    cancelAnimationFrame(playing);
    playing = null;
    button.textContent = t("play");
    button.ariaPressed = "false";
  };
  const play = () => {
    if (Number(slider.value) === last) slider.value = 0;
    let before = null;
    let place = Number(slider.value);
    button.textContent = t("pause");
    button.ariaPressed = "true";
    const step = (now) => {
      if (!slider.isConnected) return void stop();
      place += before === null ? 0 : ((now - before) / 1000 / SECONDS) * last;
      before = now;
      slider.value = Math.min(Math.round(place), last);
      show();
      if (place >= last) stop();
      else playing = requestAnimationFrame(step);
    };
    playing = requestAnimationFrame(step);
  };
  show();
  if (goes) play();
  return [
    el("div", { class: "player" }, button, slider, told),
    el("div", { class: "pair" }, pictures.map((picture) => el("div", { class: "plot" }, picture.root))),
    track.forces.length ? el("p", { class: "legend" }, track.forces.map((item, k) => el("span", {}, el("i", { class: `line c-f${k % KINDS}` }), titleOf(item.effect)))) : null,
  ].filter(Boolean);
}

function alongPath(track) {
  const plot = frame({ width: 460, height: 400, x: extent([...track.y, -0.6, 0.6]), y: extent([...track.x, -0.6]), equal: true, xLabel: `${t("transfer")} [L]`, yLabel: `${t("advance")} [L]`, label: t("in_motion") });
  const sailed = svg("path", { class: "model" });
  const [hull, blade] = ship();
  plot.root.append(path(plot, track.y, track.x, "measured faint dashed"), sailed, hull, blade);
  return {
    root: plot.root,
    show(i) {
      const psi = (track.psi[i] * Math.PI) / 180;
      const [cos, sin] = [Math.cos(psi), Math.sin(psi)];
      const place = ([ahead, aside]) => `${plot.px(track.y[i] + ahead * sin + aside * cos).toFixed(1)} ${plot.py(track.x[i] + ahead * cos - aside * sin).toFixed(1)}`;
      sailed.setAttribute("d", path(plot, track.y.slice(0, i + 1), track.x.slice(0, i + 1), "").getAttribute("d"));
      lay(hull, blade, place, track.delta[i]);
    },
  };
}

function fromAbove(track) {
  const most = Math.max(...track.forces.flatMap((item) => item.X.map((x, i) => Math.hypot(x, item.Y[i]))));
  const unit = most / LONGEST;
  const plot = frame({ width: 460, height: 400, x: [-0.9, 0.9], y: [-1.3, 1.3], equal: true, xLabel: `${t("to_starboard")} [L]`, yLabel: `${t("forces_by_effect")}, 1 L: ${unit >= 1000 ? `${num(unit / 1000)} kN` : `${num(unit)} N`}`, label: t("forces_by_effect") });
  const [hull, blade] = ship();
  const arrows = track.forces.map((_, k) => svg("path", { class: `force f${k % KINDS}` }));
  const place = ([ahead, aside]) => `${plot.px(aside).toFixed(1)} ${plot.py(ahead).toFixed(1)}`;
  plot.root.append(hull, blade, ...arrows);
  return {
    root: plot.root,
    show(i) {
      lay(hull, blade, place, track.delta[i]);
      track.forces.forEach((item, k) => {
        const [X, Y, N] = [item.X[i], item.Y[i], item.N[i]];
        const from = Math.min(Math.max((N * Y) / (Y ** 2 + (SMALL * most) ** 2) / track.L, -0.5), 0.5);
        arrows[k].setAttribute("d", arrow([from, 0], [from + X / unit, Y / unit], place));
      });
    },
  };
}

function arrow([x0, y0], [x1, y1], place) {
  const long = Math.hypot(x1 - x0, y1 - y0);
  const [ahead, aside] = [(x1 - x0) / long || 0, (y1 - y0) / long || 0];
  const head = Math.min(0.08, long / 2);
  const wing = (side) => place([x1 - head * (ahead - side * aside * 0.5), y1 - head * (aside + side * ahead * 0.5)]);
  return `M${place([x0, y0])}L${place([x1, y1])}M${wing(1)}L${place([x1, y1])}L${wing(-1)}`;
}

function ship() {
  return [svg("path", { class: "hull" }), svg("path", { class: "blade" })];
}

function lay(hull, blade, place, delta) {
  const angle = ((delta ?? 0) * Math.PI) / 180;
  hull.setAttribute("d", `M${HULL.map(place).join("L")}Z`);
  blade.setAttribute("d", `M${place([-0.5, 0])}L${place([-0.5 - BLADE * Math.cos(angle), BLADE * Math.sin(angle)])}`);
}
