// The dialog for a finer name: "strong" of Brow up.

import { byId, element } from "./ground.js";

const USUAL = ["strong", "moderate", "slight"];
const MOST_SUGGESTED = 9; // a digit each

/** chosen(note): a word or two, null for none. */
export function askFiner(answers, cluster, chosen) {
  const { answer, region, number } = cluster;
  const words = answers.words(region, { ...answer, note: null });
  byId("finer-title").textContent = `Cluster ${number}: ${words}, and finer?`;
  const suggested = [...new Set([...USUAL, ...answers.notes()])].slice(0, MOST_SUGGESTED);
  const pick = (note) => {
    byId("finer").close();
    chosen(note || null);
  };
  const input = byId("finer-note");
  input.value = answer.note ?? "";
  byId("finer-suggested").replaceChildren(...suggested.map((note, at) => {
    const button = element("button", "", element("kbd", "", String(at + 1)), element("span", "", note));
    button.type = "button";
    button.addEventListener("click", () => pick(note));
    return button;
  }));
  input.onkeydown = (event) => { // a number picks, as long as nothing is typed
    const untouched = !input.value || (input.selectionStart === 0 && input.selectionEnd === input.value.length);
    const note = untouched && /^[1-9]$/.test(event.key) ? suggested[event.key - 1] : undefined;
    if (note === undefined) return;
    event.preventDefault();
    pick(note);
  };
  byId("finer-form").onsubmit = (event) => {
    event.preventDefault();
    pick(input.value.trim().replace(/\s+/g, " "));
  };
  byId("finer").showModal();
  input.select();
}
