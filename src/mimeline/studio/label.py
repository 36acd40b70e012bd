"""The page that shows exemplars of the clusters and writes what a person calls them.

Ma et al. 2025, 3.1: a person looks at a few intervals of each cluster and names its action.
"""

import math
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from flask import Blueprint, Flask, Response, abort, render_template, request

from mimeline.annotation.label_file import Answer
from mimeline.errors import BadConfig
from mimeline.reporting import words
from mimeline.studio import server
from mimeline.studio.answers import (
    FIRST,
    MOST_CHARACTERS,
    NOT_SURE,
    Persons,
    Unfit,
    called,
)
from mimeline.studio.clusters_of_run import FURTHER, ClustersOfRun, Exemplar
from mimeline.studio.labelling import Labelling, as_json, command
from mimeline.studio.pictures import COLUMNS, EDGE, Pictures
from mimeline.studio.review import TELL

PAUSE_S = 60.0  # a longer silence is no work


class Stopwatch:
    """How long a person worked: the time between clusters shown and answers, pauses left out."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self.active_s, self._clock, self._last = 0.0, clock, -math.inf

    def tick(self) -> None:
        now = self._clock()
        if now - self._last <= PAUSE_S:
            self.active_s += now - self._last
        self._last = now


def serve(
    results: Path,
    file: Path | None,
    person: str,
    port: int,
    open_browser: bool,
    say: Callable[[str], None] = TELL,
) -> None:
    """Serve the page until Ctrl-C, then say how many clusters are named and how to use the names.

    results: a run's results. file: the label file to go on with, or to begin; None: the run's own,
    or one named after the results. person: who answers; the first is "". port: 0 for any.
    say is told what a person at the terminal has to know.
    Raises NoSuchFile where there is no run or it is not yet at exemplars; BadConfig for a person's
    name that is none, or a file that the run itself writes; BadLabels for a label file that cannot
    be read; PortTaken.
    """
    person, run = called(person), ClustersOfRun(results)
    persons, watch = Persons(file or own_file(run), run), Stopwatch()
    answers, labelling = persons.of(person), Labelling(run, persons)
    _refuse_own_names(answers.place, run)
    pictures = Pictures(run, (run.run.config.get("report") or {}).get("face"))
    try:
        _expect(labelling, pictures, labelling.next(person)[:1])
        server.serve(
            lambda key: label(labelling, pictures, watch, person, key), port, open_browser, say
        )
        answers.refresh()
        say(closing(labelling, person, watch.active_s))
    finally:
        pictures.end()


def own_file(run: ClustersOfRun) -> Path:
    """The label file of a run: label.file, or one named after its results."""
    if told := (run.run.config.get("label") or {}).get("file"):
        return Path(told)
    name = run.results.resolve().name
    name = "labels" if name == "results" else name.removeprefix("results-")
    return Path("config") / "labels" / f"{name}.yaml"


def label(
    labelling: Labelling, pictures: Pictures, watch: Stopwatch, person: str, key: str
) -> Flask:
    """The page's app. key: see server.studio.

    person: who answers where the page does not say. If that is a second one, the first is not
    served: what they said is not to be learnt here.
    """
    page = Blueprint("label", __name__)
    run, persons = labelling.run, labelling.persons

    def asked() -> str:
        return _person(request.args.get("person", FIRST)) or person

    @page.get("/")
    def index() -> str:
        return render_template(
            "label.html",
            results=run.results,
            file=persons.file,
            person=person,
            most_characters=MOST_CHARACTERS,
        )

    @page.get("/state")
    def state() -> dict:
        run.refuse_refitted()
        who = asked()
        persons.of(who).refresh()
        found = labelling.state(who)
        _expect(labelling, pictures, found["next"][:1])
        return found

    @page.get("/exemplars/<region>/<int:cluster>")
    def exemplars(region: str, cluster: int) -> dict:
        _refuse_unknown(run, region, cluster)
        run.refuse_refitted()
        ahead = [[region, cluster]]
        ahead += [which for which in labelling.next(asked()) if which != ahead[0]][:1]
        _expect(labelling, pictures, ahead)
        watch.tick()
        return {"exemplars": [_told(e) for e in run.regions[region].exemplars.get(cluster, [])]}

    @page.get("/pictures/<view>/<region>/<int:cluster>/<int:rank>")
    def picture(view: str, region: str, cluster: int, rank: int) -> Response:
        run.refuse_refitted()
        sheet = pictures.sheet(view, region, cluster, rank)
        if sheet is None:
            abort(404, "There are no such pictures.")
        return Response(sheet, mimetype="image/jpeg")

    @page.get("/answers")
    def answered() -> dict:
        answers = persons.of(asked())
        answers.refresh()
        if request.args.get("known") == answers.revision:
            return {"revision": answers.revision}
        held = answers.written()
        return {
            "revision": answers.revision,
            "answers": {
                region: {str(n): as_json(a) for n, a in own.clusters.items()}
                for region, own in held.items()
            },
        }

    @page.post("/answers")
    def answer() -> tuple[dict, int]:
        said, region, cluster, was, now, ranks = _posted(request.get_json())
        who = said or person
        answers = persons.of(who)
        _refuse_unknown(run, region, cluster)
        run.refuse_refitted()
        fit = run.regions[region].fingerprint
        if request.get_json().get("fit", fit) != fit:  # kept by a page that was open before
            abort(400, "The clusters were fitted anew since: load the page again.")
        own = {e.rank: e.interval for e in run.regions[region].exemplars.get(cluster, [])}
        if not set(ranks) <= set(own):
            abort(400, "This cluster has no such exemplar.")
        try:
            holds, ours, before = answers.decide(
                region, cluster, was, now, [own[rank] for rank in ranks]
            )
        except Unfit as error:
            abort(400, str(error))
        if not ours:
            return {"holds": as_json(holds)}, 409
        watch.tick()
        found = {"before": before, "revision": answers.revision, "now": as_json(holds)}
        return found | {"next": labelling.next(who)}, 200

    @page.get("/agreement")
    def agreed() -> dict:
        return labelling.agreement(asked())

    return server.studio(page, {}, run.results, key)


def closing(labelling: Labelling, person: str, active_s: float) -> str:
    """What was done, and the command that makes use of it."""
    answers = labelling.persons.of(person)
    named, unsure, left, total = Counter(), 0, 0, Counter()
    for region, cluster in labelling.clusters():
        total[region] += 1
        answer = answers.named(region, cluster)
        unsure += answer == NOT_SURE
        left += answer is None
        named[region] += answer is not None and answer != NOT_SURE
    by_region = words.listing([f"{region} {named[region]} of {n}" for region, n in total.items()])
    unsafe = sum(len(answers.settled(region).unsafe) for region in total)
    left -= unsafe
    text = f"\n{named.total()} of {total.total()} clusters are named: {by_region}"
    text += f", in {_time(active_s)}." if active_s else "."
    if unsure:
        text += f" {unsure} {'are' if unsure > 1 else 'is'} left as not sure."
    if left:
        text += f" {left} {'are' if left > 1 else 'is'} "
        text += "left to the proposals." if person == FIRST else "not answered."
    if person != FIRST and (told := labelling.agreement(person)).get("n"):
        both = f"{told['n']} cluster{'s' * (told['n'] != 1)} that both named"
        if told["kappa"] is None:
            text += f"\nThe first person gave the same one name to all {both}: that is no kappa."
        else:
            text += f"\nKappa with the first person: {words.score(told['kappa'])}, over {both}."
    if unsafe:
        text += (
            f"\nTo {unsafe} no name could be moved from the fit before: the run will stop there."
        )
    path = labelling.persons.path(person)
    if not path.exists():
        return text
    if answers.copy:
        text += f"\nOf {path}, the comments at its top were kept; {answers.copy} has the others."
    for region, copy in answers.copies.items():
        text += f"\nThe file as it was before the {region} was fitted anew: {copy}."
    text += f"\nThe names are in {path}."
    if person == FIRST:
        text += f" To run with them, up to the timelines:\n  {command(labelling)}"
    return text


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{words.minutes(seconds)} min"


def _expect(labelling: Labelling, pictures: Pictures, ahead: list[list]) -> None:
    """Of these clusters, and then of the first for a person who is not sure."""
    own = [labelling.run.regions[region].exemplars.get(n, []) for region, n in ahead]
    first = [e for rows in own for e in rows if e.kind != FURTHER]
    further = [e for rows in own[:1] for e in rows if e.kind == FURTHER]
    pictures.expect([*first, *further])


def _told(exemplar: Exemplar) -> dict:
    length = exemplar.end - exemplar.start
    return {
        "rank": exemplar.rank,
        "kind": exemplar.kind,
        "clip_id": exemplar.clip_id,
        "start": exemplar.start,
        "end": exemplar.end,
        "fps": exemplar.fps,
        "from": exemplar.first,
        "to": exemplar.stop,
        "seconds": length / exemplar.fps if exemplar.fps else None,
        "curves": exemplar.curves,
        "views": list(exemplar.views),
        "sheet": {"edge": EDGE, "columns": COLUMNS, "frames": exemplar.frames},
    }


def _refuse_own_names(file: Path, run: ClustersOfRun) -> None:
    """What the run writes itself it writes anew, or deletes before."""
    if file.is_relative_to(run.folder.resolve()):
        raise BadConfig(
            "--file",
            found=f"{file}, a file of the run itself",
            expected=f"a place outside of {run.folder}",
            remedy=f"Copy it, if it is there, to a place such as {file.name}, and give that one.",
        )


def _person(name: str) -> str:
    try:
        return called(name)
    except BadConfig as error:
        abort(400, f"A person is called by {error.expected}.")


def _refuse_unknown(run: ClustersOfRun, region: str, cluster: int) -> None:
    if region not in run.regions or cluster not in run.regions[region].proposed.index:
        abort(404, "This run has no such cluster.")


def _posted(body: object) -> tuple[str, str, int, Answer | None, Answer | None, list[int]]:
    """What the page believed and what it wants; refuses anything else."""
    match body:
        case {
            "person": str(person),
            "region": str(region),
            "cluster": int(cluster),
            "was": was,
            "now": now,
            "shown": list(ranks),
        } if type(cluster) is int and all(type(rank) is int for rank in ranks):
            return _person(person), region, cluster, _answer(was), _answer(now), ranks
    return abort(400, "Expected person, region, cluster, was, now and shown.")


def _answer(said: object) -> Answer | None:
    match said:
        case None:
            return None
        case {
            "action": str() | None as action,
            "note": str() | None as note,
            "same_as": int() | None as same_as,
        } if type(same_as) is not bool:
            return Answer(action, note, same_as)
    return abort(400, "An answer is action, note and same_as, or null.")
