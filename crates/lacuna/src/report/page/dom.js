// Elements by name. Text is always text: nothing here parses markup.

const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(3).filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

/** `h("td.number", {title: ".."}, "text", child)`. */
export function h(tag, attributes = {}, ...children) {
  const [name, ...classes] = tag.split(".");
  const element = document.createElement(name || "div");
  if (classes.length) element.className = classes.join(" ");
  return fill(element, attributes, children);
}

/** The same in SVG. */
export function svg(name, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

/** A word that the glossary explains on hover and focus. */
export function term(key, label = key) {
  return h("button.term", { type: "button", "data-term": key }, label);
}

/** A table: `head` is a list of cells, `rows` a list of lists; numbers are set right. */
export function table(caption, head, rows, attributes = {}) {
  const cell = (c, i) => {
    if (c instanceof HTMLTableCellElement) return c;
    const number = typeof c === "string" && /^[−+-]?[\d.]+(e[−-]?\d+)?( %| ± [\d.e−]+)?$/.test(c);
    return h(i === 0 ? "th" : number ? "td.number" : "td", i === 0 ? { scope: "row" } : {}, c ?? "–");
  };
  return h("div.scroll", { tabindex: "0", role: "region", "aria-label": caption },
    h("table", attributes,
      h("caption", {}, caption),
      h("thead", {}, h("tr", {}, head.map((c) => h("th", { scope: "col" }, c)))),
      h("tbody", {}, rows.map((row) => h("tr", {}, row.map(cell))))));
}

/** A labelled choice; `options` are `[value, text]`. */
export function choice(label, options, value, change) {
  const select = h("select", { onchange: () => change(select.value) },
    options.map(([v, text]) => h("option", { value: v, selected: String(v) === String(value) }, text)));
  return h("label.choice", {}, h("span", {}, label), select);
}

/** What a reader sees when the picture alone does not tell. */
export function asTable(summary, make) {
  const details = h("details.alternative", {}, h("summary", {}, summary));
  details.addEventListener("toggle", () => {
    if (details.open && details.childElementCount === 1) details.append(make());
  });
  return details;
}
