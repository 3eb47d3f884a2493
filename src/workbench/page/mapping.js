// A column map by choosing: what stands in a header is offered, and the choice is written as the text of a map.
import { choice, h } from "/page/dom.js";

const UNITS = {
  time: [["Seconds", "s"], ["Milliseconds", "ms"], ["Microseconds", "µs"], ["Nanoseconds", "ns"]],
  angle: [["Radians", "rad"], ["Degrees", "degrees"], ["Revolutions", "turns"]],
  rate: [["Radians", "rad/s"], ["Degrees", "degrees/s"], ["Revolutions", "turns/s"]],
  torque: [["NewtonMeters", "N m"], ["MillinewtonMeters", "mN m"], ["current", "A, times gains"]],
};
const GUESS = {
  time: /^(t|.*(time|stamp|sec).*)$/i,
  position: /(^|_)(q|pos|position|angle|theta)/i,
  velocity: /(^|_)(dq|qd|vel|velocity|rate|speed|omega)/i,
  torque: /(^|_)(tau|torque|effort|moment|current|i_)/i,
};

/** Families of headers, one for each joint: `angle_1 .. angle_7` is `angle_{1}`. */
export function families(headers, names) {
  const found = [];
  const known = new Set(headers);
  const all = (pattern) => names.every((name, k) => known.has(pattern.replace("{0}", k).replace("{1}", k + 1).replace("{name}", name)));
  for (const header of headers) {
    for (const match of header.matchAll(/\d+/g)) {
      for (const mark of ["{0}", "{1}"]) found.push(header.slice(0, match.index) + mark + header.slice(match.index + match[0].length));
    }
    if (header.includes(names[0])) found.push(header.replace(names[0], "{name}"));
  }
  return [...new Set(found)].filter((pattern) => !/[{}]/.test(pattern.replace(/\{(0|1|name)\}/, "")) && all(pattern));
}

const quoted = (text) => JSON.stringify(text);

/** The text of a map. */
export function mapText(chosen) {
  const lines = [];
  if (chosen.time) lines.push(`time: (column: ${quoted(chosen.time)}, unit: ${chosen.timeUnit})`);
  for (const kind of ["position", "velocity"]) if (chosen[kind]) lines.push(`${kind}: (columns: ${quoted(chosen[kind])}, unit: ${chosen[`${kind}Unit`]})`);
  if (chosen.torque && chosen.torqueUnit === "current") lines.push(`torque: (current: ${quoted(chosen.torque)}, gains: [${chosen.gains}])`);
  else if (chosen.torque) lines.push(`torque: (columns: ${quoted(chosen.torque)}, unit: ${chosen.torqueUnit})`);
  return `(\n${lines.map((line) => `    ${line},\n`).join("")})\n`;
}

/** Choices for a log with these headers; `write(text)` gets the map whenever one has chosen, and the guess at once when that is wanted. */
export function mapping(headers, names, write, guessed = false) {
  const patterns = families(headers, names);
  const guess = (kind, among) => among.find((name) => GUESS[kind].test(name)) ?? "";
  const velocity = guess("velocity", patterns);
  const chosen = {
    time: guess("time", headers), timeUnit: "Seconds", velocity, velocityUnit: "Radians", torque: guess("torque", patterns), torqueUnit: "NewtonMeters",
    position: guess("position", patterns.filter((p) => p !== velocity)), positionUnit: "Radians", gains: names.map(() => 1).join(", "),
  };
  const gains = h("input", { type: "text", value: chosen.gains, "aria-label": "gains, torque at the joint per current, one for each joint", oninput: () => { chosen.gains = gains.value; write(mapText(chosen)); } });
  const set = (key) => (value) => {
    chosen[key] = value;
    gains.hidden = chosen.torqueUnit !== "current";
    write(mapText(chosen));
  };
  gains.hidden = true;
  if (guessed) write(mapText(chosen));
  const pick = (kind, options, units) => h("div.tools", {},
    choice(kind, [["", "not there"], ...options.map((o) => [o, o])], chosen[kind], set(kind)),
    choice(h("span", {}, "in", h("span.hidden", {}, ` the unit, ${kind}`)), units, chosen[`${kind}Unit`], set(`${kind}Unit`)));
  return h("div.mapping", {}, pick("time", headers, UNITS.time), pick("position", patterns, UNITS.angle), pick("velocity", patterns, UNITS.rate),
    pick("torque", patterns, UNITS.torque), gains,
    h("p.note", {}, patterns.length ? "{1} stands for the joint's number from 1, {0} from 0, {name} for its name." : "No header stands there once for each joint: name the columns one by one in the text."));
}
