// The page for naming clusters: which one is shown, what is said of it, and the keys.

import { Answers, NOT_SURE, isAnswered, isMoved, named, same, sameAs } from "./answers.js";
import { Card } from "./card.js";
import { drawFacts } from "./cluster_facts.js";
import { colourOf, drawList, percent, titled } from "./cluster_list.js";
import { drawDone } from "./done.js";
import { Exemplars, firstOf } from "./exemplars.js";
import { askFiner } from "./finer.js";
import { alarm, byId, toast } from "./ground.js";
import { onKeys } from "./keys.js";
import { askMerge } from "./merge.js";
import { accepted, drawButtons } from "./name_buttons.js";
import { Outbox } from "./outbox.js";
import { askPerson } from "./persons.js";
import { Player } from "./player.js";
import { Undo } from "./undo.js";

const REFRESH_MS = 4000;
const AHEAD = 2; // clusters whose pictures are loaded before they are shown
const A_ROW = 5; // exemplars more, for one who is not sure
const SLOW_MS = 150; // what takes longer: the cards of the cluster before go at once
const SPEEDS = [1, 0.5, 2];
const VIEWS = {
  film: ["Film", "Film, and the drawn face where there is none. V: the drawn face of all"],
  face: ["Drawn face", "The face that the channels draw. V: the film"],
};
const STARTED = document.body.dataset.person; // who the page was started for
const CHOSEN = `person-of-${STARTED}`; // who answers since, for when it is loaded anew

const answers = new Answers();
const exemplars = new Exemplars();
const player = new Player({ toggled: (paused) => { byId("paused").hidden = !paused; } });
const outbox = new Outbox({
  path: "/answers",
  noun: "answer",
  same: (a, b) => a.region === b.region && a.cluster === b.cluster,
  written: (body, post) => {
    if (post.person !== answers.person) return;
    answers.wrote(body);
    wasWritten(post, body.now ?? post.now);
    prepareNext();
  },
  refused,
});
let undoable; // steps: { key, was, now, unsafe }
let shown = null; // a cluster; null: all is answered
let cards = [];
let slow; // the timer that takes the cards of the cluster before
let view = sessionStorage.getItem("view") ?? "film";
let justNamed = null; // the cluster that was named last, for its finer name
const looked = new Map(); // key → how many of its exemplars are shown

// --- the cluster shown -------------------------------------------------------------------------

async function show(cluster) {
  clearTimeout(slow); // that of a cluster that was left would take this one's cards
  shown = cluster;
  document.body.classList.toggle("finished", !cluster);
  history.replaceState(null, "", cluster ? `#${cluster.key}` : location.pathname);
  redraw();
  if (!cluster) {
    clearCards();
    return;
  }
  exemplars.giveUpBut(cluster);
  slow = setTimeout(clearCards, SLOW_MS);
  const all = await exemplars.of(cluster);
  if (!isShown(cluster)) return; // it was left meanwhile
  clearTimeout(slow);
  clearCards();
  addCards(all ?? []);
  byId("stage").scrollTop = 0;
  byId("legend").style.marginBottom = "";
  redraw(); // how many there are is known now
  prepareNext();
}

/** What is told of a cluster may have been loaded anew since. */
const isShown = (cluster) => shown?.key === cluster.key;

function clearCards() {
  for (const card of cards) {
    player.parts.delete(card);
    card.remove();
  }
  cards = [];
}

/** The cards that are to be seen and are not yet. */
function addCards(all) {
  const most = Math.max(firstOf(all).length, shown.n_shown, looked.get(shown.key) ?? 0);
  const wanted = all.slice(cards.length, most);
  const added = wanted.map((one) => new Card(one, shown.region, view, player.paused));
  byId("cards").append(...added.map((card) => card.box));
  for (const card of added) {
    card.begin();
    player.parts.add(card);
  }
  cards.push(...added);
}

/** Have the pictures of the clusters that come next ready, once those that are looked at are there. */
async function prepareNext() {
  const current = shown;
  if (current) await exemplars.prepare(current, view);
  if (shown !== current) return;
  const wanted = answers.next.map((key) => answers.byKey.get(key));
  const ahead = wanted.filter((cluster) => cluster && cluster !== shown && !isAnswered(cluster)).slice(0, AHEAD);
  for (const cluster of ahead) exemplars.prepare(cluster, view);
}

