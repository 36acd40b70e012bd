// How long each pair was looked at.

const MOST_S = 86400; // that the server takes

export class Looked {
  constructor() {
    this.counted = new Map(); // id → seconds so far
    this.id = null;
    this.since = 0;
  }

  /** From now on it is the pair of id that is looked at; null: none. */
  at(id) {
    const now = performance.now();
    if (this.id !== null) this.counted.set(this.id, this.#soFar(this.id) + (now - this.since) / 1000);
    this.id = id;
    this.since = now;
  }

  /** Of a pair, until it was last told what is looked at. */
  seconds(id) {
    return Math.min(MOST_S, Math.round(10 * this.#soFar(id)) / 10);
  }

  #soFar(id) {
    return this.counted.get(id) ?? 0;
  }
}
