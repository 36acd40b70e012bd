// One of the things that stand side by side: a face, what it does, its tracks, its channels.

import { ask, byId, element } from "./ground.js";
import { Channels } from "./preview_channels.js";
import { Face, bytesOf, contextOf } from "./preview_face.js";
import { Tracks } from "./preview_tracks.js";

const CURVES = 4; // shown of a motion without a timeline: of the channels that move most
const READING = "Reading …";
const NO_WEBGL = "This browser cannot draw the face: WebGL 2 is switched off, or is not there. The tracks and curves are here all the same.";

export class Pane {
  /** file: with its clips. box: the face's, see Face. heard: turned(pane), scrubbed(seconds),
   * began(), ended(), changed(), when another clip is there. */
  constructor(file, box, heard) {
    this.heard = heard;
    this.box = byId("pane").content.firstElementChild.cloneNode(true);
    this.part = (selector) => this.box.querySelector(selector);
    this.part("h2").textContent = file.name;
    this.part("h2").title = file.path;
    this.number = file.first;
    this.#clips(file.clips);
    const button = this.part(".open-channels");
    button.addEventListener("click", () => this.openChannels(button.getAttribute("aria-expanded") === "false"));
    const canvas = this.part("canvas");
    const context = contextOf(canvas);
    this.face = context && new Face(canvas, context, box, () => heard.turned(this));
  }

  /** Learn of the clip, and ask for its face, which comes later. */
  async load() {
    const { number } = this;
    const { status, body } = await ask(`/motions/${number}`);
    if (this.number !== number) return;
    if (status !== 200) {
      this.#say(body);
      return;
    }
    this.facts = body;
    this.frame = 0;
    this.#tell();
    this.#bring(number);
  }

  /** Draw the lanes anew: so many seconds long. */
  lay(seconds) {
    if (!this.facts) return;
    const curves = this.facts.channels.filter(({ name }) => this.tracks?.has(name));
    this.tracks = new Tracks(this.part(".timeline"), this.facts, seconds, this.heard);
    const shown = curves.length || this.facts.timeline ? curves : mostMoving(this.facts.channels);
    for (const channel of shown) this.toggleCurve(channel);
  }

  toggleCurve(channel) {
    this.tracks.toggle(channel, this.frame);
    this.channels.press(channel.name, this.tracks.has(channel.name));
  }

  openChannels(open) {
    this.part(".open-channels").setAttribute("aria-expanded", String(open));
    this.box.classList.toggle("with-channels", open);
  }

  /** It is that time now. */
  moved(seconds) {
    if (!this.tracks) return;
    const { fps, n_frames: n, invalid, acted, asked } = this.facts;
    const frame = Math.min(n - 1, Math.floor(seconds * fps + 1e-6));
    const ended = seconds * fps >= n + 1e-6;
    this.frame = frame;
    this.face?.show(frame);
    this.tracks.moved(seconds, frame);
    this.channels.moved(frame);
    const untracked = invalid.some(([start, end]) => frame >= start && frame < end);
    this.part(".face").classList.toggle("pale", untracked);
    this.part(".untracked").hidden = !untracked;
    const words = [element("b", "", `frame ${frame}`), element("span", "at", `${(frame / fps).toFixed(2)} s`)];
    if (untracked) words.push(element("span", "chip", "not tracked"));
    if (ended) words.push(element("span", "chip", "ended"));
    if (this.facts.timeline && !ended) words.push(...this.#doing(acted || asked ? "asked:" : "seen:"));
    this.part(".now").replaceChildren(...words);
  }

  get doing() {
    return this.tracks?.doing.map(({ words }) => words).join(", ") || "neutral";
  }

  #doing(word) {
    const chips = this.tracks.doing.map(({ words, colour, on }) => {
      const chip = element("span", "chip acts", words);
      chip.style.setProperty("--of", colour);
      chip.style.setProperty("--on", on);
      return chip;
    });
    return [element("span", "at", word), ...(chips.length ? chips : [element("span", "at", "neutral")])];
  }

  #clips(clips) {
    const select = this.part(".clips");
    select.hidden = clips.length < 2;
    select.replaceChildren(...clips.map(({ number, name }, at) => {
      const option = element("option", "", `${name}, ${at + 1} of ${clips.length}`);
      option.value = number;
      return option;
    }));
    select.value = this.number;
    select.addEventListener("change", () => {
      this.number = Number(select.value);
      this.tracks = null;
      select.blur(); // keys go to the page again
      this.#say(READING);
      this.heard.changed();
    });
  }

  #tell() {
    const { facts, notes, timeline } = this.facts;
    this.box.classList.toggle("timed", timeline !== null);
    this.part(".facts").replaceChildren(...[...facts, ...notes].map((text) => element("span", "", text)));
    this.channels = new Channels(this.part(".channels"), this.facts, (channel) => this.toggleCurve(channel));
  }

  async #bring(number) {
    if (!this.face) {
      this.#say(NO_WEBGL);
      return;
    }
    const gauge = this.part("progress");
    this.waiting = true;
    this.#say(READING);
    try {
      const bytes = await bytesOf(`/face/${number}.glb`, (part) => {
        gauge.hidden = false;
        gauge.value = part;
      });
      if (this.number !== number) return; // another one is on its way
      await this.face.set(bytes, this.facts.fps, this.facts.n_frames);
      this.#say("");
      this.face.show(this.frame);
    } catch (error) {
      this.#say(`The face could not be shown: ${error.message}`);
    }
    gauge.hidden = true;
    this.waiting = false;
  }

  /** In place of the face; "" where it is there. */
  #say(text) {
    this.part(".waits").hidden = !text;
    this.part(".waits p").textContent = text;
    this.ready = !text;
  }
}

/** Those with the widest range, of left and right one. */
function mostMoving(channels) {
  const range = ({ values, unit }) => {
    const known = values.filter((value) => value !== null);
    return (known.reduce((a, b) => Math.max(a, b)) - known.reduce((a, b) => Math.min(a, b))) / (unit ? 60 : 1);
  };
  const whole = new Map();
  for (const channel of channels.filter(({ values }) => values)) {
    const base = channel.name.replace(/(Left|Right)$/, "");
    if (!whole.has(base)) whole.set(base, [range(channel), channel]);
  }
  return [...whole.values()].sort(([a], [b]) => b - a).slice(0, CURVES).map(([, channel]) => channel);
}
