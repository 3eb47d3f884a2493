// Heat map: a quantity in the cells of two variables. Takes an element and data, nothing else.
import { MARGIN, Surface, colours, label, sideways } from "./canvas.js";
import { num, tickText, ticks } from "./numbers.js";

/** Cells with fewer rows stay empty: they would show chance. */
const LEAST_ROWS = 3;
const RAMPS = {
  light: [[237, 243, 250], [158, 200, 240], [64, 140, 214], [14, 80, 160], [6, 34, 84]],
  dark: [[30, 36, 46], [26, 62, 110], [30, 110, 190], [110, 180, 250], [225, 240, 255]],
  signed: [[178, 88, 12], [240, 176, 104], [200, 200, 200], [110, 172, 230], [10, 84, 170]],
};

/** Sums `values` in a grid of cells over two variables. */
export function cells(x, y, values, columns, rows) {
  const range = (of) => {
    let [low, high] = [Infinity, -Infinity];
    for (const v of of) {
      if (v < low) low = v;
      if (v > high) high = v;
    }
    return low < high ? [low, high] : [low - 0.5, low + 0.5];
  };
  const grid = { x: range(x), y: range(y), columns, rows, count: new Uint32Array(columns * rows),
    sum: new Float64Array(columns * rows), square: new Float64Array(columns * rows) };
  const place = (v, [low, high], n) => Math.min(n - 1, Math.floor(((v - low) / (high - low)) * n));
  for (let k = 0; k < values.length; k++) {
    if (!(Number.isFinite(x[k]) && Number.isFinite(y[k]) && Number.isFinite(values[k]))) continue;
    const cell = place(y[k], grid.y, rows) * columns + place(x[k], grid.x, columns);
    grid.count[cell] += 1;
    grid.sum[cell] += values[k];
    grid.square[cell] += values[k] * values[k];
  }
  return grid;
}

/** Root mean square (`rms`) or mean (`mean`) of a cell; NaN where there are too few rows. */
export function cellValue(grid, cell, kind) {
  const n = grid.count[cell];
  if (n < LEAST_ROWS) return NaN;
  return kind === "mean" ? grid.sum[cell] / n : Math.sqrt(grid.square[cell] / n);
}

export function largest(grid, kind) {
  let most = 0;
  for (let k = 0; k < grid.count.length; k++) most = Math.max(most, Math.abs(cellValue(grid, k, kind)) || 0);
  return most;
}

function shade(part, ramp) {
  const at = Math.min(Math.max(part, 0), 1) * (ramp.length - 1);
  const k = Math.min(ramp.length - 2, Math.floor(at));
  const mix = ramp[k].map((a, i) => Math.round(a + (ramp[k + 1][i] - a) * (at - k)));
  return `rgb(${mix.join(",")})`;
}

/** `options`: `grid`, `kind`, `most` (end of the colour scale), `x`, `y` (`{label}`), `unit`, `height`, `label`,
 * `brush` (called with `{x, y}`, ranges of both variables, when cells have been marked). */
export class HeatMap {
  constructor(element, options) {
    this.options = { height: 300, ...options };
    this.cell = null;
    this.marked = null;
    this.from = null;
    this.element = element;
    element.classList.add("plot");
    element.tabIndex = 0;
    element.setAttribute("role", "group");
    element.setAttribute("aria-label", options.label);
    this.surface = new Surface(element, this.options.height, (c, w, h) => this.#paint(c, w, h));
    element.addEventListener("pointerdown", (e) => this.#begin(e));
    element.addEventListener("pointermove", (e) => this.#point(e));
    element.addEventListener("pointerup", () => this.#end());
    element.addEventListener("pointercancel", () => { this.from = null; });
    element.addEventListener("pointerleave", () => this.#select(null));
    element.addEventListener("keydown", (e) => this.#key(e));
  }

  setOptions(options) {
    Object.assign(this.options, options);
    this.element.setAttribute("aria-label", this.options.label);
    this.cell = null;
    this.marked = null;
    this.surface.invalidate();
  }

  remove() {
    this.surface.remove();
  }

  #size() {
    const { width, height } = this.surface;
    return [width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom];
  }

  #colour(value) {
    const { kind, most } = this.options;
    if (kind === "mean") return shade(0.5 + 0.5 * (value / most), RAMPS.signed);
    const dark = document.documentElement.dataset.scheme === "dark";
    return shade(value / most, dark ? RAMPS.dark : RAMPS.light);
  }

  #paint(context) {
    const { grid, kind } = this.options;
    const [w, h] = this.#size();
    const c = colours();
    const [dx, dy] = [w / grid.columns, h / grid.rows];
    for (let k = 0; k < grid.count.length; k++) {
      const value = cellValue(grid, k, kind);
      if (Number.isNaN(value)) continue;
      const [i, j] = [k % grid.columns, Math.floor(k / grid.columns)];
      context.fillStyle = this.#colour(value);
      context.fillRect(MARGIN.left + i * dx, MARGIN.top + h - (j + 1) * dy, dx + 0.6, dy + 0.6);
    }
    context.strokeStyle = c.grid;
    context.strokeRect(MARGIN.left + 0.5, MARGIN.top + 0.5, w - 1, h - 1);
    const frame = (first, last, colour) => {
      const [[i, j], [k, l]] = [this.#corner(first), this.#corner(last)];
      const [left, right, low, high] = [Math.min(i, k), Math.max(i, k) + 1, Math.min(j, l), Math.max(j, l) + 1];
      context.strokeStyle = colour;
      context.lineWidth = 2;
      context.strokeRect(MARGIN.left + left * dx, MARGIN.top + h - high * dy, (right - left) * dx, (high - low) * dy);
    };
    if (this.marked) frame(...this.marked, c.accent);
    if (this.cell !== null) frame(this.cell, this.cell, c.ink);
    this.#axes(context, w, h);
  }

  #axes(context, w, h) {
    const { grid, x, y } = this.options;
    const across = ticks(...grid.x, w / 70);
    for (const at of across.at) {
      const px = MARGIN.left + ((at - grid.x[0]) / (grid.x[1] - grid.x[0])) * w;
      label(context, tickText(at, across.places), px, MARGIN.top + h + 10, "center");
    }
    const up = ticks(...grid.y, h / 40);
    for (const at of up.at) {
      const py = MARGIN.top + h - ((at - grid.y[0]) / (grid.y[1] - grid.y[0])) * h;
      label(context, tickText(at, up.places), MARGIN.left - 6, py, "right");
    }
    label(context, x.label, MARGIN.left + w / 2, MARGIN.top + h + 26, "center", "middle", colours().ink);
    sideways(context, y.label, MARGIN.top + h / 2, colours().ink);
  }

  #point(event) {
    const { grid } = this.options;
    const [w, h] = this.#size();
    const box = this.element.getBoundingClientRect();
    const i = Math.floor(((event.clientX - box.left - MARGIN.left) / w) * grid.columns);
    const j = Math.floor(((MARGIN.top + h - (event.clientY - box.top)) / h) * grid.rows);
    const inside = i >= 0 && j >= 0 && i < grid.columns && j < grid.rows;
    this.#select(inside ? j * grid.columns + i : null);
    if (this.from !== null && this.cell !== null) this.marked = [this.from, this.cell];
  }

  /** Column and row of a cell. */
  #corner(cell) {
    return [cell % this.options.grid.columns, Math.floor(cell / this.options.grid.columns)];
  }

  #begin(event) {
    if (!this.options.brush || event.button !== 0) return;
    this.#point(event);
    this.from = this.cell;
    if (this.cell !== null) this.marked = [this.cell, this.cell];
    this.element.setPointerCapture(event.pointerId);
  }

