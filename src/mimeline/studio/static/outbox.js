// Decisions on their way to the disk: one after the other, kept and tried again while nobody answers.

import { alarm, ask } from "./ground.js";

const AGAIN_MS = 1500;

export class Outbox {
  /** written(before, revision): the files' revisions. refused(post, holds): the server holds something else, or would not take it (null). */
  constructor({ written, refused }) {
    Object.assign(this, { written, refused });
    this.posts = [];
    this.busy = false;
    addEventListener("beforeunload", (event) => this.posts.length && event.preventDefault());
  }

  put(post) {
    this.posts.push(post);
    if (!this.busy) this.#send();
  }

  has(clipId) {
    return this.posts.some((post) => post.clip_id === clipId);
  }

  async #send() {
    this.busy = true;
    while (this.posts.length) {
      const post = this.posts[0];
      const { status, body } = await ask("/decisions", post);
      if (status === 200) {
        alarm("");
        this.posts.shift();
        this.written(body.before, body.revision);
      } else if (status === 409) {
        this.posts = this.posts.filter((other) => other === post || other.clip_id !== post.clip_id);
        this.posts.shift();
        this.refused(post, { seen: body.seen, reason: body.reason });
      } else if (status === 400 || status === 404) {
        this.posts.shift();
        this.refused(post, null, body);
      } else {
        const waiting = this.posts.length === 1 ? "1 decision waits" : `${this.posts.length} decisions wait`;
        alarm(`Not written yet, ${waiting} and will be tried again. ${body}`);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    }
    this.busy = false;
  }
}
