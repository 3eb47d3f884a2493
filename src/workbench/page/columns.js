// The column map: how a foreign log's columns become time, position and torque.
import { Refused, post } from "/bench/api.js";
import { Editor } from "/bench/editor.js";
import { mapping } from "/bench/mapping.js";
import { attempt, button, renew, whenChanged } from "/bench/parts.js";
import { choice, h } from "/page/dom.js";

export function columnsCard() {
  const editor = new Editor({ label: "column map", rows: 10 });
  const refused = h("div");
  const send = (body) => attempt(refused, async () => {
    try {
      await post("/api/columns", body);
      editor.show([]);
    } catch (error) {
      if (!(error instanceof Refused) || error.line === null) throw error;
      editor.show([error]);
    }
  });
  const [shipped, details] = [h("span"), h("details.card")];
  details.append(h("summary", {}, "Column map: for headers, units or signs that are not ours"),
    h("p.note", {}, "Without a map, columns are read as t, q1.., dq1.., ddq1.., tau1.. in s, rad, N m. A map says what other headers mean, in which unit, with which sign, and which gain makes torque of current."),
    editor.element, refused,
    h("div.tools", {}, button("Use this map", () => send({ text: editor.text }), { kind: "main" }),
      button("Read without a map", () => { editor.text = ""; return send({ text: null }); }), shipped));
  const chooser = h("div");
  editor.element.before(chooser);
  const write = (text) => {
    editor.text = text;
    editor.show([]);
  };
  const drawChooser = whenChanged((headers, names, needed) => renew(chooser, headers && names && mapping(headers, names, write, needed && editor.text === "")));
  const drawText = whenChanged((text, problems) => {
    editor.text = text ?? "";
    editor.show(problems);
  });
  const drawShipped = whenChanged((all) => renew(shipped, choice("ready maps", [["", "choose"], ...all.map((name) => [name, name])], "", (name) => name && send({ shipped: name }))));
  const open = whenChanged((needed) => {
    if (needed) details.open = true;
  });
  return { element: details, draw: (state) => {
    details.hidden = !state.logs.length && state.columns.text === null;
    const needed = state.columns.problems.length > 0 || state.logs.some((l) => !l.usable && l.read !== false);
    const log = state.logs.find((l) => !l.usable && l.read !== false) ?? state.logs[0];
    drawText(state.columns.text, state.columns.problems);
    drawChooser(log?.columns.map((c) => c.header).filter(Boolean) ?? null, state.robot?.joints.map((j) => j.name) ?? null, needed);
    drawShipped(state.columns.shipped);
    open(needed);
  } };
}
