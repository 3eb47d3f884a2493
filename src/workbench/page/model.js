// The model: how far off it is, what it is made of, what it lacks, and what adding that does.
import { get, post } from "/bench/api.js";
import { candidatesCard } from "/bench/candidates.js";
import { jointsCard } from "/bench/joints.js";
import { ladderCard } from "/bench/ladder.js";
import { attempt, button, renew, whenChanged } from "/bench/parts.js";
import { cellReadout, spanReadout } from "/bench/span.js";
import { maps, partials, torque } from "/page/curves.js";
import { h, term } from "/page/dom.js";
import { num, percent } from "/page/numbers.js";
import { TimeAxis } from "/page/time_axis.js";

/** The model on show and the one it is compared with. */
export function pair(state) {
  const step = (id) => state.steps.find((one) => one.id === id) ?? null;
  return { shown: step(state.shown), against: step(state.against), root: step(state.path[0]) };
}

/** What to call a step. */
export function stepName(step) {
  if (!step.added) return step.label;
  const joints = step.added.joints ?? [];
  return `+ ${step.added.effect.replaceAll("_", " ")}${joints.length ? ` on ${joints.join(", ")}` : ""}`;
}

export function modelView(study) {
  const [head, joints, side, drawing, refused] = [h("header.verdict"), h("div.joints-area"), h("div.side"), h("div.drawing"), h("div")];
  const live = { axis: new TimeAxis(0, 1), brush: true };
  const where = {};
  const element = h("div.view", { id: "view-model" }, head, refused, h("div.bench", {}, joints, side, drawing));
  const act = (path, body) => attempt(refused, () => post(path, body));
  const only = (k) => {
    live.shown = new Set([k]);
    if (study.page) draw(study.page);
    document.getElementById("torque")?.scrollIntoView({ block: "start" });
  };
  const [ladder, candidates] = [ladderCard(act), candidatesCard(act, study)];
  const table = jointsCard(only);
  joints.append(table.element);
  side.append(ladder.element, candidates.element);
  const span = spanReadout(live.axis, (query) => region(live.trace ?? 0, query));
  const cells = cellReadout((query) => region(where.chosen?.trace ?? 0, query));
  where.brush = cells.read;
  const region = (log, query) => get(`/api/region?${new URLSearchParams({ log, ...query })}`);
  // Nothing is drawn anew under a pointer that is marking something.
  let [pressed, waiting] = [false, null];
  drawing.addEventListener("pointerdown", () => { pressed = true; });
  for (const end of ["pointerup", "pointercancel"]) window.addEventListener(end, () => {
    pressed = false;
    if (waiting) setTimeout(() => waiting && draw(waiting));
  });
  const draw = (page) => {
    waiting = pressed ? page : null;
    if (pressed) return undefined;
    if (!page?.pictures?.traces.length) return renew(drawing);
    live.order = where.order = worstFirst(pair(study.state).root);
    const plots = () => [...drawing.querySelectorAll(".plot")];
    const focused = plots().indexOf(document.activeElement);
    renew(drawing, torque(page, live), maps(page, where), partials(page));
    plots()[focused]?.focus({ preventScroll: true });
    drawing.querySelector("#torque .tools").after(span.fields);
    drawing.querySelector("#torque").append(span.element);
    drawing.querySelector("#where .scale").after(cells.element);
    return span.again();
  };
  const opening = whenChanged((parts) => renew(head, heading(parts), !parts.held && !parts.busy && button("Give it one", () => study.go("data"), { kind: "main" })));
  return {
    element,
    draw: (state) => {
      opening(headingOf(state));
      element.classList.toggle("empty", state.shown === null);
      table.draw(state);
      ladder.draw(state);
      candidates.draw(state);
    },
    drawPictures: draw,
  };
}

/** Joints by their error beside what repetitions leave, or beside their torque: as the first model has it, so that the order stays. */
function worstFirst(root) {
  const size = (j) => j.held_out_rms / Math.max(j.repeat_floor_rms ?? 0.01 * j.torque_rms, 1e-12);
  return root.joints.map((_, k) => k).sort((a, b) => size(root.joints[b]) - size(root.joints[a]));
}

/** What the heading says, as data. */
function headingOf(state) {
  const { shown, root } = pair(state);
  const compared = shown !== null && root !== null && root.id !== shown.id;
  const from = compared ? root : shown;
  return {
    lines: state.verdict.length ? state.verdict : [waiting(state, shown)],
    undecided: state.diagnosis?.undecided ?? [],
    robot: state.robot?.name, logs: state.logs.filter((l) => l.role === "fit").map((l) => l.name), folds: state.folds,
    band: state.signals?.band_hz ?? null, compared, busy: state.job !== null,
    held: from && [from.held_out_percent, shown.held_out_percent],
    validated: from && shown.validation_percent !== null ? [from.validation_percent, shown.validation_percent] : null,
  };
}

function waiting(state, shown) {
  if (!state.robot?.joints.length) return "there is no robot yet";
  if (!state.logs.length) return "there is no log yet";
  if (!shown) return state.job ? "reading the log and fitting the first model" : "no model could be fitted yet: the reason stands under Data";
  return `the model leaves ${percent(shown.held_out_percent)} of the torque unexplained${state.job?.kind === "scan" ? "; looking for what it is missing" : ""}`;
}

function heading(parts) {
  const sentence = (line) => `${line.charAt(0).toUpperCase()}${line.slice(1)}.`;
  const change = (label, [before, after]) => h("div.figure", {}, h("span.label", {}, label),
    h("span.big", {}, parts.compared ? [percent(before), h("span.arrow", {}, " → "), h("b", {}, percent(after))] : percent(after)));
  return [
    h("p.kicker", {}, [parts.robot, ...parts.logs].filter(Boolean).join(" · ")),
    h("h1", {}, sentence(parts.lines[0])),
    parts.lines.slice(1).map((line) => h("p.note", {}, sentence(line))),
    parts.undecided.map((u) => h("p.caution", {}, `${u.reason}. Record ${u.record}.`)),
    parts.held && h("div.figures", {},
      change(term("held out", "error, held out"), parts.held),
      parts.validated && change(term("validation", "error on a log never fitted"), parts.validated),
      parts.band !== null && h("div.figure", {}, h("span.label", {}, term("band")), h("span.big", {}, `${num(parts.band)} Hz`)),
      parts.folds && h("div.figure", {}, h("span.label", {}, term("fold", "held out by")), h("span", {}, parts.folds))),
  ];
}
