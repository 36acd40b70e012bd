// What is shown when every cluster is answered: what was done, and what to type next.

import { isNotSure } from "./answers.js";
import { percent } from "./cluster_list.js";
import { byId, element, toast } from "./ground.js";
import { agreement } from "./persons.js";

const NONE = "The first person has named none of these clusters yet: there is nothing to compare.";

/** open(cluster): show it. */
export function drawDone(answers, open) {
  const { n, named, notSure, merged, moved, namedFrames, movedFrames } = answers.progress();
  const parts = [
    `${named - merged} named`, merged && `${merged} merged`, moved && `${moved} moved from the fit before`,
    notSure && `${notSure} not sure`,
  ].filter(Boolean);
  byId("done-what").textContent = `Of ${n} clusters ${parts.join(", ")}: ${percent(namedFrames + movedFrames)} of the frames have a name.`;
  byId("done-file").textContent = answers.told.file;
  byId("done-command").textContent = answers.told.command ?? "";
  byId("done-next").hidden = !answers.told.command;
  byId("done-alone").hidden = Boolean(answers.person);
  byId("done-agreement").replaceChildren(...answers.person ? [agreement(answers, answers.person, NONE, open)] : []);
  const unsure = answers.all.filter(isNotSure);
  byId("done-unsure").hidden = !unsure.length;
  byId("done-list").replaceChildren(...unsure.map((cluster) => {
    const button = element("button", "", `${cluster.region.name} ${cluster.number}, ${percent(cluster.share)} of frames`);
    button.type = "button";
    button.addEventListener("click", () => open(cluster));
    return element("li", "", button);
  }));
}

byId("done-copy").addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(byId("done-command").textContent);
    toast("Copied");
  } catch {
    getSelection().selectAllChildren(byId("done-command")); // not allowed: mark it instead
  }
});
