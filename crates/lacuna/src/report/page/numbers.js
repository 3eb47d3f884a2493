// Numbers for people: true minus sign, three significant digits unless more are asked for.

/** Text of a number, `–` where there is none. */
export function num(x, digits = 3) {
  if (x === null || x === undefined || !Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  const text = size >= 1e5 || size < 1e-3
    ? x.toExponential(Math.max(digits - 1, 0)).replace("e+", "e")
    : String(Number(x.toPrecision(digits)).toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(size)))));
  return text.replace(/-/g, "−");
}

/** A unit as it is printed. */
export function unitText(unit) {
  return unit.replaceAll("^2", "²").replaceAll("^3", "³");
}

export function percent(x, digits = 3) {
  return x === null || x === undefined || !Number.isFinite(x) ? "–" : `${num(x, digits)} %`;
}

export function seconds(x) {
  return `${num(x, x >= 100 ? 4 : 3)} s`;
}

/** `value ± error unit`, the error with two digits and the value to the same place. */
export function measured(value, error, unit) {
  if (!(error > 0)) return `${num(value, 4)} ${unit}`;
  const places = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(error))));
  if (Math.abs(value) >= 1e5 || Math.abs(value) < 1e-4) return `${num(value)} ± ${num(error, 2)} ${unit}`;
  return `${value.toFixed(places)} ± ${error.toFixed(places)} ${unit}`.replace(/-/g, "−");
}

/** Round positions for about `count` marks between two numbers, and the digits after the point they need. */
export function ticks(from, to, count) {
  const span = to - from;
  if (!(span > 0) || !Number.isFinite(span)) return { at: [from], places: 1 };
  const rough = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough) ?? 10 * power;
  const at = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9 * step; k++) at.push(k * step);
  return { at, places: Math.min(9, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))) };
}

/** A number at a mark of an axis. */
export function tickText(x, places) {
  if (x !== 0 && places > 5) return num(x, 3);
  return (Math.abs(x) < 1e-12 ? 0 : x).toFixed(places).replace("-", "−");
}

/** 32-bit floats from base64. */
export function floats(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

export function rms(values) {
  let sum = 0;
  for (const x of values) sum += x * x;
  return Math.sqrt(sum / Math.max(values.length, 1));
}
