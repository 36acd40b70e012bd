// The rating page: which pair is shown, what is answered on it, and the keys.

import { alarm, byId, element, toast } from "./ground.js";
import { onKeys } from "./keys.js";
import { Outbox } from "./outbox.js";
import { Looked } from "./rate_looked.js";
import { Pairs } from "./rate_pairs.js";
import { Questions } from "./rate_questions.js";
import { Timeline } from "./rate_timeline.js";
import { FaceView, FilmView } from "./rate_views.js";
import { Undo } from "./undo.js";

const SPEEDS = { 1: "1×", 0.5: "½×" };
const NOTED_MS = 700; // that an answered pair stays to be seen
const AHEAD = 2; // pairs that are asked for before they are shown

const pairs = new Pairs();
const timeline = new Timeline({ scrubbed, began: hold, ended: letGo });
const outbox = new Outbox({
  path: "/answers",
  noun: "answer",
  same: (a, b) => a.id === b.id,
  written: drawDone,
  refused: (post, holds, why) => refused(why),
});
let questions = null;
let undoable = null; // steps: { id, question, was }, was null where there was no answer
let view = null; // of all pairs: films, or faces
let screen = "";
let place = -1; // of the pair shown
let goingOn = 0; // the timer, while an answered pair is still to be seen
let speed = 1;
let held = null; // whether it was paused as the pointer went down
const looked = new Looked();
let isThere = false; // its picture
let isLost = false; // and never will be

const shown = () => pairs.all[place] ?? null;
const number = (n) => n.toLocaleString("en");
const clips = (n) => (n === 1 ? "1 clip" : `${number(n)} clips`);

// --- screens -----------------------------------------------------------------------------------

function show(name) {
  screen = name;
  for (const id of ["intro", "work", "done"]) byId(id).hidden = id !== name;
  for (const id of ["progress", "previous", "next", "undo"]) byId(id).hidden = name === "intro";
  (name === "work" ? byId("picture") : document.querySelector("main")).append(byId("toast"));
  if (name !== "work") {
    isThere = false;
    place = name === "done" ? pairs.all.length : -1;
    keepTime();
    view?.hide();
  }
  drawProgress();
}

function begin() {
  if (screen !== "intro") return;
  sessionStorage.setItem(`rating-${pairs.person}`, "begun");
  goOn(-1);
}

function finish() {
  stay();
  show("done");
  drawDone();
}

function drawIntro() {
  byId("intro-pairs").textContent = clips(pairs.all.length);
  byId("intro-questions").replaceChildren(...pairs.questions.map(({ text }) => element("li", "", text)));
  const { done } = pairs;
  if (done) byId("begin").firstChild.data = `Go on, ${done} of ${pairs.all.length} are answered `;
}

function drawDone() {
  if (screen !== "done") return;
  const unseen = pairs.all.filter(({ answers }) => Object.values(answers).includes(pairs.unseen)).length;
  byId("done-what").replaceChildren(
    `The answers on ${clips(pairs.all.length)} are ${outbox.posts.length ? "on their way" : "written"} to `,
    element("code", "", pairs.file), unseen ? `. Of ${clips(unseen)} there was no picture.` : ".",
  );
  byId("done-command").textContent = `mimeline ratings ${quoted(pairs.file)}`;
}

