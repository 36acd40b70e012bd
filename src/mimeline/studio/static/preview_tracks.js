// The tracks of a motion over its seconds, and below them the channels that are asked for, as curves.

import { element } from "./ground.js";

const TICKS_S = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600]; // between two ticks
const TICK_PX = 52; // at least, from one to the next
const SVG = "http://www.w3.org/2000/svg";

export class Tracks {
  /** box: what they fill. facts: of the motion. seconds: that the lanes last, the same for all that
   * stand side by side. heard: scrubbed(seconds), began(), ended(), while a pointer is down. */
  constructor(box, facts, seconds, heard) {
    Object.assign(this, { box, facts, seconds, heard });
    this.curves = new Map(); // name → what moves its playing value
    this.rows = (facts.timeline?.tracks ?? []).map((track) => new Row(track, seconds));
    this.ticks = element("div", "ticks");
    this.lanes = element("div", "lanes");
    this.playhead = element("i", "playhead");
    this.list = element("div", "rows", ...this.rows.map((row) => row.box));
    this.lanes.append(...this.#shades(), this.playhead);
    const ruler = element("div", "ruler", element("span"), this.ticks);
    box.replaceChildren(element("div", "scale", ruler, this.list, this.lanes));
    if (!facts.timeline) box.prepend(element("p", "none", facts.no_timeline));
    const absent = facts.timeline?.absent ?? [];
    if (absent.length) box.append(element("p", "absent", `Not ${facts.acted ? "told" : "measured"}: ${absent.join(", ")}.`));
    this.#listen();
    new ResizeObserver(() => this.#tick()).observe(this.ticks);
  }

  /** It is that time now; frame: of the motion. */
  moved(seconds, frame) {
    this.playhead.style.left = `${(100 * Math.min(seconds, this.seconds)) / this.seconds}%`;
    for (const row of this.rows) row.moved(seconds);
    for (const curve of this.curves.values()) curve(frame);
  }

  /** Its actions at this time. */
  get doing() {
    return this.rows.flatMap((row) => row.doing);
  }

  has(name) {
    return this.curves.has(name);
  }

  /** Show a channel's curve, or no longer. */
  toggle(channel, frame) {
    const { name } = channel;
    if (this.curves.delete(name)) {
      this.list.querySelector(`[data-curve="${name}"]`).remove();
      return;
    }
    const now = element("span", "value");
    const label = element("p", "label", element("span", "name", name), now);
    label.title = name;
    const lane = element("div", "lane curve", this.#curve(channel));
    const row = element("div", "track", label, lane);
    row.dataset.curve = name;
    this.list.append(row);
    this.curves.set(name, (at) => { now.textContent = shown(channel, at); });
    this.curves.get(name)(frame);
  }

  #curve({ values, unit }) {
    const { fps } = this.facts;
    const known = values.filter((value) => value !== null);
    const top = unit ? Math.max(10, ...known.map(Math.abs)) : Math.max(1, ...known);
    const bottom = unit ? -top : Math.min(0, ...known);
    const path = document.createElementNS(SVG, "path");
    const isKnown = (at) => typeof values[at] === "number";
    let drawn = "";
    values.forEach((value, at) => {
      if (value === null) return;
      const height = ((top - value) / (top - bottom)).toFixed(4);
      const second = (frame) => (frame / fps).toFixed(3);
      if (isKnown(at - 1)) drawn += `L${second(at + 0.5)} ${height}`;
      else if (isKnown(at + 1)) drawn += `M${second(at + 0.5)} ${height}`;
      else drawn += `M${second(at)} ${height}H${second(at + 1)}`; // alone: as long as its frame
    });
    path.setAttribute("d", drawn);
    const picture = document.createElementNS(SVG, "svg");
    picture.setAttribute("viewBox", `0 -0.04 ${this.seconds} 1.08`);
    picture.setAttribute("preserveAspectRatio", "none");
    picture.setAttribute("aria-hidden", "true");
    picture.append(path);
    if (unit) {
      const zero = document.createElementNS(SVG, "path");
      zero.setAttribute("d", `M0 0.5H${this.seconds}`);
      zero.setAttribute("class", "zero");
      picture.prepend(zero);
    }
    return picture;
  }

  /** Over all lanes: frames in which no face was tracked, and what is past the motion's end. */
  #shades() {
    const { invalid, fps, seconds } = this.facts;
    const gaps = invalid.map(([start, end]) => stretch("gap", start / fps, end / fps, this.seconds));
    for (const gap of gaps) gap.dataset.told = "not tracked";
    if (this.seconds - seconds < 1e-6) return gaps;
    const over = stretch("over", seconds, this.seconds, this.seconds);
    over.dataset.told = "it has ended";
    return [...gaps, over];
  }

  #tick() {
    const most = this.ticks.clientWidth / TICK_PX;
    const every = TICKS_S.find((step) => this.seconds / step <= most) ?? this.seconds;
    if (every === this.every) return;
    this.every = every;
    this.ticks.replaceChildren();
    for (let at = 0; at * every < this.seconds - every / 3; at += 1) {
      const tick = element("span", "", `${Number((at * every).toFixed(1))}${at ? "" : " s"}`);
      tick.style.left = `${(100 * at * every) / this.seconds}%`;
      this.ticks.append(tick);
    }
  }

