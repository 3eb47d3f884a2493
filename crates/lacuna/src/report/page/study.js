// A scenario: identified and retrieved parameters, engines side by side.
import { bar } from "./bars.js";
import { section } from "./answer.js";
import { h, table, term } from "./dom.js";
import { num, percent, unitText } from "./numbers.js";

/** Errors and coefficients of every identification. */
export function identifications(report) {
  if (!report.identifications.length) return null;
  return section("identification", "Identified", null, report.identifications.map((one) => [
    h("h3", {}, `${one.label}: ${one.data.join(", ")}`),
    one.signals.length > 0 && h("ul.note", {}, one.signals.map((s) => h("li", {}, s))),
    table(`Quality of the fit, ${one.label}`, ["", "value"], [
      [h("span", {}, term("relative error"), ", in sample"), percent(one.relative_error_percent)],
      [h("span", {}, term("relative error"), ", ", term("held out")), percent(one.held_out_relative_error_percent)],
      ["how it was held out", one.split ?? "not held out"],
      [term("condition number"), num(one.condition_number, 4)],
      ["rank of the rigid body", String(one.rank)], ["rows", String(one.rows)], ["weighting", one.weighting],
    ], { class: "plain" }),
    jointErrors(one), coefficients(one), one.validation.map((v) => validated(v)),
  ]));
}

function jointErrors(one) {
  if (!one.joints.length) return null;
  const most = Math.max(...one.joints.map((j) => j.held_out_relative_error_percent ?? j.relative_error_percent ?? 0), 1e-9);
  return table(`Error of each joint, ${one.label}`, ["joint", "torque rms [N m, N]", "residual rms [N m, N]", "in sample", "held out", ""],
    one.joints.map((j) => [j.name, num(j.torque_rms), num(j.rms), percent(j.relative_error_percent),
      bar((j.held_out_relative_error_percent ?? j.relative_error_percent ?? 0) / most, percent(j.held_out_relative_error_percent)),
      j.worse_than_constant ? "worse than a constant" : ""]));
}

function validated(v) {
  return table(`${v.data}, never fitted: ${percent(v.relative_error_percent)}`, ["joint", "torque rms [N m, N]", "residual rms [N m, N]", "relative error"],
    v.joints.map((j) => [j.name, num(j.torque_rms), num(j.rms), percent(j.relative_error_percent)]));
}

function coefficients(one) {
  if (!one.coefficients.length) return null;
  const published = one.coefficients.some((c) => c.published !== null);
  return h("details", { open: one.coefficients.length <= 20 }, h("summary", {}, `${one.coefficients.length} identified parameters`),
    table(`Identified parameters, ${one.label}`,
      [term("base parameter", "parameter"), "value", "unit", "standard deviation", h("span", {}, term("standard error", "robust")), ...(published ? ["published"] : []), ""],
      one.coefficients.map((c) => [c.expression, num(c.value, 5), unitText(c.unit), percent(c.relative_sd_percent), percent(c.robust_sd_percent),
        ...(published ? [num(c.published, 5)] : []), c.kept ? "" : "left out"])));
}

export function friction(report) {
  if (!report.friction.length) return null;
  return section("friction", "Friction", null, table("Friction of each joint", ["joint", "effect", "parameters", "residual rms without → with [N m]", ""],
    report.friction.map((f) => [f.joint, f.effect.replaceAll("_", " "), f.parameters.map((p) => `${p.name} ${num(p.value, 4)} ${p.unit}`).join(", "),
      `${num(f.rms[0])} → ${num(f.rms[1])}`, bar(f.rms[1] / Math.max(f.rms[0], 1e-300), "", { behind: 1 })])));
}

/** Engines on the same problem, side by side. */
export function retrievals(data) {
  const report = data.report;
  const found = report.retrievals ?? [];
  if (!found.length && !report.conflict) return null;
  const all = [report.given, ...(report.beside ?? []), ...found, report.chosen?.retrieval].filter(Boolean);
  if (report.conflict || !all.length) return contradiction(report.conflict ?? []);
  const each = (value) => all.map(value);
  const most = Math.max(...each((r) => r.objective));
  const rows = [
    ["engine", ...each((r) => r.engine)],
    [term("feasible"), ...each((r) => (r.feasible ? "yes" : "no"))],
    [term("objective"), ...each((r) => bar(r.objective / most, num(r.objective, 6)))],
    [term("lower bound"), ...each((r) => num(r.lower_bound, 6))],
    [h("span", {}, "certified ", term("gap")), ...each((r) => percent(r.certified_gap_percent))],
    ["the bound is", ...each((r) => r.bound_is ?? "–")],
    [term("violation"), ...each((r) => num(r.violation))],
    ["runs × stages", ...each((r) => `${r.runs} × ${r.stages}`)],
    ["how it ended", ...each((r) => r.status)],
  ];
  return section("retrieval", "Feasible link parameters, engine by engine", `All engines solve the same problem and are judged by the same audit. Objective: ${all[0].objective_unit}.`,
    table("Engines side by side", ["", ...each((r) => r.label)], rows, { class: "left" }),
    all.some((r) => r.bound_is === "relaxation") && h("p.note", {}, "The bound is that of the convex relaxation: the optimum may lie above it."),
    report.chosen && h("p.note", {}, `Chosen: ${report.chosen.rule}, among all with an objective up to ${num(report.chosen.largest_objective, 5)}. The choice decided, not the data: ${report.chosen.decided.join(", ") || "nothing was open"}.`),
    margins(all), links(report, all), leeway(data), errors(report, each((r) => r.label)));
}

