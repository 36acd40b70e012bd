"""The page that plays the clips of a run and writes the list of those to leave out.

What it asks of a person is rule 2 of Höll 2024, 5.1: occlusion, a wrong crop, low quality.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from flask import Blueprint, Flask, abort, render_template, request

from mimeline.clips.exclusions import REASONS
from mimeline.errors import NoSuchFile
from mimeline.reporting import words
from mimeline.run import recall
from mimeline.studio import server
from mimeline.studio.clips_of_run import ClipsOfRun
from mimeline.studio.decisions import MOST_CHARACTERS, Decision, Decisions, fits

TELL = partial(print, flush=True)  # at once, also where it is piped
UNFIT = (
    f"A reason is one line of at most {MOST_CHARACTERS} characters and does not begin with "
    "=, +, - or @."
)


def serve(
    results: Path,
    exclusions: Path,
    port: int,
    open_browser: bool,
    say: Callable[[str], None] = TELL,
) -> None:
    """Serve the page until Ctrl-C, then say how many are left out and how to use the list.

    results: a run's results. exclusions: the CSV to go on with, or to begin. port: 0 for any.
    say is told what a person at the terminal has to know.
    Raises NoSuchFile where there is no run or none of its clips has a film; BadFile for a list
    that cannot be read; PortTaken.
    """
    clips, decisions = clips_with_films(results), Decisions(exclusions)
    server.serve(lambda key: review(clips, decisions, key), port, open_browser, say)
    decisions.refresh()
    say(closing(clips, decisions, exclusions))


def clips_with_films(results: Path) -> ClipsOfRun:
    """The run's clips; raises NoSuchFile where there is nothing to look at."""
    clips = ClipsOfRun(results)
    if not clips.media["film"]:
        raise NoSuchFile(
            Path(results) / "fetch",
            found=f"no film of its {words.clips(len(clips.clips))}",
            expected="films to look at",
            remedy=f"Run `{recall(results).command('--until', 'fetch')}` with the videos in "
            "fetch.folder, or with fetch.url; a run on tracking alone has nothing to show.",
        )
    return clips


def review(clips: ClipsOfRun, decisions: Decisions, key: str) -> Flask:
    """The page's app. key: see server.studio."""
    page = Blueprint("review", __name__)
    ids = set(clips.clips.index)
    met: set[str] = set()  # reasons of the list: what is undone comes back as it was

    @page.get("/")
    def index() -> str:
        return render_template(
            "review.html",
            results=clips.results,
            exclusions=decisions.exclusions,
            reasons=list(zip(REASONS, map(_spaced, REASONS), strict=True)),
            most_characters=MOST_CHARACTERS,
        )

    @page.get("/clips")
    def listing() -> dict:
        return clips.listing()

    @page.get("/clips/<clip_id>")
    def facts(clip_id: str) -> dict:
        if clip_id not in clips:
            abort(404, "This run has no such clip.")
        return clips.facts(clip_id)

    @page.get("/decisions")
    def decided() -> dict:
        decisions.refresh()
        if request.args.get("known") == decisions.revision:
            return {"revision": decisions.revision}
        return {
            "revision": decisions.revision,
            "reasons": {name: why for name, why in decisions.reasons.items() if name in ids},
            "seen": sorted(decisions.seen & ids),
        }

    @page.post("/decisions")
    def decide() -> tuple[dict, int]:
        clip_id, was, now = _posted(request.get_json())
        if clip_id not in ids:
            abort(404, "This run has no such clip.")
        if now.reason is not None and now.reason not in met and not fits(now.reason):
            abort(400, UNFIT)
        holds, before = decisions.decide(clip_id, was, now)
        if holds != now:
            return {"seen": holds.seen, "reason": holds.reason}, 409
        if was.reason is not None:
            met.add(was.reason)
        return {"before": before, "revision": decisions.revision}, 200

    return server.studio(page, clips.media, clips.results, key)


def closing(clips: ClipsOfRun, decisions: Decisions, exclusions: Path) -> str:
    """What was done, and the command that makes use of it."""
    ids = set(clips.clips.index)
    out = decisions.reasons.keys() & ids
    looked = len((decisions.seen & ids) | out)
    text = f"\n{words.clips(looked)} looked at, {words.count(len(out))} left out."
    if others := len(decisions.reasons) - len(out):
        text += f" The list has {words.clips(others)} besides that this run does not."
    if not decisions.exclusions.exists():
        return text
    again = recall(clips.results).command(select={"exclusions": str(exclusions)})
    return f"{text}\nThe list is {exclusions}. To run without them:\n  {again}"


def _posted(body: object) -> tuple[str, Decision, Decision]:
    """The clip, what the page believed and what it wants; refuses anything else."""
    match body:
        case {"clip_id": str(clip_id), "was": was, "now": now}:
            return clip_id, _decision(was), _decision(now)
    return abort(400, "Expected clip_id, was and now.")


def _decision(said: object) -> Decision:
    match said:
        case {"seen": bool(seen), "reason": str() | None as reason}:
            return Decision(seen, reason)
    return abort(400, "A decision is seen, true or false, and reason, text or null.")


def _spaced(reason: str) -> str:
    return reason.replace("_", " ")
