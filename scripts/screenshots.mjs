#!/usr/bin/env node
// Makes docs/pictures/*.png from a simulated mystery (never from measurements that are not ours).
//
//   cargo build --release && (cd tests/browser && npm ci) && node scripts/screenshots.mjs [FOLDER]
//
// Needs Chromium from the system's packages. With FOLDER the pictures go there, with dark and narrow ones
// beside them, for looking at a change.

import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { launch, mystery, open, root, study } from "../tests/browser/browser.mjs";

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

const browser = await launch();
if (process.argv[2]) {
  for (const [name, address] of [["diagnosis", mystery()], ["study", study()]]) {
    await picture(browser, address, name);
    await picture(browser, address, `${name}-dark`, { scheme: "dark" });
    await picture(browser, address, `${name}-narrow`, { width: 390 });
  }
} else {
  await picture(browser, mystery(), "report", { width: 1080, height: 1850, only: ["missing", "torque", "where"] });
}
await browser.close();