  #listen() {
    const { lanes, heard } = this;
    const at = (event) => {
      const { left, width } = lanes.getBoundingClientRect();
      heard.scrubbed((Math.min(1, Math.max(0, (event.clientX - left) / width))) * this.seconds);
    };
    lanes.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      lanes.setPointerCapture(event.pointerId);
      heard.began();
      at(event);
    });
    lanes.addEventListener("pointermove", (event) => {
      if (lanes.hasPointerCapture(event.pointerId)) at(event);
      else this.#tell(event);
    });
    lanes.addEventListener("lostpointercapture", () => heard.ended());
  }

  /** What is under the pointer, in words. */
  #tell(event) {
    const under = document.elementsFromPoint(event.clientX, event.clientY);
    this.lanes.title = under.find((one) => one.dataset.told)?.dataset.told ?? "";
  }
}

class Row {
  constructor(track, seconds) {
    this.track = track;
    const halved = track.intervals.some(({ side }) => side);
    this.bars = track.intervals.map((interval) => {
      const bar = stretch(`act ${interval.side ?? ""}`, interval.start, interval.end, seconds);
      bar.style.setProperty("--of", interval.colour);
      bar.style.setProperty("--on", interval.on);
      bar.dataset.told = `${interval.words}, ${interval.start.toFixed(2)} to ${interval.end.toFixed(2)} s`;
      bar.append(element("span", "", interval.short));
      return bar;
    });
    const label = element("p", "label", element("span", "name", track.name));
    label.title = track.words;
    this.box = element("div", `track${halved ? " halved" : ""}`, label, element("div", "lane", ...this.bars));
    this.doing = [];
  }

  moved(seconds) {
    const near = seconds + 1e-6; // frames begin at times that floats only come near
    const holds = ({ start, end }) => near >= start && near < end;
    this.doing = this.track.intervals.filter(holds);
    this.bars.forEach((bar, at) => bar.classList.toggle("on", holds(this.track.intervals[at])));
  }
}

/** A channel's value at a frame, in words. */
export function shown({ values, unit }, frame) {
  const value = values?.[frame] ?? null;
  return value === null ? "–" : `${value.toFixed(unit ? 1 : 2)}${unit}`.replace("-", "−");
}

function stretch(className, start, end, seconds) {
  const made = element("i", className.trim());
  made.style.left = `${(100 * start) / seconds}%`;
  made.style.width = `${(100 * (end - start)) / seconds}%`;
  return made;
}
