// A text with line numbers, and marks where something is wrong. The text is an ordinary field, so that the keyboard,
// undo and screen readers work as everywhere.
import { h } from "/page/dom.js";
import { problemList, renew } from "/bench/parts.js";

const TAB = "    ";

/** `options`: `label`, `rows`, `change(text)` (called as one types), `spell` (off). */
export class Editor {
  constructor({ label, rows = 18, change = () => {} }) {
    this.change = change;
    this.problems = [];
    const id = `editor-${Math.random().toString(36).slice(2)}`;
    this.numbers = h("div.numbers", { "aria-hidden": "true" });
    this.marks = h("pre.marks", { "aria-hidden": "true" });
    this.field = h("textarea", { "aria-label": label, "aria-describedby": id, rows: String(rows), spellcheck: "false", autocapitalize: "off", autocomplete: "off", wrap: "off",
      oninput: () => { this.#lay(); this.change(this.text); }, onscroll: () => this.#follow(), onkeydown: (event) => this.#key(event) });
    this.list = h("div.found", { id, role: "status" });
    this.element = h("div.editor", {}, h("div.sheet", {}, this.numbers, h("div.paper", {}, this.marks, this.field)), this.list);
    this.#lay();
  }

  get text() {
    return this.field.value;
  }

  /** Another text; what stands there stays when it is the same. */
  set text(text) {
    if (text === this.field.value) return;
    this.field.value = text;
    this.#lay();
  }

  /** Marks problems; `none` is said when there are none. */
  show(problems, none = null) {
    this.problems = problems;
    renew(this.list, problemList(problems, (line, column) => this.go(line, column)) ?? (none && h("p.fine", {}, none)));
    this.#lay();
  }

  /** Puts the cursor at a line and a column, both from 1. */
  go(line, column) {
    const lines = this.field.value.split("\n");
    const before = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
    const at = Math.min(before + column - 1, this.field.value.length);
    this.field.focus();
    this.field.setSelectionRange(at, Math.min(at + 1, this.field.value.length));
    const height = parseFloat(getComputedStyle(this.field).lineHeight);
    this.field.scrollTop = Math.max(0, (line - 4) * height);
  }

  insert(text) {
    this.field.setRangeText(text, this.field.selectionStart, this.field.selectionEnd, "end");
    this.#lay();
    this.change(this.text);
  }

  #lay() {
    const lines = this.field.value.split("\n");
    const wrong = new Map(this.problems.filter((p) => p.line).map((p) => [p.line, p]));
    this.numbers.replaceChildren(...lines.map((_, k) => h(wrong.has(k + 1) ? `span.${wrong.get(k + 1).severity ?? "error"}` : "span", {}, String(k + 1))));
    this.marks.replaceChildren(...lines.map((line, k) => this.#line(line, wrong.get(k + 1))));
    this.#follow();
  }

  /** A line that is laid under the text; only the underline of what is wrong can be seen. */
  #line(line, problem) {
    if (!problem) return h("span.line", {}, line || " ");
    const from = Math.min(Math.max((problem.column ?? 1) - 1, 0), Math.max(line.length - 1, 0));
    const length = /^[\w.]+/.exec(line.slice(from))?.[0].length ?? 1;
    const kind = problem.severity ?? "error";
    return h(`span.line.${kind}`, {}, line.slice(0, from), h(`span.here.${kind}`, {}, line.slice(from, from + length) || " "), line.slice(from + length));
  }

  #follow() {
    this.numbers.scrollTop = this.field.scrollTop;
    this.marks.scrollTop = this.field.scrollTop;
    this.marks.scrollLeft = this.field.scrollLeft;
  }

  /** Tab indents; after Escape it leaves the field, as everywhere else. */
  #key(event) {
    if (event.key === "Escape") this.leaving = true;
    else if (event.key === "Tab" && !event.shiftKey && !this.leaving) {
      event.preventDefault();
      this.insert(TAB);
    } else if (event.key !== "Tab" && event.key !== "Shift") this.leaving = false;
  }
}

/** Calls `act` when nothing has come in for a while. */
export function later(act, milliseconds = 200) {
  let waiting = 0;
  return (...from) => {
    clearTimeout(waiting);
    waiting = setTimeout(() => act(...from), milliseconds);
  };
}
