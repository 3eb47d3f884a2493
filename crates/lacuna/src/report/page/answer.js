// The answer of a diagnosis: what is missing, what it would bring, what cannot be told.
import { bar } from "./bars.js";
import { h, table, term } from "./dom.js";
import { measured, num, percent, unitText } from "./numbers.js";

/** A name for people. */
export const words = (name) => name.replaceAll("_", " ");
/** Unit of a joint's torque. */
const unitOf = (data, name) => data.pictures?.joints.find((j) => j[0] === name)?.[2] ?? "N m";
const joints = (list) => (list.length ? list.join(", ") : "the whole robot");

/** A section with its title. */
export function section(id, title, note, ...content) {
  return h("section", { id, "aria-labelledby": `${id}-title` },
    h("h2", { id: `${id}-title` }, title), note && h("p.note", {}, note), ...content);
}

/** Name of an effect with its text from the catalogue on hover. */
export function effectName(name) {
  return term(`effect:${name}`, words(name));
}

function figure(label, before, after) {
  return h("div.figure", {}, h("span.label", {}, label),
    h("span.big", {}, before, after !== null && [h("span.arrow", {}, " → "), h("b", {}, after)]));
}

/** The sentence, and the few numbers that carry it. */
export function opening(data) {
  const d = data.diagnosis;
  const last = data.pictures?.climb.at(-1)?.held_out_relative_error_percent ?? null;
  const figures = d && [
    figure(term("held out", "error, held out"), percent(d.baseline.held_out_relative_error_percent),
      last === null ? null : percent(last)),
    d.validation && figure(term("validation", "error on a log never fitted"),
      percent(d.validation.before_relative_error_percent), percent(d.validation.after_relative_error_percent)),
    figure(term("band"), `${num(d.signals.band_hz)} Hz`, null),
    figure("rows per joint", String(d.signals.rows_used), null),
  ];
  return h("header", { id: "content" },
    h("p.kicker", {}, `${data.title} · lacuna ${data.lacuna}`),
    h("h1", {}, sentence(data.verdict[0])),
    data.verdict.slice(1).map((line) => h("p.note", {}, sentence(line))),
    d?.undecided.map((u) => h("p.caution", {}, `${u.reason}. Record ${u.record}.`)),
    figures && h("div.figures", {}, figures));
}

function sentence(line) {
  return line.charAt(0).toUpperCase() + line.slice(1) + ".";
}

/** One card per missing effect, then what has no name. */
export function missing(data) {
  const d = data.diagnosis;
  if (!d.missing.length && !d.minor.length && !d.unexplained.length) return null;
  const most = Math.max(...d.missing.map((m) => m.gain_percent), 1e-9);
  return section("missing", "What is missing", "Most important first. Everything was fitted again with each effect; gains are counted in data that the fit had not seen.",
    d.missing.map((m) => card(data, m, most)), d.unexplained.map(unknown),
    d.minor.length > 0 && h("details", {}, h("summary", {}, `${d.minor.length} more, significant but small`),
      d.minor.map((m) => card(data, m, most))));
}

function card(data, m, most) {
  return h("article.card", {},
    h("h3", {}, effectName(m.effect), h("span.where", {}, ` on ${joints(m.joints)}`)),
    h("p.equation", {}, m.equation),
    h("div.pair", {},
      h("div", {}, table(`Numbers of ${words(m.effect)}`, ["", "value", "unit"],
        m.parameters.map((p) => [p.name, measured(p.value, p.standard_error, "").trim(), unitText(p.unit)]), { class: "plain" })),
      h("div", {},
        h("p", {}, term("gain"), " ", bar(m.gain_percent / most, percent(m.gain_percent))),
        h("p", {}, term("z"), ` ${num(m.z)}`, ` · ${m.where}`),
        beforeAfter(data, m.held_out_rms),
        m.also_possible.length > 0 && h("p.caution", {}, term("also possible"), `: ${m.also_possible.map(words).join(", ")}`),
        m.caveat && h("p.caution", {}, m.caveat),
        m.remainder && h("p.caution", {}, `left over: ${m.remainder}`))));
}

