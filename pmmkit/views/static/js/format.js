// Numbers for people: three digits, a true minus, units behind a narrow space.

export function num(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text =
    size >= 1e5 || size < 1e-4
      ? value.toExponential(digits - 1).replace("e+", "e")
      : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}

export function fixed(value, places = 1) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (Math.abs(value) >= 1e7) return num(value);
  const text = value.toFixed(places);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

export function unitOf(unit) {
  return unit === "-" || !unit ? "" : unit === "deg" ? "°" : unit === "N m" ? "N·m" : unit.replace("deg/", "°/");
}

export function withUnit(value, unit, digits = 3) {
  const own = unitOf(unit);
  return own.startsWith("°") ? `${num(value, digits)}${own}` : `${num(value, digits)} ${own}`.trim();
}

export function signed(value, digits = 3) {
  return value > 0 ? `+${num(value, digits)}` : num(value, digits);
}

export function bytes(size) {
  return size >= 1e9 ? `${num(size / 1e9)} GB` : size >= 1e6 ? `${num(size / 1e6)} MB` : `${num(size / 1e3)} kB`;
}
