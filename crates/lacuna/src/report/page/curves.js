// Curves and maps of a diagnosis or a fitted study.
import { effectName, section, words } from "./answer.js";
import { asTable, choice, h, table, term } from "./dom.js";
import { cells, HeatMap, largest, Scale } from "./heat.js";
import { floats, num, rms } from "./numbers.js";
import { PartialPlot } from "./partial.js";
import { LinePlot, reading } from "./plot.js";
import { TimeAxis } from "./time_axis.js";

const TONES = ["before", "accent"];

/** Base64 becomes numbers when it is first needed, and stays. */
function lazily(holder, key, make) {
  holder.kept ??= new Map();
  if (!holder.kept.has(key)) holder.kept.set(key, make());
  return holder.kept.get(key);
}

function line(trace, series, tone, label, width) {
  const { low, high } = lazily(series, "floats", () => ({ low: floats(series.low), high: series.high && floats(series.high) }));
  return { tone, label, width, start: trace.start_s, dt: trace.dt_s * series.every, low, high };
}

function tones(p) {
  return p.models.length > 1 ? TONES : ["accent"];
}

/** Joints by the error that was left at first, worst first. */
function worstFirst(data) {
  const d = data.diagnosis;
  const count = data.pictures.joints.length;
  const order = [...Array(count).keys()];
  if (!d) return order;
  const gain = (k) => d.joints[k].held_out_rms / Math.max(d.joints[k].repeat_floor_rms ?? d.joints[k].torque_rms, 1e-12);
  order.sort((a, b) => gain(b) - gain(a));
  const first = d.joints.findIndex((j) => j.name === d.first?.joint);
  return first < 0 ? order : [first, ...order.filter((k) => k !== first)];
}

/** The log that is shown first: one that was fitted. */
function firstLog(p) {
  return Math.max(0, p.traces.findIndex((t) => t.role === "fitted"));
}

/**
 * Torque of every joint over time, and what is left of it. What the reader has chosen is kept in `state`, so that
 * other data may be drawn with the same; `state.order` is that of the joints, `state.brush` says that dragging marks a span of `state.axis`.
 */
export function torque(data, state = {}) {
  const p = data.pictures;
  const order = state.order ?? worstFirst(data);
  state.axis ??= new TimeAxis(0, 1);
  state.shown ??= new Set(order.slice(0, 2));
  state.plots?.forEach((plot) => plot.remove());
  state.plots = [];
  state.unwatch?.();
  const { axis } = state;
  const list = h("div.joints");
  const where = h("span.span", { "aria-live": "polite" });
  const rebuild = () => {
    state.plots.forEach((plot) => plot.remove());
    state.plots = [];
    const made = order.filter((k) => state.shown.has(k)).map((k) => jointFigure(data, state, axis, k));
    list.replaceChildren(...made);
  };
  const load = (index) => {
    state.trace = Number(index);
    const t = p.traces[state.trace];
    const domain = [t.start_s, t.start_s + t.dt_s * Math.max(t.rows - 1, 1)];
    if (axis.domain.some((end, k) => end !== domain[k])) axis.renew(...domain);
    rebuild();
    state.loaded?.(state.trace);
  };
  const spanned = () => {
    const [a, b] = axis.view;
    where.textContent = `${num(a, 4)} to ${num(b, 4)} s of ${num(axis.domain[0], 4)} to ${num(axis.domain[1], 4)} s`;
  };
  state.unwatch = axis.watch(spanned);
  const drag = state.brush ? "Drag to mark a span and read it" : "Drag to zoom";
  const note = h("span", {}, `All plots share one time axis. ${drag}, shift-drag to move, double-click to see all; with a plot in focus the wheel zooms, and the keys + − ← → and Home do the same. `,
    term("envelope", "Nothing is left out"), ".");
  const result = section("torque", "Torque, measured and modelled", note, legend(p, data.diagnosis?.joints.some((j) => j.repeat_floor_rms !== null)),
    h("div.tools", {}, traceChoice(p, state, load), jointChoice(p, state, rebuild), zoomButtons(axis), where), list);
  load(Math.min(state.trace ?? firstLog(p), p.traces.length - 1));
  spanned();
  return result;
}

function traceChoice(p, state, load) {
  if (p.traces.length < 2) return h("span.choice", {}, `${p.traces[0].name} (${p.traces[0].role})`);
  return choice("log", p.traces.map((t, k) => [k, `${t.name} (${t.role})`]), state.trace ?? firstLog(p), load);
}

