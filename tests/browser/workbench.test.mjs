// The loop: open, see what is missing, add it, watch the error fall, go back, compare, confirm, take away.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { begin, binary, enter, finish, root, studyOf, until, workbench } from "./browser.mjs";

const SCAN = 90_000;
let browser;
let bench;
let page;
let seen;
before(async () => { ({ browser, bench, page, seen } = await begin(["scenarios/mystery_one.ron"])); });
after(() => finish(browser));

const rungs = () => page.locator("#ladder > .rungs > li");
const state = () => studyOf(page);
const shownStep = (s) => s.steps.find((one) => one.id === s.shown);
const candidate = (name) => page.locator(".candidate", { has: page.getByRole("heading", { name, exact: true }) });
/** The pictures on the page are of the model with this name. */
const drawnWith = (text) => page.locator("#torque .legend", { hasText: text }).waitFor();

test("the first picture comes before the search has ended, the answer after it", async () => {
  await page.locator("#torque canvas").first().waitFor();
  assert.equal(await rungs().count(), 1);
  await page.getByRole("heading", { level: 1, name: /torque ripple on joint3/ }).waitFor({ timeout: SCAN });
  assert.match(await candidate("torque ripple on joint3").innerText(), /z \d+/);
});

test("a span of time that is marked says what is in it", async () => {
  await until(page, (s) => s.job === null, SCAN);
  const plot = page.locator("#torque .plot").first();
  await plot.scrollIntoViewIfNeeded();
  const box = await plot.boundingBox();
  await page.mouse.move(box.x + 200, box.y + 40);
  await page.mouse.down();
  await page.mouse.move(box.x + 420, box.y + 40, { steps: 5 });
  await page.mouse.up();
  const found = page.locator("#torque .inside");
  await found.waitFor();
  const [from, to] = (await found.getAttribute("data-found")).match(/[\d.]+/g).map(Number);
  assert.ok(to - from > 2 && to - from < 10, `${from} to ${to}`);
  assert.equal(await found.locator("tbody th", { hasText: /^joint/ }).count(), 7, "every joint, the worst first");
  await found.getByRole("button", { name: "Zoom to it" }).click();
  assert.match(await page.locator("#torque .span").innerText(), new RegExp(`^${from.toPrecision(3).slice(0, 3)}`));
  await page.getByRole("button", { name: "whole log" }).click();
  await found.getByRole("button", { name: "Clear" }).click();
  await found.waitFor({ state: "detached" });
});

test("cells of a map that are marked say what is in them, by keyboard too", async () => {
  await until(page, (s) => s.job === null, SCAN);
  await page.waitForTimeout(500);
  const map = page.locator("#where .plot").first();
  await map.focus();
  const press = async (key, times) => {
    for (let k = 0; k < times; k++) await page.keyboard.press(key);
  };
  // From a corner to beyond the middle: rows lie there, whatever the motion.
  await press("ArrowLeft", 6);
  await press("ArrowDown", 4);
  await press("Enter", 1);
  await press("ArrowRight", 9);
  await press("ArrowUp", 9);
  await press("Shift+Enter", 1);
  const found = page.locator("#where .inside", { hasText: /\d+ rows/ });
  await found.waitFor();
  await found.getByRole("button", { name: "Clear" }).click();
});

test("adding what is missing makes the error fall, joint by joint, while the ladder grows", async () => {
  const first = await state();
  const [error, rms] = [shownStep(first).held_out_percent, shownStep(first).joints[2].held_out_rms];
  const start = Date.now();
  await candidate("torque ripple on joint3").getByRole("button", { name: /^Add/ }).click();
  await drawnWith("torque ripple");
  console.log(`from the click to the new curves: ${Date.now() - start} ms`);
  assert.equal(await rungs().count(), 2);
  const second = await state();
  assert.ok(shownStep(second).held_out_percent < 0.7 * error, "the pooled error fell");
  assert.ok(shownStep(second).joints[2].held_out_rms < 0.5 * rms, "joint3 most of all");
  assert.ok(shownStep(second).validation_percent < 0.8 * shownStep(first).validation_percent, "on a log that no fit has seen too");
  const row = page.locator("#joints tbody tr").nth(2);
  assert.match(await row.innerText(), /joint3[\s\S]*→/);
  await page.waitForFunction(() => parseFloat(document.querySelector("#joints tbody tr:nth-child(3) .fill:not(.behind)").style.width) < 50);
  assert.match(await page.locator("header.verdict .figures").first().innerText(), /→/);
});

