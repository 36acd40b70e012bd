// The clips of the run, with what people decided on them, here and elsewhere.

import { alarm, ask } from "./ground.js";

export const decision = ({ seen, reason }) => ({ seen, reason });
export const same = (a, b) => a.seen === b.seen && a.reason === b.reason;
export const looked = (clip) => clip.seen || clip.reason !== null;

/** What a person reads of a decision. */
export function inWords({ seen, reason }) {
  if (reason !== null) return `left out: ${spaced(reason)}`;
  return seen ? "kept" : "not looked at";
}

const spaced = (reason) => (reason === "" ? "no reason given" : reason.replaceAll("_", " "));

export const GROUPS = {
  kept: { label: "Kept by the run", has: (clip) => clip.status === "kept" && clip.film },
  out: { label: "Left out by hand", has: (clip) => clip.reason !== null },
  lost: { label: "Dropped or failed", has: (clip) => clip.status !== "kept" },
  filmless: { label: "Kept, without a film", has: (clip) => clip.status === "kept" && !clip.film },
  all: { label: "All clips", has: () => true },
};

export class Clips {
  constructor() {
    this.all = []; // { id, status, why, film, length_s, seen, reason }
    this.byName = new Map();
    this.revision = ""; // of the files that `seen` and `reason` are from
  }

  /** All of the run; false where the server does not tell. */
  async load() {
    const { status, body } = await ask("/clips");
    if (status !== 200) {
      alarm(body);
      return false;
    }
    this.all = body.id.map((id, at) => ({
      id, status: body.status[at], why: body.why[at], film: body.film[at], length_s: body.length_s[at],
      seen: false, reason: null,
    }));
    this.byName = new Map(this.all.map((clip) => [clip.id, clip]));
    return true;
  }

  /** What others wrote meanwhile, in another tab or into the file. isIdle(): whether no decision of
   * ours is on its way; what comes while one is would be older than it. Whether anything changed. */
  async refresh(isIdle) {
    if (!isIdle()) return false;
    const { status, body } = await ask(`/decisions?known=${this.revision}`);
    if (!isIdle()) return false;
    alarm(status === 200 ? "" : body);
    if (status !== 200 || !body.seen) return false;
    this.revision = body.revision;
    const seen = new Set(body.seen);
    for (const clip of this.all) {
      clip.seen = seen.has(clip.id);
      clip.reason = Object.hasOwn(body.reasons, clip.id) ? body.reasons[clip.id] : null;
    }
    return true;
  }

  /** Files that were `before` are now at `revision` by our decision; else others wrote, too. */
  wrote(before, revision) {
    if (before === this.revision) this.revision = revision;
  }

  /** Why clips are lost → how many, most first. */
  losses() {
    const counts = new Map();
    for (const { why } of this.all) if (why) counts.set(why, (counts.get(why) ?? 0) + 1);
    return [...counts].sort((a, b) => b[1] - a[1]);
  }

  /** How far the work is, among the clips that the run keeps and shows, and others looked at. */
  progress() {
    const toDo = this.all.filter((clip) => clip.film && (clip.status === "kept" || looked(clip)));
    const done = toDo.filter(looked);
    return {
      toDo: toDo.length,
      kept: done.filter((clip) => clip.reason === null).length,
      out: done.filter((clip) => clip.reason !== null).length,
      outInAll: this.all.filter((clip) => clip.reason !== null).length,
    };
  }

  /** Reasons in use that have no key of their own. */
  otherReasons(usual) {
    const used = new Set(this.all.map((clip) => clip.reason).filter(Boolean));
    return [...used].filter((reason) => !usual.includes(reason)).sort();
  }
}
