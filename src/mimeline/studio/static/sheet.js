// A picture that holds the frames of an interval, left to right, top to bottom.

export class Sheet {
  /** path: of the picture. edge: of a frame in px. frames: their numbers in the clip, rising. */
  constructor(path, { edge, columns, frames }) {
    Object.assign(this, { path, edge, columns, frames });
    this.image = null;
    this.pending = null;
  }

  /** Whether the picture came, undefined where it was given up; asked for once where it came. */
  load() {
    if (!this.coming) {
      this.pending = new Image();
      this.coming = this.#load(this.pending);
    }
    return this.coming;
  }

  /** No longer wanted: the browser has few places in its queue. */
  giveUp() {
    if (this.image || !this.coming) return;
    const image = this.pending;
    this.pending = this.coming = null;
    image.src = "";
  }

  async #load(image) {
    image.src = this.path;
    try {
      await image.decode();
    } catch {
      if (this.pending !== image) return undefined;
      this.coming = null; // asked for again when it is wanted again
      return false;
    }
    this.image = image;
    return true;
  }

  /** Draw a frame, or the last one before it that the sheet has; false: it is not there yet. */
  draw(canvas, frame) {
    if (!this.image) return false;
    if (canvas.width !== this.edge) canvas.width = canvas.height = this.edge;
    const after = this.frames.findIndex((number) => number > frame);
    const place = Math.max(0, (after < 0 ? this.frames.length : after) - 1);
    const [x, y] = [place % this.columns, Math.floor(place / this.columns)];
    canvas.getContext("2d").drawImage(this.image, x * this.edge, y * this.edge, this.edge, this.edge, 0, 0, this.edge, this.edge);
    return true;
  }
}
