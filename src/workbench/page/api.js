// What the page asks of the program that serves it.

/** What the program said no to: `text`, and where known `help`, `file`, `line`, `column`. */
export class Refused extends Error {
  constructor(status, answer) {
    super(answer.text);
    Object.assign(this, { status, text: answer.text, help: answer.help ?? null, line: answer.line ?? null, column: answer.column ?? null });
  }
}

async function answer(response) {
  const text = await response.text();
  let body = null;
  try {
    body = JSON.parse(text);
  } catch {
    throw new Refused(response.status, { text: `the program answered with ${response.status}` });
  }
  if (!response.ok) throw new Refused(response.status, body.error ?? { text: `the program answered with ${response.status}` });
  return body;
}

async function ask(address, options) {
  try {
    return await fetch(address, options);
  } catch {
    throw new Refused(0, { text: "the program does not answer", help: "it may have been stopped" });
  }
}

export async function get(path) {
  return answer(await ask(path));
}

export async function post(path, body = {}, signal = undefined) {
  return answer(await ask(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body), signal }));
}

/** Hands a file over: `kind` is `robot`, `log`, `validate`, `model` or `map`. */
export async function upload(kind, file) {
  const query = new URLSearchParams({ kind, name: file.name });
  return answer(await ask(`/api/upload?${query}`, { method: "POST", headers: { "content-type": "application/octet-stream" }, body: file }));
}

/** Calls `on.state(version)`, `on.job(job)`, `on.retrieval(progress)`; `on.here(bool)` says whether the program is there. */
export function listen(on) {
  const source = new EventSource("/api/events");
  const tell = (name) => source.addEventListener(name, (event) => on[name](JSON.parse(event.data)));
  ["state", "job", "retrieval"].forEach(tell);
  source.addEventListener("open", () => on.here(true));
  source.addEventListener("error", () => on.here(false));
  return source;
}
