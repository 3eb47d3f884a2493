// Link parameters that a body can have: rules, engines, the search as it runs, and what the engines found.
import { Refused, post } from "/bench/api.js";
import { Editor } from "/bench/editor.js";
import { attempt, button, card, duration, renew, whenChanged } from "/bench/parts.js";
import { stepName } from "/bench/model.js";
import { choice, h, term } from "/page/dom.js";
import { num, percent } from "/page/numbers.js";
import { LinePlot } from "/page/plot.js";
import { retrievals } from "/page/study.js";
import { TimeAxis } from "/page/time_axis.js";

export function parametersView(study) {
  const wanted = { engines: new Set(["lmi", "penalty"]), runs: 5, intervals: false };
  const editor = new Editor({ label: "rules", rows: 14 });
  const [refused, tools, found] = [h("div"), h("div"), h("div")];
  const run = runCard();
  const keep = () => attempt(refused, async () => {
    try {
      await post("/api/constraints", { text: editor.text });
      editor.show([], "these rules are in use");
      return true;
    } catch (error) {
      if (!(error instanceof Refused) || error.line === null) throw error;
      editor.show([error]);
      return null;
    }
  });
  const begin = async () => {
    if (await keep()) await attempt(refused, () => post("/api/retrieve", { engines: [...wanted.engines], runs: wanted.runs, stages: null, intervals: wanted.intervals }));
  };
  const element = h("div.view", { id: "view-parameters" }, h("header.verdict", {}, h("h1", {}, "Link parameters that a body can have"),
    h("p.note", {}, "Joint torque only reveals combinations of link parameters. Say what every link must satisfy, and engines look for the ones that agree best with the model on show; they are judged by the same audit.")),
  h("div.retrieving", {}, card("Rules", { id: "rules", note: "One per line, as in a scenario. Scripts of yours stand among them." }, editor.element, tools, refused), run.element), found);
  const drawTools = whenChanged((facts) => renew(tools, controls(facts, wanted, editor, { keep, begin })));
  const drawRules = whenChanged((constraints) => {
    editor.text = constraints.text;
    editor.show(constraints.problems);
  });
  return {
    element,
    draw: (state) => {
      drawRules(state.constraints);
      drawTools({ kinds: state.constraint_kinds ?? [], engines: state.engine_kinds ?? [], ready: state.shown !== null, running: state.retrieval?.running ?? false });
      run.draw(state);
    },
    drawProgress: (progress) => run.progress(progress),
    drawResults: (page) => renew(found, page?.report && retrievals(page)),
  };
}

