// Films that are there before they are wanted: the one shown, its neighbours loading behind it.

const url = (kind, id) => `/media/${kind}/${encodeURIComponent(id)}`;
const DRIFT_S = 0.12; // sound that is further off than that is put back

export class Films {
  /** box: where films are shown. heard: what to do as the film moves on or fails. */
  constructor(box, { moved, failed, toggled }) {
    this.box = box;
    this.heard = { moved, failed, toggled };
    this.pool = new Map(); // id → video
    this.shown = null;
    this.id = null;
    this.speed = 1;
    this.sounding = false;
    this.sound = new Audio();
    this.sound.loop = true;
    requestAnimationFrame(() => this.#tick());
  }

  /** Show the film of id (null: none) and have the films of `others` ready. */
  show(id, others) {
    const wanted = new Set([id, ...others].filter((name) => name !== null));
    for (const [name, video] of this.pool) {
      if (wanted.has(name)) continue;
      video.remove();
      video.removeAttribute("src");
      video.load(); // lets go of its connection
      this.pool.delete(name);
    }
    if (id === null || id !== this.id) this.#change(id);
    for (const name of others) if (name !== null) this.#video(name);
  }

  #change(id) {
    this.shown?.pause();
    this.sound.pause();
    this.shown = id === null ? null : this.#video(id);
    this.id = id;
    this.hasSound = false;
    for (const video of this.pool.values()) video.hidden = video !== this.shown;
    this.heard.toggled(false);
    if (!this.shown) return;
    this.shown.currentTime = 0;
    this.play();
    if (this.shown.error) this.heard.failed(id);
  }

  #video(id) {
    let video = this.pool.get(id);
    if (video) return video;
    video = document.createElement("video");
    Object.assign(video, { muted: true, loop: true, playsInline: true, preload: "auto", hidden: true });
    video.disablePictureInPicture = true;
    video.addEventListener("click", () => this.toggle());
    video.addEventListener("error", () => video === this.shown && this.heard.failed(id));
    video.src = url("film", id);
    this.pool.set(id, video);
    this.box.append(video);
    return video;
  }

  play() {
    if (!this.shown) return;
    this.shown.playbackRate = this.speed;
    this.shown.play().catch(() => {}); // another film was asked for meanwhile
    this.#settleSound();
    this.heard.toggled(false);
  }

  pause() {
    if (!this.shown) return;
    this.shown.pause();
    this.#settleSound();
    this.heard.toggled(true);
  }

  toggle() {
    if (this.shown?.paused) this.play();
    else this.pause();
  }

  seek(seconds) {
    if (!this.shown) return;
    this.shown.currentTime = Math.max(0, seconds);
    this.#settleSound();
  }

  /** A frame on (1) or back (-1), standing still. */
  step(by, fps) {
    if (!this.shown) return;
    this.pause();
    const frame = Math.floor(this.shown.currentTime * fps + 0.01) + by;
    const last = Math.max(0, Math.round(this.length * fps) - 1);
    this.seek((Math.min(last, Math.max(0, frame)) + 0.5) / fps);
  }

  get length() {
    return Number.isFinite(this.shown?.duration) ? this.shown.duration : 0;
  }

  setSpeed(speed) {
    this.speed = speed;
    if (this.shown) this.shown.playbackRate = speed;
    this.#settleSound();
  }

  setSounding(sounding) {
    this.sounding = sounding;
    this.#settleSound();
  }

  /** Told once the clip's facts are known. */
  setHasSound(hasSound) {
    this.hasSound = hasSound;
    this.#settleSound();
  }

  #settleSound() {
    if (!this.sounding || !this.hasSound || !this.shown || this.shown.paused) {
      this.sound.pause();
      return;
    }
    const source = url("sound", this.id);
    if (this.sound.getAttribute("src") !== source) this.sound.src = source;
    this.sound.playbackRate = this.speed;
    this.sound.currentTime = this.shown.currentTime;
    this.sound.play().catch(() => {});
  }

  #tick() {
    if (this.shown) {
      const off = Math.abs(this.sound.currentTime - this.shown.currentTime);
      if (!this.sound.paused && off > DRIFT_S * this.speed && off < this.length - 0.3) {
        this.sound.currentTime = this.shown.currentTime;
      }
      this.heard.moved(this.shown.currentTime, this.length);
    }
    requestAnimationFrame(() => this.#tick());
  }
}
