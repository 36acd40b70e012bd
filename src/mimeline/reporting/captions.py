"""Sentences about a few clips, beside the timeline that they are made from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.clips.description.stretches import is_untimed
from mimeline.reporting.album import Album, Shot
from mimeline.reporting.drawing import Scale, second_ticks
from mimeline.reporting.shows import thing
from mimeline.vocabulary import ACTIONS

MOST = 4  # clips
TEXTS = 2  # of a clip, from each source
LEFT, WIDTH, ROW, BAR = 96, 380, 16, 9
SIZE = 192  # pixels of a clip's picture


@dataclass(frozen=True)
class Stretch:
    """An interval in the picture; action: one of ours, or empty; about: for its title."""

    x: float
    width: float
    action: str
    about: str


@dataclass(frozen=True)
class Row:
    name: str
    y: float
    stretches: list[Stretch]


@dataclass(frozen=True)
class Told:
    """What a text is made from, in rows, and the texts."""

    source: str  # catalogue or timeline
    rows: list[Row]
    texts: list[str]
    height: float


@dataclass(frozen=True)
class Caption:
    """A clip with what is told of it; facts: what holds for all of it, or nobody says when."""

    clip_id: str
    facts: list[str]
    shot: Shot
    told: list[Told]
    ticks: list[tuple[float, str]]
    end: float


@dataclass(frozen=True)
class Captions:
    clips: list[Caption]
    described: int
    texts: int
    reason: str


def captions(
    descriptions: str | Path, clips: pd.DataFrame, intervals: Sequence[str | Path], album: Album
) -> Captions:
    """Some clips of which different things are told, filmed ones first.

    clips: `clips` kept. descriptions, intervals: tables; album: is asked for a picture of each.
    """
    table = tables.read(tables.DESCRIPTIONS, descriptions)
    table = table[table["clip_id"].isin(clips["clip_id"])]
    if table.empty:
        return Captions([], 0, 0, tables.reason(descriptions) or "no clip is described")
    found = tables.read_all(tables.INTERVALS, intervals)
    texts = dict(iter(table.groupby("clip_id")))
    told_of = clips[clips["clip_id"].isin(texts)].set_index("clip_id", drop=False)
    shows = found.groupby("clip_id")["action"].agg(set).to_dict()
    shows = {
        clip.clip_id: shows.get(clip.clip_id, set()) | {m["name"] for m in _listed(clip)}
        for clip in told_of.itertuples()
    }
    shown = [
        _caption(told_of.loc[clip], found[found["clip_id"] == clip], texts[clip], album)
        for clip in _choose(shows, album)
    ]
    return Captions(shown, len(texts), len(table), "")


def _listed(clip) -> list[dict]:
    """What the catalogue says of a clip's seconds."""
    return [*clip.actions, *clip.emotions]


def _choose(shows: dict[str, set[str]], album: Album) -> list[str]:
    """Clips that show what none of those before shows; ties by id."""
    left, chosen, seen = sorted(shows), [], set()
    while left and len(chosen) < MOST:
        best = max(
            left,
            key=lambda clip: (clip in album.media, len(shows[clip] - seen), len(shows[clip])),
        )
        left.remove(best)
        chosen.append(best)
        seen |= shows[best]
    return chosen


def _caption(
    clip: pd.Series, intervals: pd.DataFrame, texts: pd.DataFrame, album: Album
) -> Caption:
    fps = float(clip["fps_num"] / clip["fps_den"])
    length_s = clip["n_frames"] / fps
    x = Scale(0, length_s, LEFT, WIDTH)
    marks = {
        "catalogue": [
            (m["name"], m["start_s"], m["end_s"], m["uncertainty_s"])
            for m in _listed(clip)
            if not is_untimed(m, length_s)
        ],
        "timeline": [
            (row.action, row.start_frame / fps, row.end_frame / fps, 0.0)
            for row in intervals.itertuples()
        ],
    }
    told = []
    for source, own in texts.groupby("source"):
        rows = _rows(marks[source], length_s, x)
        written = own.sort_values("number")["text"].head(TEXTS).tolist()
        told.append(Told(source, rows, written, ROW * len(rows)))
    sometime = [m["name"] for m in _listed(clip) if is_untimed(m, length_s)]
    if not len(clip["emotions"]) and isinstance(clip["emotion"], str):
        sometime.append(clip["emotion"])
    facts = [thing(name) for name in dict.fromkeys(clip["attributes"])]
    facts += [f"{thing(name)} at some time" for name in dict.fromkeys(sometime)]
    shot = album.ask(clip["clip_id"], int(clip["n_frames"]) // 2, SIZE)
    ticks = [(x(s), f"{s:g}") for s in second_ticks(0, length_s, most=8)]
    return Caption(clip["clip_id"], facts, shot, told, ticks, x(length_s))


def _rows(marks: list[tuple], length_s: float, x: Scale) -> list[Row]:
    """A row per name, in the order of their first start."""
    by_name: dict[str, list[Stretch]] = {}
    for name, start, end, uncertain in sorted(marks, key=lambda mark: mark[1]):
        a, b = x(min(max(start, 0.0), length_s)), x(min(max(end, 0.0), length_s))
        about = f"{thing(name)}: {start:.1f}–{end:.1f} s"
        about += f", each within {uncertain:g} s" if uncertain else ""
        action = name if name in ACTIONS else ""
        by_name.setdefault(name, []).append(Stretch(a, round(max(b - a, 1.5), 1), action, about))
    return [
        Row(thing(name), place * ROW, stretches)
        for place, (name, stretches) in enumerate(by_name.items())
    ]
