// What words mean, on hover and at the end; light and dark.
import { section } from "./answer.js";
import { repaint } from "./canvas.js";
import { h } from "./dom.js";

function explanation(data, key) {
  if (!key.startsWith("effect:")) return data.glossary[key] ?? "";
  const [title, text, equation] = data.catalogue[key.slice(7)] ?? ["a shape that was found in these data", "", ""];
  return [title, text, equation].filter(Boolean).join("\n");
}

/** One tip for all terms, on hover and on focus. `data` has a `glossary` and a `catalogue`. */
export function explain(data) {
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

/** Every term that the page uses. */
export function glossary(data) {
  const used = [...new Set([...document.querySelectorAll("[data-term]")].map((e) => e.dataset.term))];
  const text = (key) => key.replace("effect:", "").replaceAll("_", " ");
  const entries = used.filter((key) => explanation(data, key)).sort((a, b) => text(a).localeCompare(text(b)));
  return section("glossary", "Glossary", null, h("details", {}, h("summary", {}, `${entries.length} terms`),
    h("dl", {}, entries.map((key) => [h("dt", {}, text(key)), h("dd", {}, explanation(data, key))]))));
}

/** Follows the reader's preference; paper is always light. */
export function followScheme() {
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
