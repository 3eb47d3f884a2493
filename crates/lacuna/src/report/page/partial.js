// Partial residual: rows with neighbouring values of a variable, and the fitted curve through them.
import { MARGIN, Surface, colours, label, rule, sideways } from "./canvas.js";
import { tickText, ticks } from "./numbers.js";


/** `options`: `at`, `mean`, `low`, `high`, `curve` (arrays), `x` (label), `unit`, `height`, `label`. */
export class PartialPlot {
  constructor(element, options) {
    this.options = { height: 210, ...options };
    element.classList.add("plot", "still");
    element.setAttribute("role", "img");
    element.setAttribute("aria-label", options.label);
    this.element = element;
    this.surface = new Surface(element, this.options.height, (c, w, h) => this.#paint(c, w, h));
  }

  setOptions(options) {
    Object.assign(this.options, options);
    this.element.setAttribute("aria-label", this.options.label);
    this.surface.invalidate();
  }

  #paint(context, width, height) {
    const { at, mean, low, high, curve, unit, x: name } = this.options;
    if (!at.length) return;
    const c = colours();
    const ends = [at[0], at[at.length - 1]];
    const [left, right] = ends[1] > ends[0] ? ends : [ends[0] - 0.5, ends[0] + 0.5];
    const least = Math.min(...low, ...curve);
    const most = Math.max(...high, ...curve);
    const room = 0.06 * (most - least) || 1;
    const [bottom, top] = [least - room, most + room];
    const w = width - MARGIN.left - MARGIN.right;
    const h = height - MARGIN.top - MARGIN.bottom;
    const x = (v) => MARGIN.left + ((v - left) / (right - left)) * w;
    const y = (v) => MARGIN.top + ((top - v) / (top - bottom)) * h;
    this.#grid(context, { c, x, y, left, right, bottom, top, w, h, name, unit });
    context.beginPath();
    at.forEach((v, k) => context.lineTo(x(v), y(high[k])));
    for (let k = at.length - 1; k >= 0; k--) context.lineTo(x(at[k]), y(low[k]));
    context.fillStyle = c["before-soft"];
    context.fill();
    context.beginPath();
    at.forEach((v, k) => context.lineTo(x(v), y(curve[k])));
    context.strokeStyle = c.accent;
    context.lineWidth = 2;
    context.stroke();
    context.fillStyle = c.measured;
    at.forEach((v, k) => {
      context.beginPath();
      context.arc(x(v), y(mean[k]), 2.2, 0, 7);
      context.fill();
    });
  }

  #grid(context, { c, x, y, left, right, bottom, top, w, h, name, unit }) {
    const up = ticks(bottom, top, h / 34);
    for (const v of up.at) {
      rule(context, MARGIN.left, y(v), MARGIN.left + w, y(v), Math.abs(v) < 1e-12 ? c.faint : c.grid);
      label(context, tickText(v, up.places), MARGIN.left - 6, y(v), "right");
    }
    const across = ticks(left, right, w / 70);
    for (const v of across.at) {
      rule(context, x(v), MARGIN.top, x(v), MARGIN.top + h, c.grid);
      label(context, tickText(v, across.places), x(v), MARGIN.top + h + 10, "center");
    }
    label(context, name, MARGIN.left + w / 2, MARGIN.top + h + 26, "center", "middle", c.ink);
    sideways(context, unit, MARGIN.top + h / 2);
  }
}
