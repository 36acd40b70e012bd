// The pairs to judge, what was answered on them, and what the server tells of each.

import { alarm, ask } from "./ground.js";

const REMEMBERED = 8; // pairs whose facts are kept at hand

export class Pairs {
  constructor() {
    this.all = []; // { id, answers: question → point }
    this.questions = []; // { name, text }
    this.points = []; // { value, text, key }, from least to most agreement
    this.unseen = null; // the answer to each question where there is no picture
    this.facts = new Map(); // id → promise
  }

  /** Ask the server for all; false where it does not tell. */
  async load() {
    const { status, body } = await ask("/state");
    if (status !== 200) {
      alarm(body);
      return false;
    }
    Object.assign(this, body, { all: body.pairs });
    this.points.sort((a, b) => a.value - b.value); // in the order of the keys
    return true;
  }

  /** What others wrote meanwhile, or we before. isIdle(): whether no answer is on its way. */
  async refresh(isIdle) {
    if (!isIdle()) return;
    const { status, body } = await ask("/state");
    if (!isIdle()) return;
    alarm(status === 200 ? "" : body);
    if (status !== 200) return;
    const answers = new Map(body.pairs.map((pair) => [pair.id, pair.answers]));
    for (const pair of this.all) pair.answers = answers.get(pair.id) ?? pair.answers;
  }

  isAnswered(pair) {
    return this.questions.every(({ name }) => name in pair.answers);
  }

  get done() {
    return this.all.filter((pair) => this.isAnswered(pair)).length;
  }

  /** The place of the next pair that is not answered, seen from one; -1: all are. */
  nextOpen(from) {
    const n = this.all.length;
    for (let by = 1; by <= n; by += 1) {
      if (!this.isAnswered(this.all[(from + by) % n])) return (from + by) % n;
    }
    return -1;
  }

  /** What there is to see of a pair, asked for once; null where the server has none to give. */
  learn({ id }) {
    if (!this.facts.has(id)) {
      this.facts.set(id, ask(`/pairs/${id}`).then(({ status, body }) => {
        if (status === 200) return { ...body, id };
        alarm(body);
        this.facts.delete(id);
        return null;
      }));
      if (this.facts.size > REMEMBERED) this.facts.delete(this.facts.keys().next().value);
    }
    return this.facts.get(id);
  }
}
