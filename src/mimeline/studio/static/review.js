// The review page: which clip is shown, what is decided on it, and the keys.

import { GROUPS, Clips, decision, inWords, looked, same } from "./clips.js";
import { showFacts, showTime } from "./facts.js";
import { Films } from "./film.js";
import { alarm, ask, byId, element, toast } from "./ground.js";
import { onKeys } from "./keys.js";
import { List } from "./list.js";
import { Outbox } from "./outbox.js";
import { Undo } from "./undo.js";

const AROUND = [1, 2, -1]; // films that are kept ready, seen from the one shown
const REFRESH_MS = 4000;
const REMEMBERED = 30; // facts kept at hand
const SPEEDS = [1, 2];

const usual = [...document.querySelectorAll("[data-reason]")].map((button) => button.dataset.reason);
const clips = new Clips();
const facts = new Map(); // id → promise of what the server tells of a clip
const undoable = new Undo("review"); // steps: { clip_id, was, now }
let place = -1; // of the clip shown, in the list

const shown = () => list.items[place] ?? null;
const number = (n) => n.toLocaleString("en");

const films = new Films(byId("film"), {
  moved: showTime,
  failed: () => tellNoFilm("The browser cannot play this film, or it is no longer there."),
  toggled: (paused) => { byId("paused").hidden = !paused; },
});
const list = new List(byId("list"), byId("rows"), { fill: fillRow, chosen: go });
const outbox = new Outbox({
  path: "/decisions",
  noun: "decision",
  same: (a, b) => a.clip_id === b.clip_id,
  written: ({ before, revision }) => clips.wrote(before, revision),
  refused,
});

// --- which clips -------------------------------------------------------------------------------

function fillGroups() {
  const select = byId("group");
  const chosen = select.value || (clips.all.some(GROUPS.kept.has) ? "kept" : "all");
  select.replaceChildren();
  const option = (value, label, count) => {
    const made = element("option", "", `${label} (${number(count)})`);
    made.value = value;
    select.append(made);
  };
  for (const [name, { label, has }] of Object.entries(GROUPS)) {
    option(name, label, clips.all.filter(has).length);
    const losses = name === "lost" ? clips.losses() : [];
    if (losses.length > 1) for (const [why, count] of losses) option(`why:${why}`, `\u2003${why}`, count);
  }
  select.value = chosen;
}

/** The list anew, as the filters are; the clip shown stays if it is among them. */
function filter(wanted = shown()?.id) {
  const group = byId("group").value;
  const has = group.startsWith("why:") ? (clip) => clip.why === group.slice(4) : GROUPS[group].has;
  const sought = byId("search").value.trim().toLowerCase();
  const onlyUnseen = byId("unseen").checked;
  list.set(clips.all.filter((clip) => has(clip)
    && (!sought || clip.id.toLowerCase().includes(sought))
    && (!onlyUnseen || !looked(clip))));
  const n = list.items.length;
  byId("found").textContent = n === 1 ? "1 clip" : `${number(n)} clips`;
  const at = list.items.findIndex((clip) => clip.id === wanted);
  const first = list.items.findIndex((clip) => !looked(clip));
  go(at >= 0 ? at : Math.max(0, first));
}

function fillRow(button, clip) {
  const [sign, kind] = clip.reason !== null ? ["✕", "out"] : clip.seen ? ["✓", "kept"] : ["·", ""];
  const told = [clip.id, inWords(clip), clip.why, clip.film ? "" : "no film"].filter(Boolean).join(", ");
  if (button.title === told) return;
  button.title = told;
  button.setAttribute("aria-label", told);
  button.classList.toggle("lost", clip.status !== "kept");
  button.classList.toggle("bare", !clip.film);
  button.replaceChildren(
    element("span", `mark ${kind}`, sign),
    element("span", "name", clip.id),
    element("span", "s", clip.film ? `${clip.length_s.toFixed(1)} s` : "no film"),
  );
}

// --- the clip shown ----------------------------------------------------------------------------

function go(to) {
  place = list.items.length ? Math.min(Math.max(to, 0), list.items.length - 1) : -1;
  const clip = shown();
  list.setCurrent(place);
  byId("no-film").hidden = true;
  byId("times").classList.toggle("filmless", !clip?.film);
  const ahead = AROUND.map((by) => list.items[place + by]).filter(Boolean);
  films.show(clip?.film ? clip.id : null, ahead.map((other) => (other.film ? other.id : null)));
  byId("place").textContent = clip ? `${number(place + 1)} of ${number(list.items.length)}` : "";
  byId("previous").disabled = place <= 0;
  byId("next").disabled = place < 0 || place === list.items.length - 1;
  drawDecision();
  if (!clip) {
    tellNoFilm("No clip is in this list.");
    showFacts(null);
    return;
  }
  history.replaceState(null, "", `#${encodeURIComponent(clip.id)}`);
  tellFacts(clip);
  for (const other of ahead) learn(other.id);
}

