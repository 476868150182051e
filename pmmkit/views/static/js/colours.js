// Colours as the style sheet has them, for what is drawn on a canvas.

const probe = document.createElement("span");

export function colour(name) {
  if (!probe.isConnected) {
    probe.hidden = true;
    document.body.append(probe);
  }
  probe.style.setProperty("color", `var(--${name})`);
  return getComputedStyle(probe).color;
}

// Errors of forces are told over their uncertainty. The uncertainty of a smoothed track is so
// small that everything is beyond it: motions are told over what was measured of them.
export const SCALES = {
  "captive": { edges: [1, 2, 4, 8, 16], words: ["< 1", "1–2", "2–4", "4–8", "8–16", "> 16"], of: (cell) => cell.ratio },
  "free-running": {
    edges: [5, 10, 20, 40, 80], words: ["< 5 %", "5–10", "10–20", "20–40", "40–80", "> 80 %"],
    of: (cell) => (cell.measured ? (100 * cell.error) / cell.measured : null),
  },
};

// How far an error is up its scale: from 0, which needs no look, to 5.
export function heat(scale, value) {
  return scale.edges.filter((edge) => value >= edge).length;
}
