// One clock for all that plays: everything goes on together, stands still together, steps together.

const MOST_S = 0.1; // what a page in the background missed is not caught up with

export class Player {
  /** toggled(paused): called when it begins or ends to stand still. */
  constructor({ toggled }) {
    this.toggled = toggled;
    this.parts = new Set(); // what plays: advance(seconds), step(frames), perhaps rest(), when all stands still
    this.speed = 1;
    this.paused = matchMedia("(prefers-reduced-motion: reduce)").matches;
    requestAnimationFrame((now) => this.#tick(now, now));
    toggled(this.paused);
  }

  toggle() {
    this.paused = !this.paused;
    if (this.paused) for (const part of this.parts) part.rest?.();
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

/** A place in frames [from, to) that goes round, within [start, end) so many times slower. */
export class Loop {
  constructor({ from, to, start, end, fps, slow }) {
    Object.assign(this, { from, to, start, end, fps, slow, at: from });
  }

  get frame() {
    return Math.floor(this.at);
  }

  toMiddle() {
    this.at = Math.floor((this.start + this.end) / 2);
  }

  advance(seconds) {
    for (let left = seconds; left > 0;) {
      const [bound, fps] = this.#stretch();
      const needed = (bound - this.at) / fps;
      if (left < needed) this.at += left * fps;
      else this.#go(bound);
      left -= needed;
    }
  }

  step(by) {
    this.#go(this.frame + by);
  }

  /** Up to where it goes at which pace, from where it is. */
  #stretch() {
    if (this.at < this.start) return [this.start, this.fps];
    return this.at < this.end ? [this.end, this.fps / this.slow] : [this.to, this.fps];
  }

  #go(at) {
    const n = this.to - this.from;
    this.at = this.from + ((((at - this.from) % n) + n) % n);
  }
}
