// What is seen of a pair: its film, or a face drawn frame by frame. Both are moved by the same words.

import { Films } from "./film.js";
import { byId } from "./ground.js";
import { Loop, Player } from "./player.js";
import { Sheet } from "./sheet.js";

const STILL = matchMedia("(prefers-reduced-motion: reduce)");

/** heard, of both: moved(frame), toggled(paused), waits(why), "" when it is there, failed(why). */
export class FilmView {
  constructor(heard) {
    this.heard = heard;
    this.films = new Films(byId("picture"), {
      moved: () => this.#follow(),
      failed: () => heard.failed("The browser cannot play this film, or it is no longer there."),
      toggled: heard.toggled,
    });
  }

  /** Show a pair from its beginning. */
  show(facts) {
    this.facts = facts;
    this.watched = null;
    this.films.show(facts.id, []);
    if (STILL.matches) this.films.pause();
    const { error, readyState } = this.films.shown;
    if (!error) this.heard.waits(readyState < 2 ? "Loading …" : ""); // else it was told already
  }

  /** Have the films of these ready. */
  prepare(ahead) {
    this.films.show(this.facts.id, ahead.map(({ id }) => id));
  }

  hide() {
    this.films.show(null, []);
  }

  toggle() {
    this.films.toggle();
  }

  pause() {
    this.films.pause();
  }

  play() {
    this.films.play();
  }

  get paused() {
    return this.films.shown?.paused ?? true;
  }

  step(by) {
    this.films.step(by, this.facts.fps);
  }

  seek(frame) {
    this.films.seek((frame + 0.5) / this.facts.fps);
  }

  setSpeed(speed) {
    this.films.setSpeed(speed);
  }

  /** The frame on the screen; the film's clock may be one ahead of it. */
  #follow() {
    const film = this.films.shown;
    if (!film || film === this.watched || film.readyState < 2) return;
    this.#came(film.currentTime + 0.01 / this.facts.fps);
    if (!film.requestVideoFrameCallback) return; // then the clock has to do
    this.watched = film;
    const { id } = this.facts;
    const presented = (_, { mediaTime }) => {
      if (this.facts.id !== id || this.films.shown !== film) return;
      this.#came(mediaTime + 0.5 / this.facts.fps);
      film.requestVideoFrameCallback(presented);
    };
    film.requestVideoFrameCallback(presented);
  }

  #came(seconds) {
    const { fps, n_frames: n } = this.facts;
    this.heard.waits("");
    this.heard.moved(Math.min(n - 1, Math.floor(seconds * fps)));
  }
}

export class FaceView {
  constructor(heard) {
    this.heard = heard;
    this.canvas = byId("face");
    this.canvas.hidden = false;
    this.canvas.addEventListener("click", () => this.toggle());
    this.sheets = new Map(); // id → Sheet, of the pair shown and the next
    this.loop = null;
    this.player = new Player({ toggled: heard.toggled });
    this.player.parts.add({
      advance: (seconds) => {
        if (!this.drawn) return; // it begins when it is there
        this.loop?.advance(seconds);
        this.#draw();
      },
      step: (by) => this.loop && this.seek(Math.min(this.loop.to - 1, Math.max(0, this.loop.frame + by))),
    });
  }

  show(facts) {
    const n = facts.n_frames;
    this.loop = new Loop({ from: 0, to: n, start: 0, end: n, fps: facts.fps, slow: 1 });
    this.drawn = false;
    this.shownFrame = null;
    this.canvas.getContext("2d").clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.player.paused && !STILL.matches) this.player.toggle();
    this.sheet = this.#sheet(facts);
    this.coming = this.#await(this.sheet);
  }

  /** Have the next one's faces ready, when those that are shown are there: a sheet is large. */
  async prepare([next]) {
    const { sheet } = this;
    const wanted = next ? [sheet, this.#sheet(next)] : [sheet];
    for (const [id, other] of this.sheets) {
      if (wanted.includes(other)) continue;
      other.giveUp();
      this.sheets.delete(id);
    }
    await this.coming;
    if (this.sheet === sheet) wanted.at(-1).load();
  }

  hide() {
    this.loop = this.sheet = null;
    this.drawn = false;
  }

  async #await(sheet) {
    this.heard.waits(sheet.image ? "" : "Drawing …");
    const came = await sheet.load();
    if (this.sheet !== sheet) return;
    if (came) this.heard.waits("");
    else this.heard.failed("The face could not be drawn, or did not come.");
    this.drawn = came === true;
    this.#draw();
  }

  #sheet(facts) {
    if (!this.sheets.has(facts.id)) {
      this.sheets.set(facts.id, new Sheet(`/sheet/${facts.id}`, facts.sheet));
    }
    return this.sheets.get(facts.id);
  }

  toggle() {
    this.player.toggle();
  }

  pause() {
    if (!this.player.paused) this.player.toggle();
  }

  play() {
    if (this.player.paused) this.player.toggle();
  }

  get paused() {
    return this.player.paused;
  }

  step(by) {
    this.player.step(by);
  }

  seek(frame) {
    if (!this.loop) return;
    this.loop.at = frame;
    this.#draw();
  }

  setSpeed(speed) {
    this.player.speed = speed;
  }

  #draw() {
    const frame = this.loop?.frame;
    if (frame === undefined || frame === this.shownFrame) return;
    if (!this.drawn || !this.sheet.draw(this.canvas, frame)) return;
    this.shownFrame = frame;
    this.heard.moved(frame);
  }
}
