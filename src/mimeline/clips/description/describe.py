"""Each clip in sentences, what is shown how often, and weights that even it out."""

import logging
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from mimeline import tables
from mimeline.clips.description.appearance import degree_of, nouns, subject_of
from mimeline.clips.description.frequencies import evened, frequencies
from mimeline.clips.description.lexicon import Lexicon
from mimeline.clips.description.sentences import Scene, texts_of
from mimeline.clips.description.stretches import Run, is_untimed, runs
from mimeline.clips.description.telling import told
from mimeline.clips.description.templates import read_templates
from mimeline.clips.intervals import Interval, over
from mimeline.errors import printable

log = logging.getLogger(__name__)

CLIP_COLUMNS = (
    *("clip_id", "start_s", "end_s", "fps_num", "fps_den", "n_frames"),
    *("actions", "emotion", "emotions", "attributes"),
)
INTERVAL_COLUMNS = ("clip_id", "action", "start_frame", "end_frame")
NAMED = 5  # names without a template that the log tells


class Seen(NamedTuple):
    """What one source says of a clip: runs with their times, and names of what is seen sometime."""

    runs: list[Run]
    untimed: list[str]


def describe(
    clips: Sequence[Path],
    intervals: Sequence[Path],
    descriptions: Path,
    attributes: Path,
    weights: Path,
    texts: int,
    min_s: float,
    max_stretches: int,
    max_words: int,
    templates: Path | None,
    balance: float,
    seed: int,
) -> None:
    """Write the descriptions of all clips (Höll 2024, 5.3), what they show, and their weights.

    clips, intervals: tables of these names. The other keys are those of the configuration. A clip
    is told once by what its catalogue says and once by its timeline, where there is either.
    Raises BadFile where the templates are not what they should be.
    """
    lexicon = Lexicon(read_templates(Path(templates) if templates else None))
    known = tables.read_all(tables.CLIPS, clips, CLIP_COLUMNS)
    known["length_s"] = _lengths(known)
    known["attributes"] = [tuple(dict.fromkeys(names)) for names in known["attributes"]]
    timelines = _timelines(known, tables.read_all(tables.INTERVALS, intervals, INTERVAL_COLUMNS))
    limits = {"min_s": min_s, "max_stretches": max_stretches, "max_words": max_words}
    rows: list[tuple] = []
    shown: list[tuple] = []
    for clip in known.to_dict("records"):
        clip_id, length_s = clip["clip_id"], clip["length_s"]
        actions = _seen(_known_names(clip["actions"], lexicon), length_s)
        timeline = _seen(timelines.get(clip_id, ()), length_s)
        emotions = _seen(_emotions(clip), length_s)
        for kind, seen in (("action", actions), ("timeline", timeline), ("emotion", emotions)):
            shown += [(clip_id, kind, *row) for row in _seconds(seen)]
        shown += [(clip_id, "attribute", name, None) for name in clip["attributes"]]
        for source, seen in (("catalogue", actions), ("timeline", timeline)):
            if not any(seen) and (source == "timeline" or not any(emotions)):
                continue
            scene = _scene(clip, seen, emotions, lexicon, **limits)
            found = texts_of(scene, lexicon, texts, key=f"{seed}\0{clip_id}\0{source}")
            rows += [(clip_id, source, number, text) for number, text in enumerate(found)]
    _tell(rows, len(known), lexicon)
    described = pd.DataFrame(rows, columns=tables.DESCRIPTIONS.schema.names)
    reason = "" if rows else "no clip has an action, an emotion or a timeline"
    tables.write(tables.DESCRIPTIONS, described, descriptions, reason=reason)
    table = pd.DataFrame(shown, columns=["clip_id", "kind", "attribute", "seconds"])
    tables.write(tables.ATTRIBUTES, frequencies(table, len(known)), attributes)
    tables.write(tables.WEIGHTS, evened(known["clip_id"], table, balance), weights)


