// A canvas that fits its element, is drawn once per frame at most, and only while it can be seen.

/** Room around what is drawn, for numbers and names of the axes. */
export const MARGIN = { left: 60, right: 10, top: 8, bottom: 34 };

let palette = null;
const surfaces = new Set();

/** Colours of the style sheet as they are now. */
export function colours() {
  if (!palette) {
    const style = getComputedStyle(document.body);
    const of = (name) => style.getPropertyValue(`--${name}`).trim();
    palette = Object.fromEntries(
      ["ink", "muted", "faint", "grid", "paper", "accent", "accent-soft", "before", "before-soft", "measured", "warm", "band"]
        .map((name) => [name, of(name)]));
    palette.font = `12px ${style.fontFamily || "sans-serif"}`;
  }
  return palette;
}

/** After light and dark have changed. */
export function repaint() {
  palette = null;
  for (const surface of surfaces) surface.draw();
}

/** Gives up every surface that is no longer on the page. */
export function tidyUp() {
  for (const surface of surfaces) if (!surface.element.isConnected) surface.remove();
}

/** A canvas in `element`; `paint(context, width, height)` draws it in CSS pixels. */
export class Surface {
  #paint;
  #waiting = false;
  #seen = true;
  #stale = true;

  constructor(element, height, paint) {
    this.element = element;
    this.height = height;
    this.#paint = paint;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    this.canvas.style.height = `${height}px`;
    element.append(this.canvas);
    this.width = 0;
    this.sizes = new ResizeObserver(() => this.#resize());
    this.sizes.observe(element);
    this.sight = new IntersectionObserver((entries) => {
      this.#seen = entries.at(-1).isIntersecting;
      if (this.#seen && this.#stale) this.invalidate();
    }, { rootMargin: "200px" });
    this.sight.observe(element);
    surfaces.add(this);
  }

  #resize() {
    const width = Math.floor(this.element.clientWidth);
    if (width === this.width) return;
    this.width = width;
    this.invalidate();
  }

  /** Draws in the next frame. */
  invalidate() {
    this.#stale = true;
    if (this.#waiting || !this.#seen) return;
    this.#waiting = true;
    requestAnimationFrame(() => {
      this.#waiting = false;
      this.draw();
    });
  }

  /** Draws now. */
  draw() {
    this.width ||= Math.floor(this.element.clientWidth);
    if (!this.width) return;
    this.#stale = false;
    const scale = window.devicePixelRatio || 1;
    const [w, h] = [Math.round(this.width * scale), Math.round(this.height * scale)];
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    const context = this.canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    context.font = colours().font;
    this.#paint(context, this.width, this.height);
  }

  remove() {
    surfaces.delete(this);
    this.sizes.disconnect();
    this.sight.disconnect();
    this.canvas.remove();
  }
}

/** A straight line on whole pixels. */
export function rule(context, x0, y0, x1, y1, colour) {
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
  context.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
  context.stroke();
}

export function label(context, text, x, y, align = "left", baseline = "middle", colour = colours().muted) {
  context.fillStyle = colour;
  context.textAlign = align;
  context.textBaseline = baseline;
  context.fillText(text, x, y);
}

/** Name of an upright axis. */
export function sideways(context, text, y, colour = colours().muted) {
  context.save();
  context.translate(8, y);
  context.rotate(-Math.PI / 2);
  label(context, text, 0, 0, "center", "middle", colour);
  context.restore();
}
