// The clusters at the left, by region: how large each is and what is known of it.

import { isAnswered, isMoved, isNotSure } from "./answers.js";
import { byId, element } from "./ground.js";

export const percent = (share) => `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;
/** Neutral's own grey would not be seen on the page's. */
export const colourOf = (action) => (action?.name === "Neutral" ? "#7d8187" : action?.colour);
export const titled = (name) => name[0].toUpperCase() + name.slice(1);

/** Draw the list anew. shown: the cluster that is open, or null. chosen(cluster): one was clicked. */
export function drawList(answers, shown, chosen) {
  const box = byId("clusters");
  const focused = document.activeElement?.dataset?.cluster;
  const scrolled = box.scrollTop;
  box.replaceChildren(...answers.regions.map((region) => {
    const done = region.clusters.filter(isAnswered).length;
    const head = element("h3", "", titled(region.name),
      element("span", "", region.clusters.length ? `${done} of ${region.clusters.length}` : ""));
    const rows = region.clusters.map((cluster) => row(answers, cluster, cluster === shown, chosen));
    const part = element("section", "region", head, ...rows);
    if (region.reason) part.append(element("p", "quiet", region.reason));
    return part;
  }));
  box.scrollTop = scrolled;
  if (focused) box.querySelector(`[data-cluster="${CSS.escape(focused)}"]`)?.focus();
  box.querySelector('[aria-current="true"]')?.scrollIntoView({ block: "nearest" });
}

function row(answers, cluster, isShown, chosen) {
  const { sign, text, kind, more } = told(answers, cluster);
  const swatch = element("i", "swatch", sign);
  const colour = colourOf(answers.action(cluster));
  if (colour && kind !== "unsafe" && kind !== "unsure") swatch.style.setProperty("--of", colour);
  const bar = element("i", "share");
  bar.style.setProperty("--part", cluster.share);
  const name = element("span", "name", text);
  if (more) name.append(element("small", "", more));
  const button = element("button", `cluster ${kind}`, element("span", "number", String(cluster.number)),
    swatch, name, element("span", "size", kind === "named" && more ? "" : percent(cluster.share)), bar);
  button.type = "button";
  button.dataset.cluster = cluster.key;
  button.setAttribute("aria-current", String(isShown));
  button.setAttribute("aria-label",
    `${cluster.region.name}, cluster ${cluster.number}: ${[STATES[kind], text, more].filter(Boolean).join(" ")}, ${percent(cluster.share)} of frames`);
  button.addEventListener("click", (event) => {
    if (event.detail) button.blur(); // keys go to the cluster, not to the row
    chosen(cluster);
  });
  return button;
}

const STATES = { proposed: "proposed:", moved: "moved:", unsafe: "needs you:", named: "named:", merged: "", unsure: "", bare: "" };

/** What a row says of a cluster. */
function told(answers, cluster) {
  const { region, answer, proposed } = cluster;
  if (cluster.unsafe) return { kind: "unsafe", sign: "!", text: "needs you", more: "" };
  if (isNotSure(cluster)) return { kind: "unsure", sign: "?", text: "not sure", more: "" };
  if (isMoved(cluster)) {
    return { kind: "moved", sign: "", text: answers.words(region, answer), more: percent(cluster.agreement) };
  }
  if (answer?.same_as != null) {
    return { kind: "merged", sign: "", text: answers.words(region, answer), more: answers.action(cluster)?.words ?? "" };
  }
  if (answer) return { kind: "named", sign: "", text: answers.words(region, named(answer)), more: answer.note ?? "" };
  if (!proposed?.action) return { kind: "bare", sign: "", text: "no name yet", more: "" };
  const sure = proposed.confidence === null ? "" : percent(proposed.confidence);
  return { kind: "proposed", sign: "", text: answers.words(region, named(proposed)), more: sure };
}

const named = ({ action }) => ({ action, note: null, same_as: null });
