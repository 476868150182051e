// Plots drawn as SVG: axes with round numbers, lines, points, areas.

import { svg } from "./dom.js";
import { num } from "./format.js";

export function ticks(low, high, count = 5) {
  const span = high - low || 1;
  const raw = span / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 2.5, 5, 10].find((x) => x * power >= raw * 0.8);
  const found = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9 * span; x += step) {
    found.push(Math.abs(x) < step * 1e-9 ? 0 : x);
  }
  return found;
}

// Width of a plot that has a row to itself, so that its letters keep their size.
export function roomOf(root) {
  const style = getComputedStyle(root);
  const inner = root.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
  return Math.min(Math.max(inner || 860, 300), 900);
}

export function extent(values, margin = 0.06) {
  const known = values.filter((x) => x !== null && Number.isFinite(x));
  if (!known.length) return [0, 1];
  let low = known.reduce((a, b) => Math.min(a, b));
  let high = known.reduce((a, b) => Math.max(a, b));
  if (low === high) [low, high] = [low - (Math.abs(low) || 1) * 0.5, high + (Math.abs(high) || 1) * 0.5];
  const more = margin * (high - low);
  return [low - more, high + more];
}

// A frame with axes; `x` and `y` are ranges. Equal scales where the picture is a map.
export function frame({ width = 460, height = 260, x, y, xLabel, yLabel, equal = false, label }) {
  const edge = { left: 52, right: 12, top: 18, bottom: 38 };
  const inner = { w: width - edge.left - edge.right, h: height - edge.top - edge.bottom };
  let [x0, x1] = x;
  let [y0, y1] = y;
  if (equal) {
    const scale = Math.max((x1 - x0) / inner.w, (y1 - y0) / inner.h);
    const [mx, my] = [(x0 + x1) / 2, (y0 + y1) / 2];
    [x0, x1] = [mx - (scale * inner.w) / 2, mx + (scale * inner.w) / 2];
    [y0, y1] = [my - (scale * inner.h) / 2, my + (scale * inner.h) / 2];
  }
  const px = (v) => edge.left + ((v - x0) / (x1 - x0)) * inner.w;
  const py = (v) => edge.top + (1 - (v - y0) / (y1 - y0)) * inner.h;
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label ?? `${yLabel}, ${xLabel}` });
  for (const v of ticks(y0, y1, Math.max(3, Math.round(inner.h / 44)))) {
    root.append(
      svg("line", { class: v === 0 ? "axis" : "grid", x1: edge.left, x2: width - edge.right, y1: py(v), y2: py(v) }),
      svg("text", { x: edge.left - 6, y: py(v) + 4, "text-anchor": "end" }, num(v)),
    );
  }
  for (const v of ticks(x0, x1, Math.max(3, Math.round(inner.w / 70)))) {
    root.append(
      svg("line", { class: v === 0 ? "axis" : "grid", y1: edge.top, y2: height - edge.bottom, x1: px(v), x2: px(v) }),
      svg("text", { x: px(v), y: height - edge.bottom + 16, "text-anchor": "middle" }, num(v)),
    );
  }
  root.append(
    svg("text", { x: edge.left + inner.w / 2, y: height - 3, "text-anchor": "middle" }, xLabel),
    svg("text", { x: 2, y: 11 }, yLabel),
  );
  return { root, px, py };
}

export function path(plot, xs, ys, name) {
  let text = "";
  let pen = "M";
  xs.forEach((x, i) => {
    if (x === null || ys[i] === null || ys[i] === undefined) {
      pen = "M";
      return;
    }
    text += `${pen}${plot.px(x).toFixed(1)} ${plot.py(ys[i]).toFixed(1)}`;
    pen = "L";
  });
  return svg("path", { class: name, d: text });
}

export function area(plot, xs, low, high) {
  const up = xs.map((x, i) => `${plot.px(x).toFixed(1)} ${plot.py(high[i]).toFixed(1)}`);
  const down = xs.map((x, i) => `${plot.px(x).toFixed(1)} ${plot.py(low[i]).toFixed(1)}`).reverse();
  return svg("path", { class: "area", d: `M${up.join("L")}L${down.join("L")}Z` });
}

export function dots(plot, xs, ys, name, radius = 1.6) {
  const group = svg("g", { class: name });
  xs.forEach((x, i) => {
    if (ys[i] === null || ys[i] === undefined) return;
    group.append(svg("circle", { cx: plot.px(x).toFixed(1), cy: plot.py(ys[i]).toFixed(1), r: radius }));
  });
  return group;
}