async function tellFacts(clip) {
  if (!facts.has(clip.id)) showFacts({ id: clip.id, length_s: clip.length_s });
  const known = await learn(clip.id);
  if (shown() !== clip) return; // it was left meanwhile
  if (!known) {
    facts.delete(clip.id);
    return;
  }
  showFacts(known, (seconds) => films.seek(seconds));
  films.setHasSound(known.sound);
  if (!clip.film) tellNoFilm(known.no_film);
}

/** The facts of a clip, asked for once; null where the server has none to give. */
function learn(id) {
  if (!facts.has(id)) {
    facts.set(id, ask(`/clips/${encodeURIComponent(id)}`).then(({ status, body }) => {
      if (status !== 200) alarm(body);
      return status === 200 ? body : null;
    }));
    if (facts.size > REMEMBERED) facts.delete(facts.keys().next().value);
  }
  return facts.get(id);
}

function tellNoFilm(text) {
  byId("no-film").textContent = text;
  byId("no-film").hidden = false;
}

function drawDecision() {
  const clip = shown();
  const out = clip !== null && clip.reason !== null;
  const kept = clip !== null && !out && clip.seen;
  byId("film").classList.toggle("out", out);
  byId("film").classList.toggle("kept", kept);
  byId("verdict").hidden = !out && !kept;
  byId("verdict").classList.toggle("out", out);
  byId("verdict").textContent = clip ? inWords(clip) : "";
  const press = (button, pressed) => button.setAttribute("aria-pressed", String(pressed));
  for (const button of document.querySelectorAll(".decide button")) {
    button.disabled = !clip;
    if ("keep" in button.dataset) press(button, kept);
    if ("reason" in button.dataset) press(button, out && button.dataset.reason === clip.reason);
    if ("other" in button.dataset) press(button, out && !usual.includes(clip.reason));
    if ("undo" in button.dataset) button.disabled = !undoable.steps.length;
  }
}

function drawProgress() {
  const { toDo, kept, out, outInAll } = clips.progress();
  byId("progress").textContent = `${number(kept + out)} of ${number(toDo)} looked at, ${number(outInAll)} left out`;
  const share = (n) => `${toDo ? (100 * n) / toDo : 0}%`;
  byId("gauge-kept").style.width = share(kept);
  byId("gauge-out").style.width = share(out);
}

function redraw() {
  if (document.activeElement !== byId("group")) fillGroups(); // it may be open
  drawDecision();
  drawProgress();
  list.draw();
}

// --- deciding ----------------------------------------------------------------------------------

function set(clip, now) {
  const was = decision(clip);
  Object.assign(clip, now);
  outbox.put({ clip_id: clip.id, was, now });
  return was;
}

function decide(reason) {
  const clip = shown();
  if (!clip) return;
  const now = { seen: true, reason };
  if (!same(now, clip)) {
    undoable.push({ clip_id: clip.id, was: set(clip, now), now });
  }
  const text = `${clip.id} ${inWords(now)}`;
  toast(text);
  const last = place === list.items.length - 1;
  if (!last) go(byId("unseen").checked ? nextUnseen() : place + 1);
  redraw();
  if (!last) return;
  const left = list.items.filter((other) => !looked(other)).length;
  toast(`${text}. That was the last of this list${left ? `, ${number(left)} not looked at yet: N` : ""}.`);
}

function undo() {
  const step = undoable.pop();
  if (!step) {
    toast("Nothing to undo");
    redraw();
    return;
  }
  const clip = clips.byName.get(step.clip_id);
  if (!clip) return;
  if (!same(clip, step.now)) toast(`${clip.id} was decided anew meanwhile: it stays as it is`);
  else {
    set(clip, step.was);
    toast(`Undone: ${clip.id}`);
  }
  reveal(clip);
  redraw();
}

/** Show a clip, in the list that is open where it is in it. */
function reveal(clip) {
  const at = list.items.indexOf(clip);
  if (at >= 0) {
    go(at);
    return;
  }
  byId("search").value = "";
  byId("unseen").checked = false;
  byId("group").value = "all";
  filter(clip.id);
}

function nextUnseen() {
  const n = list.items.length;
  for (let by = 1; by <= n; by += 1) {
    if (!looked(list.items[(place + by) % n])) return (place + by) % n;
  }
  toast("All clips of this list are looked at");
  return place;
}

