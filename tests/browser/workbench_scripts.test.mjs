// Scripts written in the page, and the search for link parameters: run, watched, stopped, compared.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { begin, finish, studyOf, until } from "./browser.mjs";

const SEARCH = 120_000;
let browser;
let bench;
let page;
let seen;
before(async () => {
  ({ browser, bench, page, seen } = await begin(["scenarios/mystery_one.ron"]));
  await page.locator("#torque canvas").first().waitFor();
});
after(() => finish(browser));

const state = () => studyOf(page);

test("a broken script is marked at its line and column as one types", async () => {
  await page.getByRole("link", { name: "Scripts" }).click();
  const field = page.getByRole("textbox", { name: "script" });
  await page.getByText("no problem found").waitFor();
  const good = await field.inputValue();
  const lines = good.split("\n");
  const row = lines.findIndex((l) => l.includes("let v ="));
  lines[row] = "    let v = now.dq_sharp * ;";
  await field.fill(lines.join("\n"));
  const place = page.locator("#script .problems .place");
  await place.waitFor();
  assert.match(await place.innerText(), new RegExp(`line ${row + 1}, column \\d+`));
  assert.equal(await page.locator("#script .numbers .error").innerText(), String(row + 1));
  assert.ok(await page.getByRole("button", { name: "Add it to the model" }).isDisabled());
  await place.click();
  const at = await field.evaluate((f) => f.value.slice(0, f.selectionStart).split("\n").length);
  assert.equal(at, row + 1, "the place leads to the line");
  lines[row] = "    let v = now.dq_sharper;";
  await field.fill(lines.join("\n"));
  await page.locator("#script .problems", { hasText: "dq_sharper" }).waitFor();
  await field.fill(good);
  await page.getByText("no problem found").waitFor();
  assert.match(await page.locator(".says").innerText(), /fq/, "what the script means stands beside it");
});

test("an effect script is used at once", async () => {
  await page.getByRole("combobox", { name: "on" }).selectOption("joint3");
  await page.getByRole("button", { name: "Add it to the model" }).click();
  await page.locator("#ladder > .rungs > li").nth(1).waitFor();
  const s = await state();
  assert.equal(s.scripts.filter((one) => one.kind === "effect").length >= 1, true);
  assert.ok(s.steps.find((one) => one.id === s.shown).parameters.some((p) => p.symbol === "fq3"), "its parameter was fitted");
  await page.getByRole("button", { name: "Undo" }).click();
});

test("a rule that is a script joins the rules, one that is broken is refused where it breaks", async () => {
  await page.getByRole("link", { name: "Scripts" }).click();
  await page.getByRole("button", { name: "New rule" }).click();
  await page.getByText("no problem found").waitFor();
  await page.getByRole("button", { name: "Use it as a rule" }).click();
  const field = page.getByRole("textbox", { name: "rules" });
  await page.waitForFunction(() => /script/.test(document.querySelector("#rules textarea").value));
  const good = await field.inputValue();
  await field.fill(good.replace("[", "[\n    {\"total_mas\": ()},"));
  await page.getByRole("button", { name: "Use these rules" }).click();
  await page.locator("#rules .problems", { hasText: /line 3, column \d+/ }).waitFor();
  await field.fill(good);
  await page.getByRole("button", { name: "Use these rules" }).click();
  await page.getByText("these rules are in use").waitFor();
});

test("a search shows how far it is, and stopped it keeps its best", async () => {
  await page.getByRole("spinbutton", { name: "runs of penalty" }).fill("200");
  await page.getByRole("checkbox", { name: "lmi" }).uncheck();
  await page.getByRole("button", { name: "Look for link parameters" }).click();
  const search = page.locator("#search");
  await page.waitForFunction(() => /objective[\s\S]*\d/.test(document.querySelector("#search .figures")?.innerText ?? ""), null, { timeout: SEARCH });
  // How far it is and how long it will take, in the bar at the top and beside the figures.
  await page.waitForFunction(() => /left\s*(about )?\d/i.test(document.querySelector("#search .figures").innerText), null, { timeout: SEARCH });
  await page.locator("#job .left", { hasText: /about .* left/ }).waitFor();
  assert.ok(await search.getByRole("progressbar").evaluate((bar) => bar.value > 0 && bar.value < 1));
  await search.getByRole("button", { name: "Stop" }).click();
  await page.getByRole("heading", { name: /^Stopped/ }).waitFor();
  const s = await state();
  assert.equal(s.retrieval.running, false);
  assert.ok(s.retrieval.results.length > 0 && Number.isFinite(s.retrieval.results[0].objective), "the best so far was kept");
});

test("penalty and LMI are compared on the same rules, with the certified gap", async () => {
  await page.getByRole("spinbutton", { name: "runs of penalty" }).fill("2");
  await page.getByRole("checkbox", { name: "lmi" }).check();
  await page.getByRole("button", { name: "Look for link parameters" }).click();
  await until(page, (s) => s.retrieval !== null && !s.retrieval.running && s.retrieval.results.length === 2);
  const table = page.locator("#retrieval table").first();
  await table.waitFor();
  const text = await table.innerText();
  assert.match(text, /lmi/);
  assert.match(text, /penalty/);
  assert.match(text, /certified gap/);
  await page.getByRole("link", { name: "Take away" }).click();
  const waiting = page.waitForEvent("download");
  await page.getByRole("link", { name: "robot.urdf" }).click();
  const urdf = readFileSync(await (await waiting).path(), "utf8");
  assert.match(urdf, /<inertial>/);
});

test("nothing went wrong in the page", () => assert.deepEqual(seen.troubles.filter((t) => !/422/.test(t)), []));
