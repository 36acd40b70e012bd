// What is known of the clip shown: its facts, its actions as tracks under the film, the run's ledger.

import { byId, element } from "./ground.js";

let lengthS = 0; // of the clip, by its tables

/** seek(seconds): called for a place in the film that a decision names. null: nothing to tell. */
export function showFacts(clip, seek = () => {}) {
  lengthS = clip?.length_s ?? 0;
  byId("clip-id").textContent = clip?.id ?? "";
  document.title = clip ? `${clip.id} · Review` : "Review";
  byId("facts").replaceChildren(...(clip?.facts ?? []).flatMap(([name, text]) => [
    element("dt", "", name), element("dd", "", text),
  ]));
  byId("ledger").replaceChildren(...(clip?.ledger ?? []).map((row) => ledgerRow(row)));
  byId("texts").replaceChildren(...(clip?.texts ?? []).map((text) => element("p", "", text)));
  byId("texts-part").hidden = !clip?.texts?.length;
  const broken = (clip?.ledger ?? []).filter((row) => row.frames && clip.fps);
  byId("tracks").replaceChildren(
    ...broken.map((row) => brokenTrack(row, clip.fps, seek)),
    ...(clip?.tracks ?? []).map((one) => track(one.name, one.kind, one.spans)),
  );
}

/** The clock, the slider and the line across the tracks. length: the film's own, in seconds. */
export function showTime(seconds, length) {
  byId("clock").textContent = `${seconds.toFixed(1)} / ${(length || lengthS).toFixed(1)} s`;
  const slider = byId("seek");
  const share = length ? Math.min(1, seconds / length) : 0;
  if (!slider.matches(":active")) slider.value = share;
  slider.setAttribute("aria-valuetext", `${seconds.toFixed(1)} seconds`);
  for (const line of document.querySelectorAll(".lane b")) line.style.left = `${100 * share}%`;
}

function ledgerRow({ stage, status, rule, measured, frames, detail }) {
  const where = frames && (frames[0] === frames[1] ? `frame ${frames[0]}` : `frames ${frames[0]}–${frames[1]}`);
  const more = [measured, where, detail].filter(Boolean).join("; ");
  const said = element("span", `status ${status}`, rule && status !== "kept" ? `${status}: ${rule}` : status);
  const cell = element("span", "", said);
  if (rule && status === "kept") cell.append(element("small", "", rule));
  if (more) cell.append(element("small", "", more));
  return element("li", "", element("span", "stage-name", stage), cell);
}

function brokenTrack({ stage, rule, frames, status }, fps, seek) {
  const [first, last] = frames;
  const made = track(stage, status === "kept" ? "noted" : "broken", [[first / fps, (last + 1) / fps, 0]]);
  made.title = rule;
  made.querySelector(".lane").addEventListener("click", () => seek((first + 0.5) / fps));
  return made;
}

/** spans: start, end and how far each edge may be off, in seconds. */
function track(name, kind, spans) {
  const lane = element("div", "lane");
  for (const [start, end, unsure] of spans) {
    if (unsure > 0) lane.append(bar(start - unsure, end + unsure, "unsure"));
    lane.append(bar(start, end, ""));
  }
  lane.append(element("b"));
  const label = element("span", "label", name);
  const made = element("div", `track ${kind}`, label, lane);
  const told = spans.map(([start, end]) => `${start.toFixed(1)}–${end.toFixed(1)} s`).join(", ");
  made.title = `${name}: ${told}`;
  return made;
}

function bar(start, end, className) {
  const made = element("i", className);
  const from = Math.max(0, start);
  const to = Math.min(lengthS, end);
  made.style.left = `${(100 * from) / (lengthS || 1)}%`;
  made.style.width = `${(100 * Math.max(0, to - from)) / (lengthS || 1)}%`;
  return made;
}
