// How the workbench looks and lasts: narrow, dark, for screen readers, after a kill.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { begin, enter, finish, serious, studyOf, until, workbench } from "./browser.mjs";

const PLACES = ["Model", "Data", "Link parameters", "Scripts", "Take away"];
let browser;
let bench;
let page;
let seen;
before(async () => { ({ browser, bench, page, seen } = await begin(["scenarios/mystery_one.ron"])); });
after(() => finish(browser));

test("wide, dark and narrow: no error, no serious finding, nothing scrolls sideways", async () => {
  await page.getByRole("heading", { level: 1, name: /torque ripple/ }).waitFor({ timeout: 90_000 });
  await page.locator(".candidate .main").first().click();
  await until(page, (s) => s.job === null && s.path.length === 2);
  for (const [scheme, width] of [["light", 1440], ["dark", 1440], ["light", 390], ["dark", 390]]) {
    await page.emulateMedia({ colorScheme: scheme });
    await page.setViewportSize({ width, height: 900 });
    await page.locator(`html[data-scheme='${scheme}']`).waitFor();
    for (const place of PLACES) {
      await page.getByRole("link", { name: place, exact: true }).click();
      await page.evaluate(() => document.querySelectorAll("main details").forEach((d) => { d.open = true; }));
      await page.waitForTimeout(300);
      assert.deepEqual(await serious(page), [], `${place}, ${scheme}, ${width}`);
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth)) <= 0, `${place} scrolls sideways at ${width}`);
    }
  }
  const light = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number).reduce((a, b) => a + b) / 3);
  await page.emulateMedia({ colorScheme: "dark" });
  await page.locator("html[data-scheme='dark']").waitFor();
  assert.ok((await light()) < 60);
  assert.deepEqual(seen.troubles, []);
  assert.ok(seen.requests.every((address) => address.startsWith(bench.origin)), "it asked somebody else");
  await page.context().close();
});

test("the whole loop by keyboard", async () => {
  // The cookie of a second browser needs a workbench of its own: an address opens once.
  const own = await workbench(["scenarios/mystery_one.ron"]);
  const { page } = await enter(browser, own);
  await page.getByRole("heading", { level: 1, name: /torque ripple/ }).waitFor({ timeout: 90_000 });
  const add = page.getByRole("button", { name: "Add torque ripple on joint3" });
  await add.focus();
  await page.keyboard.press("Enter");
  await page.locator("#ladder > .rungs > li").nth(1).waitFor();
  await page.getByRole("button", { name: "Undo" }).focus();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelectorAll("#ladder > .rungs > li").length === 1);
  assert.equal(await page.evaluate(() => document.activeElement.dataset.key ?? document.activeElement.tagName), "undo", "the focus stays where it was");
  await own.stop();
});

test("a killed workbench loses no finished step", async () => {
  const first = await workbench(["scenarios/mystery_one.ron"]);
  const { page } = await enter(browser, first);
  await page.getByRole("heading", { level: 1, name: /torque ripple/ }).waitFor({ timeout: 90_000 });
  await page.getByRole("button", { name: "Add torque ripple on joint3" }).click();
  const before = await until(page, (s) => s.path.length === 2);
  await first.kill();
  await page.locator("#alarm", { hasText: "does not answer" }).waitFor();
  assert.match(await page.locator("#alarm").innerText(), /--resume/);
  const second = await workbench(["--resume", first.out], first.out);
  const again = await enter(browser, second);
  await again.page.locator("#ladder > .rungs > li").nth(1).waitFor({ timeout: 60_000 });
  const after = await studyOf(again.page);
  assert.deepEqual(after.path, before.path);
  const error = (s) => s.steps.find((one) => one.id === s.shown).held_out_percent;
  assert.ok(Math.abs(error(after) - error(before)) < 1e-9);
  assert.deepEqual(again.seen.troubles, []);
  await second.stop();
});
