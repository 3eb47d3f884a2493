// The page: reads the data, builds the sections, explains terms, follows light and dark.
import { doubts, jointTable, ladder, missing, opening, ranking, section, signals } from "./answer.js";
import { repaint } from "./canvas.js";
import { maps, partials, torque } from "./curves.js";
import { h } from "./dom.js";
import { friction, identifications, retrievals, warnings } from "./study.js";

/** Names in the list of sections, where the title is too long for it. */
const SHORT = { missing: "Missing", joints: "Joints", torque: "Torque", where: "Where", effects: "Effects", doubts: "Doubts", retrieval: "Link parameters" };

function explanation(data, key) {
  if (!key.startsWith("effect:")) return data.glossary[key] ?? "";
  const [title, text, equation] = data.catalogue[key.slice(7)] ?? ["a shape that was found in these data", "", ""];
  return [title, text, equation].filter(Boolean).join("\n");
}

/** One tip for all terms, on hover and on focus. */
function explain(data) {
  const tip = document.getElementById("tip");
  const show = (event) => {
    const word = event.target.closest?.("[data-term]");
    if (!word) return;
    const text = explanation(data, word.dataset.term);
    if (!text) return;
    tip.textContent = text;
    tip.hidden = false;
    word.setAttribute("aria-describedby", "tip");
    const box = word.getBoundingClientRect();
    const left = Math.min(Math.max(8, box.left), document.documentElement.clientWidth - tip.offsetWidth - 8);
    const below = box.bottom + tip.offsetHeight + 12 < window.innerHeight;
    tip.style.left = `${left}px`;
    tip.style.top = `${below ? box.bottom + 6 : box.top - tip.offsetHeight - 6}px`;
  };
  const hide = (event) => {
    event?.target?.closest?.("[data-term]")?.removeAttribute("aria-describedby");
    tip.hidden = true;
  };
  document.addEventListener("pointerover", (e) => (e.target.closest?.("[data-term]") ? show(e) : hide(e)));
  document.addEventListener("focusin", show);
  document.addEventListener("focusout", hide);
  document.addEventListener("keydown", (e) => e.key === "Escape" && hide());
  document.addEventListener("scroll", () => hide(), { passive: true });
}

function glossary(data) {
  const used = [...new Set([...document.querySelectorAll("[data-term]")].map((e) => e.dataset.term))];
  const text = (key) => key.replace("effect:", "").replaceAll("_", " ");
  const entries = used.filter((key) => explanation(data, key)).sort((a, b) => text(a).localeCompare(text(b)));
  return section("glossary", "Glossary", null, h("details", {}, h("summary", {}, `${entries.length} terms`),
    h("dl", {}, entries.map((key) => [h("dt", {}, text(key)), h("dd", {}, explanation(data, key))]))));
}

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

/** Follows the reader's preference; paper is always light. */
function followScheme() {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const print = window.matchMedia("print");
  const set = () => {
    document.documentElement.dataset.scheme = dark.matches && !print.matches ? "dark" : "light";
    repaint();
  };
  dark.addEventListener("change", set);
  print.addEventListener("change", set);
  window.addEventListener("beforeprint", () => {
    document.documentElement.dataset.scheme = "light";
    repaint();
  });
  window.addEventListener("afterprint", set);
  set();
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
