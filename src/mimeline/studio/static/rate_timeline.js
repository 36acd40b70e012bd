// The eight tracks of a pair: bars, a playhead that follows the picture, and the word for now.

import { byId, element } from "./ground.js";

const TICKS_S = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300]; // between two ticks
const TICK_PX = 50; // at least, from one to the next

export class Timeline {
  /** scrubbed(frame): a person wants that one; began(), ended(): while the pointer is down. */
  constructor({ scrubbed, began, ended }) {
    this.heard = { scrubbed, began, ended };
    this.facts = null;
    this.#listen();
  }

  /** Draw the tracks of a pair, at its first frame. */
  set(facts) {
    this.facts = facts;
    const n = facts.n_frames;
    const seek = byId("seek"); // its thumb goes from the first frame's middle to the last one's
    seek.max = n - 1;
    seek.style.left = `calc(${50 / n}% - var(--thumb) / 2)`;
    seek.style.width = `calc(${(100 * (n - 1)) / n}% + var(--thumb))`;
    byId("ticks").replaceChildren(...this.#ticks());
    this.rows = facts.tracks.map((track) => new Row(track, facts));
    byId("tracks").replaceChildren(...this.rows.map((row) => row.box));
    this.moved(0);
  }

  /** The picture shows that frame. */
  moved(frame) {
    const { n_frames: n, fps } = this.facts;
    this.frame = frame;
    byId("playhead").style.left = `${(100 * (frame + 0.5)) / n}%`;
    byId("clock").textContent = `${(frame / fps).toFixed(2)} s`;
    const seek = byId("seek");
    seek.value = frame;
    for (const row of this.rows) row.moved(frame);
    const doing = this.rows.map((row) => row.doing).filter(Boolean).join(", ");
    seek.setAttribute("aria-valuetext", `frame ${frame + 1} of ${n}: ${doing || "neutral"}`);
  }

  #ticks() {
    const { n_frames: n, fps } = this.facts;
    const seconds = n / fps;
    const most = byId("lanes").clientWidth / TICK_PX;
    const every = TICKS_S.find((step) => seconds / step <= most) ?? seconds;
    const ticks = [];
    for (let at = 0; at * every < seconds - every / 3; at += 1) {
      const tick = element("span", "", `${Number((at * every).toFixed(1))}${at ? "" : " s"}`);
      tick.style.left = `${(100 * at * every) / seconds}%`;
      ticks.push(tick);
    }
    return ticks;
  }

  #listen() {
    const lanes = byId("lanes");
    const seek = byId("seek");
    const at = (event) => {
      const { left, width } = lanes.getBoundingClientRect();
      const frame = Math.floor(((event.clientX - left) / width) * this.facts.n_frames);
      this.heard.scrubbed(this.#within(frame));
    };
    lanes.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !this.facts) return;
      event.preventDefault();
      lanes.setPointerCapture(event.pointerId);
      this.heard.began();
      at(event);
    });
    lanes.addEventListener("pointermove", (event) => {
      if (lanes.hasPointerCapture(event.pointerId)) at(event);
      else this.#tell(event);
    });
    lanes.addEventListener("lostpointercapture", () => this.heard.ended());
    seek.addEventListener("pointerdown", () => this.heard.began());
    seek.addEventListener("pointerup", () => {
      seek.blur(); // keys go to the page again
      this.heard.ended();
    });
    seek.addEventListener("input", () => this.heard.scrubbed(this.#within(Number(seek.value))));
  }

  /** The bar under the pointer, in words. */
  #tell(event) {
    const under = document.elementsFromPoint(event.clientX, event.clientY);
    byId("lanes").title = under.find((one) => one.matches(".act, .gap"))?.dataset.told ?? "";
  }

  #within(frame) {
    return Math.min(this.facts.n_frames - 1, Math.max(0, frame));
  }
}

class Row {
  constructor(track, { n_frames, fps }) {
    this.track = track;
    this.now = element("b", "now");
    this.lane = element("div", "lane");
    this.bars = track.intervals.map((interval) => {
      const bar = stretch("act", interval, n_frames);
      bar.style.setProperty("--of", interval.colour);
      bar.style.setProperty("--on", interval.on);
      bar.dataset.told = `${interval.words}, ${seconds(interval.start / fps)} to ${seconds(interval.end / fps)}`;
      bar.append(element("span", "", interval.words));
      return bar;
    });
    const gaps = (track.gaps ?? []).map(([start, end]) => {
      const gap = stretch("gap", { start, end }, n_frames);
      gap.dataset.told = "not known here";
      return gap;
    });
    const name = element("span", "name", track.words);
    const absent = (track.absent ?? []).join(", ");
    if (absent && track.measured) {
      name.append(element("small", "", `without ${absent}`));
      name.title = `Not measured: ${absent}`;
    }
    this.lane.append(...gaps, ...this.bars);
    if (!track.measured) this.lane.append(element("span", "unmeasured", "not measured"));
    this.box = element("div", `track${track.measured ? "" : " missing"}`, element("p", "label", name, this.now), this.lane);
    this.box.dataset.track = track.name;
    this.shown = undefined;
  }

  /** What it does at that frame stands beside its name; "" is nothing. */
  moved(frame) {
    const holds = ({ start, end }) => frame >= start && frame < end;
    const place = this.track.intervals.findIndex(holds);
    const unknown = !this.track.measured || (this.track.gaps ?? []).some(([start, end]) => holds({ start, end }));
    const shown = place >= 0 ? place : unknown ? "unknown" : "neutral";
    if (shown === this.shown) return;
    this.shown = shown;
    const interval = this.track.intervals[place];
    this.doing = interval?.words ?? "";
    this.bars.forEach((bar, at) => bar.classList.toggle("on", at === place));
    this.now.className = `now ${interval ? "acts" : shown}`;
    this.now.style.setProperty("--of", interval?.colour ?? "transparent");
    this.now.textContent = interval?.words ?? (!this.track.measured ? "not measured" : unknown ? "not known" : "neutral");
  }
}

function stretch(className, { start, end }, n) {
  const made = element("i", className);
  made.style.left = `${(100 * start) / n}%`;
  made.style.width = `${(100 * (end - start)) / n}%`;
  return made;
}

const seconds = (s) => `${s.toFixed(2)} s`;
