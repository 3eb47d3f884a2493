// Series over time. Takes an element and data, nothing else; zooms with all plots of the same axis.
import { MARGIN, Surface, colours, label, rule, sideways } from "./canvas.js";
import { num, tickText, ticks } from "./numbers.js";
import { Pyramid } from "./pyramid.js";
import { TimeAxis } from "./time_axis.js";


/**
 * `options`: `axis` (a TimeAxis, shared), `label` (for screen readers), `unit`, `height`, `times` (whether
 * times are written below), `bands` (`[{from, to}]` in seconds), `level` (a half width drawn about zero),
 * `brush` (dragging marks a span instead of zooming),
 * `series`: `[{ tone, label, start, dt, low, high? }]`; `low` and `high` hold one number per `dt`.
 * Tones are colours of the style sheet: `measured`, `before`, `accent`.
 */
export class LinePlot {
  #low = new Float32Array(0);
  #high = new Float32Array(0);
  #drag = null;

  constructor(element, options) {
    this.options = { height: 150, times: true, bands: [], level: null, unit: "", ...options };
    this.axis = options.axis ?? new TimeAxis(0, 1);
    this.element = element;
    element.classList.add("plot");
    element.tabIndex = 0;
    element.setAttribute("role", "group");
    element.setAttribute("aria-label", options.label ?? "series over time");
    this.setSeries(options.series ?? []);
    this.surface = new Surface(element, this.options.height, (c, w, h) => this.#paint(c, w, h));
    this.unwatch = this.axis.watch(() => this.surface.invalidate());
    this.#listen();
  }

  /** Other data in the same plot. */
  setSeries(series) {
    this.series = series.map((s) => ({ ...s, pyramid: new Pyramid(s.low, s.high ?? s.low) }));
    this.surface?.invalidate();
  }

  setOptions(options) {
    Object.assign(this.options, options);
    this.surface.invalidate();
  }

  remove() {
    this.unwatch();
    this.surface.remove();
  }

  /** Value of every series at a time. */
  valuesAt(time) {
    return this.series.map((s) => s.pyramid.at(Math.floor((time - s.start) / s.dt + (s.high ? 0 : 0.5))));
  }

  #time(x) {
    const [from, to] = this.axis.view;
    const inner = this.surface.width - MARGIN.left - MARGIN.right;
    return from + ((to - from) * Math.min(Math.max(x - MARGIN.left, 0), inner)) / inner;
  }