function jointChoice(p, state, rebuild) {
  const boxes = p.joints.map(([name], k) => {
    const box = h("input", { type: "checkbox", checked: state.shown.has(k), onchange: () => {
      if (box.checked) state.shown.add(k);
      else state.shown.delete(k);
      rebuild();
    } });
    return [box, h("label.chip", {}, box, name)];
  });
  const all = h("button", { type: "button", onclick: () => {
    const every = state.shown.size < p.joints.length;
    boxes.forEach(([box], k) => {
      box.checked = every;
      if (every) state.shown.add(k);
      else state.shown.delete(k);
    });
    rebuild();
  } }, "all");
  return h("fieldset.chips", {}, h("legend.hidden", {}, "joints shown"), boxes.map(([, chip]) => chip), all);
}

function zoomButtons(axis) {
  const button = (text, title, act) => h("button", { type: "button", "aria-label": title, title, onclick: act }, text);
  return h("span.buttons", {},
    button("←", "earlier", () => axis.pan(-0.5)), button("→", "later", () => axis.pan(0.5)),
    button("+", "zoom in", () => axis.zoom(0.5)), button("−", "zoom out", () => axis.zoom(2)),
    button("all", "whole log", () => axis.reset()));
}

function legend(p, floors) {
  const item = (tone, text) => h("li", {}, h(`span.swatch.${tone}`, { "aria-hidden": "true" }), text);
  return h("ul.legend", {}, item("measured", "measured"),
    p.models.map(([label, heldOut], k) => item(tones(p)[k], `${label}${heldOut ? " (held out)" : ""}`)),
    floors && item("band", "shaded in the residual: what repetitions differ by"));
}

function jointFigure(data, state, axis, k) {
  const p = data.pictures;
  const [name, , unit] = p.joints[k];
  const t = p.traces[state.trace];
  const colours = tones(p);
  const models = p.models.map(([label], m) => line(t, t.models[m][k], colours[m], label));
  const left = p.models.map(([label], m) => line(t, t.residuals[m][k], colours[m], label));
  const measured = line(t, t.measured[k], "measured", "measured", 1.6);
  const [above, below] = [h("div"), h("div")];
  const bands = data.diagnosis?.events.map((e) => ({ from: e.from_s, to: e.to_s })) ?? [];
  const level = data.diagnosis?.joints[k].repeat_floor_rms ?? null;
  const read = h("span.reading", { "aria-hidden": "true" });
  const summary = summarise(p, t, k, left);
  const figure = h("figure", {}, h("figcaption", {}, h("h3", {}, name), read), above, below,
    h("p.note", {}, summary), asTable(`${name} as a table`, () => slices(p, t, k, measured, left)));
  const top = new LinePlot(above, { axis, unit, times: false, height: 130, bands, brush: state.brush, series: [measured, ...models],
    label: `torque of ${name} over time. ${summary}` });
  const bottom = new LinePlot(below, { axis, unit, height: 110, bands, level, brush: state.brush, series: left,
    label: `residual of ${name} over time: measured minus model. ${summary}` });
  const unwatch = axis.watch(() => {
    const at = axis.cursor;
    if (at === null) return void (read.textContent = "");
    const [torqueAt] = top.valuesAt(at);
    const errors = bottom.valuesAt(at).map((v) => reading(v, unit)).join(" → ");
    read.textContent = `${num(at, 5)} s   measured ${reading(torqueAt, unit)}   residual ${errors}`;
  });
  state.plots.push(top, bottom, { remove: unwatch });
  return figure;
}

function bounds(series) {
  let most = 0;
  let at = 0;
  const high = series.high ?? series.low;
  for (let i = 0; i < series.low.length; i++) {
    const size = Math.max(Math.abs(series.low[i]), Math.abs(high[i]));
    if (size > most) [most, at] = [size, i];
  }
  return [most, series.start + at * series.dt];
}

function pointsOf(t, key) {
  return lazily(t.points, key, () => {
    const [kind, a, b] = key.split(":");
    if (kind === "residual") return floats(t.points.residuals[a][b]);
    return floats(kind === "channel" ? t.points.channels[a] : t.points[kind][a]);
  });
}

function summarise(p, t, k, left) {
  const unit = p.joints[k][2];
  const part = p.models.map(([label], m) => {
    const [most, at] = bounds(left[m]);
    return `${label}: residual rms ${num(rms(pointsOf(t, `residual:${m}:${k}`)))} ${unit}, at most ${num(most)} ${unit} at ${num(at, 4)} s`;
  });
  return `${part.join("; ")}.`;
}

