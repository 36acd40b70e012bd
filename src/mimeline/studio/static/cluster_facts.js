// What is known of the cluster shown, in words.

import { isAnswered, isMoved, named } from "./answers.js";
import { colourOf, percent, titled } from "./cluster_list.js";
import { lineOf } from "./curves.js";
import { byId, element } from "./ground.js";

const APART = [[1, "hard to tell apart"], [4, "near"], [10, "clearly apart"], [Infinity, "far apart"]]; // nats a frame

export function drawFacts(answers, cluster) {
  const { region } = cluster;
  byId("heading").replaceChildren(`${titled(region.name)}, cluster ${cluster.number}`);
  document.title = `${region.name} ${cluster.number} · Label`;
  drawState(answers, cluster);
  byId("facts").replaceChildren(...[
    ["Size", size(cluster)],
    ["Within", within(cluster)],
    ["Closest", closest(answers, cluster)],
    ["Proposal", proposal(cluster)],
  ].filter(([, text]) => text).map(([name, text]) => element("div", "", element("dt", "", name), element("dd", "", text))));
  byId("legend").replaceChildren(...region.channels.map(line), ...notes(region));
}

/** The name that it bears now, beside the heading. */
function drawState(answers, cluster) {
  const { region, answer, agreement, unsafe, proposed } = cluster;
  const chip = byId("state");
  const colour = colourOf(answers.action(cluster));
  chip.style.setProperty("--of", colour ?? "transparent");
  const [kind, text] = unsafe ? ["unsafe", `Needs you: ${unsafe}`]
    : isMoved(cluster) ? ["moved", `Moved: ${answers.words(region, answer)}, as ${percent(agreement)} of its frames before`]
    : isAnswered(cluster) ? ["named", answers.words(region, answer) + (answer.same_as === null ? "" : ` (${answers.action(cluster)?.words ?? "no name yet"})`)]
    : proposed?.action ? ["proposed", `Proposed: ${answers.words(region, named(proposed.action))}${sure(proposed)}`]
    : ["bare", "No name yet"];
  chip.className = `state ${kind}`;
  chip.replaceChildren(element("i"), text);
}

function size({ share, n_intervals: intervals, n_clips: clips, median_s: s, median_frames: frames }) {
  const typical = s === null ? `${Math.round(frames)} frames` : `${s.toFixed(s < 10 ? 1 : 0)} s`;
  return `${percent(share)} of frames: ${count(intervals, "interval")} in ${count(clips, "clip")}, typically ${typical}`;
}

const count = (n, noun) => `${n.toLocaleString("en")} ${noun}${n === 1 ? "" : "s"}`;

function within({ purity, proposed }) {
  if (proposed === null) return ""; // a second person is not told
  return purity === null ? "How alike it is cannot be told" : `About ${Math.round(100 * purity)} % of it looks alike`;
}

function closest(answers, { region, nearest, distance }) {
  if (nearest === null) return "";
  const other = region.clusters.find((cluster) => cluster.number === nearest);
  const root = other && answers.root(other);
  const bears = root?.answer ? answers.words(region, root.answer) : answers.action(other)?.words;
  const apart = distance === null ? "" : `, ${APART.find(([most]) => distance < most)[1]}`;
  return `Cluster ${nearest}${bears ? ` (${bears})` : ""}${apart}`;
}

const sure = ({ confidence }) => (confidence === null ? "" : `, ${percent(confidence)} sure`);

/** Why there is none, or what speaks against it; the proposal itself stands beside the heading. */
function proposal({ proposed }) {
  if (!proposed) return "";
  return proposed.action ? proposed.why ?? "" : `None: ${proposed.why || "no rule fits"}`;
}

function line(channel, place) {
  const key = element("i");
  key.style.setProperty("--of", lineOf(place));
  return element("span", "", key, channel);
}

function notes(region) {
  const words = (name) => region.actions.find((action) => action.name === name)?.words ?? name;
  const left = region.left_out.length ? `${region.left_out.join(", ")} hardly moves and is left out` : "";
  const blind = region.unmeasured.length ? `No channel tells ${region.unmeasured.map(words).join(", ")}` : "";
  return [left, blind].filter(Boolean).map((text) => element("em", "", text));
}
