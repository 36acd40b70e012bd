// The dialog that asks which cluster the one shown is the same as.

import { colourOf } from "./cluster_list.js";
import { byId, element } from "./ground.js";
import { Picture } from "./picture.js";
import { Loop } from "./player.js";

/** chosen(cluster): called with the one that it is merged into. */
export function askMerge(answers, exemplars, player, cluster, view, chosen) {
  const { region } = cluster;
  const others = region.clusters.filter((other) => other !== cluster && answers.root(other) === other);
  const action = answers.action(cluster);
  const rank = (other) => [other.number !== cluster.nearest, !action || answers.action(other) !== action, other.number];
  others.sort((a, b) => compare(rank(a), rank(b)));
  byId("merge-title").textContent = `Cluster ${cluster.number} is the same as …`;
  const playing = [];
  const pick = (other) => {
    byId("merge").close();
    chosen(other);
  };
  byId("merge-into").replaceChildren(...others.map((other) => {
    const box = element("div", "thumbnail", element("p", "none", "Loading …"));
    exemplars.of(other).then((all) => {
      if (!all?.length || !byId("merge").open) return;
      const part = thumbnail(box, all[0], view);
      playing.push(part);
      player.parts.add(part);
    });
    return candidate(answers, cluster, other, box, pick);
  }));
  const number = byId("merge-number");
  number.value = "";
  number.oninput = () => {
    const fitting = others.filter((other) => String(other.number).startsWith(number.value.trim()));
    if (number.value.trim() && fitting.length === 1 && String(fitting[0].number) === number.value.trim()) pick(fitting[0]);
  };
  byId("merge-form").onsubmit = (event) => {
    event.preventDefault();
    const other = others.find((one) => String(one.number) === number.value.trim());
    if (other) pick(other);
  };
  byId("merge").onclose = () => playing.forEach((part) => player.parts.delete(part));
  byId("merge").showModal();
  number.focus();
}

const compare = (a, b) => a.map((value, at) => Number(value) - Number(b[at])).find((by) => by) ?? 0;

function thumbnail(box, exemplar, view) {
  const { start, end } = exemplar;
  const loop = new Loop({ ...exemplar, from: start, to: end });
  const picture = new Picture(exemplar, view);
  box.replaceChildren(picture.box);
  return {
    advance(seconds) {
      loop.advance(seconds);
      picture.draw(loop.frame);
    },
    step: (by) => loop.step(by),
  };
}

function candidate(answers, cluster, other, picture, pick) {
  const action = answers.action(other);
  const name = other.answer ? answers.words(other.region, other.answer) : action ? `${action.words}, proposed` : "no name yet";
  const swatch = element("i", "swatch");
  if (action) swatch.style.setProperty("--of", colourOf(action));
  const made = element("button", "candidate", picture,
    element("span", "", element("kbd", "", String(other.number)), swatch, name),
    element("small", "", other.number === cluster.nearest ? "closest" : ""));
  made.type = "button";
  made.dataset.into = String(other.number);
  made.addEventListener("click", () => pick(other));
  return made;
}
