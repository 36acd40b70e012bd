// The clusters of the run and what a person said of them, here and elsewhere.

import { alarm, ask } from "./ground.js";

export const NOT_SURE = { action: null, note: null, same_as: null };
export const named = (action, note = null) => ({ action, note, same_as: null });
export const sameAs = (number) => ({ action: null, note: null, same_as: number });
export const same = (a, b) => a === b || (a !== null && b !== null
  && a.action === b.action && a.note === b.note && a.same_as === b.same_as);

/** A name that was moved from another fit, and that nobody has kept yet. */
export const isMoved = (cluster) => cluster.answer !== null && cluster.agreement !== null;
export const isAnswered = (cluster) => cluster.answer !== null && !cluster.unsafe && !isMoved(cluster);
export const isNotSure = (cluster) => isAnswered(cluster) && same(cluster.answer, NOT_SURE);

export class Answers {
  constructor() {
    this.person = "";
    this.regions = [];
    this.all = []; // clusters, in the order in which they are listed
    this.byKey = new Map(); // "brow/3" → cluster
    this.next = []; // keys, what is worth most first
  }

  /** What the server knows, for a person; false where it does not tell. */
  async load(person) {
    const { status, body } = await ask(`/state?person=${encodeURIComponent(person)}`);
    alarm(status === 200 ? "" : body);
    if (status !== 200) return false;
    Object.assign(this, { person, told: body, regions: body.regions, revision: body.revision });
    for (const region of this.regions) {
      for (const cluster of region.clusters) {
        cluster.region = region;
        cluster.key = `${region.name}/${cluster.number}`;
      }
      region.clusters.sort((a, b) => Boolean(b.unsafe) - Boolean(a.unsafe) || a.number - b.number);
    }
    this.all = this.regions.flatMap((region) => region.clusters);
    this.byKey = new Map(this.all.map((cluster) => [cluster.key, cluster]));
    this.#order(body.next);
    return true;
  }

  /** What others wrote meanwhile. isIdle(): whether no answer of ours is on its way; what comes
   * while one is would be older than it. Whether anything changed. */
  async refresh(isIdle) {
    if (!isIdle()) return false;
    const who = encodeURIComponent(this.person);
    const { status, body } = await ask(`/answers?person=${who}&known=${this.revision}`);
    if (!isIdle()) return false;
    alarm(status === 200 ? "" : body);
    if (status !== 200 || !body.answers) return false;
    return this.load(this.person);
  }

  /** Our answer is on disk: others wrote, too, where the file was not at our revision before. */
  wrote({ before, revision, next }) {
    if (before === this.revision) this.revision = revision;
    this.#order(next);
  }

  /** The cluster that is worth most of those that nobody answered; undefined: there is none. */
  mostWorth(except) {
    const open = (cluster) => cluster && cluster !== except && !isAnswered(cluster) && !isMoved(cluster);
    const wanted = this.next.map((key) => this.byKey.get(key));
    return this.all.find((cluster) => open(cluster) && cluster.unsafe)
      ?? wanted.find(open) ?? this.all.find(open);
  }

  /** The cluster whose name it bears: itself, or what it was merged with. */
  root(cluster) {
    const met = new Set();
    let at = cluster;
    while (at.answer?.same_as != null && !met.has(at)) {
      met.add(at);
      at = this.byKey.get(`${at.region.name}/${at.answer.same_as}`) ?? at;
    }
    return at;
  }

  /** The action of its region that it bears, or would bear by the proposal; null: none. */
  action(cluster) {
    const root = this.root(cluster);
    const name = root.answer ? root.answer.action : root.proposed?.action;
    return root.region.actions.find((action) => action.name === name) ?? null;
  }

  /** An answer as a person reads it. */
  words(region, answer) {
    if (answer === null) return "no name yet";
    if (answer.same_as !== null) return `same as ${answer.same_as}`;
    if (answer.action === null) return "not sure";
    return [wordsOf(region, answer.action), answer.note].filter(Boolean).join(", ");
  }

  /** How far the work is; frames as a share of all regions' frames. */
  progress() {
    const frames = (clusters) => clusters.reduce((sum, cluster) => sum + cluster.n_frames, 0);
    const sure = this.all.filter((cluster) => isAnswered(cluster) && !isNotSure(cluster));
    const moved = this.all.filter(isMoved);
    const all = frames(this.all) || 1;
    return {
      n: this.all.length,
      named: sure.length,
      notSure: this.all.filter(isNotSure).length,
      merged: sure.filter((cluster) => cluster.answer.same_as !== null).length,
      moved: moved.length,
      namedFrames: frames(sure) / all,
      movedFrames: frames(moved) / all,
    };
  }

  /** Finer names as they came into use: each keeps its place, also when it is used no longer. */
  notes() {
    const stored = `notes-${this.person}`;
    const used = this.all.map((cluster) => cluster.answer?.note).filter(Boolean);
    const notes = [...new Set([...JSON.parse(sessionStorage.getItem(stored) ?? "[]"), ...used])];
    sessionStorage.setItem(stored, JSON.stringify(notes));
    return notes;
  }

  #order(next) {
    this.next = next.map(([region, number]) => `${region}/${number}`);
  }
}

export const wordsOf = (region, name) => region.actions.find((action) => action.name === name)?.words ?? name;
