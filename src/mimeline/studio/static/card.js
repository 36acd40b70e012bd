// An exemplar that plays: its picture, bright and framed inside the interval, and its curves.

import { Curves } from "./curves.js";
import { KINDS } from "./exemplars.js";
import { element } from "./ground.js";
import { Loop } from "./player.js";

export class Card {
  /** view: film or face. still: begin in the interval's middle, as nothing moves. */
  constructor(exemplar, channels, top, view, still) {
    this.exemplar = exemplar;
    this.loop = new Loop(exemplar, still ? Math.floor((exemplar.start + exemplar.end) / 2) : exemplar.from);
    this.looked = null; // the frame that is pointed at
    this.drawn = {};
    this.canvas = element("canvas");
    this.none = element("p", "none");
    this.none.hidden = true;
    this.curvesBox = element("div", "curves");
    const kind = KINDS[exemplar.kind] ?? exemplar.kind;
    this.box = element("figure", "card",
      element("div", "picture", this.canvas, this.none),
      this.curvesBox,
      element("figcaption", "", element("b", "", kind), element("span", "", exemplar.length),
        element("small", "", exemplar.clip_id)));
    this.box.title = `${exemplar.clip_id}, frames ${exemplar.start}–${exemplar.end - 1}`;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${kind}, ${exemplar.length}, clip ${exemplar.clip_id}`);
    this.channels = channels;
    this.top = top;
    this.setView(view);
  }

  /** Once it is in the page: curves need to know how wide they are. */
  begin() {
    this.curves = new Curves(this.curvesBox, this.exemplar, this.channels, this.top, (frame) => { this.looked = frame; });
  }

  setView(view) {
    const sheet = this.exemplar.pictures(view);
    if (!sheet) return this.#tell("No picture");
    this.none.hidden = true;
    sheet.load().then((came) => {
      if (sheet !== this.exemplar.pictures(view)) return;
      if (!came) this.#tell("The picture did not come");
      this.sheet = sheet;
    });
  }

  advance(seconds) {
    this.loop.advance(seconds);
    this.#draw();
  }

  step(by) {
    this.loop.step(by);
  }

  remove() {
    this.curves?.remove();
    this.box.remove();
  }

  #draw() {
    const frame = this.looked ?? this.loop.frame;
    if (this.drawn.frame === frame && this.drawn.sheet === this.sheet) return;
    if (this.sheet?.draw(this.canvas, frame)) this.drawn = { frame, sheet: this.sheet };
    this.box.classList.toggle("inside", this.exemplar.holds(frame));
    this.curves?.show(frame);
  }

  #tell(text) {
    this.none.textContent = text;
    this.none.hidden = false;
  }
}