def _lengths(known: pd.DataFrame) -> pd.Series:
    """Seconds of the clips: of their frames where these are known, else of the catalogue."""
    frames, fps_num, fps_den = (
        known[name].to_numpy(float, na_value=float("nan"))
        for name in ("n_frames", "fps_num", "fps_den")
    )
    by_frames = pd.Series(frames * fps_den / fps_num, index=known.index)
    return by_frames.where(by_frames > 0, known["end_s"] - known["start_s"])


def _timelines(known: pd.DataFrame, intervals: pd.DataFrame) -> dict[str, list[Interval]]:
    """Each clip's timeline in seconds."""
    clocks = known.set_index("clip_id")[["fps_num", "fps_den"]].dropna().astype(float)
    intervals = intervals[intervals["clip_id"].isin(clocks.index)]
    clock = clocks.loc[intervals["clip_id"]]
    frame_s = clock["fps_den"].to_numpy() / clock["fps_num"].to_numpy()  # (n_intervals,)
    timelines: dict[str, list[Interval]] = {}
    for clip_id, action, start_s, end_s in zip(
        intervals["clip_id"],
        intervals["action"],
        intervals["start_frame"].to_numpy(float) * frame_s,
        intervals["end_frame"].to_numpy(float) * frame_s,
        strict=True,
    ):
        interval = {"name": action, "start_s": start_s, "end_s": end_s, "uncertainty_s": 0.0}
        timelines.setdefault(clip_id, []).append(interval)
    return timelines


def _known_names(actions: Iterable[Interval], lexicon: Lexicon) -> list[Interval]:
    return [interval | {"name": lexicon.action(interval["name"])} for interval in actions]


def _emotions(clip: dict) -> list[Interval]:
    """The clip's emotions; the one that stands alone is shown sometime."""
    if len(clip["emotions"]) or not isinstance(clip["emotion"], str):
        return list(clip["emotions"])
    return [over(clip["emotion"], clip["length_s"])]


def _seen(intervals: Iterable[Interval], length_s: float) -> Seen:
    timed, untimed = [], []
    for interval in intervals:
        if is_untimed(interval, length_s):
            untimed.append(interval["name"])
        else:
            unsure = interval["uncertainty_s"]
            timed.append(interval | {"uncertainty_s": 0.0 if pd.isna(unsure) else unsure})
    return Seen(runs(timed, length_s), list(dict.fromkeys(untimed)))


def _seconds(seen: Seen) -> Iterator[tuple[str, float | None]]:
    """Name and seconds of each run; no seconds for what is seen sometime."""
    yield from ((run.name, run.seconds) for run in seen.runs)
    yield from ((name, None) for name in seen.untimed)


def _scene(
    clip: dict,
    actions: Seen,
    emotions: Seen,
    lexicon: Lexicon,
    min_s: float,
    max_stretches: int,
    max_words: int,
) -> Scene:
    attributes, templates = clip["attributes"], lexicon.templates
    subject, degree = subject_of(attributes), degree_of(attributes, templates)
    looks = [run._replace(name=lexicon.emotion(run.name, degree)) for run in emotions.runs]
    untimed = actions.untimed + [lexicon.emotion(name, degree) for name in emotions.untimed]

    def n_words(name: str) -> int:
        return lexicon.said(name, subject).n_words

    named = nouns(attributes, templates)
    before = max(len(noun.split()) - 1 for noun in named)
    before += sum(n_words(name) + 1 for name in untimed)
    parts = told(
        sorted([*actions.runs, *looks]),
        clip["length_s"],
        min_s,
        max_stretches,
        max_words - before,
        lexicon.rank,
        n_words,
    )
    return Scene(subject, named, untimed, parts, clip["length_s"], min_s)


def _tell(rows: list[tuple], n_clips: int, lexicon: Lexicon) -> None:
    n_described = len({clip_id for clip_id, *_ in rows})
    log.info("%d descriptions of %d of %d clips", len(rows), n_described, n_clips)
    if lexicon.untold:
        some = sorted(lexicon.untold.items())[:NAMED]
        names = ", ".join(printable(f"{name} as '{words}'") for name, words in some)
        more = f" and {len(lexicon.untold) - NAMED} more" if len(lexicon.untold) > NAMED else ""
        log.warning(
            "without a template, told by their names: %s%s (describe.templates)", names, more
        )
