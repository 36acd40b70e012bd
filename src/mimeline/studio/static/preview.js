// The preview page: one clock in seconds for all that is shown, the keys, the buttons.

import { alarm, ask, byId, toast } from "./ground.js";
import { onKeys } from "./keys.js";
import { Player } from "./player.js";
import { VIEWS } from "./preview_face.js";
import { Pane } from "./preview_pane.js";

const SPEEDS = [1, 2, 0.5];
const SPEED_WORDS = { 0.5: "½×", 1: "1×", 2: "2×" };
const ZOOM = 0.87; // of the distance, a press
const WIDE = matchMedia("(min-width: 1080px)");

const panes = [];
let now = 0; // seconds
let seconds = 0; // of the longest motion
let fps = 1; // of the fastest: a step is one of its frames
let looping = true;
let view = "front", sign = 1; // of the camera
let goesOn = false; // when what is scrubbed is let go

const ticks = () => Math.max(1, Math.round(seconds * fps));
const tick = () => Math.min(ticks() - 1, Math.floor(now * fps + 1e-6));

const player = new Player({
  toggled: (paused) => { byId("play").textContent = paused ? "Play" : "Pause"; },
});

// --- the clock -----------------------------------------------------------------------------------

function go(to) {
  now = Math.min(Math.max(0, to), seconds);
  draw();
}

/** The start of a step, clamped to those that there are. */
const goTick = (to) => go(Math.min(ticks() - 1, Math.max(0, to)) / fps);

function draw() {
  const at = tick();
  for (const pane of panes) pane.moved(now);
  byId("seek").value = at;
  byId("clock").textContent = `${(at / fps).toFixed(2)} / ${seconds.toFixed(2)} s`;
  const doing = panes.map((pane) => pane.doing).join("; ");
  byId("seek").setAttribute("aria-valuetext", `${(at / fps).toFixed(2)} seconds, frame ${at}: ${doing}`);
}

player.parts.add({
  advance(by) {
    if (!by || !seconds || panes.some(({ waiting }) => waiting)) return;
    if (now + by < seconds) {
      go(now + by);
    } else if (looping) {
      go((now + by) % seconds);
    } else {
      goTick(ticks() - 1);
      player.toggle();
    }
  },
  step: (by) => goTick(tick() + by),
});

function toggle() {
  if (player.paused && tick() === ticks() - 1) go(0);
  player.toggle();
}

/** A person moves the playhead: it stands still meanwhile. */
const scrubbing = {
  began() {
    goesOn = !player.paused;
    if (goesOn) player.toggle();
  },
  scrubbed: (to) => goTick(Math.min(ticks() - 1, Math.floor(to * fps + 1e-6))),
  ended() {
    if (goesOn && player.paused) player.toggle();
    goesOn = false;
  },
};

function jump(to) {
  if (!player.paused) player.toggle();
  goTick(to);
}

// --- the camera ----------------------------------------------------------------------------------

/** From the front; from one side, the next time from the other. */
function look(wanted) {
  sign = wanted === view ? -sign : 1;
  for (const { face } of panes) face?.look(sign * VIEWS[wanted]);
  view = wanted;
}

function zoom(by) {
  panes.find(({ face }) => face)?.face.zoom(by);
}

function turned(pane) {
  view = "";
  for (const other of panes) if (other !== pane) other.face?.follow(pane.face);
}

// --- keys and buttons ----------------------------------------------------------------------------

function changeSpeed() {
  player.speed = SPEEDS[(SPEEDS.indexOf(player.speed) + 1) % SPEEDS.length];
  byId("speed").textContent = SPEED_WORDS[player.speed];
  byId("speed").setAttribute("aria-label", `Speed ${player.speed}×`);
}

function changeLoop() {
  looping = !looping;
  byId("loop").setAttribute("aria-pressed", String(looping));
  toast(looping ? "Begins again at the end" : "Stops at the end");
}

function changeChannels() {
  const open = panes.some(({ box }) => box.classList.contains("with-channels"));
  for (const pane of panes) pane.openChannels(!open);
}

const far = (event) => (event.shiftKey ? 10 : 1);

onKeys({
  " ": toggle,
  ArrowLeft: (event) => player.step(-far(event)),
  ArrowRight: (event) => player.step(far(event)),
  ",": () => player.step(-1),
  ".": () => player.step(1),
  Home: () => jump(0),
  End: () => jump(ticks() - 1),
  l: changeLoop,
  s: changeSpeed,
  c: changeChannels,
  1: () => look("front"),
  2: () => look("three"),
  3: () => look("side"),
  "+": () => zoom(ZOOM),
  "=": () => zoom(ZOOM),
  "-": () => zoom(1 / ZOOM),
  "?": () => byId("help").showModal(),
}, ["ArrowLeft", "ArrowRight", ",", ".", "+", "=", "-"]);

byId("play").addEventListener("click", toggle);
byId("back").addEventListener("click", () => player.step(-1));
byId("on").addEventListener("click", () => player.step(1));
byId("speed").addEventListener("click", changeSpeed);
byId("loop").addEventListener("click", changeLoop);
byId("front").addEventListener("click", () => look("front"));
byId("three").addEventListener("click", () => look("three"));
byId("side").addEventListener("click", () => look("side"));
byId("help-open").addEventListener("click", () => byId("help").showModal());
byId("seek").addEventListener("pointerdown", scrubbing.began);
byId("seek").addEventListener("pointerup", (event) => { event.target.blur(); scrubbing.ended(); });
byId("seek").addEventListener("input", (event) => goTick(Number(event.target.value)));

// --- the beginning -------------------------------------------------------------------------------

/** Have every pane's clip, then lanes of one length for all. */
async function load(which) {
  await Promise.all(which.map((pane) => pane.load()));
  const known = panes.map(({ facts }) => facts).filter(Boolean);
  if (!known.length) return;
  seconds = Math.max(...known.map((facts) => Math.max(facts.seconds, facts.timeline?.seconds ?? 0)));
  fps = Math.max(...known.map((facts) => facts.fps));
  byId("seek").max = ticks() - 1;
  for (const pane of panes) pane.lay(seconds);
  go(0);
}

async function start() {
  const { status, body } = await ask("/files");
  if (status !== 200) {
    alarm(body);
    return;
  }
  for (const file of body.files) {
    const pane = new Pane(file, body.face, { ...scrubbing, turned, changed: () => load([pane]) });
    panes.push(pane);
    byId("panes").append(pane.box);
    pane.openChannels(WIDE.matches && body.files.length === 1);
  }
  if (body.face.unsaid.length) alarm(`This face as glTF goes without ${body.face.unsaid.join(" and ")}.`);
  await load(panes);
}

start();

window.mimeline = { panes }; // for the console, and for whoever tests what is drawn
