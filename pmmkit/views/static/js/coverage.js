// What these runs could show: of each effect the size that could hide, over its usual size.

import { el, svg } from "./dom.js";
import { t, titleOf } from "./words.js";
import { num } from "./format.js";

const LARGEST = 30;

export function coveragePanel(covered, width) {
  const sizes = covered.map((item) => Math.min(item.size ?? LARGEST, LARGEST));
  const low = Math.floor(Math.log10(Math.max(Math.min(...sizes), 1e-4)));
  const high = Math.log10(LARGEST);
  const longest = Math.max(...covered.map((item) => titleOf(item.effect).length));
  const [left, right, row, top] = [Math.min(6.4 * longest + 14, width / 2), 46, 19, 6];
  const height = top + row * covered.length + 22;
  const at = (size) => left + ((Math.log10(Math.max(size, 10 ** low)) - low) / (high - low)) * (width - left - right);
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": t("coverage") });
  for (let power = low; power <= high; power += 1) {
    const x = at(10 ** power);
    root.append(
      svg("line", { class: power === 0 ? "level" : "grid", x1: x, x2: x, y1: top, y2: height - 18 }),
      svg("text", { x, y: height - 5, "text-anchor": "middle" }, num(10 ** power)),
    );
  }
  covered.forEach((item, i) => {
    const y = top + row * i;
    const end = at(sizes[i]);
    root.append(
      svg("text", { x: left - 8, y: y + 13, "text-anchor": "end" }, titleOf(item.effect)),
      svg("rect", { class: item.shown ? "bar" : "bar first", x: left, y: y + 3, height: 12, width: Math.max(end - left, 1.5), rx: 2 }),
      svg("text", { x: end + 5, y: y + 13 }, item.size !== null && item.size <= LARGEST ? num(item.size, 2) : `> ${LARGEST}`),
    );
  });
  return el("section", { class: "panel", "aria-label": t("coverage") },
    el("div", { class: "head" }, el("h2", {}, t("coverage")), el("span", { class: "soft small" }, t("coverage_about"))),
    el("p", { class: "legend" },
      el("span", {}, el("i", { class: "line c-model" }), t("coverage_shown")), el("span", {}, el("i", { class: "line c-measured" }), t("coverage_hidden"))),
    el("div", { class: "plot" }, root));
}