function controls(facts, wanted, editor, { keep, begin }) {
  const engine = ({ name, title, takes }) => {
    const box = h("input", { type: "checkbox", checked: wanted.engines.has(name), onchange: () => (box.checked ? wanted.engines.add(name) : wanted.engines.delete(name)) });
    return h("label.chip", { title: `${title}; takes ${takes}` }, box, name);
  };
  const runs = h("input", { type: "number", min: "1", max: "200", step: "1", value: wanted.runs, onchange: () => { wanted.runs = Math.max(1, Math.round(Number(runs.value)) || 1); } });
  const box = h("input", { type: "checkbox", checked: wanted.intervals, onchange: () => { wanted.intervals = box.checked; } });
  const insert = (name) => {
    const kind = facts.kinds.find((k) => k.name === name);
    if (!kind) return;
    const end = editor.text.lastIndexOf("]");
    const before = editor.text.slice(0, end).trimEnd();
    const comma = /[[,]$/.test(before) ? "" : ",";
    editor.text = `${before}${comma}\n    ${kind.template}\n${editor.text.slice(end)}`;
    editor.show([], "not in use yet");
  };
  return [
    h("div.tools", {},
      facts.kinds.length > 0 && choice("insert a rule", [["", "choose"], ...facts.kinds.map((k) => [k.name, `${k.name}: ${k.title}`])], "", insert),
      button("Use these rules", keep, { key: "keep", disabled: facts.running })),
    h("div.tools", {}, h("fieldset.chips", {}, h("legend.hidden", {}, "engines"), facts.engines.map(engine)),
      h("label.choice", {}, h("span", {}, "runs of penalty"), runs), h("label.chip", {}, box, term("interval", "intervals")),
      button("Look for link parameters", begin, { kind: "main", key: "begin", disabled: !facts.ready || facts.running })),
  ];
}

/** The search as it runs. */
function runCard() {
  const element = h("div");
  const holder = h("div");
  const plot = { axis: new TimeAxis(0, 1), line: null };
  const [figures, bar] = [h("div.figures"), h("progress", { max: "1", "aria-label": "progress of the search" })];
  const frame = whenChanged((facts) => {
    if (!facts) return renew(element);
    return renew(element, card(facts.running ? "Searching" : facts.stopped ? "Stopped: the best so far was kept" : "Searched", { id: "search", note: `${facts.name}; engines ${facts.engines.join(", ")}`,
      tools: facts.running && button("Stop", () => post("/api/stop").catch(() => {}), { key: "stop-search" }) },
    facts.running && bar, figures, holder, facts.conflict && conflict(facts.conflict)));
  });
  const history = whenChanged((points) => drawHistory(plot, holder, points));
  const progress = (r) => {
    if (!r) return;
    if (r.fraction !== null && r.fraction !== undefined) bar.value = r.fraction;
    const one = (label, value) => h("div.figure", {}, h("span.label", {}, label), h("span.big", {}, value));
    renew(figures, one("engine", r.engine ?? "–"), one(term("objective"), num(r.objective, 6)), one(term("violation"), num(r.violation)), r.seconds_left ? one("left", duration(r.seconds_left)) : null);
  };
  return {
    element, progress,
    draw: (state) => {
      const r = state.retrieval;
      const step = r && state.steps.find((s) => s.id === r.step);
      frame(r && { running: r.running, stopped: r.stopped, engines: r.engines, name: step ? stepName(step) : "", conflict: r.conflict ?? null });
      if (r?.running) progress({ ...r, fraction: state.job?.fraction, seconds_left: state.job?.seconds_left });
      else if (r) renew(figures, outcome(r));
      history(r?.history ?? []);
    },
  };
}

function outcome(r) {
  return r.results.map((one) => h("div.figure", {}, h("span.label", {}, one.label), h("span.big", {}, num(one.objective, 6)),
    h("span.note", {}, one.feasible ? "feasible" : "not feasible", one.certified_gap_percent === null ? "" : `, gap ${percent(one.certified_gap_percent)}`)));
}

function conflict(labels) {
  return h("div.caution", { role: "alert" }, "No parameters satisfy these rules together; without any one of them the others can hold:", h("ul", {}, labels.map((l) => h("li", {}, l))));
}

/** The best objective so far over time, on a logarithmic scale where it spans more than a decade. */
function drawHistory(plot, holder, points) {
  plot.line?.remove();
  plot.line = null;
  holder.replaceChildren();
  const good = points.filter((p) => p[1] > 0);
  if (good.length < 2 || !(good[0][1] > 1.001 * good.at(-1)[1])) return;
  const [first, last] = [good[0][0], good.at(-1)[0]];
  const dt = Math.max((last - first) / 400, 1e-3);
  let k = 0;
  const low = Float32Array.from({ length: Math.floor((last - first) / dt) + 1 }, (_, i) => {
    while (k + 1 < good.length && good[k + 1][0] <= first + i * dt) k += 1;
    return Math.log10(good[k][1]);
  });
  plot.axis.renew(first, Math.max(last, first + dt));
  const field = h("div");
  holder.append(field);
  plot.line = new LinePlot(field, { axis: plot.axis, unit: "log10 objective", height: 140, label: `best objective so far, from ${num(good[0][1])} to ${num(good.at(-1)[1])}`, series: [{ low, tone: "accent", label: "objective", start: first, dt }] });
}
