// Keys that act wherever the focus is, except where they are typed or press what has the focus.

/** actions: key → what it does with the event. repeating: the keys that act again while held down. */
export function onKeys(actions, repeating) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.isComposing) return;
    if (document.querySelector("dialog[open]")) return;
    const on = event.target;
    if (on.matches("input:not([type=checkbox], [type=range]), select")) {
      if (event.key === "Escape" || (event.key === "Enter" && on.type === "search")) on.blur();
      return;
    }
    if (on.matches("button, input") && (event.key === " " || event.key === "Enter")) return;
    if (on.matches("[type=range]") && event.key.startsWith("Arrow")) return;
    const digit = /^(Digit|Numpad)([0-9])$/.exec(event.code)?.[2]; // where digits need Shift, too
    const action = actions[event.key] ?? actions[event.key.toLowerCase()] ?? actions[digit];
    if (!action || (event.repeat && !repeating.includes(event.key))) return;
    event.preventDefault();
    action(event);
  });
  document.addEventListener("click", (event) => {
    const pressed = event.target.closest("button, [type=checkbox]");
    if (pressed && event.detail) pressed.blur(); // or Space would press it again
  });
}
