// The intervals that stand for a cluster, asked for once and kept while they may be wanted.

import { alarm, ask } from "./ground.js";
import { Sheet } from "./sheet.js";

const FPS = 30; // where a clip does not say
const KEPT = 16; // clusters whose pictures are kept
const LEAST_S = 0.7; // a shorter interval plays slower, or nobody would see it
const PACES = { 1: "", 2: "½ speed", 4: "¼ speed", 8: "⅛ speed" };

export const KINDS = { // what a person reads
  medoid: "typical", longest: "longest", border: "least sure", random: "random", further: "further",
};

/** Those that everybody is shown; the others are for one who is not sure. */
export const firstOf = (exemplars) => exemplars.filter((one) => one.kind !== "further");

export class Exemplars {
  constructor() {
    this.person = ""; // who asks: the server makes their next cluster's pictures ready
    this.asked = new Map(); // key → promise
  }

  /** The exemplars of a cluster by rank; null where the server has none to give. */
  of(cluster) {
    const asked = this.asked.get(cluster.key) ?? this.#ask(cluster);
    this.asked.delete(cluster.key); // the one asked for last goes last
    this.asked.set(cluster.key, asked);
    if (this.asked.size > KEPT) this.asked.delete(this.asked.keys().next().value);
    return asked;
  }

  /** Have a cluster's first pictures ready before it is shown. */
  async prepare(cluster, view) {
    const exemplars = await this.of(cluster);
    await Promise.all(firstOf(exemplars ?? []).map((one) => one.sheets.get(one.view(view))?.load()));
  }

  /** Of the pictures that did not come yet, wait for this cluster's alone. */
  giveUpBut(cluster) {
    for (const [key, asked] of this.asked) {
      if (key === cluster?.key) continue;
      asked.then((all) => all?.forEach((one) => one.sheets.forEach((sheet) => sheet.giveUp())));
    }
  }

  async #ask(cluster) {
    const { status, body } = await ask(`/exemplars/${cluster.key}?person=${encodeURIComponent(this.person)}`);
    if (status !== 200) {
      alarm(body);
      this.asked.delete(cluster.key);
      return null;
    }
    return body.exemplars.map((told) => new Exemplar(cluster, told));
  }
}

class Exemplar {
  constructor(cluster, told) {
    Object.assign(this, told, { cluster, fps: told.fps ?? FPS });
    const lasts = (told.end - told.start) / this.fps;
    this.slow = [1, 2, 4].find((slow) => slow * lasts >= LEAST_S) ?? 8;
    this.sheets = new Map(told.views.map((view) => [
      view, new Sheet(`/pictures/${view}/${cluster.key}/${told.rank}`, told.sheet),
    ]));
  }

  /** The view that is wanted, else the one that there is; undefined: there is none. */
  view(wanted) {
    return this.sheets.has(wanted) ? wanted : this.views[0];
  }

  /** Whether a frame lies in the interval, not in what is around it. */
  holds(frame) {
    return frame >= this.start && frame < this.end;
  }

  /** How its interval plays, as a person reads it. */
  get pace() {
    return PACES[this.slow];
  }

  get length() {
    const frames = this.end - this.start;
    return this.seconds === null ? `${frames} frames` : `${this.seconds.toFixed(this.seconds < 10 ? 1 : 0)} s`;
  }
}
