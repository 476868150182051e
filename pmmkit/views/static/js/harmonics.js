// Forces of a run from their harmonics: C0, C1, S1 … over the phase θ.

export function factorOf(label, theta) {
  const order = Number(label.slice(1));
  if (order === 0) return 1;
  return label[0] === "C" ? Math.cos(order * theta) : Math.sin(order * theta);
}

export function summed(labels, values, theta) {
  return labels.reduce((sum, label, i) => sum + (values[i] ?? 0) * factorOf(label, theta), 0);
}

// Half of the band at a phase: uncertainties of the harmonics add in squares.
export function halfBand(labels, values, theta) {
  return Math.sqrt(labels.reduce((sum, label, i) => sum + ((values[i] ?? 0) * factorOf(label, theta)) ** 2, 0));
}

export function circle(count = 121) {
  return Array.from({ length: count }, (_, i) => (2 * Math.PI * i) / (count - 1));
}

// Mean of a motion in bins of the phase, at the phases of `circle`.
export function overPhase(theta, values, phases) {
  const bins = phases.length - 1;
  const sums = new Float64Array(bins);
  const counts = new Float64Array(bins);
  theta.forEach((angle, i) => {
    const bin = Math.floor((angle / (2 * Math.PI)) * bins + 0.5) % bins;
    if (values[i] !== null) {
      sums[bin] += values[i];
      counts[bin] += 1;
    }
  });
  return phases.map((_, i) => (counts[i % bins] ? sums[i % bins] / counts[i % bins] : null));
}
