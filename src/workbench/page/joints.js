// Joint by joint: the error before and after, with the floor that repetitions set.
import { card, button, renew, whenChanged } from "/bench/parts.js";
import { pair, stepName } from "/bench/model.js";
import { bar } from "/page/bars.js";
import { h, table, term } from "/page/dom.js";
import { num, percent } from "/page/numbers.js";

/** `only(joint)` draws the curves of one joint. */
export function jointsCard(only) {
  const element = h("div");
  let last = null;
  const redraw = whenChanged((shown, against, units) => {
    renew(element, shown && jointTable(shown, against, units, only));
    if (shown && against && last !== shown.id) fall(element);
    last = shown?.id ?? null;
  });
  return {
    element,
    draw: (state) => {
      const { shown, against } = pair(state);
      redraw(brief(shown), brief(against), state.robot?.joints.map((j) => j.torque) ?? []);
    },
  };
}

function brief(step) {
  return step && { id: step.id, name: stepName(step), joints: step.joints, validation: step.validation_rms };
}

function jointTable(shown, against, units, only) {
  const relative = (j) => j.relative_error_percent ?? 0;
  const most = Math.max(...shown.joints.map(relative), 1e-9);
  const rows = shown.joints.map((j, k) => {
    const was = against?.joints[k] ?? null;
    const start = was?.held_out_rms ?? 0;
    const floor = j.repeat_floor_rms;
    const line = was
      ? bar(j.held_out_rms / Math.max(start, 1e-300), `${num(start)} → ${num(j.held_out_rms)} ${units[k]}`, { behind: 1, tone: j.held_out_rms > 1.05 * start ? "warm" : "accent", mark: floor === null ? null : floor / start })
      : bar(relative(j) / most, `${num(j.held_out_rms)} ${units[k]}`, { mark: floor === null ? null : (relative(j) / most) * (floor / j.held_out_rms) });
    const seen = shown.validation?.[j.name] ?? null;
    return [button(j.name, () => only(k), { kind: "link", title: `curves of ${j.name}` }), line, percent(relative(j)), num(floor),
      ...(shown.validation ? [`${against?.validation ? `${num(against.validation[j.name])} → ` : ""}${num(seen)}`] : [])];
  });
  const note = against
    ? h("span", {}, `Grey: ${against.name}. Blue: ${shown.name}; orange where it got worse by more than a twentieth. The thin line is what repetitions of the motion differ by.`)
    : h("span", {}, `${shown.name}, each joint beside the others.`);
  const head = ["joint", h("span", {}, "error ", term("rms"), ", ", term("held out")), term("relative error", "relative"), term("repeat floor", "floor"), ...(shown.validation ? [term("validation")] : [])];
  return card("Joint by joint", { id: "joints", note }, table("Torque error of each joint", head, rows));
}

/** The bars begin where they were and fall to where they are. */
function fall(element) {
  const bars = [...element.querySelectorAll(".fill:not(.behind)")];
  const ends = bars.map((one) => one.style.width);
  for (const one of bars) one.style.width = "100%";
  requestAnimationFrame(() => requestAnimationFrame(() => bars.forEach((one, k) => {
    one.classList.add("falling");
    one.style.width = ends[k];
  })));
}
