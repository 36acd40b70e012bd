// Every channel: how far it goes now, where it comes from, how far that is to be relied on.

import { element } from "./ground.js";
import { shown } from "./preview_tracks.js";

const DOUBTFUL = 0.5; // quality below which it is said in colour
const WORDS = { measured: "measured", made: "made", absent: "not measured" };
const FULL_DEGREES = 40; // an angle that fills its bar

export class Channels {
  /** box: what they fill. toggled(channel): a person wants its curve, or no longer. */
  constructor(box, channels, toggled) {
    this.rows = [];
    const groups = new Map();
    for (const channel of channels) {
      if (!groups.has(channel.group)) groups.set(channel.group, []);
      groups.get(channel.group).push(this.#row(channel, toggled));
    }
    const absent = channels.filter(({ state }) => state === "absent").length;
    const known = channels.length - absent;
    const state = channels.find((channel) => channel.state !== "absent")?.state;
    const sum = element("p", "sum", `${known} ${WORDS[state] ?? "known"}`);
    if (absent) sum.append(element("span", "quiet", `, ${absent} not: they rest at 0, which is not what was seen`));
    const parts = [...groups].map(([name, rows]) => element("section", "", element("h3", "", name), ...rows));
    box.replaceChildren(sum, element("p", "quiet hint", "Press one to see its curve."), ...parts);
  }

  moved(frame) {
    for (const { channel, bar, value } of this.rows) {
      const now = channel.values[frame] ?? 0;
      const share = channel.unit ? now / FULL_DEGREES / 2 : now;
      const width = Math.min(channel.unit ? 0.5 : 1, Math.abs(share));
      bar.style.left = channel.unit ? `${50 + 100 * Math.min(0, Math.max(-0.5, share))}%` : "0";
      bar.style.width = `${100 * width}%`;
      value.textContent = shown(channel, frame);
    }
  }

  /** Whether a channel's curve is shown. */
  press(name, pressed) {
    this.rows.find((row) => row.channel.name === name)?.button.setAttribute("aria-pressed", String(pressed));
  }

  #row(channel, toggled) {
    const { name, state, origin, quality } = channel;
    const told = `${name}: ${WORDS[state]}${origin ? `, ${origin}` : ""}${quality === null ? "" : `, reliable to ${percent(quality)}`}`;
    if (state === "absent") {
      const row = element("p", "channel absent", element("span", "name", name), element("span", "value", "not measured"));
      row.title = told;
      return row;
    }
    const bar = element("i");
    const value = element("span", "value");
    const button = element("button", `channel${channel.unit ? " angle" : ""}`, element("span", "name", name));
    if (quality !== null) button.append(element("span", `quality${quality < DOUBTFUL ? " doubtful" : ""}`, percent(quality)));
    button.append(value, element("span", "amount", bar));
    Object.assign(button, { type: "button", title: told });
    button.setAttribute("aria-pressed", "false");
    button.addEventListener("click", () => toggled(channel));
    this.rows.push({ channel, bar, value, button });
    return button;
  }
}

const percent = (share) => `${Math.round(100 * share)} %`;
