// The model so far: one rung per effect, undo, and another model beside it.
import { button, card, renew, whenChanged } from "/bench/parts.js";
import { pair, stepName } from "/bench/model.js";
import { bar } from "/page/bars.js";
import { choice, h } from "/page/dom.js";
import { percent } from "/page/numbers.js";

/** `act(path, body)` asks the program for something. */
export function ladderCard(act) {
  const element = h("div");
  const redraw = whenChanged((facts) => renew(element, facts && ladder(facts, act)));
  return { element, draw: (state) => redraw(factsOf(state)) };
}

function factsOf(state) {
  const { shown, root } = pair(state);
  if (!shown) return null;
  const one = (s) => ({ id: s.id, name: stepName(s), percent: s.held_out_percent, parent: s.parent });
  const path = state.path.map((id) => one(state.steps.find((s) => s.id === id)));
  return {
    path, shown: shown.id, against: state.against, parent: shown.parent, floor: floor(root),
    aside: state.steps.filter((s) => !state.path.includes(s.id)).map(one),
    all: state.steps.map(one), base: root.friction ? "classic" : "rigid",
    retrieving: state.job?.kind === "retrieve",
  };
}

/** Pooled error that repetitions of the motion differ by [per cent], where every joint has one. */
function floor(step) {
  if (!step.joints.every((j) => j.repeat_floor_rms !== null)) return null;
  const square = (of) => step.joints.reduce((sum, j) => sum + of(j) ** 2, 0);
  return 100 * Math.sqrt(square((j) => j.repeat_floor_rms) / square((j) => j.torque_rms));
}

function ladder(facts, act) {
  const top = Math.max(...facts.all.map((s) => s.percent ?? 0), 1e-9);
  const mark = facts.floor === null ? null : facts.floor / top;
  const line = (s) => bar((s.percent ?? 0) / top, percent(s.percent), { mark });
  const rung = (s) => h("li", { "aria-current": s.id === facts.shown ? "step" : null },
    button(s.name, () => act("/api/show", { step: s.id, against: s.parent }), { kind: "link", key: `step${s.id}`, title: "show this model" }), line(s));
  const named = (s) => `${s.id === facts.path[0].id ? s.name : `${s.id}: ${s.name}`}, ${percent(s.percent)}`;
  const others = facts.all.filter((s) => s.id !== facts.shown);
  const note = facts.floor === null ? "Pooled error, held out." : `Pooled error, held out. The thin line is the floor that repetitions set, ${percent(facts.floor)}.`;
  return card("The model so far", { id: "ladder", note, tools: button("Undo", () => act("/api/undo"), { key: "undo", disabled: facts.parent === null, title: "take the last effect out again" }) },
    h("ol.rungs", {}, facts.path.map(rung)),
    facts.aside.length > 0 && h("details", {}, h("summary", {}, `${facts.aside.length} set aside`), h("ul.rungs", {}, facts.aside.map(rung))),
    h("div.tools", {},
      choice("compare with", [["", "nothing"], ...others.map((s) => [s.id, named(s)])], facts.against ?? "", (id) => act("/api/show", { step: facts.shown, against: id === "" ? null : Number(id) })),
      facts.path.length === 1 && choice("starting model", [["classic", "rigid body and friction"], ["rigid", "rigid body alone"]], facts.base, (model) => act("/api/model", { model }))));
}