function beforeAfter(data, rms) {
  const rows = Object.entries(rms);
  if (!rows.length) return null;
  return h("ul.steps", {}, rows.map(([joint, [before, after]]) =>
    h("li", {}, `${joint} `, bar(after / Math.max(before, 1e-300), `${num(before)} → ${num(after)} ${unitOf(data, joint)} rms`, { behind: 1 }))));
}

function unknown(u) {
  return h("article.card.unknown", {},
    h("h3", {}, "no effect of the catalogue", h("span.where", {}, ` on ${u.joint}, ${u.depends_on.length ? `depends on ${u.depends_on.join(", ")}` : "follows no variable of the log"}`)),
    u.formula && h("p.equation", {}, `a shape that fits: ${u.formula}`),
    u.depends_on.length > 0 && h("p", {}, term("z"), ` ${num(u.z)} · explains ${percent(u.gain_percent)} of the joint's held-out squared error`),
    u.floors && h("p", {}, `the error that is left is ${num(u.floors, 2)} times the joint's floor`),
    u.nearest && h("p.note", {}, `nearest known effect: ${words(u.nearest)} of the reducible error`));
}

/** Error of each joint before and after, with the floor that repetitions set. */
export function jointTable(data) {
  const d = data.diagnosis;
  const validated = d.validation?.rms ?? {};
  const rows = d.joints.map((j, k) => [
    j.name, num(j.torque_rms), data.pictures?.joints[k]?.[2] ?? "",
    bar(j.held_out_rms_after / Math.max(j.held_out_rms, 1e-300), `${num(j.held_out_rms)} → ${num(j.held_out_rms_after)}`,
      { behind: 1, mark: j.repeat_floor_rms === null ? null : j.repeat_floor_rms / j.held_out_rms }),
    num(j.repeat_floor_rms), percent(j.relative_error_percent),
    ...(d.validation ? [validated[j.name] ? validated[j.name].map((x) => num(x)).join(" → ") : "–"] : []),
    j.worse_than_constant ? "worse than a constant" : "",
  ]);
  const head = ["joint", h("span", {}, "torque ", term("rms")), "unit", h("span", {}, "error, ", term("held out")),
    term("repeat floor"), h("span", {}, term("relative error"), " before"), ...(d.validation ? [term("validation")] : []), ""];
  return section("joints", "Joint by joint", "Bars: grey is the starting model, blue what is left with everything that was found, the thin line what repetitions of the motion differ by.",
    table("Torque error of each joint, before and after", head, rows));
}

/** The error falling as effects come in. */
export function ladder(data) {
  const steps = data.pictures?.climb ?? data.diagnosis.ladder;
  if (!steps.length) return null;
  const d = data.diagnosis;
  const start = d.baseline.held_out_relative_error_percent;
  const square = (of) => d.joints.reduce((sum, j) => sum + of(j) ** 2, 0);
  const floors = d.joints.every((j) => j.repeat_floor_rms !== null);
  const floor = floors ? 100 * Math.sqrt(square((j) => j.repeat_floor_rms) / square((j) => j.torque_rms)) : null;
  const row = (name, where, error, rms) => [name, where,
    bar(error / start, percent(error), { mark: floor === null ? null : floor / start }),
    ...d.joints.map((j) => num(rms[j.name]))];
  const rows = [
    row("starting model", "", start, Object.fromEntries(d.joints.map((j) => [j.name, j.held_out_rms]))),
    ...steps.map((s) => row(h("span", {}, "+ ", effectName(s.effect)), joints(s.joints), s.held_out_relative_error_percent, s.rms)),
  ];
  const note = floor === null ? "The motion does not repeat, so there is no floor to compare with."
    : `The thin line is the floor that repetitions set, ${percent(floor)}.`;
  return section("ladder", "Ladder", `Pooled held-out error with one effect after the other, in the order in which they were found. ${note}`,
    table("Ladder: held-out error with one effect after the other", ["step", "on", "error of all joints", ...d.joints.map((j) => `${j.name} rms [${unitOf(data, j.name)}]`)], rows));
}

