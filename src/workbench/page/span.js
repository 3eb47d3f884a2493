// What lies in a span of time or in cells of a map that the reader has marked.
import { button, refusal, renew } from "/bench/parts.js";
import { h, table } from "/page/dom.js";
import { num } from "/page/numbers.js";

/** Joints that stand out most are listed first; so many before one asks for the rest. */
const FIRST = 3;

/** A read-out of the span that is marked on a time axis; `ask(query)` gets what lies in it. */
export function spanReadout(axis, ask) {
  const inputs = [field("from"), field("to")];
  const element = h("div.readout.docked", { "aria-live": "polite" });
  const mark = () => {
    const [from, to] = inputs.map((f) => Number(f.input.value));
    if (inputs.every((f) => f.input.value !== "") && from !== to) axis.select(from, to);
  };
  const fields = h("details", {}, h("summary", {}, "read a span of time by its ends"),
    h("div.tools", {}, inputs.map((f) => f.label), button("Read", mark, { title: "read what lies in this span" })));
  const newest = latest(element);
  const read = () => newest(async () => {
    const span = axis.selection;
    if (!span) return () => renew(element);
    inputs.forEach((f, k) => { f.input.value = span[k].toFixed(3); });
    const answer = await ask({ from: span[0], to: span[1] });
    const tools = [button("Zoom to it", () => axis.show(...span)), button("Clear", () => axis.select(null))];
    return () => renew(element, found(answer, `${num(span[0], 4)} to ${num(span[1], 4)} s`, tools));
  });
  axis.watch((what) => what === "selection" && read());
  return { element, fields, again: () => axis.selection && read() };
}

/** A read-out of cells that are marked on a map. */
export function cellReadout(ask) {
  const element = h("div.readout", { "aria-live": "polite" });
  const newest = latest(element);
  const read = (marked) => newest(async () => {
    const { x, y, names: [one, other], joint } = marked;
    const answer = await ask({ variable: one, low: x[0], high: x[1], variable2: other, low2: y[0], high2: y[1], joint });
    const span = (name, [low, high]) => `${name} ${num(low)} to ${num(high)}`;
    return () => renew(element, found(answer, `${span(one, x)}, ${span(other, y)}`, [button("Clear", () => renew(element))]));
  });
  return { element, read };
}

function field(name) {
  const input = h("input", { type: "number", step: "any", inputmode: "decimal" });
  return { input, label: h("label.choice", {}, h("span", {}, `${name} [s]`), input) };
}

/** Asks, and shows the answer in `holder`; one that a later question has overtaken is not shown. */
function latest(holder) {
  let count = 0;
  return async (ask) => {
    const mine = (count += 1);
    try {
      const show = await ask();
      if (mine === count) show();
    } catch (error) {
      if (mine === count) renew(holder, refusal(error));
    }
  };
}

function found(answer, where, tools) {
  const pairs = answer.joints.some((j) => j.rms.length > 1);
  const arrow = (values) => values.map((v) => num(v)).join(" → ");
  const row = (j) => [j.name, num(j.torque_rms), arrow(j.rms), arrow(j.rms_elsewhere), arrow(j.most), num(j.at_s, 4)];
  const factor = (j) => (j.rms.at(-1) ?? 0) / Math.max(j.rms_elsewhere.at(-1) ?? 0, 1e-12);
  const order = [...answer.joints].sort((a, b) => factor(b) - factor(a));
  const head = ["joint", "torque rms", "residual rms here", "elsewhere", "largest", "at [s]"];
  const all = (joints) => table(`Residual in ${where}${pairs ? ", compared model → shown model" : ""}`, head, joints.map(row));
  return h("div.card.inside", { "data-found": where }, h("span.buttons", {}, tools),
    h("h3", {}, where), h("p", {}, answer.text),
    order.length > 0 && all(order.slice(0, FIRST)),
    answer.depends.length > 0 && h("p.note", {}, "Here the residual follows: ", answer.depends.map((d) => `${d.joint} ${d.variable} (r ${num(d.r, 2)})`).join(", "), "."),
    order.length > FIRST && h("details", {}, h("summary", {}, `${order.length - FIRST} more joints`), all(order.slice(FIRST))),
    answer.motion.length > 0 && h("details", {}, h("summary", {}, "how the robot moves here"),
      table("Motion", ["variable", "from", "to", "unit"], answer.motion.map((m) => [m.variable, num(m.from), num(m.to), m.unit]))));
}
