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

const EDGES = [1, 2, 4, 8, 16];

// How far an error is beyond its uncertainty: 0 within it, 5 far beyond.
export function heat(ratio) {
  return EDGES.filter((edge) => ratio >= edge).length;
}
