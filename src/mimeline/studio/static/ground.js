// What every page needs: talking to its own server, elements whose content is text, a passing note.

export const byId = (id) => document.getElementById(id);

/** An element; its children are elements or text, never markup. */
export function element(tag, className, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  made.append(...children);
  return made;
}

/** The server's answer. Its `body` is JSON, or text where it refuses; status 0: it is not there. */
export async function ask(path, post) {
  const options = post === undefined ? {} : {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(post),
  };
  try {
    const answer = await fetch(path, options);
    const isJson = (answer.headers.get("Content-Type") ?? "").startsWith("application/json");
    return { status: answer.status, body: isJson ? await answer.json() : await answer.text() };
  } catch {
    return { status: 0, body: "The server does not answer: was it ended in the terminal?" };
  }
}

let fading;

/** A note at the lower edge that goes by itself. */
export function toast(text) {
  const note = byId("toast");
  note.textContent = text;
  note.classList.add("shown");
  clearTimeout(fading);
  fading = setTimeout(() => note.classList.remove("shown"), 2600);
}

/** A line at the top that stays until there is nothing wrong: alarm(""). */
export function alarm(text) {
  byId("alarm").hidden = !text;
  if (byId("alarm").textContent !== text) byId("alarm").textContent = text;
}
