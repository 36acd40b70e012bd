// What a person decided, on its way to the disk: one post after the other, kept and tried again
// while nobody answers.

import { alarm, ask } from "./ground.js";

const AGAIN_MS = 1500;

export class Outbox {
  /** path: where posts go. noun: what one is called ("decision"). same(a, b): whether two posts are
   * about the same thing. written(body, post): it is on disk. refused(post, holds, why): the server
   * holds something else (its answer to a conflict), or would not take it (null, why). */
  constructor({ path, noun, same, written, refused }) {
    Object.assign(this, { path, noun, same, written, refused });
    this.posts = [];
    this.busy = false;
    addEventListener("beforeunload", (event) => this.posts.length && event.preventDefault());
  }

  put(post) {
    this.posts.push(post);
    if (!this.busy) this.#send();
  }

  async #send() {
    this.busy = true;
    while (this.posts.length) {
      const post = this.posts[0];
      const { status, body } = await ask(this.path, post);
      if (status === 200) {
        alarm("");
        this.posts.shift();
        this.written(body, post);
      } else if (status === 409) {
        this.posts = this.posts.filter((other) => other === post || !this.same(other, post));
        this.posts.shift();
        this.refused(post, body);
      } else if (status === 400 || status === 404) {
        this.posts.shift();
        this.refused(post, null, body);
      } else {
        const n = this.posts.length;
        const waiting = n === 1 ? `1 ${this.noun} waits` : `${n} ${this.noun}s wait`;
        alarm(`Not written yet, ${waiting} and will be tried again. ${body}`);
        await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      }
    }
    this.busy = false;
  }
}
