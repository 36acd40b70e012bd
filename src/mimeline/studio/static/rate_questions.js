// The questions of a pair with their points, one of them marked: the one that keys answer.

import { byId, element } from "./ground.js";

export class Questions {
  /** questions: { name, text }; points: { value, text, key }. chosen(name, value): a point was. */
  constructor(questions, points, chosen) {
    this.questions = questions;
    this.points = points;
    this.marked = 0;
    this.boxes = questions.map((question) => this.#box(question, chosen));
    byId("questions").replaceChildren(...this.boxes);
  }

  /** Mark the first that has no answer; of a pair that has all, the first. */
  markOpen(answers) {
    this.marked = Math.max(0, this.questions.findIndex(({ name }) => !(name in answers)));
  }

  mark(place) {
    this.marked = Math.min(this.questions.length - 1, Math.max(0, place));
  }

  get current() {
    return this.questions[this.marked].name;
  }

  draw(answers) {
    this.questions.forEach(({ name }, at) => {
      const box = this.boxes[at];
      box.classList.toggle("marked", at === this.marked);
      box.classList.toggle("answered", name in answers);
      for (const button of box.querySelectorAll("button")) {
        button.setAttribute("aria-pressed", String(Number(button.value) === answers[name]));
      }
    });
  }

  /** An answer in words. */
  words(value) {
    return this.points.find((point) => point.value === value)?.text ?? "No picture";
  }

  #box({ name, text }, chosen) {
    const title = element("h2", "", text);
    title.id = `question-${name}`;
    const buttons = this.points.map(({ value, text: words, key }) => {
      const button = element("button", "", element("kbd", "", key), element("span", "", words));
      button.type = "button";
      button.value = value;
      button.setAttribute("aria-keyshortcuts", key);
      button.addEventListener("click", () => chosen(name, value));
      return button;
    });
    const points = element("div", "points", ...buttons);
    points.setAttribute("role", "group");
    points.setAttribute("aria-labelledby", title.id);
    const box = element("section", "question", title, points);
    box.dataset.question = name;
    return box;
  }
}
