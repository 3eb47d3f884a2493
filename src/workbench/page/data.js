// Robot and logs: what was read, what is wrong with it, and how foreign columns become ours.
import { post, upload } from "/bench/api.js";
import { columnsCard } from "/bench/columns.js";
import { attempt, button, card, duration, problemList, renew, whenChanged } from "/bench/parts.js";
import { choice, h, table } from "/page/dom.js";
import { num, percent } from "/page/numbers.js";

const KINDS = [
  ["robot", "Robot", "a URDF, or a Denavit-Hartenberg table in RON", ".urdf,.ron,.xml"],
  ["log", "Log to explain", "CSV with a header: t, q1.., tau1.. ; velocities and more columns welcome; .csv.gz too", ".csv,.gz,.txt"],
  ["validate", "Log that is never fitted", "another motion of the same robot: it shows whether a better fit is a better model", ".csv,.gz,.txt"],
];

export function dataView(study) {
  const onward = h("div");
  const [refused, drops, robot, logs] = [h("div"), h("div.drops"), h("div"), h("div")];
  const columns = columnsCard();
  const act = (path, body) => attempt(refused, () => post(path, body));
  const take = (kind, files) => attempt(refused, async () => {
    for (const file of files) {
      refused.replaceChildren(h("p.note", { role: "status" }, `taking in ${file.name} ..`));
      await upload(kind, file);
    }
    refused.replaceChildren();
  });
  const zones = KINDS.map((kind) => dropZone(kind, take));
  drops.append(...zones.map((zone) => zone.element));
  const element = h("div.view", { id: "view-data" }, h("header.verdict", {}, h("h1", {}, "Robot and logs"),
    h("p.note", {}, "Give the workbench a robot and a log of its motion and torque; the first model is fitted at once. Everything stays on this computer, in the study's folder."), onward), drops, refused, h("div.loading", {}, h("div", {}, robot, logs), columns.element));
  anywhere(element, take);
  const drawOnward = whenChanged((there) => renew(onward, there && button("See what the model says", () => study.go("model"), { kind: "main" })));
  const drawRobot = whenChanged((one) => renew(robot, one && robotCard(one)));
  const drawLogs = whenChanged((all) => renew(logs, all.map((log) => logCard(log, act))));
  return {
    element,
    draw: (state) => {
      const named = (role) => state.logs.filter((l) => l.role === role).map((l) => `${l.usable ? "✓" : l.read === false ? "…" : "!"} ${l.name}`).join("  ");
      [state.robot?.joints.length ? `✓ ${state.robot.name}` : "", named("fit"), named("validate")].forEach((text, k) => zones[k].have(text));
      drawOnward(state.shown !== null);
      drawRobot(state.robot);
      columns.draw(state);
      drawLogs(state.logs);
    },
  };
}

function dropZone([kind, title, what, accept], take) {
  const input = h("input", { type: "file", accept, multiple: kind !== "robot", class: "hidden", "data-kind": kind, "aria-label": title,
    onchange: async () => {
      await take(kind, [...input.files]);
      input.value = "";
    } });
  const now = h("span.now");
  const zone = h("label.drop", { "data-drop": kind }, input, h("b", {}, title), h("span.note", {}, what), now, h("span.pick", { "aria-hidden": "true" }, "Choose a file, or drop it here"));
  const have = (text) => {
    now.textContent = text;
  };
  const over = (is) => (event) => {
    event.preventDefault();
    event.stopPropagation();
    zone.classList.toggle("over", is);
  };
  zone.addEventListener("dragover", over(true));
  zone.addEventListener("dragleave", over(false));
  zone.addEventListener("drop", (event) => {
    over(false)(event);
    take(kind, [...event.dataTransfer.files]);
  });
  return { element: zone, have };
}

/** Whatever is dropped elsewhere on the page is told by its name. */
function anywhere(element, take) {
  element.addEventListener("dragover", (event) => event.preventDefault());
  element.addEventListener("drop", (event) => {
    event.preventDefault();
    for (const file of event.dataTransfer.files) take(/\.(urdf|xml|ron)$/i.test(file.name) ? "robot" : "log", [file]);
  });
}

function robotCard(robot) {
  const kind = (j) => (j.position === "m" ? "slides" : "turns");
  return card(robot.joints.length ? `Robot: ${robot.name}` : "Robot: it cannot be used yet", { id: "robot", note: `${robot.file}, ${robot.joints.length} joints` },
    problemList(robot.problems), remarks(robot.remarks),
    robot.joints.length > 0 && h("details", {}, h("summary", {}, "joints"), table("Joints in the order of the columns", ["joint", "kind", "position in", "torque in"],
      robot.joints.map((j) => [j.name, kind(j), j.position, j.torque]))));
}

function remarks(all) {
  return all.length > 0 && h("ul.remarks", {}, all.map((text) => h("li", {}, text)));
}

function logCard(log, act) {
  const dropped = Object.entries(log.dropped).map(([why, n]) => `${n} ${why}`).join(", ");
  const facts = [`${log.rows} rows`, log.seconds === null ? null : `${num(log.seconds, 4)} s`, log.rate_hz ? `${num(log.rate_hz, 4)} Hz` : null, dropped ? `left out: ${dropped}` : "no row left out"].filter(Boolean).join(" · ");
  const tools = h("div.tools", {},
    choice("used", [["fit", "to fit"], ["validate", "only to check"]], log.role, (role) => act("/api/role", { log: log.id, role })),
    button("Take out", () => act("/api/remove", { log: log.id }), { key: `remove${log.id}`, "aria-label": `Take ${log.name} out` }));
  return card(log.name, { id: `log${log.id}`, note: facts, tools },
    !log.usable && h("p.caution", {}, log.read === false ? "It is being read .." : "It cannot be used yet."),
    problemList(log.problems), findings(log.findings), remarks(log.remarks),
    log.sound && !log.findings.length && h("p.fine", {}, "✓ It belongs to this robot: units, signs, order and mounting agree."),
    log.suggested_map && button("Use the suggested column map", () => act("/api/columns", { text: log.suggested_map }), { kind: "main", key: `suggest${log.id}` }),
    columnTable(log));
}

/** What does not fit between log and robot, and what would mend it. */
function findings(all) {
  if (!all.length) return null;
  return h("ul.problems", {}, all.map((f) => h(`li.${f.severity === "defect" ? "error" : "warning"}`, {}, f.text,
    f.error_percent && h("span", {}, ` (error ${percent(f.error_percent[0])} → ${percent(f.error_percent[1])})`),
    f.remedy && h("span.help", {}, f.remedy),
    f.also_possible.length > 0 && h("span.help", {}, `also possible: ${f.also_possible.join("; ")}`))));
}

function columnTable(log) {
  if (!log.columns.length) return null;
  const rows = log.columns.map((c, k) => [c.header ?? `column ${c.number}`,
    c.meaning === "not read" ? h("span.where", {}, "not read") : `${c.meaning}${c.joint ? ` of ${c.joint}` : ""}`, c.unit || "–",
    ...log.sample.map((row) => h("td.number", {}, row[k] ?? ""))]);
  const heads = ["column", "read as", "unit", ...log.sample.map((_, k) => `row ${k + 1}`)];
  return h("details", { open: (!log.usable && log.read !== false) || log.problems.length > 0 }, h("summary", {}, `${log.columns.length} columns`), table(`Columns of ${log.name}`, heads, rows));
}
