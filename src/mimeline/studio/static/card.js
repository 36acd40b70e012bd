// An exemplar that plays: its picture, bright and framed inside the interval, and its curves.

import { Curves } from "./curves.js";
import { KINDS } from "./exemplars.js";
import { element } from "./ground.js";
import { Picture } from "./picture.js";
import { Loop } from "./player.js";

export class Card {
  /** view: film or face. still: begin in the interval's middle, as nothing moves. */
  constructor(exemplar, { channels, top }, view, still) {
    this.exemplar = exemplar;
    this.loop = new Loop(exemplar);
    if (still) this.loop.toMiddle();
    this.looked = null; // the frame that is pointed at
    this.channels = channels;
    this.top = top;
    this.picture = new Picture(exemplar, view);
    this.curvesBox = element("div", "curves");
    const kind = KINDS[exemplar.kind] ?? exemplar.kind;
    const length = [exemplar.length, exemplar.pace].filter(Boolean).join(", ");
    this.box = element("figure", "card",
      this.picture.box,
      this.curvesBox,
      element("figcaption", "", element("b", "", kind), element("span", "", length),
        element("small", "", exemplar.clip_id)));
    this.box.title = `${exemplar.clip_id}, frames ${exemplar.start}–${exemplar.end - 1}`;
    this.picture.canvas.setAttribute("role", "img");
    this.picture.canvas.setAttribute("aria-label", `${kind}, ${length}, clip ${exemplar.clip_id}`);
  }

  /** Once it is in the page: curves need to know how wide they are. */
  begin() {
    this.curves = new Curves(this.curvesBox, this.exemplar, this.channels, this.top, (frame) => { this.looked = frame; });
  }

  setView(view) {
    this.picture.setView(view);
  }

  advance(seconds) {
    this.loop.advance(seconds);
    const frame = this.looked ?? this.loop.frame;
    const isThere = this.picture.draw(frame);
    this.box.classList.toggle("inside", isThere && this.exemplar.holds(frame));
    this.curves?.show(frame);
  }

  step(by) {
    this.loop.step(by);
  }

  /** A short interval would mostly be missed: it stands still on its middle. */
  rest() {
    if (this.exemplar.slow > 1) this.loop.toMiddle();
    this.advance(0);
  }

  remove() {
    this.curves?.remove();
    this.box.remove();
  }
}
