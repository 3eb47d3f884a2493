// Files that are handed over: a robot and its logs, foreign columns, rubbish; and who is not let in.

import assert from "node:assert/strict";
import { readFileSync, statSync } from "node:fs";
import { request } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { gunzipSync } from "node:zlib";
import { begin, enter, finish, HOSTILE, root, studyOf, until, workbench } from "./browser.mjs";

let browser;
let bench;
let page;
let seen;
before(async () => { ({ browser, bench, page, seen } = await begin([])); });
after(() => finish(browser));

const log = gunzipSync(readFileSync(join(root, "scenarios/mystery/one_fit.csv.gz"))).toString();
const give = (kind, name, text) => page.locator(`input[data-kind="${kind}"]`).setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });

/** The log with positions in degrees under names of its own. */
function foreign() {
  const [head, ...rows] = log.trim().split("\n");
  const names = head.split(",");
  const renamed = names.map((n) => n.replace(/^q(\d)$/, "angle_$1").replace(/^dq(\d)$/, "rate_$1").replace(/^tau(\d)$/, "torque_$1"));
  const degrees = rows.map((row) => row.split(",").map((x, k) => (/^d?q\d$/.test(names[k]) ? (Number(x) * 180) / Math.PI : x)).join(","));
  return [renamed.join(","), ...degrees].join("\n");
}

test("an empty workbench asks for a robot and a log first", async () => {
  await page.getByRole("heading", { level: 1, name: "Robot and logs" }).waitFor();
  assert.equal(await page.locator(".drop").count(), 3);
});

test("rubbish is refused with the place where it is wrong, and nothing else happens", async () => {
  await give("robot", "arm.urdf", "<robot name='x'>\n  <link name='a'/>\n  <joint name='j' type='revolut'>\n");
  await page.locator("#view-data .problems, #view-data .caution").first().waitFor();
  assert.match(await page.locator("#view-data").innerText(), /line \d|:\d+:\d+|revolut|closed/);
  await give("robot", "arm.ron", "PK\u0003\u0004\u0000\u0000 not a robot");
  await page.waitForTimeout(500);
  const s = await studyOf(page);
  assert.equal(s.steps.length, 0);
});

test("a robot and a log are taken in; columns, units and roles are shown", async () => {
  // Dropped, as from a file manager; the logs below come through the button.
  await page.evaluate((text) => {
    const carried = new DataTransfer();
    carried.items.add(new File([text], "panda.ron"));
    document.querySelector("[data-drop=robot]").dispatchEvent(new DragEvent("drop", { dataTransfer: carried, bubbles: true, cancelable: true }));
  }, readFileSync(join(root, "robots/panda.ron"), "utf8"));
  await page.getByRole("heading", { name: "Robot: panda" }).waitFor();
  await page.locator('input[data-kind="log"]').setInputFiles(join(root, "scenarios/mystery/one_fit.csv.gz"));
  const card = page.locator("#log0");
  await card.waitFor();
  await card.locator("summary", { hasText: "columns" }).click();
  assert.match(await card.locator("tbody tr", { hasText: "tau3" }).innerText(), /torque of joint3\s+N m/);
  await page.getByRole("link", { name: "Model" }).click();
  await page.locator("#torque canvas").first().waitFor({ timeout: 60_000 });
  await page.getByRole("link", { name: "Data" }).click();
});

test("a log with foreign columns is mended with a column map in the page", async () => {
  await give("validate", "angles.csv", foreign());
  const card = page.locator(".part", { has: page.getByRole("heading", { name: "angles.csv" }) });
  await card.waitFor();
  await card.getByText("It cannot be used yet.").waitFor();
  await card.getByRole("button", { name: /^Take angles/ }).click();
  await card.waitFor({ state: "detached" });
  await page.getByRole("button", { name: /^Take one_fit/ }).click();
  await page.waitForFunction(() => document.querySelectorAll("[id^=log]").length === 0);
  await give("log", "angles.csv", foreign());
  await card.getByText("It cannot be used yet.").waitFor();
  const map = page.getByRole("textbox", { name: "column map" });
  await map.fill("(\n    position: (columns: \"angle_{1}\", unit: Degres),\n)");
  await page.getByRole("button", { name: "Use this map" }).click();
  await page.locator("#view-data .editor .problems", { hasText: "line 2" }).waitFor();
  await map.fill("(\n    position: (columns: \"angle_{1}\", unit: Degrees),\n    velocity: (columns: \"rate_{1}\", unit: Degrees),\n    torque: (columns: \"torque_{1}\"),\n)");
  await page.getByRole("button", { name: "Use this map" }).click();
  const s = await until(page, (one) => one.shown !== null && one.logs.every((l) => l.usable));
  assert.ok(s.steps.find((one) => one.id === s.shown).held_out_percent < 2, "in radians the model fits as before");
});

