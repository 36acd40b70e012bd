"""The page on which people judge, blind, whether timelines fit what is seen.

Ma et al. 2025, "User Study". Of a pair the page learns pictures and a timeline: not its kind, and
no clip's name.
"""

import math
import shlex
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from flask import Blueprint, Flask, Response, abort, render_template, request

from mimeline.reporting import words
from mimeline.reporting.stand_in import GROUND, stand_in
from mimeline.reporting.style import colours, readable_on
from mimeline.studio import server
from mimeline.studio.labelling import DARK
from mimeline.studio.rated import Rated
from mimeline.studio.rating_file import POINTS, QUESTIONS, UNSEEN
from mimeline.studio.review import TELL
from mimeline.studio.sheets import Order, Sheets, Tiles
from mimeline.studio.study import Pair, Study, Track
from mimeline.studio.timelines_of_run import GENERATION, KINDS, TimelinesOfRun

EDGE = 320  # pixels of a picture
COLUMNS = 16  # of a sheet
MOST_FPS = 30  # faces are drawn at
MOST_PICTURES = 320  # of a sheet: of longer clips fewer frames per second are shown
MOST_S = 86_400  # that somebody looks at a pair
AHEAD = 3  # pairs whose faces are drawn before they are asked for


class Faces:
    """The sheets of a study's pairs that are drawn. face: as report.face."""

    def __init__(self, study: Study, face: str | Path | None):
        self.study = study
        self._actor = stand_in(face)
        self._load = threading.Lock()
        self._sheets = Sheets[str](self._order, EDGE, COLUMNS)

    def sheet(self, pair: Pair) -> bytes | None:
        return self._sheets.get(pair.id)

    def expect(self, pairs: Sequence[Pair]) -> None:
        """Draw these next, in that order."""
        self._sheets.expect([pair.id for pair in pairs if not pair.film])

    def end(self) -> None:
        """Stop; returns when none is being drawn, and none will be."""
        self._sheets.end()

    def is_drawn(self, pair: str) -> bool:
        return self._sheets.is_made(pair)

    def frames(self, pair: Pair) -> list[int]:
        """Those that are drawn, evenly spaced."""
        n, fps = self.study.n_frames(pair), self.study.fps(pair)
        step = max(1, round(fps / MOST_FPS), math.ceil(n / MOST_PICTURES))
        return list(range(0, n, step))

    def _order(self, name: str) -> Order:
        frames = self.frames(self.study.pairs[name])
        return Order(frames, self._drawn(name, frames), GROUND, f"face of {name}")

    def _drawn(self, name: str, frames: Sequence[int]) -> Tiles:
        """A frame that was not measured shows the one before it."""
        with self._load:
            motion = self.study.motion[name]
        rows: pd.DataFrame = motion[motion["valid"] & motion["frame"].isin(frames)]
        pictures, known, shown = self._actor.pictures(rows, EDGE), set(rows["frame"]), None
        for frame in frames:
            if frame in known:
                shown = next(pictures)
            if shown is not None:
                yield frame, shown


def serve(
    results: Path,
    file: Path | None,
    person: str,
    pairs: int,
    seed: int,
    kinds: Sequence[str],
    port: int,
    open_browser: bool,
    say: Callable[[str], None] = TELL,
) -> None:
    """Serve the page until Ctrl-C, then say how much is answered and how to read it.

    results: a run's results. file: the CSV to go on with, or to begin; None: one named after the
    results. person: who answers. pairs, seed, kinds: see `Study`. port: 0 for any. say is told what
    a person at the terminal has to know.
    Raises NoSuchFile where there is no run or it has no timelines; BadConfig for a person, pairs or
    kinds that there cannot be; BadFile for a file that cannot be read or is of other results;
    PortTaken.
    """
    run = TimelinesOfRun(results)
    study = Study(run, pairs, seed, kinds)
    rated = Rated(file or own_file(results), study, person)
    faces = Faces(study, run.face)
    try:
        faces.expect(_next(rated)[:AHEAD])
        server.serve(
            lambda key: rate(rated, faces, key),
            port,
            open_browser,
            lambda address: say(f"{address}\n{opening(study)}"),
        )
        rated.refresh()
        say(closing(rated))
    finally:
        faces.end()


def own_file(results: Path) -> Path:
    """The file of answers of a run that was given none."""
    name = Path(results).resolve().name.removeprefix("results-")
    return Path("config") / "ratings" / f"{name}.csv"


