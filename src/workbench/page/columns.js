// The column map: how a foreign log's columns become time, position and torque.
import { Refused, post } from "/bench/api.js";
import { Editor } from "/bench/editor.js";
import { attempt, button, renew, whenChanged } from "/bench/parts.js";
import { choice, h } from "/page/dom.js";

const EXAMPLE = `(
    // Names as they stand in the file's header; {1} counts the joints from 1, {0} from 0.
    time: (column: "stamp_ms", unit: Milliseconds),
    position: (columns: "angle_{1}", unit: Degrees),
    torque: (columns: "torque_{1}"),
)
`;

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
      button("Write an example", () => { editor.text = EXAMPLE; editor.show([]); }),
      button("Read without a map", () => { editor.text = ""; return send({ text: null }); }), shipped));
  const draw = whenChanged((columns, opened) => {
    editor.text = columns.text ?? "";
    editor.show(columns.problems);
    renew(shipped, choice("ready maps", [["", "choose"], ...columns.shipped.map((name) => [name, name])], "", (name) => name && send({ shipped: name })));
    if (opened) details.open = true;
  });
  return { element: details, draw: (state) => draw(state.columns, state.columns.problems.length > 0 || state.logs.some((l) => !l.usable)) };
}
