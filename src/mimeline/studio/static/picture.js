// The picture of an exemplar, frame by frame, or the word why there is none yet.

import { element } from "./ground.js";

const COMES = { film: "Loading …", face: "Drawing …" };
const IS = { film: "filmed", face: "drawn" };

export class Picture {
  /** view: film or face, the one that is wanted; the other is shown where there is no such. */
  constructor(exemplar, view) {
    this.exemplar = exemplar;
    this.canvas = element("canvas");
    this.none = element("p", "none");
    this.other = element("small", "other");
    this.box = element("div", "picture", this.canvas, this.none, this.other);
    this.setView(view);
  }

  setView(view) {
    const found = this.exemplar.view(view);
    this.other.textContent = found === view ? "" : IS[found] ?? "";
    this.sheet = this.exemplar.sheets.get(found);
    this.drawn = null;
    this.none.textContent = COMES[found] ?? "No picture";
    const { sheet } = this;
    sheet?.load().then((came) => {
      if (came === false && this.sheet === sheet) this.none.textContent = "The picture did not come";
    });
  }

  /** Show a frame; whether its picture is there. */
  draw(frame) {
    if (this.drawn !== frame && this.sheet?.draw(this.canvas, frame)) this.drawn = frame;
    this.none.hidden = this.drawn === frame;
    return this.none.hidden;
  }
}
