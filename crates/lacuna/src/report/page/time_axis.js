// One time axis for many plots: whoever changes it changes all of them.

/** What part of a log is shown, and where the cursor is \[s]. */
export class TimeAxis {
  #watchers = new Set();

  constructor(from, to) {
    this.domain = [from, to];
    this.view = [from, to];
    this.cursor = null;
    this.selection = null;
  }

  watch(watcher) {
    this.#watchers.add(watcher);
    return () => this.#watchers.delete(watcher);
  }

  #tell(what) {
    for (const watcher of this.#watchers) watcher(what);
  }

  /** Shows `from..to`, kept within the log and not shorter than its millionth part. */
  show(from, to) {
    const [first, last] = this.domain;
    const span = Math.min(Math.max(to - from, 1e-6 * (last - first)), last - first);
    const start = Math.min(Math.max(from, first), last - span);
    this.view = [start, start + span];
    this.#tell("view");
  }

  /** Zooms by `factor` (below 1: closer) about the time `at`. */
  zoom(factor, at = 0.5 * (this.view[0] + this.view[1])) {
    this.show(at - (at - this.view[0]) * factor, at + (this.view[1] - at) * factor);
  }

  /** Moves by a part of what is shown. */
  pan(part) {
    const by = part * (this.view[1] - this.view[0]);
    this.show(this.view[0] + by, this.view[1] + by);
  }

  reset() {
    this.show(...this.domain);
  }

  /** Another log. */
  renew(from, to) {
    this.domain = [from, to];
    this.cursor = null;
    this.selection = null;
    this.reset();
  }

  /** Marks a span of time; nothing when `from` is `null`. */
  select(from, to) {
    const [first, last] = this.domain;
    const within = (at) => Math.min(Math.max(at, first), last);
    this.selection = from === null ? null : [within(Math.min(from, to)), within(Math.max(from, to))];
    this.#tell("selection");
  }

  point(at) {
    this.cursor = at;
    this.#tell("cursor");
  }
}
