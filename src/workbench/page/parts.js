// Small pieces that every part of the workbench is made of.
import { h } from "/page/dom.js";
import { tidyUp } from "/page/canvas.js";

/** New content for an element; the focus stays on whatever has the same `data-key`. */
export function renew(element, ...children) {
  const key = element.contains(document.activeElement) ? document.activeElement.dataset.key : undefined;
  element.replaceChildren(...children.flat(3).filter((c) => c !== null && c !== undefined && c !== false));
  if (key !== undefined) element.querySelector(`[data-key="${CSS.escape(key)}"]`)?.focus({ preventScroll: true });
  tidyUp();
  return element;
}

/** Calls `draw` only when what it draws from has changed. */
export function whenChanged(draw) {
  let was = null;
  return (...from) => {
    const now = JSON.stringify(from);
    if (now === was) return;
    was = now;
    draw(...from);
  };
}

/** A button; `key` keeps the focus on it when it is drawn again, even while it is `disabled`. */
export function button(text, act, { key = text, kind = "", disabled = false, ...attributes } = {}) {
  const press = (event) => event.currentTarget.getAttribute("aria-disabled") !== "true" && act(event);
  return h(kind ? `button.${kind}` : "button", { type: "button", "data-key": key, "aria-disabled": disabled && "true", onclick: press, ...attributes }, text);
}

/** A card with a title. */
export function card(title, { id = null, note = null, tools = null } = {}, ...content) {
  return h("section.card.part", { id, "aria-label": title },
    h("div.head", {}, h("h2", {}, title), tools), note && h("p.note", {}, note), ...content);
}

/** Problems with the place they are at; `go(line, column)` leads there. */
export function problemList(problems, go = null) {
  if (!problems.length) return null;
  return h("ul.problems", {}, problems.map((p) => {
    const at = p.line === null || p.line === undefined ? null : `line ${p.line}, column ${p.column ?? 1}`;
    const place = at && (go ? button(at, () => go(p.line, p.column ?? 1), { kind: "place" }) : h("b", {}, at));
    return h(`li.${p.severity ?? "error"}`, {}, h("span.hidden", {}, `${p.severity ?? "error"}: `), place, place && " ", first(p.text), p.help && h("span.help", {}, p.help));
  }));
}

/** The message without the place and the help that stand beside it. */
export function first(text) {
  return text.replace(/^\S+:\d+:\d+: /, "").split("\n  help: ")[0];
}

/** A reason why something was refused, shown where it was asked for. */
export function refusal(error) {
  return h("p.caution", { role: "alert" }, error.text ?? String(error), error.help && h("span.help", {}, error.help));
}

/** Runs `act`; what it is refused stands in `holder`. */
export async function attempt(holder, act) {
  holder.replaceChildren();
  try {
    return await act();
  } catch (error) {
    holder.replaceChildren(refusal(error));
    return null;
  }
}

/** Seconds for people. */
export function duration(seconds) {
  if (seconds === null || seconds === undefined) return "";
  if (seconds < 1) return "less than a second";
  if (seconds < 90) return `${Math.round(seconds)} s`;
  return `${Math.round(seconds / 60)} min`;
}
