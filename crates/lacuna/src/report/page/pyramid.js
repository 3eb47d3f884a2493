// Envelopes at every scale: a million points are drawn from a thousand numbers, and no spike is lost.

const FACTOR = 4;

/** Smallest and largest values of stretches of 1, 4, 16, .. samples. */
export class Pyramid {
  /** `low` and `high` are the same array for a plain series. */
  constructor(low, high = low) {
    this.length = low.length;
    this.levels = [{ low, high, size: 1 }];
    while (this.levels.at(-1).low.length > FACTOR) this.levels.push(this.#next(this.levels.at(-1)));
  }

  #next(of) {
    const count = Math.ceil(of.low.length / FACTOR);
    const low = new Float32Array(count);
    const high = new Float32Array(count);
    for (let k = 0; k < count; k++) {
      let least = Infinity;
      let most = -Infinity;
      for (let i = k * FACTOR; i < Math.min((k + 1) * FACTOR, of.low.length); i++) {
        if (of.low[i] < least) least = of.low[i];
        if (of.high[i] > most) most = of.high[i];
      }
      low[k] = least;
      high[k] = most;
    }
    return { low, high, size: of.size * FACTOR };
  }

  /**
   * Writes the envelope of samples `from..to` (they may be fractions) into `width` columns. A column takes
   * every stretch that it touches, so it may show a little more than its own samples, never less; without
   * samples it is NaN.
   */
  columns(from, to, width, low, high) {
    const per = (to - from) / width;
    let level = this.levels[0];
    for (const next of this.levels) if (next.size <= per / 2) level = next;
    const last = level.low.length - 1;
    for (let p = 0; p < width; p++) {
      const first = Math.max(0, Math.floor((from + p * per) / level.size));
      const final = Math.min(last, Math.floor((from + (p + 1) * per) / level.size));
      let least = Infinity;
      let most = -Infinity;
      for (let i = first; i <= final; i++) {
        if (level.low[i] < least) least = level.low[i];
        if (level.high[i] > most) most = level.high[i];
      }
      low[p] = least > most ? NaN : least;
      high[p] = least > most ? NaN : most;
    }
  }

  /** Value at a sample: the middle of its envelope. */
  at(sample) {
    const { low, high } = this.levels[0];
    return sample < 0 || sample >= this.length ? NaN : 0.5 * (low[sample] + high[sample]);
  }
}
