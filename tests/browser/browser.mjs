// What the tests share: the browser of the system, reports made by the command, a server for modules.

import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join, resolve } from "node:path";
import { createInterface } from "node:readline";
import { chromium } from "playwright-core";

export const root = resolve(import.meta.dirname, "../..");
export const binary = process.env.LACUNA ?? join(root, "target/debug/lacuna");

/** Where Debian and others put it. */
export const executable = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
  .find((path) => path && existsSync(path));

export function launch() {
  return chromium.launch({ executablePath: executable, args: ["--no-sandbox", "--disable-gpu", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"] });
}

/** A page that notes whatever goes wrong in it and whatever it asks for. */
export async function open(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(20_000);
  const seen = { troubles: [], requests: [] };
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && seen.troubles.push(message.text()));
  page.on("pageerror", (error) => seen.troubles.push(String(error)));
  page.on("request", (request) => !request.url().startsWith("data:") && seen.requests.push(request.url()));
  page.on("dialog", (dialog) => {
    seen.troubles.push(`dialog: ${dialog.message()}`);
    dialog.dismiss();
  });
  await page.goto(address);
  return { page, seen };
}

const made = new Map();

/** Runs the command once per name and answers with the address of its report. */
export function report(name, args) {
  if (!made.has(name)) {
    const out = join(mkdtempSync(join(tmpdir(), "lacuna-report-")), name);
    mkdirSync(out);
    try {
      execFileSync(binary, [...args, "--out", out, "--quiet"], { cwd: root, stdio: ["ignore", "ignore", "inherit"] });
    } catch (error) {
      // 1 is an answer too: nothing can be decided, or nothing is feasible.
      if (error.status !== 1) throw error;
    }
    made.set(name, `file://${join(out, "report.html")}`);
  }
  return made.get(name);
}

export const mystery = () => report("two", ["diagnose", "scenarios/mystery_two.ron", "--auto"]);
export const study = () => report("study", ["scenario", "scenarios/panda.ron"]);
export const HOSTILE = "</script><img src=x onerror=alert(1)>";

/** The report of a robot whose first joint is called like an attack. */
export function hostile() {
  const folder = mkdtempSync(join(tmpdir(), "lacuna-hostile-"));
  const robot = join(folder, "robot.ron");
  const text = readFileSync(join(root, "robots/panda.ron"), "utf8");
  writeFileSync(robot, text.replace(/rows: \[\s*\(/, (found) => `${found}name: ${JSON.stringify(HOSTILE)}, `));
  return report("hostile", ["diagnose", "--robot", robot, "--data", "scenarios/mystery/two_fit.csv.gz"]);
}

/** Serves the page's modules as they are, as a program would. */
export async function serve(html) {
  const folder = join(root, "crates/lacuna/src/report/page");
  const types = { ".js": "text/javascript", ".css": "text/css" };
  const server = createServer((request, response) => {
    const type = types[extname(request.url)];
    if (!type) return response.setHeader("content-type", "text/html").end(html);
    return response.setHeader("content-type", type).end(readFileSync(join(folder, request.url.slice(1))));
  });
  await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
  return { address: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** A fresh folder. */
export const folder = () => mkdtempSync(join(tmpdir(), "lacuna-bench-"));

const running = new Set();

/** Ends whatever is still there, also after a test that failed. */
export async function finish(browser) {
  for (const child of running) child.kill("SIGKILL");
  await browser.close();
}

/** Starts a workbench and waits for the address it prints; `out` is the study's folder. */
export async function workbench(args, out = join(folder(), "study")) {
  const resumed = args.includes("--resume");
  const child = spawn(binary, ["workbench", ...args, ...(resumed ? [] : ["--out", out])], { cwd: root, stdio: ["ignore", "pipe", "pipe"] });
  running.add(child);
  let said = "";
  child.stderr.on("data", (text) => { said += text; });
  const ended = new Promise((done) => { child.on("exit", done); });
  ended.then(() => running.delete(child));
  const address = await new Promise((found, failed) => {
    createInterface({ input: child.stdout }).on("line", (line) => {
      const match = /http:\/\/\S+/.exec(line);
      if (match) found(match[0]);
    });
    ended.then((code) => failed(new Error(`the workbench ended with ${code}: ${said}`)));
  });
  const end = async (signal) => {
    child.kill(signal);
    await ended;
  };
  return { address, origin: new URL(address).origin, out, pid: child.pid, stop: () => end("SIGINT"), kill: () => end("SIGKILL") };
}

/** A browser, a workbench and a page in it. */
export async function begin(args) {
  const browser = await launch();
  const bench = await workbench(args);
  return { browser, bench, ...await enter(browser, bench) };
}

/** Opens a workbench; afterwards `seen.troubles` holds whatever went wrong in the page. */
export async function enter(browser, bench, options = {}) {
  return open(browser, bench.address, { acceptDownloads: true, ...options });
}

/** What the study is like. */
export const studyOf = (page) => page.evaluate(() => fetch("/api/state").then((r) => r.json()));

/** Waits until the study is as `so` says. */
export async function until(page, so, milliseconds = 120_000) {
  const end = Date.now() + milliseconds;
  for (;;) {
    const state = await studyOf(page);
    if (so(state)) return state;
    if (Date.now() > end) throw new Error(`still waiting; job ${JSON.stringify(state.job)}, trouble ${JSON.stringify(state.trouble)}, for ${so}`);
    await page.waitForTimeout(200);
  }
}

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Serious findings of the accessibility checker. The page's own policy allows no foreign script: it comes in through the debugger. */
export async function serious(page) {
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  return found.violations.filter((v) => ["serious", "critical"].includes(v.impact))
    .map((v) => `${v.id}: ${v.nodes.slice(0, 3).map((n) => n.html.slice(0, 120)).join(" | ")}`);
}
