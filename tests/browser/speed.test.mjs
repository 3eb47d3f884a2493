// A million samples: what a zoom step costs, and that no spike is lost.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, open, serve } from "./browser.mjs";

const SAMPLES = 1_000_000;
const SPIKE = 765_432;
const HTML = `<!DOCTYPE html><html lang="en"><title>speed</title><link rel="icon" href="data:,">
<link rel="stylesheet" href="/page.css"><div id="plots"></div>
<script type="module">
import { LinePlot } from "/plot.js";
import { TimeAxis } from "/time_axis.js";
import { Pyramid } from "/pyramid.js";
const wave = (by) => Float32Array.from({ length: ${SAMPLES} }, (_, k) => Math.sin(by * k) + 0.1 * Math.sin(k * k));
const one = wave(1e-4), two = wave(1.0003e-4);
two[${SPIKE}] = 9;
const axis = new TimeAxis(0, ${SAMPLES} / 1000);
const series = (low, tone) => ({ low, tone, label: tone, start: 0, dt: 1e-3 });
for (let k = 0; k < 4; k++) {
  const element = document.createElement("div");
  document.getElementById("plots").append(element);
  new LinePlot(element, { axis, unit: "N m", series: [series(one, "measured"), series(two, "before"), series(wave(1e-4 + k * 1e-7), "accent")] });
}
window.ready = { axis, Pyramid, two };
</script>`;

let browser;
let server;
before(async () => {
  browser = await launch();
  server = await serve(HTML);
});
after(async () => {
  await browser.close();
  server.close();
});

test("a zoom step of four plots with three series of a million points takes less than 16 ms", async () => {
  const { page, seen } = await open(browser, server.address);
  await page.waitForFunction(() => window.ready);
  await page.waitForTimeout(300);
  const steps = await page.evaluate(async () => {
    let spent = 0;
    const next = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (draw) => next((now) => {
      const start = performance.now();
      draw(now);
      spent += performance.now() - start;
    });
    const element = document.querySelector(".plot");
    element.focus();
    const box = element.getBoundingClientRect();
    const all = [];
    for (let k = 0; k < 50; k++) {
      spent = 0;
      const start = performance.now();
      element.dispatchEvent(new WheelEvent("wheel", { deltaY: k < 25 ? -120 : 120, clientX: box.left + 700, clientY: box.top + 50, cancelable: true, bubbles: true }));
      const handled = performance.now() - start;
      await new Promise((done) => next(() => next(done)));
      all.push(handled + spent);
    }
    return all.sort((a, b) => a - b);
  });
  console.log(`script time per zoom step: median ${steps[25].toFixed(2)} ms, largest ${steps[49].toFixed(2)} ms`);
  assert.ok(steps[0] > 0.05, "nothing was drawn");
  assert.ok(steps[25] < 16);
  assert.deepEqual(seen.troubles, []);
});

test("one spike in a million is there at every width", async () => {
  const { page } = await open(browser, server.address);
  await page.waitForFunction(() => window.ready);
  const found = await page.evaluate(() => {
    const pyramid = new window.ready.Pyramid(window.ready.two);
    return [7, 100, 333, 1000, 1920].map((width) => {
      const [low, high] = [new Float32Array(width), new Float32Array(width)];
      pyramid.columns(0, window.ready.two.length, width, low, high);
      return Math.max(...high);
    });
  });
  assert.deepEqual(found, [9, 9, 9, 9, 9]);
});
