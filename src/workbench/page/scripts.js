// Scripts of effects and of rules: written, checked as one types, and used at once.
import { Refused, post } from "/bench/api.js";
import { Editor, later } from "/bench/editor.js";
import { attempt, button, card, problemList, renew, whenChanged } from "/bench/parts.js";
import { choice, h } from "/page/dom.js";
import { EXAMPLES } from "/bench/examples.js";

export function scriptsView(study) {
  const open = { kind: "effect", file: null, joint: "" };
  const [files, says, refused, use] = [h("div"), h("div.says"), h("div"), h("div.tools")];
  const check = later(async () => {
    const asked = editor.text;
    const answer = await attempt(refused, () => post("/api/script/check", { kind: open.kind, text: asked }));
    if (answer === null || asked !== editor.text) return;
    open.ok = answer.ok;
    editor.show(answer.problems, "no problem found");
    renew(says, sections(answer.sections));
    offers();
  });
  const editor = new Editor({ label: "script", rows: 24, change: () => { open.ok = false; check(); } });
  const load = (kind, file, text) => {
    Object.assign(open, { kind, file, ok: false });
    editor.text = text;
    editor.show([]);
    renew(says);
    drawFiles(study.state.scripts, file);
    check();
  };
  const save = () => attempt(refused, async () => {
    try {
      const answer = await post("/api/script/save", { kind: open.kind, text: editor.text, file: open.file });
      open.file = answer.file;
      editor.show(answer.problems, `saved as ${answer.file}`);
      offers();
      return answer.file;
    } catch (error) {
      if (error instanceof Refused && error.line !== null) {
        editor.show([error]);
        return null;
      }
      throw error;
    }
  });
  const add = async () => {
    const file = await save();
    if (!file) return;
    if ((await attempt(refused, () => post("/api/add", { effect: file, joints: open.joint ? [open.joint] : [] }))) !== null) study.go("model");
  };
  const offers = () => renew(use, offered(open, study.state, { save, add, parameters: async () => (await save()) && study.go("parameters") }));
  const drawFiles = whenChanged((scripts, chosen) => renew(files, list(scripts, chosen, load)));
  const element = h("div.view", { id: "view-scripts" }, h("header.verdict", {}, h("h1", {}, "Scripts"),
    h("p.note", {}, "What no list has, in a few lines: an effect makes torque of motion, a rule says what link parameters must satisfy. A script cannot read files or reach the network, and what it means is shown as you type.")),
    h("div.scripting", {}, files, card("Script", { id: "script" }, editor.element, refused, use), says));
  let begun = false;
  return {
    element,
    draw: (state) => {
      drawFiles(state.scripts, open.file);
      if (!begun && state.robot) {
        begun = true;
        load("effect", null, EXAMPLES.effect);
      }
      offers();
    },
  };
}

function list(scripts, chosen, load) {
  const entry = (s) => h("li", { "aria-current": s.file === chosen ? "true" : null },
    button(s.file, () => load(s.kind, s.file, s.text), { kind: "link" }), h("span.where", {}, ` ${s.title}`), problemList(s.problems));
  return card("In this study", { id: "script-files" },
    scripts.length ? h("ul.plain", {}, scripts.map(entry)) : h("p.note", {}, "No script yet."),
    h("div.tools", {}, button("New effect", () => load("effect", null, EXAMPLES.effect)), button("New rule", () => load("constraint", null, EXAMPLES.constraint))));
}

function offered(open, state, { save, add, parameters }) {
  const joints = state?.robot?.joints.map((j) => j.name) ?? [];
  const off = { disabled: !open.ok };
  return [
    button(open.file ? `Save ${open.file}` : "Save", save, { key: "save", ...off }),
    open.kind === "effect"
      ? [choice("on", [["", "every joint"], ...joints.map((j) => [j, j])], open.joint, (value) => { open.joint = value; }),
        button("Add it to the model", add, { kind: "main", key: "use", disabled: !open.ok || !state || state.shown === null })]
      : button("Use it as a rule", parameters, { kind: "main", key: "use", ...off }),
  ];
}

/** What the script means, in the words of `lacuna check`. */
function sections(all) {
  return all.map((s) => h("section.card", { "aria-label": s.title }, h("h3", {}, s.title), h("pre.words", {}, s.lines.join("\n"))));
}