/** Every candidate, whether it won or not. */
export function ranking(data) {
  const all = data.pictures?.ranking ?? [];
  if (!all.length) return null;
  const most = Math.max(...all.map((r) => r.usefulness), 1e-9);
  const rows = all.map((r) => [h("span", {}, effectName(r.effect), h("span.where", {}, ` ${r.symbols.join(", ")}`)), r.joint ?? "the whole robot",
    bar(r.usefulness / most, num(r.usefulness)), percent(r.gain_percent), num(r.z),
    `${num(r.rms[0])} → ${num(r.rms[1])} ${unitOf(data, r.rms_joint)}`, r.rms_joint, status(r, data.diagnosis)]);
  const head = () => ["candidate", "on", h("span", {}, "gain over the ", term("noise floor")), term("gain"), term("z"), "rms before → after", "of", "what became of it"];
  const first = 12;
  return section("candidates", "Candidates", `Every effect of the catalogue beside the starting model, each fitted alone with it, ranked by held-out gain in units of each joint's noise floor. Believed from z ${num(data.diagnosis.gate[0])} on; sign flips of these data reach ${num(data.diagnosis.gate[1])}.`,
    table("Candidates, most useful first", head(), rows.slice(0, first)),
    rows.length > first && h("details", {}, h("summary", {}, `${rows.length - first} more candidates`),
      table("More candidates", head(), rows.slice(first))));
}

function status(r, d) {
  const same = (m) => m.effect === r.effect && (r.joint === null ? m.joints.length === 0 : m.joints.includes(r.joint));
  if (d.missing.some(same) || d.minor.some(same)) return h("b", {}, "named");
  if (d.refused.some(same)) return "refused";
  return r.passes ? "needless beside what was found" : "not significant";
}

/** What fits but cannot be, what cannot be told apart, and what changed. */
export function doubts(d) {
  const parts = [
    d.refused.length > 0 && table("Fits, but refused", ["effect", "on", "why"],
      d.refused.map((r) => [effectName(r.effect), joints(r.joints), r.reason])),
    d.inseparable.length > 0 && table("Cannot be told apart with this motion", ["effects", "a motion that would tell"],
      d.inseparable.map((i) => [`${words(i.effects[0])} and ${i.effects.slice(1).map(words).join(" or ")}`, i.separating_motion])),
    d.events.length > 0 && table("Events", ["what", "from [s]", "to [s]", "force in the base frame [N]"],
      d.events.map((e) => [words(e.kind), num(e.from_s, 4), num(e.to_s, 4), e.force_n.map((f) => num(f)).join(", ")])),
    d.moved.length > 0 && moved(d.moved),
  ].filter(Boolean);
  return parts.length ? section("doubts", "Doubts and consequences", null, parts) : null;
}

function moved(all) {
  const title = "Parameters that moved when the missing effects came in";
  const made = table(title, ["parameter", "before", "after", "unit"],
    all.map((m) => [m.parameter, num(m.before, 4), measured(m.after, m.standard_error, "").trim(), unitText(m.unit)]));
  return all.length <= 12 ? made : h("details", {}, h("summary", {}, `${all.length} parameters moved when the missing effects came in`), made);
}

/** How the signals were prepared: no error means anything without it. */
export function signals(d) {
  const s = d.signals;
  const hz = (x) => (x === null ? "–" : `${num(x)} Hz`);
  const dropped = Object.entries(s.rows_dropped).map(([why, n]) => `${n} ${why}`).join(", ") || "none";
  const rows = [
    ["mode", `${s.mode}: one zero-phase filter on torque and on every model column`],
    [term("band"), hz(s.band_hz)],
    ["source of velocities", s.source_of_velocity],
    ["motion filtered before differentiation", hz(s.position_cutoff_hz)],
    ["velocities inside signs filtered", hz(s.friction_cutoff_hz)],
    ["widths of the smoothed signs", s.sign_width.map((w) => num(w)).join(", ") + " rad/s or m/s"],
    ["cut from both ends", `${num(s.trim_s)} s`],
    ["rows per joint", String(s.rows_used)],
    ["rows left out", dropped],
    ...Object.entries(s.thinned).map(([log, t]) => ["very long log", `${log}: ${t.every > 1 ? `${num(t.to_hz, 4)} Hz of ${num(t.from_hz, 4)} Hz kept after a low-pass, ` : ""}${num(t.rows_hz)} rows per second fitted`]),
    [term("fold", "held out"), s.folds],
    ["starting model", d.baseline.effects.map(words).join(" + ")],
  ];
  return section("signals", "Signals", null, table("Settings of the signal step", ["setting", "value"], rows, { class: "plain" }));
}
