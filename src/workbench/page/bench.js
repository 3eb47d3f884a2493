// The workbench: fetches the state of the study whenever it has changed, and lets every part draw its share.
import { Refused, get, listen } from "/bench/api.js";
import { dataView } from "/bench/data.js";
import { filesView } from "/bench/files.js";
import { jobView } from "/bench/job.js";
import { modelView } from "/bench/model.js";
import { parametersView } from "/bench/parameters.js";
import { scriptsView } from "/bench/scripts.js";
import { h } from "/page/dom.js";
import { explain, followScheme } from "/page/explain.js";
import { button, renew } from "/bench/parts.js";

const PLACES = [["model", "Model"], ["data", "Data"], ["parameters", "Link parameters"], ["scripts", "Scripts"], ["files", "Take away"]];

/** Everything that is known; `page` is what the pictures are drawn from. */
const study = { state: null, page: null, words: { glossary: {}, catalogue: {} }, go };
const views = {};
/** Whether the reader or the first state has said which part is shown. */
let placed = location.hash.length > 1;

function go(place) {
  placed = true;
  if (location.hash !== `#${place}`) location.hash = place;
  show(place);
}

function show(place) {
  const known = PLACES.some(([id]) => id === place) ? place : "model";
  for (const [id] of PLACES) {
    views[id].element.hidden = id !== known;
    const link = document.querySelector(`#places a[href="#${id}"]`);
    if (id === known) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  window.scrollTo(0, 0);
}

function places() {
  document.getElementById("places").replaceChildren(...PLACES.map(([id, name]) =>
    h("li", {}, h("a", { href: `#${id}`, onclick: (event) => { event.preventDefault(); go(id); } }, name))));
  window.addEventListener("hashchange", () => show(location.hash.slice(1)));
}

/** One fetch at a time; what comes in between is fetched afterwards. */
function coalesced(act) {
  let [running, again] = [null, false];
  return () => {
    again = running !== null;
    running ??= (async () => {
      try {
        do {
          again = false;
          await act();
        } while (again);
      } finally {
        running = null;
      }
    })();
    return running;
  };
}

const refresh = coalesced(async () => {
  try {
    study.state = await get("/api/state");
    alarm(null);
  } catch (error) {
    return alarm(error);
  }
  draw();
  return pictures();
});

function draw() {
  const { state } = study;
  for (const entry of state.catalogue) study.words.catalogue[entry.name] = [entry.title, entry.text, entry.equation];
  document.getElementById("study").replaceChildren(h("b", {}, "lacuna"), ` ${state.study}`);
  document.title = `${state.study} - lacuna workbench`;
  views.job.draw(state.job, state.trouble);
  for (const [id] of PLACES) views[id].draw(state);
  if (!placed) show(ready(state) ? "model" : "data");
  placed = true;
}

/** Whether there is something to look at. */
function ready(state) {
  return Boolean(state.robot?.joints.length) && state.logs.length > 0;
}

let drawn = null;

/** The series of the model on show, fetched when it or what is known of it has changed. */
async function pictures() {
  const s = study.state;
  const step = s.steps.find((one) => one.id === s.shown);
  if (!step) {
    [drawn, study.page] = [null, null];
    return views.model.drawPictures(null);
  }
  const results = s.retrieval?.running ? 0 : s.retrieval?.results.length ?? 0;
  // A study that was taken up again is fitted again first.
  if ([s.shown, s.against].some((id) => s.steps.find((one) => one.id === id)?.fitted === false)) return undefined;
  const key = JSON.stringify([s.shown, s.against, step.scanned, step.held_out_percent, s.diagnosis !== null, s.logs.map((l) => [l.id, l.role]), results]);
  if (key === drawn) return undefined;
  const query = new URLSearchParams({ step: s.shown });
  if (s.against !== null) query.set("against", s.against);
  try {
    study.page = await get(`/api/page?${query}`);
  } catch (error) {
    // The study has moved on while this was asked: the next state brings it.
    return error.status === 404 || error.status === 409 ? undefined : alarm(error);
  }
  drawn = key;
  Object.assign(study.words.glossary, study.page.glossary);
  Object.assign(study.words.catalogue, study.page.catalogue);
  views.model.drawPictures(study.page);
  return views.parameters.drawResults(study.page);
}

/** What keeps the whole page from working. */
function alarm(error) {
  const holder = document.getElementById("alarm");
  if (error === null) return holder.replaceChildren();
  if (!(error instanceof Refused)) throw error;
  const again = `nothing that was finished is lost: start it again with lacuna workbench --resume ${study.state?.folder ?? "FOLDER"} and open the address it prints`;
  // Whoever notices first that the program is gone, a question or the stream of events, says the same.
  const help = error.status === 0 ? again : error.help ?? (error.status === 403 ? "open the address that the program prints when it starts" : again);
  return renew(holder, h("p", {}, h("b", {}, error.text), " – ", help, " ", button("try again", refresh)));
}

function start() {
  followScheme();
  explain(study.words);
  views.job = jobView(document.getElementById("job"), document.getElementById("trouble"));
  Object.assign(views, { model: modelView(study), data: dataView(study), parameters: parametersView(study), scripts: scriptsView(study), files: filesView(study) });
  document.getElementById("views").replaceChildren(...PLACES.map(([id]) => views[id].element));
  places();
  show(location.hash.slice(1));
  listen({
    state: refresh,
    job: (job) => views.job.draw(job, study.state?.trouble ?? null),
    retrieval: (progress) => views.parameters.drawProgress(progress),
    here: (is) => (is ? alarm(null) : alarm(new Refused(0, { text: "the program does not answer" }))),
  });
  refresh();
}

start();
