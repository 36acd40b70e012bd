// Every channel: how far it goes now, where it comes from, how far that is to be relied on.

import { element } from "./ground.js";
import { shown } from "./preview_tracks.js";

const DOUBTFUL = 0.5; // quality below which it is said in colour
const FULL_DEGREES = 40; // an angle that fills its bar

export class Channels {
  /** box: what they fill. facts: of the motion. toggled(channel): a person wants its curve, or no longer. */
  constructor(box, { channels, states }, toggled) {
    this.rows = [];
    const groups = new Map();
    for (const channel of channels) {
      if (!groups.has(channel.group)) groups.set(channel.group, []);
      groups.get(channel.group).push(this.#row(channel, states, toggled));
    }
    const known = channels.filter((channel) => channel.known).length;
    const absent = channels.length - known;
    const sum = element("p", "sum", `${known} channels ${states.known}`);
    if (absent) sum.append(element("span", "quiet", `, ${absent} ${states.absent}: on the face these rest at 0, which says nothing of them`));
    const rated = channels.some(({ quality }) => quality !== null);
    const hint = `Press one to see its curve.${rated ? " The percentage is how far it may be relied on." : ""}`;
    const parts = [...groups].map(([name, rows]) => element("section", "", element("h3", "", name), ...rows));
    box.replaceChildren(sum, element("p", "quiet hint", hint), ...parts);
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

  #row(channel, states, toggled) {
    const { name, known, origin, quality } = channel;
    const told = `${name}: ${known ? states.known : states.absent}${origin ? `, ${origin}` : ""}${quality === null ? "" : `, reliable to ${percent(quality)}`}`;
    if (!known) {
      const row = element("p", "channel absent", element("span", "name", name), element("span", "value", states.absent));
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