def rate(rated: Rated, faces: Faces, key: str) -> Flask:
    """The page's app. key: see server.studio."""
    page = Blueprint("rate", __name__)
    study, run = rated.study, rated.study.run

    def asked(name: str) -> Pair:
        if name not in study.pairs:
            abort(404, "There is no such pair.")
        return study.pairs[name]

    @page.get("/")
    def index() -> str:
        return render_template(
            "rate.html", results=run.results, file=rated.file, person=rated.person
        )

    @page.get("/state")
    def state() -> dict:
        run.refuse_changed()
        rated.refresh()
        return {
            "results": str(run.results),
            "file": str(rated.file),
            "person": rated.person,
            "questions": [{"name": name, "text": text} for name, text in QUESTIONS.items()],
            "unseen": UNSEEN,
            "points": [{"value": n, "text": t, "key": str(n)} for n, t in POINTS.items()],
            "pairs": [
                {"id": pair.id, "answers": rated.of(pair.id)} for pair in study.order(rated.person)
            ],
            "revision": rated.revision,
        }

    @page.get("/pairs/<name>")
    def shown(name: str) -> dict:
        pair = asked(name)
        run.refuse_changed()
        after = [other for other in _next(rated, name) if other is not pair]
        faces.expect([pair, *after[: AHEAD - 1]])
        return _told(study, faces, pair)

    @page.get("/sheet/<name>")
    def sheet(name: str) -> Response:
        pair = asked(name)
        if pair.film or (drawn := faces.sheet(pair)) is None:
            abort(404, "There are no such pictures.")
        return Response(drawn, mimetype="image/jpeg")

    @page.post("/answers")
    def answer() -> dict:
        name, answers, seconds = _posted(request.get_json())
        pair = asked(name)
        run.refuse_changed()
        rated.answer(pair, answers, seconds)
        return {"revision": rated.revision, "done": rated.done, "of": len(study.pairs)}

    films = {pair.id: pair.film for pair in study.pairs.values() if pair.film}
    return server.studio(page, {"film": films}, run.results, key)


def opening(study: Study) -> str:
    """What there is to judge."""
    counts = Counter(pair.kind for pair in study.pairs.values())
    told = words.listing([f"{counts[kind]} {kind}" for kind in KINDS if kind in counts])
    text = f"{len(study.pairs)} pairs: {told}, as {'films' if study.filmed else 'drawn faces'}."
    for kind, why in study.run.absent.items():
        text += f"\n  None of kind {kind}: {why}."
    if counts[GENERATION] and study.run.is_behind:
        command = study.run.run.command("--until", "evaluate_timeline")
        text += (
            "\n  The generated motion is older than the timelines, and may have been asked for by "
            f"others: unless you copied the results, run `{command}` first."
        )
    return text


def closing(rated: Rated) -> str:
    """What was done, and the command that makes use of it."""
    text = f"\n{rated.done} of {len(rated.study.pairs)} pairs are answered."
    if rated.unseen:
        text += f" Of {rated.unseen} there was no picture: the rows whose answer is {UNSEEN}."
    if not rated.file.exists():
        return text
    command = f"mimeline ratings {shlex.quote(str(rated.file))}"
    return f"{text}\nThe answers are in {rated.file}. To see what they say:\n  {command}"


def _next(rated: Rated, after: str = "") -> list[Pair]:
    """Pairs that the person has not answered, in their order, first those after a pair."""
    pairs = rated.study.order(rated.person)
    place = next((n for n, pair in enumerate(pairs, 1) if pair.id == after), 0)
    return [
        pair for pair in [*pairs[place:], *pairs[:place]] if len(rated.of(pair.id)) < len(QUESTIONS)
    ]


def _told(study: Study, faces: Faces, pair: Pair) -> dict[str, Any]:
    n, fps = study.n_frames(pair), study.fps(pair)
    sheet = None
    if not pair.film:
        sheet = {"edge": EDGE, "columns": COLUMNS, "frames": faces.frames(pair)}
    return {
        "fps": float(fps),
        "n_frames": n,
        "seconds": float(n / fps),
        "view": pair.view,
        "tracks": [_track(track) for track in study.tracks(pair)],
        "film": f"/media/film/{pair.id}" if pair.film else None,
        "sheet": sheet,
    }


def _track(track: Track) -> dict[str, Any]:
    return {
        "name": track.name,
        "words": words.TRACK_NAMES[track.name].capitalize(),
        "measured": track.measured,
        "intervals": [_interval(*interval) for interval in track.intervals],
        "gaps": [list(gap) for gap in track.gaps],
        "absent": [words.spaced(action) for action in track.absent],
    }


def _interval(action: str, start: int, end: int) -> dict[str, Any]:
    colour = colours()[action][DARK]
    return {
        "action": action,
        "words": words.spaced(action).capitalize(),
        "start": start,
        "end": end,
        "side": None,
        "colour": colour,
        "on": readable_on(colour),
    }


def _posted(body: object) -> tuple[str, dict[str, int | None], float]:
    """The pair, the answers by question, None: taken back, and how long it took; refuses anything
    else."""
    match body:
        case {"id": str(name), "answers": dict(answers), "seconds": int() | float() as seconds} if (
            answers
            and answers.keys() <= QUESTIONS.keys()
            and all(map(_is_answer, answers.values()))
            and type(seconds) is not bool
            and 0 <= seconds <= MOST_S
        ):
            return name, answers, float(seconds)
    return abort(400, "Expected id, answers (from 0 to 5, or null, by question) and seconds.")


def _is_answer(said: object) -> bool:
    return said is None or (type(said) is int and said in (UNSEEN, *POINTS))