test("undo goes back, and two models stand beside each other", async () => {
  await page.getByRole("button", { name: "Undo" }).click();
  await page.waitForFunction(() => document.querySelectorAll("#ladder > .rungs > li").length === 1);
  await page.getByText("1 set aside").click();
  await page.locator("#ladder details .rungs button").click();
  await page.waitForFunction(() => document.querySelectorAll("#ladder > .rungs > li").length === 2);
  await page.getByRole("combobox", { name: "compare with" }).selectOption("");
  await page.waitForFunction(() => document.querySelectorAll("#torque .swatch.before").length === 0);
  await page.getByRole("combobox", { name: "compare with" }).selectOption({ index: 1 });
  await page.locator("#torque .swatch.before").waitFor();
});

test("two tabs see the same study", async () => {
  const other = await page.context().newPage();
  await other.goto(bench.origin);
  await other.locator("#ladder > .rungs > li").nth(1).waitFor();
  await page.getByRole("button", { name: "Undo" }).click();
  await other.waitForFunction(() => document.querySelectorAll("#ladder > .rungs > li").length === 1);
  await page.getByText("1 set aside").click();
  await page.locator("#ladder details .rungs button").click();
  await other.waitForFunction(() => document.querySelectorAll("#ladder > .rungs > li").length === 2);
  await other.close();
});

test("what was done is taken away, and the command repeats it", async () => {
  await until(page, (s) => s.job === null, SCAN);
  await page.getByRole("link", { name: "Take away" }).click();
  const taken = {};
  for (const name of ["scenario.ron", "model.ron", "report.html"]) {
    const waiting = page.waitForEvent("download");
    await page.getByRole("link", { name, exact: true }).click();
    taken[name] = await (await waiting).path();
  }
  assert.match(readFileSync(taken["model.ron"], "utf8"), /torque_ripple/);
  assert.match(readFileSync(taken["report.html"], "utf8"), /torque_ripple/);
  assert.match(readFileSync(taken["scenario.ron"], "utf8"), /torque_ripple/);
  const s = await state();
  const command = s.commands.find((c) => c.startsWith("lacuna scenario")).split(" ").slice(1);
  const again = JSON.parse(execFileSync(binary, [...command, "--json", "--quiet"], { cwd: root, maxBuffer: 1e8 }));
  const told = again.identification.held_out_relative_error_percent;
  assert.ok(Math.abs(told - shownStep(s).held_out_percent) < 0.02 * told, `${told} and ${shownStep(s).held_out_percent}`);
});

test("all that is named is added, one step after the other", async () => {
  const two = await enter(browser, await workbench(["scenarios/mystery_two.ron"]));
  const all = two.page.getByRole("button", { name: "Add all that is named" });
  await all.waitFor({ timeout: SCAN });
  const before = await until(two.page, (s) => s.path.length === 1 && s.job === null, SCAN);
  await all.click();
  const s = await until(two.page, (s) => s.path.length > before.path.length && s.job === null, SCAN);
  const errors = s.path.map((id) => s.steps.find((one) => one.id === id).held_out_percent);
  assert.ok(errors.at(-1) < errors[before.path.length - 1], `${errors}`);
  await two.page.waitForFunction((n) => document.querySelectorAll("#ladder > .rungs > li").length === n, s.path.length);
  assert.deepEqual(two.seen.troubles, []);
});

test("nothing went wrong in the page", () => assert.deepEqual(seen.troubles, []));
