// The page: reads the data, builds the sections.
import { doubts, jointTable, ladder, missing, opening, ranking, signals } from "./answer.js";
import { maps, partials, torque } from "./curves.js";
import { h } from "./dom.js";
import { explain, followScheme, glossary } from "./explain.js";
import { friction, identifications, retrievals, warnings } from "./study.js";

/** Names in the list of sections, where the title is too long for it. */
const SHORT = { missing: "Missing", joints: "Joints", torque: "Torque", where: "Where", effects: "Effects", doubts: "Doubts", retrieval: "Link parameters" };

function sections(data) {
  const { diagnosis: d, report, pictures } = data;
  const drawn = pictures?.traces.length > 0;
  return [
    d && missing(data),
    d && jointTable(data),
    report && warnings(report),
    drawn && torque(data),
    drawn && maps(data),
    drawn && partials(data),
    d && ranking(data),
    d && ladder(data),
    d && doubts(d),
    report && retrievals(data),
    report && identifications(report),
    report && friction(report),
    d && signals(d),
  ].filter(Boolean);
}

function start() {
  const data = JSON.parse(document.getElementById("data").textContent);
  followScheme();
  const made = sections(data);
  const links = made.map((s) => h("li", {}, h("a", { href: `#${s.id}` }, SHORT[s.id] ?? s.querySelector("h2").textContent)));
  document.getElementById("page").replaceChildren(opening(data), h("nav", { "aria-label": "sections" }, h("ul", {}, links)), h("main", {}, made));
  document.querySelector("main").append(glossary(data));
  explain(data);
}

start();