function redraw() {
  drawList(answers, shown, show);
  drawProgress();
  if (!shown) {
    drawDone(answers, show);
    return;
  }
  drawFacts(answers, shown);
  drawMoved(shown.region);
  drawButtons(answers, shown, {
    more: hasMore(), canUndo: undoable.steps.length > 0,
    accept, name: (action) => say(named(action)), unsure, merge, finer, undo,
  });
  byId("cards").style.setProperty("--of", colourOf(answers.action(shown)) ?? "var(--soft)");
}

function drawProgress() {
  const { n, named: sure, notSure, moved, namedFrames, movedFrames } = answers.progress();
  const more = [moved && `${moved} moved`, notSure && `${notSure} not sure`].filter(Boolean);
  byId("progress").textContent = [`${sure} of ${n} named`, ...more, `${percent(namedFrames)} of frames`].join(" · ");
  byId("gauge-named").style.width = `${100 * namedFrames}%`;
  byId("gauge-moved").style.width = `${100 * movedFrames}%`;
  byId("who").hidden = !answers.person;
  byId("who").textContent = `${answers.person} answers, blind`;
}

/** After a refit: how much of the region kept its name. */
function drawMoved(region) {
  byId("moved").hidden = !region.moved;
  if (!region.moved) return;
  const { kept, known } = region.moved;
  const unknown = known !== null && known < 0.995 ? `; ${percent(1 - known)} of the frames are new` : "";
  byId("moved-text").textContent = kept === 0 ? `${titled(region.name)}: fitted anew, and no name of the fit before could be moved.`
    : `${titled(region.name)}: names moved from the fit before. ${percent(kept)} of the frames keep theirs${unknown}.`;
  const safe = region.clusters.filter(isMoved).length;
  byId("keep-all").hidden = !safe;
  byId("keep-all").textContent = safe === 1 ? "Keep the name" : `Keep all ${safe} names`;
}

// --- answering ---------------------------------------------------------------------------------

/** Set a cluster's answer and send it. */
function set(cluster, now, unsafe = "") {
  const { region } = cluster;
  const post = {
    person: answers.person, region: region.name, fit: region.fit, cluster: cluster.number, was: cluster.answer, now,
    shown: cardsOf(cluster).map((card) => card.exemplar.rank),
  };
  if (region.moved) settle(region); // the first answer writes the whole region for this fit
  const step = { key: cluster.key, was: cluster.answer, now, unsafe: cluster.unsafe };
  Object.assign(cluster, { answer: now, unsafe });
  outbox.put(post);
  return step;
}

/** What the server writes of a region whose names were moved: they hold, the rest stays open. */
function settle(region) {
  region.moved = null;
  for (const cluster of region.clusters) cluster.agreement = null;
}

function say(now) {
  const cluster = shown;
  if (!cluster) return;
  const text = `${titled(cluster.region.name)} ${cluster.number}: ${answers.words(cluster.region, now)}`;
  if (!isAnswered(cluster) || !same(cluster.answer, now)) undoable.push(set(cluster, now));
  justNamed = now.action ? cluster : null;
  toast(now.action && !now.note ? `${text}. F for a finer name` : text);
  show(answers.mostWorth(cluster) ?? null);
}

function accept() {
  const now = shown && accepted(shown);
  if (now) say(now);
  else next();
}

/** Its cards, none while those of the cluster before still stand. */
const cardsOf = (cluster) => cards.filter((card) => card.exemplar.cluster.key === cluster.key);

function hasMore() {
  return shown !== null && cardsOf(shown).length < shown.n_exemplars;
}

async function unsure() {
  const cluster = shown;
  if (!cluster || (cluster.n_exemplars && !cardsOf(cluster).length)) return; // nothing was seen yet
  if (!hasMore()) {
    say(NOT_SURE);
    return;
  }
  looked.set(cluster.key, Math.min(cluster.n_exemplars, cards.length + A_ROW));
  const all = await exemplars.of(cluster);
  if (!isShown(cluster)) return;
  const before = cards.length;
  addCards(all ?? []);
  redraw();
  if (cards.length) showLastRow();
  const left = cluster.n_exemplars - cards.length;
  toast(`${cards.length - before} more, chosen where they tell most. X again: ${left ? `${left} more` : "leave it as not sure"}`);
}

