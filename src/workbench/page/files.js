// What can be taken away, and the command that does the same without this page.
import { button, card, renew, whenChanged } from "/bench/parts.js";
import { h } from "/page/dom.js";

const WHAT = {
  "scenario.ron": "repeats this study from the command line",
  "model.ron": "the model on show, for lacuna compare, dynamics and diagnose --model",
  "robot.urdf": "the robot with link parameters that a body can have",
  "robot.mjcf": "the same for MuJoCo",
  "report.html": "everything on one page that fetches nothing",
  "diagnosis.json": "the answer to what is missing, as data",
  "report.json": "results of the search for link parameters, as data",
  "retrieved.ron": "the model with link parameters that a body can have, for lacuna export and dynamics",
  "identified.ron": "the identified coefficients behind them",
  "constraints.ron": "the rules on link parameters",
  "columns.ron": "the column map",
  "steps.json": "every step that was taken here",
};

export function filesView() {
  const holder = h("div");
  const element = h("div.view", { id: "view-files" }, h("header.verdict", {}, h("h1", {}, "Take away")), holder);
  const draw = whenChanged((files, commands, folder) => renew(holder, downloads(files), repeating(commands, folder)));
  return { element, draw: (state) => draw(state.files, state.commands, state.folder) };
}

function downloads(files) {
  if (!files.length) return card("Files", {}, h("p.note", {}, "There is nothing yet: a robot, a log and a first model make the first files."));
  return card("Files", { note: "As they are now; they also lie in the study's folder." }, h("ul.files", {}, files.map((name) =>
    h("li", {}, h("a", { href: `/api/file/${encodeURIComponent(name)}`, download: name }, name), h("span.note", {}, WHAT[name] ?? "a script of this study")))),
  !files.includes("robot.urdf") && h("p.note", {}, "robot.urdf comes with feasible link parameters: see Link parameters."));
}

function repeating(commands, folder) {
  if (!commands.length) return null;
  const said = h("span.where", { role: "status" });
  const copy = (text) => navigator.clipboard.writeText(text).then(() => { said.textContent = " copied"; }, () => { said.textContent = " could not be copied"; });
  return card("Again from the command line", { note: `The study lies in ${folder}. To go on with it another time: lacuna workbench --resume ${folder}` },
    commands.map((text, k) => h("div.command", {}, h("code", { tabindex: "0" }, text), button("Copy", () => copy(text), { key: `copy${k}` }))), said);
}