function contradiction(conflict) {
  return section("retrieval", "Feasible link parameters", "No parameters satisfy these constraints together; dropping any one of them makes the others possible.",
    h("ul", {}, conflict.map((label) => h("li", {}, label))));
}

function margins(all) {
  const labels = all[0].constraints.map((c) => c.label);
  const rows = labels.map((label, k) => [label, all[0].constraints[k].unit,
    ...all.map((r) => {
      const c = r.constraints.find((one) => one.label === label);
      return h(c && c.margin < 0 ? "td.number.fails" : "td.number", {}, c ? num(c.margin) : "–", c?.active && h("span.tag", {}, "active"));
    })]);
  const active = all.map((r) => `${r.label} ${r.constraints.filter((c) => c.active).length}`).join(", ");
  return h("details", { open: rows.length <= 30 }, h("summary", {}, `${rows.length} constraints; active: ${active}`),
    table("Margins of every constraint", [term("margin", "constraint"), "unit", ...all.map((r) => r.label)], rows));
}

const TENSOR = ["xx", "xy", "xz", "yy", "yz", "zz"];

function links(report, all) {
  const range = new Map((report.intervals ?? []).map((i) => [i.parameter, i]));
  const interval = (name) => {
    const i = range.get(name);
    return i ? `${num(i.low, 4)} to ${num(i.high, 4)}` : "–";
  };
  const rows = [];
  all[0].links.forEach((link, k) => {
    const add = (what, key, unit, value) => rows.push([`${link.name} ${what}`, ...all.map((r) => num(value(r.links[k]), 5)), ...(range.size ? [interval(key)] : []), unit]);
    add("mass", `m${k + 1}`, "kg", (l) => l.mass);
    ["x", "y", "z"].forEach((axis, i) => add(`centre of mass ${axis}`, `c${k + 1}${axis}`, "m", (l) => l.com?.[i] ?? null));
    // Intervals of inertia are about the link origin and stand in their own table.
    TENSOR.forEach((e, i) => add(`inertia ${e}`, "", "kg m²", (l) => l.inertia[i]));
  });
  return h("details", {}, h("summary", {}, `${all[0].links.length} links, ${rows.length} parameters`),
    table("Link parameters of every engine; inertia about the centre of mass", ["parameter", ...all.map((r) => r.label), ...(range.size ? [term("interval")] : []), "unit"], rows));
}

function errors(report, order) {
  const mse = report.comparison?.validation_mse;
  if (!mse || !Object.keys(mse).length) return null;
  const labels = order.filter((label) => mse[label]);
  const { joints, data, fitted, relative_error_percent: all } = report.comparison;
  const rows = joints.map((joint) => [joint, ...labels.map((l) => num(mse[l][joint], 4))]);
  rows.push([h("span", {}, term("relative error"), " of all joints"), ...labels.map((l) => percent(all[l]))]);
  return table(`Mean squared torque error through Newton-Euler [(N m)²] on ${data} (${fitted ? "fitted" : "never fitted"})`, ["joint", ...labels], rows);
}

/** What data and constraints leave open. */
function leeway(data) {
  const all = data.report.intervals ?? [];
  if (!all.length) return null;
  const open = new Set(data.open);
  const rows = all.map((i) => [i.parameter, num(i.low, 5), num(i.high, 5), unitText(i.unit), open.has(i.parameter) ? "left open: constraints and prior decide" : "determined by data and constraints"]);
  return h("details", { open: rows.length <= 30 }, h("summary", {}, `${all.length} intervals; ${data.open.length} parameters are left open`),
    table("All values that data and constraints leave open; inertia J about the link origin", [term("interval", "parameter"), "low", "high", "unit", "what decides"], rows));
}

export function warnings(report) {
  return report.warnings.length ? section("warnings", "What deserves attention", null, h("ul", {}, report.warnings.map((w) => h("li", {}, w)))) : null;
}