/** Bring the last row into sight, no further than needed, with whole rows above. */
function showLastRow() {
  const [stage, legend] = [byId("stage"), byId("legend")];
  const tops = cards.map((card) => card.box.offsetTop - cards[0].box.offsetTop);
  const last = tops.at(-1);
  const hidden = last + cards.at(-1).box.offsetHeight - stage.clientHeight;
  if (hidden <= stage.scrollTop) return;
  const wanted = Math.min(last, tops.find((top) => top >= hidden) ?? last);
  legend.style.marginBottom = `${Math.max(0, wanted + stage.clientHeight - stage.scrollHeight)}px`;
  stage.scrollTop = wanted;
}

function merge() {
  if (!shown) return;
  const cluster = shown;
  askMerge(answers, exemplars, player, cluster, view, (other) => isShown(cluster) && still(cluster) && say(sameAs(other.number)));
}

/** What a dialog asked about, as it is told now; null, and said, where it was answered elsewhere meanwhile. */
function still(cluster) {
  const told = answers.byKey.get(cluster.key);
  if (told && same(told.answer, cluster.answer)) return told;
  toast(`${titled(cluster.region.name)} ${cluster.number} was answered elsewhere meanwhile: it stays as it is`);
  return null;
}

/** For the cluster shown where it has a name, else for the one that was just named. */
function finer() {
  const hasName = (cluster) => cluster && isAnswered(cluster) && cluster.answer.action !== null;
  const cluster = [shown, justNamed].find(hasName);
  if (!cluster) {
    toast("Name it first, then F for a finer name");
    return;
  }
  askFiner(answers, cluster, (note) => {
    const now = named(cluster.answer.action, note);
    const told = still(cluster);
    if (!told || same(told.answer, now)) return;
    undoable.push(set(told, now));
    toast(`${titled(told.region.name)} ${told.number}: ${answers.words(told.region, now)}`);
    redraw();
  });
}

function undo() {
  const step = undoable.pop();
  const cluster = step && answers.byKey.get(step.key);
  if (!cluster) {
    toast("Nothing to undo");
    redraw();
    return;
  }
  if (!same(cluster.answer, step.now)) toast(`${cluster.region.name} ${cluster.number} was answered anew meanwhile: it stays as it is`);
  else {
    set(cluster, step.was, step.unsafe);
    toast(`Undone: ${cluster.region.name} ${cluster.number}`);
  }
  show(cluster);
}

/** The safe names of the region, all at once: to write one of them writes them all. */
function keepAll() {
  const region = shown?.region;
  const moved = region?.clusters.filter(isMoved) ?? [];
  if (!moved.length) return;
  set(moved[0], moved[0].answer);
  toast(`${titled(region.name)}: ${moved.length} names kept`);
  show(answers.mostWorth(null) ?? null);
}

/** A merger is written into the root of the cluster that was named. */
function wasWritten(post, now) {
  const cluster = answers.byKey.get(`${post.region}/${post.cluster}`);
  if (!cluster || same(post.now, now)) return;
  if (same(cluster.answer, post.now)) cluster.answer = now;
  for (const step of undoable.steps) if (step.key === cluster.key && same(step.now, post.now)) step.now = now;
  redraw();
}

/** The server keeps to something else: what was said elsewhere, or what was before. */
function refused(post, conflict, why) {
  const cluster = answers.byKey.get(`${post.region}/${post.cluster}`);
  if (!cluster || post.person !== answers.person) return;
  cluster.answer = conflict ? conflict.holds : post.was;
  undoable.forget((step) => step.key === cluster.key);
  const name = `${cluster.region.name} ${cluster.number}`;
  if (conflict) toast(`${name} was answered elsewhere meanwhile, ${answers.words(cluster.region, cluster.answer)}. It stays so.`);
  else alarm(`${name}: ${why}`);
  redraw();
}

