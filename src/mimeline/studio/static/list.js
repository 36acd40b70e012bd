// A list of any length: only the rows in sight are elements.

import { element } from "./ground.js";

const ROW_PX = 30;
const SPARE = 6; // rows beyond the edges

export class List {
  /** box: what scrolls. rows: what is as high as all rows. fill(button, item): what a row shows. */
  constructor(box, rows, { fill, chosen }) {
    Object.assign(this, { box, rows, fill, chosen });
    this.items = [];
    this.current = -1;
    this.made = new Map(); // place → button
    box.addEventListener("scroll", () => this.draw(), { passive: true });
    new ResizeObserver(() => this.draw()).observe(box);
  }

  set(items) {
    this.items = items;
    this.rows.style.height = `${items.length * ROW_PX}px`;
    for (const button of this.made.values()) button.remove();
    this.made.clear();
    this.draw();
  }

  /** Mark a place (-1: none) and bring it into sight, with some of what follows. */
  setCurrent(place) {
    this.current = place;
    const top = place * ROW_PX;
    const room = Math.min(3 * ROW_PX, this.box.clientHeight / 3);
    if (place >= 0 && top < this.box.scrollTop + ROW_PX) this.box.scrollTop = top - room;
    const lowest = this.box.scrollTop + this.box.clientHeight - ROW_PX - room;
    if (place >= 0 && top > lowest) this.box.scrollTop = top + ROW_PX + room - this.box.clientHeight;
    this.draw();
  }

  draw() {
    const first = Math.max(0, Math.floor(this.box.scrollTop / ROW_PX) - SPARE);
    const seen = Math.ceil(this.box.clientHeight / ROW_PX) + 2 * SPARE;
    const end = Math.min(this.items.length, first + seen);
    for (const [place, button] of this.made) {
      if (place >= first && place < end) continue;
      button.remove();
      this.made.delete(place);
    }
    for (let place = first; place < end; place += 1) {
      let button = this.made.get(place);
      if (!button) {
        button = element("button", "clip");
        button.type = "button";
        button.style.transform = `translateY(${place * ROW_PX}px)`;
        button.addEventListener("click", (event) => {
          if (event.detail) button.blur(); // keys go to the film, not to the row
          this.chosen(place);
        });
        this.made.set(place, button);
        this.rows.append(button);
      }
      button.setAttribute("aria-current", String(place === this.current));
      this.fill(button, this.items[place]);
    }
  }
}