  #paint(context, width, height) {
    const c = colours();
    const [from, to] = this.axis.view;
    const bottom = height - (this.options.times ? 20 : 4);
    const inner = Math.max(1, Math.round(width - MARGIN.left - MARGIN.right));
    const envelopes = this.series.map((s) => this.#envelope(s, from, to, inner));
    const [low, high] = this.#range(envelopes);
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - 6);
    const x = (time) => MARGIN.left + ((time - from) / (to - from)) * inner;
    this.#grid(context, { c, x, y, low, high, bottom, width, from, to });
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, 0, inner, bottom + 1);
    context.clip();
    for (const band of this.options.bands) {
      context.fillStyle = c.band;
      context.fillRect(x(band.from), 0, x(band.to) - x(band.from), bottom);
    }
    if (this.options.level) {
      context.fillStyle = c.band;
      context.fillRect(MARGIN.left, y(this.options.level), inner, y(-this.options.level) - y(this.options.level));
    }
    envelopes.forEach((e, k) => this.#line(context, e, y, c[this.series[k].tone], this.series[k].width));
    this.#overlay(context, { c, x, bottom });
    context.restore();
  }

  /** Columns of a series; where samples are far apart, its points instead. */
  #envelope(series, from, to, inner) {
    const a = (from - series.start) / series.dt;
    const b = (to - series.start) / series.dt;
    if (b - a < inner / 2 && !series.high) return this.#points(series, a, b, inner);
    if (this.#low.length < inner) {
      this.#low = new Float32Array(inner);
      this.#high = new Float32Array(inner);
    }
    series.pyramid.columns(a, b, inner, this.#low, this.#high);
    return { low: this.#low.slice(0, inner), high: this.#high.slice(0, inner) };
  }

  #points(series, a, b, inner) {
    const xs = [];
    const ys = [];
    const last = Math.min(series.low.length - 1, Math.ceil(b));
    for (let k = Math.max(0, Math.floor(a)); k <= last; k++) {
      xs.push(MARGIN.left + ((k - a) / (b - a)) * inner);
      ys.push(series.low[k]);
    }
    return { xs, low: ys, high: ys };
  }

  #range(envelopes) {
    let [low, high] = [Infinity, -Infinity];
    for (const e of envelopes) {
      for (const v of e.low) if (v < low) low = v;
      for (const v of e.high) if (v > high) high = v;
    }
    if (this.options.level) {
      low = Math.min(low, -this.options.level);
      high = Math.max(high, this.options.level);
    }
    if (!(low <= high)) return [-1, 1];
    const room = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
    return [low - room, high + room];
  }

  #grid(context, { c, x, y, low, high, bottom, width, from, to }) {
    const marks = ticks(low, high, Math.max(3, bottom / 28));
    for (const at of marks.at) {
      rule(context, MARGIN.left, y(at), width - MARGIN.right, y(at), Math.abs(at) < 1e-12 ? c.faint : c.grid);
      label(context, tickText(at, marks.places), MARGIN.left - 6, y(at), "right");
    }
    const times = ticks(from, to, (width - MARGIN.left) / 90);
    for (const at of times.at) {
      rule(context, x(at), 0, x(at), bottom, c.grid);
      if (this.options.times) label(context, `${tickText(at, times.places)} s`, x(at), bottom + 12, "center");
    }
    if (this.options.unit) sideways(context, this.options.unit, bottom / 2);
  }

  #line(context, e, y, colour, width = 1.3) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.beginPath();
    let begun = false;
    for (let p = 0; p < e.low.length; p++) {
      if (Number.isNaN(e.low[p])) {
        begun = false;
        continue;
      }
      const x = e.xs ? e.xs[p] : MARGIN.left + p + 0.5;
      const [top, bottom] = [y(e.high[p]), y(e.low[p])];
      if (!begun) context.moveTo(x, top);
      else context.lineTo(x, top);
      // A column shows both its extremes.
      if (bottom - top > 0.5) context.lineTo(x, bottom);
      begun = true;
    }
    context.stroke();
  }

  #overlay(context, { c, x, bottom }) {
    if (this.#drag && this.#drag.mode === "select" && this.#drag.now !== null) {
      const [a, b] = [x(this.#drag.from), x(this.#drag.now)];
      context.fillStyle = c["accent-soft"];
      context.fillRect(Math.min(a, b), 0, Math.abs(b - a), bottom);
    }
    if (this.axis.selection) {
      const [a, b] = this.axis.selection.map(x);
      context.fillStyle = c["accent-soft"];
      context.fillRect(a, 0, Math.max(1, b - a), bottom);
    }
    const cursor = this.axis.cursor;
    if (cursor !== null) rule(context, x(cursor), 0, x(cursor), bottom, c.muted);
  }

  #listen() {
    const at = (event) => this.#time(event.clientX - this.element.getBoundingClientRect().left);
    const on = (name, listener, how) => this.element.addEventListener(name, listener, how);
    on("pointerdown", (event) => {
      if (event.button !== 0) return;
      const mode = event.shiftKey ? "pan" : "select";
      this.#drag = { mode, from: at(event), now: null, x: event.clientX, view: [...this.axis.view] };
      this.element.setPointerCapture(event.pointerId);
    });
    on("pointermove", (event) => this.#move(event, at(event)));
    on("pointerup", () => this.#drop());
    on("pointercancel", () => { this.#drag = null; });
    on("pointerleave", () => this.axis.point(null));
    on("dblclick", () => this.axis.reset());
    on("wheel", (event) => {
      // The page scrolls until somebody has turned to this plot.
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== this.element) return;
      event.preventDefault();
      this.axis.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY / 300))), at(event));
    }, { passive: false });
    on("keydown", (event) => this.#key(event));
  }

  #move(event, time) {
    if (!this.#drag) return this.axis.point(time);
    if (this.#drag.mode === "pan") {
      const [from, to] = this.#drag.view;
      const by = ((event.clientX - this.#drag.x) / (this.surface.width - MARGIN.left - MARGIN.right)) * (to - from);
      return this.axis.show(from - by, to - by);
    }
    if (Math.abs(event.clientX - this.#drag.x) > 4) this.#drag.now = time;
    return this.axis.point(time);
  }

  #drop() {
    const drag = this.#drag;
    this.#drag = null;
    if (drag?.mode !== "select" || drag.now === null) return;
    if (this.options.brush) this.axis.select(drag.from, drag.now);
    else this.axis.show(Math.min(drag.from, drag.now), Math.max(drag.from, drag.now));
  }

  #key(event) {
    const steps = {
      "+": () => this.axis.zoom(0.7), "=": () => this.axis.zoom(0.7), "-": () => this.axis.zoom(1 / 0.7),
      ArrowLeft: () => this.axis.pan(-0.2), ArrowRight: () => this.axis.pan(0.2),
      Home: () => this.axis.reset(), 0: () => this.axis.reset(),
      Escape: () => (this.axis.selection ? this.axis.select(null) : this.axis.reset()),
    };
    const step = event.ctrlKey || event.metaKey || event.altKey ? null : steps[event.key];
    if (!step) return;
    event.preventDefault();
    step();
  }
}

/** `0.123 N m`, for a read-out. */
export function reading(value, unit) {
  return Number.isNaN(value) ? "–" : `${num(value, 4)} ${unit}`;
}
