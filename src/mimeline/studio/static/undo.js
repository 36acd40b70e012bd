// Steps that can be taken back, also after the page was loaded anew.

const STORED = 5000; // steps kept over a reload

export class Undo {
  /** name: of the page, as the browser stores steps by it. A step is plain data. */
  constructor(name) {
    this.name = `undo-${name}`;
    this.steps = JSON.parse(sessionStorage.getItem(this.name) ?? "[]");
  }

  push(step) {
    this.steps.push(step);
    this.#remember();
  }

  /** The last step, which is one no longer; undefined where there is none. */
  pop() {
    const step = this.steps.pop();
    this.#remember();
    return step;
  }

  /** Forget the steps that cannot be taken back any more. */
  forget(isGone) {
    this.steps = this.steps.filter((step) => !isGone(step));
    this.#remember();
  }

  #remember() {
    sessionStorage.setItem(this.name, JSON.stringify(this.steps.slice(-STORED)));
  }
}