/** The server keeps to something else: what was decided elsewhere, or to what was before. */
function refused(post, holds, why) {
  const clip = clips.byName.get(post.clip_id);
  Object.assign(clip, holds ?? post.was);
  undoable.forget((step) => step.clip_id === post.clip_id);
  if (holds) toast(`${clip.id} was decided on elsewhere meanwhile, ${inWords(holds)}. It stays so.`);
  else alarm(`${clip.id}: ${why}`);
  redraw();
}

async function refresh() {
  if (document.hidden || !(await clips.refresh(() => !outbox.posts.length))) return;
  redraw();
}

// --- keys and buttons --------------------------------------------------------------------------

function setSpeed(speed) {
  films.setSpeed(speed);
  byId("speed").textContent = `${speed}×`;
  byId("speed").setAttribute("aria-label", `Speed ${speed}×`);
  sessionStorage.setItem("speed", speed);
}

const changeSpeed = () => setSpeed(SPEEDS[(SPEEDS.indexOf(films.speed) + 1) % SPEEDS.length]);

function changeSound() {
  films.setSounding(!films.sounding);
  byId("sound").setAttribute("aria-pressed", String(films.sounding));
  byId("sound").textContent = films.sounding ? "Sound on" : "Sound off";
}

function askOther() {
  if (!shown()) return;
  byId("other-reasons").replaceChildren(...clips.otherReasons(usual).map((reason) => {
    const option = element("option");
    option.value = reason;
    return option;
  }));
  const now = shown().reason;
  byId("other-reason").value = now && !usual.includes(now) ? now : "";
  byId("other-complaint").textContent = "Kept in the list as the reason.";
  byId("other").showModal();
  byId("other-reason").select();
}

byId("other-form").addEventListener("submit", (event) => {
  const reason = byId("other-reason").value.trim().replace(/\s+/g, " ");
  if (reason && !/^[=+\-@]/.test(reason)) {
    decide(reason);
    return;
  }
  event.preventDefault();
  byId("other-complaint").textContent = reason
    ? "A table program would take that for a formula: begin with a letter."
    : "Say in a word why, or cancel.";
});

async function stepFrame(by) {
  const clip = shown();
  const known = clip && (await learn(clip.id));
  if (known && shown() === clip) films.step(by, known.fps ?? 25);
}

const actions = {
  " ": () => films.toggle(),
  ArrowLeft: () => go(place - 1),
  ArrowRight: () => go(place + 1),
  Enter: () => decide(null),
  k: () => decide(null),
  u: undo,
  n: () => go(nextUnseen()),
  m: changeSound,
  s: changeSpeed,
  ",": () => stepFrame(-1),
  ".": () => stepFrame(1),
  "/": () => byId("search").focus(),
  "?": () => byId("help").showModal(),
};
usual.forEach((reason, at) => { actions[at + 1] = () => decide(reason); });
actions[usual.length + 1] = askOther;
onKeys(actions, ["ArrowLeft", "ArrowRight", ",", "."]); // a held key decides nothing

for (const button of document.querySelectorAll("[data-reason]")) {
  button.addEventListener("click", () => decide(button.dataset.reason));
}
document.querySelector("[data-keep]").addEventListener("click", () => decide(null));
document.querySelector("[data-other]").addEventListener("click", askOther);
document.querySelector("[data-undo]").addEventListener("click", undo);
byId("other-cancel").addEventListener("click", () => byId("other").close());
byId("previous").addEventListener("click", () => go(place - 1));
byId("next").addEventListener("click", () => go(place + 1));
byId("speed").addEventListener("click", changeSpeed);
byId("sound").addEventListener("click", changeSound);
byId("help-open").addEventListener("click", () => byId("help").showModal());
byId("seek").addEventListener("input", (event) => films.seek(event.target.value * films.length));
byId("seek").addEventListener("pointerup", (event) => event.target.blur());
byId("search").addEventListener("input", () => filter());
byId("group").addEventListener("change", (event) => { filter(); event.target.blur(); });
byId("unseen").addEventListener("change", (event) => { filter(); event.target.blur(); });
document.addEventListener("visibilitychange", refresh);

// --- the beginning -----------------------------------------------------------------------------

async function start() {
  if (!(await clips.load())) return;
  await clips.refresh(() => true);
  fillGroups();
  const wanted = wantedByAddress();
  filter(wanted);
  if (clips.byName.has(wanted) && shown()?.id !== wanted) reveal(clips.byName.get(wanted));
  drawProgress();
  setSpeed(Number(sessionStorage.getItem("speed")) || 1);
  setInterval(refresh, REFRESH_MS);
}

function wantedByAddress() {
  try {
    return decodeURIComponent(location.hash.slice(1));
  } catch {
    return "";
  }
}

start();