  #end() {
    if (this.from === null) return;
    this.from = null;
    if (this.marked) this.#brush();
  }

  /** Tells what the marked cells span. */
  #brush() {
    const { grid, brush } = this.options;
    const [[i, j], [k, l]] = this.marked.map((cell) => this.#corner(cell));
    const span = ([low, high], a, b, n) => [low + ((high - low) * Math.min(a, b)) / n, low + ((high - low) * (Math.max(a, b) + 1)) / n];
    this.surface.invalidate();
    brush({ x: span(grid.x, i, k, grid.columns), y: span(grid.y, j, l, grid.rows) });
  }

  #key(event) {
    const { grid, brush } = this.options;
    if (event.key === "Enter" && brush && this.cell !== null) {
      // Shift and Enter stretch what is marked to this cell.
      this.marked = [event.shiftKey && this.marked ? this.marked[0] : this.cell, this.cell];
      return this.#brush();
    }
    const step = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: grid.columns, ArrowDown: -grid.columns }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = (this.cell ?? Math.floor(grid.count.length / 2)) + step;
    if (next >= 0 && next < grid.count.length) this.#select(next);
  }

  #select(cell) {
    if (cell === this.cell) return;
    this.cell = cell;
    this.surface.invalidate();
    this.options.tell?.(cell === null ? "" : this.describe(cell));
  }

  /** A cell in words. */
  describe(cell) {
    const { grid, kind, x, y, unit } = this.options;
    const [i, j] = [cell % grid.columns, Math.floor(cell / grid.columns)];
    const part = ([low, high], k, n) => `${num(low + ((high - low) * k) / n)} to ${num(low + ((high - low) * (k + 1)) / n)}`;
    const value = cellValue(grid, cell, kind);
    const what = Number.isNaN(value) ? "too few rows" : `${kind} ${num(value)} ${unit}`;
    return `${x.label} ${part(grid.x, i, grid.columns)}, ${y.label} ${part(grid.y, j, grid.rows)}: ${what}, ${grid.count[cell]} rows`;
  }

  /** Cells with the largest values, worst first. */
  worst(count) {
    const { grid, kind } = this.options;
    const value = (k) => Math.abs(cellValue(grid, k, kind));
    return [...grid.count.keys()].filter((k) => !Number.isNaN(value(k)))
      .sort((a, b) => value(b) - value(a)).slice(0, count);
  }
}

/** The colour scale of heat maps, drawn into `element`. */
export class Scale {
  constructor(element, options) {
    this.options = options;
    this.surface = new Surface(element, 34, (context, width) => this.#paint(context, width));
  }

  setOptions(options) {
    Object.assign(this.options, options);
    this.surface.invalidate();
  }

  #paint(context, width) {
    const { kind, most, unit } = this.options;
    const dark = document.documentElement.dataset.scheme === "dark";
    const ramp = kind === "mean" ? RAMPS.signed : dark ? RAMPS.dark : RAMPS.light;
    const length = Math.min(260, width - 20);
    for (let k = 0; k < length; k++) {
      context.fillStyle = shade(k / length, ramp);
      context.fillRect(8 + k, 4, 1.5, 10);
    }
    const low = kind === "mean" ? `−${num(most)}` : "0";
    label(context, low, 8, 24, "left");
    label(context, `${num(most)} ${unit}`, 8 + length, 24, "right");
  }
}
