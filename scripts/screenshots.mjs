#!/usr/bin/env node
// Makes docs/pictures/*.png from a simulated mystery (never from measurements that are not ours).
//
//   cargo build --release && (cd tests/browser && npm ci) && node scripts/screenshots.mjs [FOLDER]
//
// Needs Chromium from the system's packages. With FOLDER the pictures go there, with dark and narrow ones
// beside them, for looking at a change.

import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { enter, launch, mystery, open, root, study, until, workbench } from "../tests/browser/browser.mjs";

const folder = process.argv[2] ?? join(root, "docs/pictures");
mkdirSync(folder, { recursive: true });

/** Everything is drawn only when it comes into sight, so the window takes the whole page. */
async function picture(browser, address, name, { width = 1200, height = 0, scheme = "light", only = null } = {}) {
  const { page } = await open(browser, address, { viewport: { width, height: 900 }, colorScheme: scheme });
  const whole = await page.evaluate(() => document.documentElement.scrollHeight);
  await page.setViewportSize({ width, height: Math.min(whole, 16_000) });
  if (only) await page.evaluate((kept) => document.querySelectorAll("section, nav").forEach((s) => { s.hidden = !kept.includes(s.id); }), only);
  await page.waitForTimeout(500);
  const end = await page.evaluate(() => document.getElementById("page").scrollHeight);
  await page.screenshot({ path: join(folder, `${name}.png`), clip: { x: 0, y: 0, width, height: height || Math.min(end, 16_000) } });
  await page.context().close();
}

/** The workbench after the first effect has been added. */
async function bench(browser, name, { width = 1280, height = 1100, scheme = "light", places = [["model", ""]] } = {}) {
  const one = await workbench(["scenarios/mystery_two.ron"]);
  const { page } = await enter(browser, one, { viewport: { width, height }, colorScheme: scheme });
  await until(page, (s) => s.shown !== null && s.job === null && s.candidates.some((c) => c.rank === "missing"));
  await page.locator(".candidate .main").first().click();
  await until(page, (s) => s.path.length === 2 && s.job === null);
  for (const [place, suffix] of places) {
    await page.locator(`#places a[href="#${place}"]`).click();
    await page.mouse.move(0, 0);
    await page.waitForTimeout(1000);
    await page.screenshot({ path: join(folder, `${name}${suffix}.png`) });
  }
  await page.context().close();
  await one.stop();
}

const browser = await launch();
if (process.argv[2]) {
  for (const [name, address] of [["diagnosis", mystery()], ["study", study()]]) {
    await picture(browser, address, name);
    await picture(browser, address, `${name}-dark`, { scheme: "dark" });
    await picture(browser, address, `${name}-narrow`, { width: 390 });
  }
  const places = ["model", "data", "parameters", "scripts", "files"].map((p) => [p, `-${p}`]);
  await bench(browser, "workbench", { places });
  await bench(browser, "workbench-dark", { places, scheme: "dark" });
  await bench(browser, "workbench-narrow", { places, width: 390, height: 2400 });
} else {
  await picture(browser, mystery(), "report", { width: 1080, height: 1850, only: ["missing", "torque", "where"] });
  await bench(browser, "workbench");
}
await browser.close();
