// The report in a browser: nothing fetched, nothing broken, everything reachable.

import assert from "node:assert/strict";
import { statSync } from "node:fs";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { HOSTILE, hostile, launch, mystery, open, serious, study } from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

async function unharmed({ page, seen }, address) {
  await page.evaluate(async () => {
    // Everything is drawn only when it comes into sight.
    for (let y = 0; y < document.documentElement.scrollHeight; y += 600) {
      window.scrollTo(0, y);
      await new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)));
    }
    window.scrollTo(0, 0);
  });
  assert.deepEqual(seen.troubles, []);
  assert.deepEqual(seen.requests, [address], "the page asked for something");
}

for (const [name, address] of [["diagnosis", mystery], ["study", study]]) {
  for (const options of [{}, { colorScheme: "dark" }, { viewport: { width: 390, height: 844 } }]) {
    test(`${name}: no error, no request, no serious finding ${JSON.stringify(options)}`, async () => {
      const opened = await open(browser, address(), options);
      await unharmed(opened, address());
      const { page } = opened;
      assert.ok((await page.locator("h1").innerText()).length > 10, "the verdict comes first");
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth)) <= 0, "it scrolls sideways");
      await page.evaluate(() => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
      await page.waitForTimeout(50);
      assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth)) <= 0, "opened, it scrolls sideways");
      assert.deepEqual(await serious(page), []);
      await page.context().close();
    });
  }
}

test("one file of moderate size", () => {
  assert.ok(statSync(fileURLToPath(mystery())).size < 4e6);
});

test("dark mode is dark, paper is light", async () => {
  const { page } = await open(browser, mystery(), { colorScheme: "dark" });
  const light = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number).reduce((a, b) => a + b) / 3);
  assert.ok((await light()) < 60);
  await page.emulateMedia({ media: "print", colorScheme: "dark" });
  assert.ok((await light()) > 200);
  await page.context().close();
});

const times = (page) => page.locator("#torque .span").innerText();

test("wheel, drag, keys and buttons zoom, and all plots share the time axis", async () => {
  // Tall enough that all four are in sight: the others are drawn when they come into it.
  const { page, seen } = await open(browser, mystery(), { viewport: { width: 1280, height: 2400 } });
  const plots = page.locator("#torque .plot");
  assert.equal(await plots.count(), 4, "two joints, torque and residual");
  await plots.first().scrollIntoViewIfNeeded();
  const whole = await times(page);
  const pictures = () => page.evaluate(() => [...document.querySelectorAll("#torque canvas")].map((c) => c.toDataURL()));
  const box = await plots.first().boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, -200);
  assert.equal(await times(page), whole, "the wheel scrolls until a plot has the focus");
  await plots.first().focus();
  await plots.first().scrollIntoViewIfNeeded();
  const again = await plots.first().boundingBox();
  await page.mouse.move(again.x + again.width / 2, again.y + 40);
  const first = await pictures();
  const step = async (act, name) => {
    const was = await times(page);
    await act();
    await page.waitForTimeout(80);
    assert.notEqual(await times(page), was, name);
  };
  await step(() => page.mouse.wheel(0, -300), "wheel");
  const second = await pictures();
  first.forEach((picture, k) => assert.ok(picture !== second[k], `plot ${k} did not follow`));
  await step(() => page.keyboard.press("ArrowRight"), "arrow");
  await step(() => page.keyboard.press("+"), "plus");
  await step(() => page.keyboard.press("Home"), "home");
  assert.equal(await times(page), whole);
  await step(async () => {
    await page.mouse.move(again.x + 200, again.y + 40);
    await page.mouse.down();
    await page.mouse.move(again.x + 400, again.y + 40, { steps: 4 });
    await page.mouse.up();
  }, "drag");
  await step(() => page.getByRole("button", { name: "zoom out" }).click(), "button");
  await step(() => page.getByRole("button", { name: "whole log" }).click(), "whole log");
  await page.getByRole("checkbox", { name: "joint3" }).check();
  assert.equal(await plots.count(), 6);
  assert.deepEqual(seen.troubles, []);
  await page.context().close();
});

test("maps take any two variables, partial residuals any of theirs", async () => {
  const { page, seen } = await open(browser, mystery());
  const section = page.locator("#where");
  const picture = () => section.locator("canvas").first().evaluate((c) => c.toDataURL());
  await section.scrollIntoViewIfNeeded();
  await page.waitForTimeout(100);
  const was = await picture();
  await section.getByRole("combobox", { name: "over" }).selectOption("time");
  await page.waitForTimeout(100);
  assert.ok((await picture()) !== was, "the map did not change");
  await section.getByRole("combobox", { name: "as" }).selectOption("mean");
  await section.getByRole("combobox", { name: "residual of" }).selectOption("4");
  await section.locator(".plot").first().focus();
  await page.keyboard.press("ArrowLeft");
  assert.match(await section.locator(".reading").innerText(), /time \[s\].*rows/);
  const effects = page.locator("#effects figure").first();
  await effects.getByRole("combobox", { name: "against" }).selectOption("1");
  await effects.getByText("as a table").click();
  await effects.locator("tbody tr").first().waitFor();
  assert.ok((await effects.locator("tbody tr").count()) > 5);
  assert.deepEqual(seen.troubles, []);
  await page.context().close();
});

test("terms are explained on hover and on focus, and at the end", async () => {
  const { page } = await open(browser, mystery());
  const term = page.locator("[data-term='held out']").first();
  await term.hover();
  assert.match(await page.locator("#tip").innerText(), /has not seen/);
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#tip").isVisible(), false);
  await term.focus();
  assert.equal(await term.getAttribute("aria-describedby"), "tip");
  assert.ok((await page.locator("#glossary dt").count()) > 8);
  await page.context().close();
});

test("a joint called like an attack stays a name", async () => {
  const address = hostile();
  const opened = await open(browser, address);
  await unharmed(opened, address);
  const { page } = opened;
  assert.equal(await page.locator("img").count(), 0);
  assert.ok((await page.locator("#joints").innerText()).includes(HOSTILE));
  await page.context().close();
});
