// One clock for all that plays: everything goes on together, stands still together, steps together.

const MOST_S = 0.1; // what a page in the background missed is not caught up with

export class Player {
  /** toggled(paused): called when it begins or ends to stand still. */
  constructor({ toggled }) {
    this.toggled = toggled;
    this.parts = new Set(); // what plays: advance(seconds), step(frames)
    this.speed = 1;
    this.paused = matchMedia("(prefers-reduced-motion: reduce)").matches;
    requestAnimationFrame((now) => this.#tick(now, now));
    toggled(this.paused);
  }

  toggle() {
    this.paused = !this.paused;
    this.toggled(this.paused);
  }

  /** A frame on (1) or back (-1), standing still. */
  step(by) {
    if (!this.paused) this.toggle();
    for (const part of this.parts) part.step(by);
  }

  #tick(now, before) {
    const seconds = this.paused ? 0 : Math.min(MOST_S, (now - before) / 1000) * this.speed;
    for (const part of this.parts) part.advance(seconds);
    requestAnimationFrame((next) => this.#tick(next, now));
  }
}

/** A place in frames [from, to) that goes round. */
export class Loop {
  constructor({ from, to, fps }, at = from) {
    Object.assign(this, { from, to, fps, at });
  }

  get frame() {
    return Math.floor(this.at);
  }

  advance(seconds) {
    this.#go(this.at + seconds * this.fps);
  }

  step(by) {
    this.#go(this.frame + by);
  }

  #go(at) {
    const n = this.to - this.from;
    this.at = this.from + ((((at - this.from) % n) + n) % n);
  }
}