/** A path as a shell takes it. */
const quoted = (path) => (/^[\w@%+=:,./-]+$/.test(path) ? path : `'${path.replaceAll("'", `'"'"'`)}'`);

// --- the pair shown ----------------------------------------------------------------------------

async function go(to) {
  stay();
  if (to >= pairs.all.length) {
    const open = pairs.nextOpen(place);
    if (open >= 0) toast(`That is the last one. ${number(pairs.all.length - pairs.done)} not answered yet: N`);
    else finish();
    return;
  }
  if (to < 0) return;
  isThere = false;
  place = to;
  const pair = shown();
  questions.markOpen(pair.answers);
  if (screen !== "work") show("work");
  byId("work").classList.add("coming");
  waits("Loading …");
  redraw();
  const facts = await pairs.learn(pair);
  if (shown() !== pair) return; // it was left meanwhile
  if (!facts) {
    waits("It did not come");
    return;
  }
  byId("work").classList.remove("coming");
  timeline.set(facts);
  view ??= viewOf(facts);
  view.setSpeed(speed);
  view.show(facts);
  const ahead = await aheadOf(place);
  if (shown() === pair) view.prepare(ahead);
}

/** What is known of the pairs after a place. */
async function aheadOf(from) {
  const after = pairs.all.slice(from + 1, from + 1 + AHEAD);
  const known = await Promise.all(after.map((pair) => pairs.learn(pair)));
  return known.filter(Boolean);
}

function viewOf(facts) {
  const heard = { moved: (frame) => timeline.moved(frame), toggled, waits, failed };
  return facts.view === "film" ? new FilmView(heard) : new FaceView(heard);
}

/** Why there is no picture; "": there is. */
function waits(why) {
  byId("no-picture").hidden = !why;
  byId("why-none").textContent = why;
  isThere = !why;
  byId("unseen").hidden = true;
  isLost = false;
  keepTime();
}

/** Nothing will come: they may go on without. */
function failed(why) {
  waits(why);
  isLost = true;
  byId("unseen").hidden = false;
  refresh(); // an alarm tells where it is the server that is gone
}

/** A page in the background is not looked at. */
const keepTime = () => looked.at(isThere && !document.hidden ? shown().id : null);

function toggled(paused) {
  byId("paused").hidden = !paused;
  byId("play").firstElementChild.textContent = paused ? "Play" : "Pause";
}

/** On to the next pair that has not all its answers, after a place; past the last: all have. */
function goOn(from) {
  const open = pairs.nextOpen(from);
  if (open < 0) finish();
  else go(open);
}

function redraw() {
  if (shown()) questions.draw(shown().answers);
  drawProgress();
}

function drawProgress() {
  const { length } = pairs.all;
  const { done } = pairs;
  const at = shown() ? `${number(place + 1)} of ${number(length)}` : "";
  if (byId("place").textContent !== at) byId("place").textContent = at;
  byId("answered").textContent = done === length ? "all answered" : `${number(done)} answered`;
  byId("gauge-answered").style.width = `${length ? (100 * done) / length : 0}%`;
  byId("previous").disabled = place <= 0;
  byId("next").disabled = place >= length - 1 && done < length;
  byId("next").hidden = screen !== "work";
  byId("undo").disabled = !undoable?.steps.length;
}

// --- answering ---------------------------------------------------------------------------------

/** value null: no answer. */
function set(pair, question, value) {
  const was = pair.answers[question] ?? null;
  if (value === null) delete pair.answers[question];
  else pair.answers[question] = value;
  keepTime();
  outbox.put({ id: pair.id, answers: { [question]: value }, seconds: looked.seconds(pair.id) });
  return was;
}

function answer(question, value) {
  const pair = shown();
  if (!pair || goingOn) return;
  if (!isThere) {
    toast(isLost ? "There is nothing to be seen" : "Nothing is to be seen yet");
    return;
  }
  const wasAnswered = pairs.isAnswered(pair);
  give(pair, question, value);
  for (const { name } of pairs.questions) if (pair.answers[name] === pairs.unseen) give(pair, name, null);
  const at = pairs.questions.findIndex(({ name }) => name === question);
  const isLast = at === pairs.questions.length - 1;
  if (!pairs.isAnswered(pair)) questions.markOpen(pair.answers);
  else if (wasAnswered && !isLast) questions.mark(at + 1); // they go through it once more
  else goOnSoon(pairs.questions.map(({ name }) => questions.words(pair.answers[name]).toLowerCase()).join(" · "));
  redraw();
}

/** An answer, or none, that can be taken back. */
function give(pair, question, value) {
  if ((pair.answers[question] ?? null) === value) return;
  undoable.push({ id: pair.id, question, was: set(pair, question, value) });
}

/** There is no picture to judge. */
function passOver() {
  const pair = shown();
  if (!pair || !isLost || goingOn) return;
  for (const { name } of pairs.questions) give(pair, name, pairs.unseen);
  goOnSoon("no picture");
  redraw();
}

/** The pair has its answers: it is seen for a moment what was said. */
function goOnSoon(said) {
  toast(`✓ ${number(place + 1)}: ${said}`);
  byId("questions").classList.add("noted");
  goingOn = setTimeout(() => goOn(place), NOTED_MS);
}

function stay() {
  clearTimeout(goingOn);
  goingOn = 0;
  byId("questions").classList.remove("noted");
}

function answerMarked(value) {
  if (screen === "work") answer(questions.current, value);
}

function undo() {
  if (screen === "intro") return;
  const step = undoable.pop();
  const at = pairs.all.findIndex(({ id }) => id === step?.id);
  if (at < 0) {
    toast("Nothing to take back");
    redraw();
    return;
  }
  stay();
  set(pairs.all[at], step.question, step.was);
  if (at !== place) go(at);
  questions.mark(pairs.questions.findIndex(({ name }) => name === step.question));
  redraw();
  toast(step.was === null ? `Taken back, ${number(at + 1)} is open again` : `Taken back: ${questions.words(step.was).toLowerCase()}`);
}

/** The server would not take it: what it holds counts. */
async function refused(why) {
  await pairs.refresh(() => !outbox.posts.length);
  alarm(why);
  redraw();
}

async function refresh() {
  keepTime();
  if (document.hidden) return;
  await pairs.refresh(() => !outbox.posts.length);
  redraw();
  drawDone();
}

// --- keys and buttons --------------------------------------------------------------------------

function scrubbed(frame) {
  view?.seek(frame);
  timeline.moved(frame);
}

function hold() {
  held = view?.paused ?? true;
  view?.pause();
}

function letGo() {
  if (held === false) view?.play();
  held = null;
}

function setSpeed(wanted) {
  speed = wanted in SPEEDS ? wanted : 1;
  view?.setSpeed(speed);
  byId("speed").textContent = SPEEDS[speed];
  byId("speed").setAttribute("aria-label", `Speed ${SPEEDS[speed]}`);
  sessionStorage.setItem("speed", speed);
}

const changeSpeed = () => setSpeed(speed === 1 ? 0.5 : 1);
const inWork = (act) => () => screen === "work" && act();

const actions = {
  " ": inWork(() => view?.toggle()),
  ",": inWork(() => view?.step(-1)),
  ".": inWork(() => view?.step(1)),
  ArrowLeft: () => screen !== "intro" && go(place - 1),
  ArrowRight: inWork(() => go(place + 1)),
  ArrowUp: inWork(() => { questions.mark(questions.marked - 1); redraw(); }),
  ArrowDown: inWork(() => { questions.mark(questions.marked + 1); redraw(); }),
  Enter: begin,
  u: undo,
  Backspace: undo,
  n: () => screen !== "intro" && goOn(place),
  0: inWork(passOver),
  s: inWork(changeSpeed),
  "?": () => byId("help").showModal(),
};

for (const [id, act] of Object.entries({
  begin, undo, unseen: passOver, previous: actions.ArrowLeft, next: actions.ArrowRight, back: actions[","],
  on: actions["."], play: actions[" "], speed: changeSpeed, "help-open": actions["?"],
})) byId(id).addEventListener("click", act);

byId("done-copy").addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(byId("done-command").textContent);
    toast("Copied");
  } catch {
    getSelection().selectAllChildren(byId("done-command")); // not allowed: mark it instead
  }
});
document.addEventListener("visibilitychange", refresh);

// --- the beginning -----------------------------------------------------------------------------

async function start() {
  if (!(await pairs.load())) return;
  undoable = new Undo(`rate-${pairs.person}`);
  questions = new Questions(pairs.questions, pairs.points, answer);
  for (const { key, value } of pairs.points) actions[key] = () => answerMarked(value);
  onKeys(actions, [",", "."]); // a held key answers nothing
  setSpeed(Number(sessionStorage.getItem("speed")) || 1);
  drawIntro();
  show("intro");
  byId("begin").focus();
  if (sessionStorage.getItem(`rating-${pairs.person}`)) begin();
}

start();