/** The picture as numbers: a row per twentieth of the log. */
function slices(p, t, k, measured, left) {
  const parts = 20;
  const unit = p.joints[k][2];
  const rows = [...Array(parts).keys()].map((i) => {
    const part = (s) => [Math.floor((s.low.length * i) / parts), Math.floor((s.low.length * (i + 1)) / parts)];
    const [a, b] = part(measured);
    const high = measured.high ?? measured.low;
    const from = measured.start + a * measured.dt;
    const points = (m) => pointsOf(t, `residual:${m}:${k}`);
    const cut = (v) => v.subarray(Math.floor((v.length * i) / parts), Math.floor((v.length * (i + 1)) / parts));
    return [`${num(from, 4)} to ${num(measured.start + b * measured.dt, 4)}`,
      num(Math.min(...measured.low.subarray(a, b))), num(Math.max(...high.subarray(a, b))),
      ...left.map((_, m) => num(rms(cut(points(m)))))];
  });
  return table(`${p.joints[k][0]}: torque and residual by parts of the log`,
    ["time [s]", `least torque [${unit}]`, `largest torque [${unit}]`, ...p.models.map(([l]) => `residual rms, ${l} [${unit}]`)], rows);
}

/** Variables that a reader may choose, with where their values are. */
function variables(p, joint) {
  const all = [];
  const t = p.traces[0];
  p.joints.forEach(([name, position], j) => {
    all.push([`q:${j}`, `position of ${name} [${position}]`, `q${j + 1}`],
      [`dq:${j}`, `speed of ${name} [${position}/s]`, `dq${j + 1}`],
      [`ddq:${j}`, `acceleration of ${name} [${position}/s²]`, `ddq${j + 1}`]);
  });
  all.push([`load:${joint}`, `load: torque of ${p.joints[joint][0]} [${p.joints[joint][2]}]`, "load"], ["time", "time [s]", "time"]);
  Object.keys(t.points.channels).forEach((c) => all.push([`channel:${c}`, c, c]));
  return all;
}

function valuesOf(t, key) {
  if (key !== "time") return pointsOf(t, key);
  return lazily(t.points, "time", () => {
    const n = pointsOf(t, "load:0").length;
    return Float32Array.from({ length: n }, (_, i) => t.start_s + i * t.dt_s * t.points.every);
  });
}

/** Where the models fail: the residual over any two variables. `kept` holds what the reader has chosen. */
export function maps(data, kept = {}) {
  const p = data.pictures;
  const first = (kept.order ?? worstFirst(data))[0];
  const region = data.diagnosis?.regions.find((r) => r.joint === p.joints[first][0]);
  const named = (name, otherwise) => variables(p, first).find((v) => v[2] === name)?.[0] ?? otherwise;
  const depends = data.diagnosis?.unexplained.find((u) => u.joint === p.joints[first][0])?.depends_on[0];
  const state = { joint: first, x: named(depends ?? `q${first + 1}`, `q:${first}`), y: `dq:${first}`, kind: "rms", trace: firstLog(p) };
  if (region && !depends) state.x = named(region.variable, state.x);
  if (state.x === state.y) state.x = `q:${first}`;
  Object.assign(state, kept.chosen);
  kept.chosen = state;
  state.trace = Math.min(state.trace, p.traces.length - 1);
  kept.maps?.forEach((map) => map.remove());
  const holders = p.models.map(() => h("div"));
  const [scale, tell, worst, tools] = [h("div.scale"), h("p.reading", { "aria-live": "polite" }), h("div"), h("div.tools")];
  const made = { maps: null, scale: null };
  const draw = () => drawMaps(data, state, { holders, scale, tell, worst, made, kept });
  const set = (key) => (value) => {
    const [was, now] = [state.joint, key === "joint" || key === "trace" ? Number(value) : value];
    state[key] = now;
    if (key === "joint") {
      for (const axis of ["x", "y"]) state[axis] = state[axis].replace(/^(q|dq|ddq|load):(\d+)$/, (all, kind, j) => (Number(j) === was ? `${kind}:${now}` : all));
      controls();
    }
    draw();
  };
  const controls = () => {
    const options = variables(p, state.joint).map(([key, label]) => [key, label]);
    tools.replaceChildren(...[
      choice("residual of", p.joints.map(([name], k) => [k, name]), state.joint, set("joint")),
      choice("over", options, state.x, set("x")), choice("and", options, state.y, set("y")),
      choice("as", [["rms", "rms"], ["mean", "mean, with sign"]], state.kind, set("kind")),
      p.traces.length > 1 && choice("log", p.traces.map((t, k) => [k, `${t.name} (${t.role})`]), state.trace, set("trace")),
    ].filter(Boolean));
  };
  controls();
  const figures = p.models.map(([label], m) => h("figure", {}, h("figcaption", {}, h("h3", {}, label)), holders[m]));
  const result = section("where", "Where it fails", `Residual${p.models[0][1] ? ", held out," : ""} over any two variables; empty where fewer than three rows lie. The maps share one scale. Arrow keys read single cells${kept.brush ? "; drag over cells, or Enter and Shift-Enter, to read what lies in them" : ""}.`,
    tools, h("div.pair", {}, figures), scale, tell, worst, regions(data));
  queueMicrotask(draw);
  return result;
}