async function refresh() {
  if (document.hidden || !(await answers.refresh(() => !outbox.posts.length))) return;
  shown = shown && (answers.byKey.get(shown.key) ?? null);
  redraw();
}

// --- walking, keys and buttons -----------------------------------------------------------------

function walk(by) {
  const at = shown ? answers.all.indexOf(shown) + by : by > 0 ? 0 : answers.all.length - 1;
  if (answers.all[at]) show(answers.all[at]);
}

function next() {
  const cluster = answers.mostWorth(shown);
  if (cluster || !shown || isAnswered(shown) || isMoved(shown)) show(cluster ?? null);
  else toast("This is the last one without a name");
}

function setSpeed(speed) {
  player.speed = speed;
  byId("speed").textContent = `${speed === 0.5 ? "½" : speed}×`;
  byId("speed").setAttribute("aria-label", `Speed ${speed}×`);
  sessionStorage.setItem("speed", speed);
}

const changeSpeed = () => setSpeed(SPEEDS[(SPEEDS.indexOf(player.speed) + 1) % SPEEDS.length]);

function setView(wanted) {
  view = wanted;
  sessionStorage.setItem("view", view);
  [byId("view").textContent, byId("view").title] = VIEWS[view];
  for (const card of cards) card.setView(view);
  prepareNext();
}

const changeView = () => setView(view === "film" ? "face" : "film");

/** Whether the server tells what a person has answered; from then on they answer. */
async function begin(person) {
  if (!(await answers.load(person))) return false;
  exemplars.person = person;
  undoable = new Undo(`label-${person}`);
  byId("help-file").textContent = answers.told.file;
  return true;
}

async function change(person) {
  if (!(await begin(person))) return;
  sessionStorage.setItem(CHOSEN, person);
  justNamed = null;
  looked.clear();
  toast(person ? `${person} answers now, blind` : "The first person answers now"); // and no answer of another's stands
  show(answers.mostWorth(null) ?? null);
}

const second = () => askPerson(answers, STARTED, change, show);

const actions = {
  " ": () => player.toggle(),
  ArrowUp: () => walk(-1),
  ArrowLeft: () => walk(-1),
  ArrowDown: () => walk(1),
  ArrowRight: () => walk(1),
  Enter: accept,
  x: unsure,
  m: merge,
  f: finer,
  u: undo,
  n: next,
  p: second,
  s: changeSpeed,
  v: changeView,
  ",": () => player.step(-1),
  ".": () => player.step(1),
  "?": () => byId("help").showModal(),
};
for (let digit = 0; digit <= 9; digit += 1) {
  actions[digit] = () => {
    const action = shown?.region.actions.find(({ key }) => key === String(digit));
    if (action) say(named(action.name));
  };
}
onKeys(actions, ["ArrowUp", "ArrowLeft", "ArrowDown", "ArrowRight", ",", "."]); // a held key names nothing

byId("speed").addEventListener("click", changeSpeed);
byId("view").addEventListener("click", changeView);
byId("person-open").addEventListener("click", second);
byId("done-second").addEventListener("click", second);
byId("help-open").addEventListener("click", () => byId("help").showModal());
byId("previous").addEventListener("click", () => walk(-1));
byId("next").addEventListener("click", () => walk(1));
byId("keep-all").addEventListener("click", keepAll);
for (const button of document.querySelectorAll("[data-close]")) {
  button.addEventListener("click", () => button.closest("dialog").close());
}
addEventListener("hashchange", () => {
  const cluster = byAddress();
  if (cluster && cluster !== shown) show(cluster);
});

// --- the beginning -----------------------------------------------------------------------------

const byAddress = () => answers.byKey.get(location.hash.slice(1));

async function start() {
  if (!(await begin(sessionStorage.getItem(CHOSEN) ?? STARTED))) return;
  setSpeed(Number(sessionStorage.getItem("speed")) || 1);
  setView(view);
  await show(byAddress() ?? answers.mostWorth(null) ?? null);
  setInterval(refresh, REFRESH_MS);
  document.addEventListener("visibilitychange", refresh);
}

start();
