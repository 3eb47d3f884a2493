// What the model is missing, most useful first, and a button that adds it.
import { button, card, renew, whenChanged } from "/bench/parts.js";
import { effectName } from "/page/answer.js";
import { bar } from "/page/bars.js";
import { choice, h, table, term } from "/page/dom.js";
import { measured, num, percent, unitText } from "/page/numbers.js";

/** Candidates that did not pass and are listed before one asks for the rest. */
const OTHERS = 8;

export function candidatesCard(act, study) {
  const element = h("div");
  const wanted = { effect: null, joint: "" };
  const redraw = whenChanged((facts) => renew(element, facts && list(facts, act, wanted, study)));
  return { element, draw: (state) => redraw(factsOf(state)) };
}

function factsOf(state) {
  const step = state.steps.find((s) => s.id === state.shown);
  if (!step) return null;
  return {
    step: state.shown, scanned: step.scanned, scanning: state.job?.kind === "scan", all: state.candidates,
    joints: state.robot.joints.map((j) => j.name), units: state.robot.joints.map((j) => j.torque), gate: state.diagnosis?.gate ?? null,
    effects: state.catalogue.map((e) => e.name), scripts: state.scripts.filter((s) => s.kind === "effect").map((s) => [s.file, s.title]),
    refused: state.diagnosis?.refused ?? [], inseparable: state.diagnosis?.inseparable ?? [], busy: ["add", "retrieve"].includes(state.job?.kind),
  };
}

function list(facts, act, wanted) {
  const rank = (name) => facts.all.filter((c) => c.rank === name);
  const [missing, minor, others] = [rank("missing"), rank("minor"), rank("other")];
  const most = Math.max(...facts.all.map((c) => c.gain_percent), 1e-9);
  const entries = (some) => some.map((c) => entry(c, facts, act, most));
  // A formula is a proposal to read first: each is added by hand.
  const many = [...missing, ...minor].some((c) => c.effect !== "formula") && button("Add all that is named", () => act("/api/diagnose", { auto: true }), { key: "auto", disabled: facts.busy });
  return card("What to add", { id: "candidates", note: noteOf(facts, missing), tools: many },
    entries(missing),
    minor.length > 0 && h("details", {}, h("summary", {}, `${minor.length} more, significant but small`), entries(minor)),
    others.length > 0 && h("details", {}, h("summary", {}, `${others.length} that did not pass`), entries(others.slice(0, OTHERS)),
      others.length > OTHERS && h("details", {}, h("summary", {}, `${others.length - OTHERS} more`), entries(others.slice(OTHERS)))),
    doubts(facts), byHand(facts, act, wanted));
}

function noteOf(facts, missing) {
  if (!facts.scanned && facts.all.length) return facts.scanning ? "First scores, each effect alone beside this model; the full search goes on." : "First scores, each effect alone beside this model.";
  if (!facts.scanned) return facts.scanning ? "Every effect of the catalogue is being tried beside this model." : "This model has not been searched yet.";
  if (missing.length) return h("span", {}, "What each would remove of the ", term("held out", "held-out"), " squared error, everything fitted again.");
  return facts.gate ? `Nothing significant is missing: no effect reaches the z that is believed here, ${num(facts.gate[0])}.` : "Nothing significant is missing.";
}

function entry(c, facts, act, most) {
  const where = c.joints.length ? c.joints.join(", ") : "the whole robot";
  const name = c.effect.replaceAll("_", " ");
  const listed = facts.effects.includes(c.effect) && !c.effect.endsWith(".rhai");
  const also = [c.also_possible ?? []].flat();
  const unit = facts.units[facts.joints.indexOf(c.rms_joint)] ?? "";
  const add = button("Add", async (event) => {
    const pressed = event.currentTarget;
    pressed.setAttribute("aria-disabled", "true");
    if ((await act("/api/add", c.add)) === null) pressed.removeAttribute("aria-disabled");
  }, { kind: c.rank === "missing" ? "main" : "", key: `add ${c.effect} ${where}`, "aria-label": `Add ${name} on ${where}`, disabled: facts.busy });
  return h(`article.candidate.${c.rank}`, {},
    h("div.head", {}, h("h3", {}, listed ? effectName(c.effect) : c.title, h("span.where", {}, ` on ${where}`)), add),
    h("p", {}, bar(c.gain_percent / most, percent(c.gain_percent)), h("span.where", {}, "  ", term("z"), ` ${num(c.z)}`)),
    c.rms && h("p.where", {}, `${c.rms_joint} ${num(c.rms[0])} → ${num(c.rms[1])} ${unit} rms`),
    also.length > 0 && h("p.caution", {}, term("also possible"), `: ${also.map((e) => e.replaceAll("_", " ")).join(", ")}`),
    !listed && c.equation && h("p.equation", {}, c.equation),
    h("details", {}, h("summary", {}, "what it is"), h("p.equation", {}, c.equation), c.about && h("p.note", {}, c.about), parameters(c, name)));
}

function parameters(c, name) {
  if (!c.parameters.length) return null;
  return table(`Numbers of ${name}`, ["", "value", "unit"],
    c.parameters.map((p) => [p.name ?? p.symbol, measured(p.value, p.standard_error, "").trim(), unitText(p.unit)]), { class: "plain" });
}

function doubts(facts) {
  const name = (e) => e.replaceAll("_", " ");
  return [
    facts.refused.length > 0 && h("details", {}, h("summary", {}, `${facts.refused.length} that fit but are refused`),
      h("ul", {}, facts.refused.map((r) => h("li", {}, h("b", {}, name(r.effect)), r.joints.length ? ` on ${r.joints.join(", ")}: ` : ": ", r.reason)))),
    facts.inseparable.length > 0 && h("details", {}, h("summary", {}, `${facts.inseparable.length} that this motion cannot tell apart`),
      h("ul", {}, facts.inseparable.map((i) => h("li", {}, h("b", {}, `${name(i.effects[0])} and ${i.effects.slice(1).map(name).join(" or ")}`), `: ${i.separating_motion}`)))),
  ];
}

/** Anything that the catalogue or a script has, whether it was proposed or not. */
function byHand(facts, act, wanted) {
  wanted.effect ??= facts.effects[0];
  const effects = [...facts.scripts.map(([file, title]) => [file, `${file}: ${title}`]), ...facts.effects.map((e) => [e, e.replaceAll("_", " ")])];
  return h("details", {}, h("summary", {}, "add something else"),
    h("div.tools", {},
      choice("effect", effects, wanted.effect, (value) => { wanted.effect = value; }),
      choice("on", [["", "every joint"], ...facts.joints.map((j) => [j, j])], wanted.joint, (value) => { wanted.joint = value; }),
      button("Add it", () => act("/api/add", { effect: wanted.effect, joints: wanted.joint ? [wanted.joint] : [] }), { disabled: facts.busy }),
      button("Search again", () => act("/api/diagnose", { auto: false }), { disabled: facts.busy })));
}
