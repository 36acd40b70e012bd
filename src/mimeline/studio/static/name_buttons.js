// The names that a cluster can be given, and what else can be said of it, with their keys.

import { isAnswered, isMoved } from "./answers.js";
import { colourOf } from "./cluster_list.js";
import { byId, element } from "./ground.js";

/** What Enter gives the cluster: the name moved to it, or the one proposed; null: neither. */
export function accepted({ answer, proposed, unsafe, ...cluster }) {
  if (unsafe) return null;
  if (isMoved({ answer, ...cluster })) return answer;
  return answer === null && proposed?.action ? { action: proposed.action, note: null, same_as: null } : null;
}

/** does: accept(), name(action), unsure(), merge(), finer(), undo(). more: exemplars not shown yet. */
export function drawButtons(answers, cluster, { more, canUndo, ...does }) {
  const { region, answer } = cluster;
  const enter = accepted(cluster);
  const said = isAnswered(cluster) ? answer : null;
  const first = button("accept", "⏎", enter ? `${isMoved(cluster) ? "Keep" : "Accept"} “${answers.words(region, enter)}”` : "Next", does.accept);
  first.classList.toggle("chief", enter !== null);
  first.setAttribute("aria-keyshortcuts", "Enter");
  const names = region.actions.map((action) => {
    const made = button("name", action.key, action.words, () => does.name(action.name));
    made.dataset.action = action.name;
    made.style.setProperty("--of", colourOf(action));
    made.style.setProperty("--on", action.on);
    made.setAttribute("aria-pressed", String(said?.action === action.name));
    if (region.unmeasured.includes(action.name)) {
      made.classList.add("unmeasured");
      made.title = "No channel of the fit tells it";
    }
    return made;
  });
  const unsure = button("", "X", more ? "Not sure …" : "Not sure", does.unsure);
  unsure.title = more ? "Not sure: show more of it first" : "Leave it without a name";
  unsure.setAttribute("aria-pressed", String(Boolean(said) && said.action === null && said.same_as === null));
  const merge = button("", "M", "Same as …", does.merge);
  merge.setAttribute("aria-pressed", String(said?.same_as != null));
  const undo = button("", "U", "Undo", does.undo);
  undo.disabled = !canUndo;
  byId("name").replaceChildren(
    first, element("div", "names", ...names),
    element("div", "others", unsure, merge, button("", "F", "Finer …", does.finer), undo),
  );
}

function button(className, key, text, does) {
  const made = element("button", className, element("kbd", "", key), element("span", "", text));
  made.type = "button";
  made.addEventListener("click", does);
  return made;
}