test("foreign columns are told by choosing: headers are guessed, units chosen, and the map is written", async () => {
  const own = await begin([]);
  const take = (kind, name, text) => own.page.locator(`input[data-kind="${kind}"]`).setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
  await take("robot", "panda.ron", readFileSync(join(root, "robots/panda.ron"), "utf8"));
  await own.page.locator("#robot").waitFor();
  await take("log", "angles.csv", foreign().replace(/^t,/, "clock,"));
  await own.page.locator("#log0").getByText("It cannot be used yet.").waitFor();
  const map = own.page.getByRole("textbox", { name: "column map" });
  const pick = (name, option) => own.page.getByRole("combobox", { name, exact: true }).selectOption({ label: option });
  await pick("time", "clock");
  assert.match(await map.inputValue(), /position: \(columns: "angle_\{1\}", unit: Radians\)/, "the guess");
  await pick("in the unit, position", "degrees");
  await pick("in the unit, velocity", "degrees/s");
  assert.equal(await map.inputValue(), [
    "(", "    time: (column: \"clock\", unit: Seconds),", "    position: (columns: \"angle_{1}\", unit: Degrees),",
    "    velocity: (columns: \"rate_{1}\", unit: Degrees),", "    torque: (columns: \"torque_{1}\", unit: NewtonMeters),", ")", ""].join("\n"));
  const gains = own.page.getByRole("textbox", { name: /gains/ });
  await pick("in the unit, torque", "A, times gains");
  await gains.fill("1, 1, 1, 1, 1, 1, 2");
  assert.match(await map.inputValue(), /torque: \(current: "torque_\{1\}", gains: \[1, 1, 1, 1, 1, 1, 2\]\)/);
  await pick("in the unit, torque", "N m");
  assert.equal(await gains.isVisible(), false);
  await own.page.getByRole("button", { name: "Use this map" }).click();
  const s = await until(own.page, (one) => one.shown !== null);
  assert.ok(s.logs[0].usable && s.steps[0].held_out_percent < 2, "with this map it is the log it was");
  assert.deepEqual(own.seen.troubles, []);
  await own.bench.stop();
  await own.browser.close();
});

test("a joint called like an attack stays a name, in robots and in logs", async () => {
  const robot = readFileSync(join(root, "robots/panda.ron"), "utf8").replace(/rows: \[\s*\(/, (found) => `${found}name: ${JSON.stringify(HOSTILE)}, `);
  const other = await workbench([]);
  const opened = await enter(browser, other);
  const take = (kind, name, text) => opened.page.locator(`input[data-kind="${kind}"]`).setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
  await take("robot", "<img src=x onerror=alert(1)>.ron", robot);
  await opened.page.locator("#robot").waitFor();
  await take("log", "<img src=x onerror=alert(2)>.csv", log);
  await opened.page.locator("#log0").waitFor();
  await opened.page.getByRole("link", { name: "Model" }).click();
  await opened.page.locator("#joints", { hasText: HOSTILE }).waitFor({ timeout: 60_000 });
  assert.equal(await opened.page.locator("img").count(), 0);
  assert.deepEqual(opened.seen.troubles, []);
  await other.stop();
});

test("the folder is its owner's alone", () => assert.equal(statSync(bench.out).mode & 0o777, 0o700));

/** A request as a foreign program or page would send it. */
function knock(path, { method = "GET", headers = {}, body = "" } = {}) {
  const { hostname, port } = new URL(bench.origin);
  return new Promise((done, failed) => {
    const sent = request({ hostname, port, path, method, headers }, (response) => {
      let text = "";
      response.on("data", (part) => { text += part; });
      response.on("end", () => done({ status: response.statusCode, text, headers: response.headers }));
    });
    sent.on("error", failed);
    sent.end(body);
  });
}

test("who has no cookie, a wrong token, a used token, a foreign host or origin is not let in", async () => {
  assert.equal((await knock("/api/state")).status, 403);
  assert.equal((await knock("/?token=0000")).status, 403);
  const used = new URL(bench.address);
  assert.equal((await knock(`${used.pathname}${used.search}`)).status, 403, "a token opens once");
  const cookies = await page.context().cookies(bench.origin);
  assert.ok(cookies.every((c) => c.httpOnly && c.sameSite === "Strict"));
  const cookie = cookies.map((c) => `${c.name}=${c.value}`).join("; ");
  assert.equal((await knock("/api/state", { headers: { cookie } })).status, 200);
  assert.equal((await knock("/api/state", { headers: { cookie, host: "evil.example" } })).status, 403, "a name that was bent to this address");
  const post = { method: "POST", body: "{}" };
  const json = { cookie, "content-type": "application/json" };
  assert.equal((await knock("/api/undo", { ...post, headers: { ...json, origin: "http://evil.example" } })).status, 403);
  assert.equal((await knock("/api/undo", { ...post, headers: { ...json, "sec-fetch-site": "cross-site" } })).status, 403);
  assert.equal((await knock("/api/undo", { ...post, headers: { cookie, "content-type": "text/plain" } })).status, 415);
  assert.equal((await knock("/api/events", { headers: { cookie, origin: "http://evil.example" } })).status, 403);
  const policy = (await knock("/", { headers: { cookie } })).headers["content-security-policy"];
  assert.match(policy, /script-src 'self'/);
  assert.doesNotMatch(policy, /unsafe/);
});

test("someone without the address is told what to do", async () => {
  const stranger = await browser.newContext();
  const tab = await stranger.newPage();
  const response = await tab.goto(bench.origin);
  assert.equal(response.status(), 403);
  assert.match(await tab.locator("body").innerText(), /address/);
  await stranger.close();
});

test("nothing went wrong in the page but what was refused", () => {
  assert.deepEqual(seen.troubles.filter((t) => !/status of 4(00|04|22)/.test(t)), []);
});