function drawMaps(data, state, { holders, scale, tell, worst, made, kept }) {
  const p = data.pictures;
  const t = p.traces[state.trace];
  const unit = p.joints[state.joint][2];
  const all = variables(p, state.joint);
  const name = (key) => all.find((v) => v[0] === key)?.[1] ?? key;
  const shortName = (key) => all.find((v) => v[0] === key)?.[2] ?? key;
  const [x, y] = [valuesOf(t, state.x), valuesOf(t, state.y)];
  // Few rows want large cells.
  const side = Math.max(8, Math.min(28, Math.round(Math.sqrt(x.length / 6))));
  const grids = p.models.map((_, m) => cells(x, y, pointsOf(t, `residual:${m}:${state.joint}`), Math.round(1.3 * side), side));
  const most = Math.max(...grids.map((g) => largest(g, state.kind)), 1e-12);
  const options = grids.map((grid, m) => ({ grid, kind: state.kind, most, unit, x: { label: name(state.x) }, y: { label: name(state.y) },
    label: `${state.kind} of the residual of ${p.joints[state.joint][0]}, ${p.models[m][0]}, over ${name(state.x)} and ${name(state.y)}; arrow keys read cells`,
    tell: (text) => { tell.textContent = text; },
    brush: kept.brush && ((ranges) => kept.brush({ ...ranges, names: [shortName(state.x), shortName(state.y)], units: [name(state.x), name(state.y)], joint: p.joints[state.joint][0], trace: state.trace })) }));
  if (made.maps) made.maps.forEach((map, m) => map.setOptions(options[m]));
  else made.maps = holders.map((holder, m) => new HeatMap(holder, options[m]));
  kept.maps = made.maps;
  if (made.scale) made.scale.setOptions({ kind: state.kind, most, unit: `${unit} ${state.kind}` });
  else made.scale = new Scale(scale, { kind: state.kind, most, unit: `${unit} ${state.kind}` });
  worst.replaceChildren(asTable("worst cells as a list", () => h("ol", {}, made.maps[0].worst(10).map((c) => h("li", {}, made.maps[0].describe(c))))));
}

function regions(data) {
  const all = data.diagnosis?.regions ?? [];
  if (!all.length) return null;
  const row = (r) => [r.joint, r.variable, `${num(r.from)} to ${num(r.to)}`, num(r.rms), String(r.rows), num(r.z)];
  return h("details", {}, h("summary", {}, "regions where the starting model's error stands out"),
    table("Regions where the starting model fails, worst first", ["joint", "variable", "from, to", "residual rms [N m, N]", "rows", term("z")], all.slice(0, 40).map(row)));
}

/** Each effect against its own variable. */
export function partials(data) {
  const p = data.pictures;
  const found = p.effects.filter((e) => e.found);
  const given = p.effects.filter((e) => !e.found);
  if (!p.effects.length) return null;
  const draw = (list) => h("div.grid", {}, list.map((e) => partialFigure(p, e)));
  const more = given.length > 0 && asTable(found.length || data.diagnosis ? `${given.length} effects of the starting model` : `${given.length} effects of the model`, () => draw(given));
  const note = h("span", {}, term("partial residual", "Partial residuals"), ": dots are means of neighbouring rows, the grey band holds eight tenths of them, the blue line is the effect as fitted. Dots off the line mean that the shape is not right.");
  return section("effects", "Each effect against its own variable", note, draw(found), more);
}

function partialFigure(p, e) {
  const [name, , unit] = p.joints[e.joint];
  const holder = h("div");
  const alternative = h("div");
  let plot = null;
  const show = (index) => {
    const one = e.partials[index];
    const of = (key) => lazily(one, key, () => floats(one[key]));
    const title = one.unit ? `${one.variable} [${one.unit}]` : one.variable;
    const options = { at: of("at"), mean: of("mean"), low: of("low"), high: of("high"), curve: of("curve"), x: title, unit,
      label: `partial residual of ${words(e.effect)} on ${name} against ${title}; the values stand in the table below` };
    if (plot) plot.setOptions(options);
    else plot = new PartialPlot(holder, options);
    alternative.replaceChildren(asTable("as a table", () => partialTable(e, one, title, of, unit)));
  };
  const pick = choice("against", e.partials.map((v, k) => [k, v.variable]), 0, (k) => show(Number(k)));
  const figure = h("figure", {}, h("figcaption", {}, h("h3", {}, effectName(e.effect), h("span.where", {}, ` on ${name}`)), pick), holder, alternative);
  show(0);
  return figure;
}

function partialTable(e, one, title, of, unit) {
  const rows = [...of("at")].map((at, k) => [num(at), num(of("mean")[k]), num(of("low")[k]), num(of("high")[k]), num(of("curve")[k]), String(one.rows[k])]);
  return table(`${words(e.effect)}: partial residual`, [title, `mean [${unit}]`, "a tenth below", "a tenth above", "fitted", "rows"], rows);
}
