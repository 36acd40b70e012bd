// The dialog for a second person: who answers, and how far two agree.

import { ask, byId, element } from "./ground.js";

const KAPPA = [[0.8, "almost perfect"], [0.6, "substantial"], [0.4, "moderate"], [0.2, "fair"], [-Infinity, "poor"]]; // Landis and Koch 1977

/** started: who the page was started for: the first person is not served on another's page.
 * change(person): somebody else answers from now on. open(cluster): show one that differs. */
export function askPerson(answers, started, change, open) {
  const { person } = answers;
  const others = answers.told.persons.filter((name) => name && name !== person);
  byId("person-now").textContent = person
    ? `${person} answers now, without seeing what the first person said until it is answered.`
    : "Somebody else names the same clusters without seeing your answers or the proposals. How far you agree tells how clear the names are.";
  const to = (name, text) => {
    const button = element("button", "", text);
    button.type = "button";
    button.addEventListener("click", () => {
      byId("person").close();
      change(name);
    });
    return button;
  };
  byId("person-others").replaceChildren(...person && !started ? [to("", "Back to the first person")] : [], ...others.map((name) => to(name, `Go on as ${name}`)));
  byId("person-name").value = "";
  byId("person-form").onsubmit = (event) => {
    event.preventDefault();
    const name = byId("person-name").value.trim();
    if (!name) return;
    byId("person").close();
    change(name);
  };
  byId("agreement").replaceChildren(...(person ? [person] : others).map((name) =>
    agreement(answers, name, "No cluster has a name from both yet.", open)));
  byId("person").showModal();
  byId("person-name").focus();
}

/** How far a person agrees with the first, and on which clusters they do not. none: what is said
 * where both have named none. */
export function agreement(answers, person, none, open) {
  const box = element("div");
  tell(box, answers, person, none, open);
  return box;
}

async function tell(box, answers, person, none, open) {
  const { status, body } = await ask(`/agreement?person=${encodeURIComponent(person)}`);
  if (status !== 200) return;
  const title = element("h3", "", `The first person and ${person}`);
  if (!body.n) {
    box.append(title, element("p", "", none));
    return;
  }
  const kappa = body.kappa === null ? "kappa is not defined yet"
    : `kappa ${body.kappa.toFixed(2)}, ${KAPPA.find(([least]) => body.kappa >= least)[1]}`;
  const frames = body.kappa_frames === null ? "" : `; by frames ${body.kappa_frames.toFixed(2)}`;
  box.append(title, element("p", "", `${kappa}, over ${body.n} cluster${body.n === 1 ? "" : "s"}${frames}. ${body.differing.length} differ.`));
  if (!body.differing.length) return;
  box.append(element("ul", "differing", ...body.differing.map((one) => {
    const cluster = answers.byKey.get(`${one.region}/${one.cluster}`);
    const words = (answer) => (cluster ? answers.words(cluster.region, answer) : "");
    const button = element("button", "", element("b", "", `${one.region} ${one.cluster}`),
      element("span", "", `${words(one.first)} / ${words(one.second)}`));
    button.type = "button";
    button.addEventListener("click", () => {
      byId("person").close();
      if (cluster) open(cluster);
    });
    return element("li", "", button);
  })));
}
