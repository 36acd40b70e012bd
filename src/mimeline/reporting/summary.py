"""The head of the page: a line of figures, a few sentences, and what is missing."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from mimeline.reporting import words
from mimeline.reporting.album import Album
from mimeline.reporting.channels import Channels
from mimeline.reporting.clusters import Region
from mimeline.reporting.funnel import Funnel
from mimeline.reporting.pairs import Pairs
from mimeline.reporting.scores import Scores
from mimeline.reporting.timelines import Timelines
from mimeline.reporting.training import Model

NAMED = 6  # of many


@dataclass(frozen=True)
class Figure:
    """A number of the head, with what it counts and a line of context."""

    value: str
    name: str
    context: str


def figures(
    way: Funnel, clips: pd.DataFrame, intervals: int, scored: Scores, models: Sequence[Model]
) -> list[Figure]:
    """The few numbers that a reader looks for first; clips: those that came through."""
    seconds = _seconds(clips)
    kept = words.percent(way.kept / way.entered) if way.entered else "–"
    shown = [
        Figure(f"{words.count(way.kept)}", f"of {words.clips(way.entered)} kept", kept),
        Figure(words.minutes(seconds), "minutes of motion", _people(clips)),
        Figure(words.count(intervals), "actions found", _per_minute(intervals, seconds)),
    ]
    if scored.mean is not None:
        context = "mean of brow, eye, mouth"
        context += f"; {scored.partly}" if scored.partly else ""
        shown.append(Figure(words.score(scored.mean), "annotation F1", context))
    for model in models:
        told = model.tas.get("request")
        if told is not None:
            empty = model.tas.get("empty")
            context = "" if empty is None else f"{words.score(empty)} when told nothing happens"
            context += "; partly on training clips" if model.seen else ""
            shown.append(Figure(words.score(told), f"alignment of the {model.name} model", context))
    return shown


def lead(way: Funnel, parts: pd.DataFrame, regions: Sequence[Region], against: str) -> list[str]:
    """What happened, in sentences. against: of the scores."""
    if not way.kept:
        return ["No clip came through. The funnel below says at which stage each one was lost."]
    lost = way.entered - way.kept
    text = f"Of {words.clips(way.entered)}, {words.count(way.kept)} came through"
    others = "the other" if lost == 1 else f"each of the other {words.count(lost)}"
    text += f"; the reason of {others} stands below." if lost else "."
    sentences = [text]
    clusters = [f"{len(r.clusters)} for the {r.name}" for r in regions if r.clusters]
    if clusters:
        total = sum(len(r.clusters) for r in regions)
        told = f"The motion falls into {total} clusters ({words.listing(clusters)})"
        sentences.append(f"{told}; {_named(regions)}.")
    sizes = parts["part"].value_counts()
    if len(sizes):
        told = [
            f"{words.count(sizes[part])} for {word}"
            for part, word in (("train", "training"), ("val", "validation"), ("test", "testing"))
            if part in sizes
        ]
        sentences.append(f"Clips are divided {words.listing(told)}.")
    if against:
        sentences.append(f"{against.capitalize()} is known here: the scores are measured by it.")
    return sentences


def _named(regions: Sequence[Region]) -> str:
    """Who named the clusters, and how many have no name."""
    found = [cluster for region in regions for cluster in region.clusters]
    named = [cluster.source for cluster in found if cluster.action is not None]
    if named.count("proposed") == len(found):
        return "a rule proposed every name"
    ways = {
        "human": "a person named {}",
        "moved": "{} kept the name of the fit before",
        "proposed": "a rule proposed the names of {}",
    }
    told = [text.format(n) for way, text in ways.items() if (n := named.count(way))]
    unnamed = len(found) - len(named)
    told += [f"{unnamed} {'has' if unnamed == 1 else 'have'} no name"] if unnamed else []
    return words.listing(told)


def missing(
    way: Funnel,
    measured: Channels,
    regions: Sequence[Region],
    drawn: Timelines,
    scored: Scores,
    models: Sequence[Model],
    album: Album,
    alike: Pairs,
) -> list[tuple[str, str]]:
    """(anchor, sentence) of everything that this run could not tell, nor show."""
    told: list[tuple[str, str]] = []
    if measured.absent and not measured.reason:
        told.append(("channels", _some(measured.absent, "is not measured", "are not measured")))
    if measured.dead:
        told.append(("channels", _some(measured.dead, "hardly moves", "hardly move")))
    told += [("clusters", f"no {r.name} clusters: {r.reason}") for r in regions if r.reason]
    told += [("clusters", _unnamed(r)) for r in regions if r.unnamed]
    told += [
        ("clusters", f"{words.listing([words.spaced(a) for a in r.unmeasured])}: not measured")
        for r in regions
        if r.unmeasured
    ]
    if drawn.unmeasured:
        names = words.listing([words.TRACK_NAMES[t] for t in drawn.unmeasured])
        told.append(("timelines", f"not measured on the timelines: {names}"))
    told += [
        ("funnel", f"{note.stage}: {note.text} ({words.clips(note.clips)})")
        for note in way.notes
        if "not applied" in note.text or note.text.startswith("parts are")
    ]
    if alike.reason.startswith("split.near_duplicates"):
        told.append(("funnel", f"near-duplicates were not looked for: {alike.reason}"))
    if scored.reason:
        told.append(("scores", f"no annotation scores: {scored.reason}"))
    for model in models:
        if model.reason:
            told.append(("model", f"no {model.name} model: {model.reason}"))
        elif model.metrics_reason:
            told.append(("model", f"no scores of {model.name}: {model.metrics_reason}"))
    if album.gone:
        names = ", ".join(sorted(album.gone)[:NAMED]) + (" …" if len(album.gone) > NAMED else "")
        many = f"{words.clips(len(album.gone))} ({names})"
        instead = "the motion is drawn instead (`snakemake -R fetch` cuts the films anew)"
        told.append(("funnel", f"the film of {many} cannot be shown: {instead}"))
    if album.stand_in.reason:
        told.append(("clusters", f"the embedded face stands in: {album.stand_in.reason}"))
    return told


def _unnamed(region: Region) -> str:
    unnamed = region.unnamed
    share = words.percent(sum(cluster.share for cluster in unnamed))
    have = "has" if len(unnamed) == 1 else "have"
    return (
        f"{len(unnamed)} of the {len(region.clusters)} {region.name} clusters {have} no name: "
        f"what {share} of the frames show is not known, and no score counts them"
    )


def _some(names: Sequence[str], one: str, many: str) -> str:
    shown = ", ".join(names[:NAMED]) + (" …" if len(names) > NAMED else "")
    subject = f"1 channel {one}" if len(names) == 1 else f"{len(names)} channels {many}"
    return f"{subject} ({shown})"


def _seconds(clips: pd.DataFrame) -> float:
    if clips.empty:
        return 0.0
    return float((clips["n_frames"] * clips["fps_den"] / clips["fps_num"]).sum())


def _people(clips: pd.DataFrame) -> str:
    people = clips["subject_id"].nunique()
    if people:
        return f"{words.count(people)} {'person' if people == 1 else 'people'}"
    videos = clips["source_id"].nunique()
    return f"{words.count(videos)} {'recording' if videos == 1 else 'recordings'}" if videos else ""


def _per_minute(intervals: int, seconds: float) -> str:
    return f"{intervals / seconds * 60:.0f} per minute" if seconds else ""
