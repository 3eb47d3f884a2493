// What the program is doing in the background, and how to stop it.
import { post } from "/bench/api.js";
import { button, duration, first, renew, whenChanged } from "/bench/parts.js";
import { h } from "/page/dom.js";

/** Draws into the bar at the top. A screen reader hears what begins and what has ended, not every step of it. */
export function jobView(element, strip) {
  const fail = whenChanged((trouble) => renew(strip, trouble && [h("p", {}, h("b", {}, first(trouble.text)), trouble.help && h("span.where", {}, ` ${trouble.help}`)), button("Dismiss", () => strip.replaceChildren())]));
  const told = h("p.hidden", { role: "status" });
  const holder = h("div.job");
  element.replaceChildren(told, holder);
  let was = null;
  const draw = (job, trouble) => {
    const now = job?.kind ?? null;
    if (now !== was) told.textContent = job ? job.text : was ? "done" : "";
    was = now;
    element.dataset.kind = now ?? "";
    renew(holder, job ? working(job) : h("span.idle", {}, trouble ? "not done" : "ready"));
    fail(job ? null : trouble);
  };
  return { draw };
}

function working(job) {
  const bar = h("progress", { "aria-label": job.text, max: "1", value: job.fraction });
  const left = job.seconds_left ? `about ${duration(job.seconds_left)} left` : job.seconds >= 2 ? duration(job.seconds) : "";
  return [h("span.what", { title: job.text }, job.text), bar, h("span.left", {}, left),
    job.stoppable && button("Stop", () => post("/api/stop").catch(() => {}), { key: "stop" })];
}
