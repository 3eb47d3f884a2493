// Bars inside tables: they print, they can be read aloud, and they need no axis of their own.
import { h } from "./dom.js";

/** A bar of `part` (0 to 1) with its number; `mark` is where a thin line stands. */
export function bar(part, text, { mark = null, tone = "accent", behind = null } = {}) {
  const track = h("span.track", { "aria-hidden": "true" });
  const add = (kind, size) => {
    const piece = h(`span.${kind}`);
    piece.style.width = `${100 * Math.min(Math.max(size, 0), 1)}%`;
    track.append(piece);
  };
  if (behind !== null) add("fill.behind", behind);
  add(`fill.${tone}`, part);
  if (mark !== null) {
    const line = h("span.mark");
    line.style.left = `${100 * Math.min(Math.max(mark, 0), 1)}%`;
    track.append(line);
  }
  return h("span.bar", {}, track, h("span.value", {}, text));
}
