"""Timelines of a few clips: pictures over eight tracks of intervals, with the truth below each."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.annotate import track_codes, unmeasured_actions
from mimeline.annotation.runs import run_starts
from mimeline.reporting import words
from mimeline.reporting.album import Album, Shot
from mimeline.reporting.drawing import Scale, second_ticks
from mimeline.reporting.filmstrip import Place, places
from mimeline.vocabulary import ACTIONS, TRACKS, track_actions

LEFT, RIGHT, WIDTH = 112, 20, 860
ROW, BAR, TRUTH, TOP = 25, 13, 4, 4
LONGEST_S = 12.0  # of a longer clip, the part richest in actions is drawn
LETTER = 5.9  # width of a letter of a label
PARTS = {"train": "training", "val": "validation", "test": "test", "no": "in no"}
GAP = "?"  # a stretch that is not known
UNKNOWN = "not measured, or its cluster has no name"


@dataclass(frozen=True)
class Stretch:
    """An interval in the picture."""

    action: str
    x: float
    width: float
    label: str
    title: str


@dataclass(frozen=True)
class Row:
    """A track: measured "all", "part" or "none" of the frames.

    absent: those of its actions, in words, that were not measured though others were.
    """

    name: str
    y: float
    measured: str
    stretches: list[Stretch]
    truth: list[Stretch]
    gaps: list[Stretch]
    absent: str


@dataclass(frozen=True)
class Picture:
    """The timeline of a clip."""

    clip_id: str
    about: str
    rows: list[Row]
    ticks: list[tuple[float, str]]
    height: float
    end: float
    has_truth: bool
    strip: list[tuple[Place, Shot]]


@dataclass(frozen=True)
class Timelines:
    """unmeasured: tracks; absent: actions that were not measured of tracks that were."""

    pictures: list[Picture]
    reason: str
    unmeasured: list[str]
    absent: list[str]

    @property
    def gaps(self) -> bool:
        """Whether a track that is drawn is not known throughout."""
        return any(row.measured == "part" for picture in self.pictures for row in picture.rows)


def timelines(
    clips: pd.DataFrame,
    intervals: Sequence[str | Path],
    frames: pd.DataFrame,
    truth: pd.DataFrame | None,
    wanted: int,
    parts: Mapping[str, str],
    album: Album,
) -> Timelines:
    """Pictures of the clips that together show the most actions, filmed ones first.

    clips: `clips` kept, with fps; frames: the `frames` table; truth: such a table, or None;
    parts: clip → train, val or test; album: is asked for the strips' pictures.
    """
    found = tables.read_all(tables.INTERVALS, intervals)
    if frames.empty:
        why = next((r for path in intervals if (r := tables.reason(path))), "no clip came through")
        return Timelines([], why, [], [])
    absent = {track: unmeasured_actions(frames, track) for track in TRACKS}
    unmeasured = [t for t in TRACKS if frames[list(track_actions(t))].isna().all(axis=None)]
    chosen = choose(found, sorted(frames["clip_id"].unique()), wanted, set(album.media))
    by_id = clips.set_index("clip_id")
    spans = {clip: _span(clip, by_id, frames, found) for clip in chosen}
    longest = max((span[2] - span[1]) / span[0] for span in spans.values())
    pictures = [
        _picture(
            clip, spans[clip], longest, found, frames, truth, absent, parts.get(clip, "no"), album
        )
        for clip in chosen
    ]
    told = [name for track in TRACKS if track not in unmeasured for name in absent[track]]
    return Timelines(pictures, "", unmeasured, told)


def choose(
    intervals: pd.DataFrame, clips: Sequence[str], wanted: int, filmed: Collection[str] = ()
) -> list[str]:
    """Clips that show many different actions, those not shown yet first; ties by id.

    Filmed ones come before all others.
    """
    shows = intervals.groupby("clip_id")["action"].agg(set).to_dict()
    counts = intervals["clip_id"].value_counts()
    left, chosen, seen = list(clips), [], set()
    while left and len(chosen) < wanted:
        best = min(
            left,
            key=lambda clip: (
                clip not in filmed,
                -len(shows.get(clip, set()) - seen),
                -len(shows.get(clip, set())),
                -int(counts.get(clip, 0)),
                clip,
            ),
        )
        left.remove(best)
        chosen.append(best)
        seen |= shows.get(best, set())
        if len(seen) == len(ACTIONS):
            seen = set()
    return chosen


def _span(
    clip: str, clips: pd.DataFrame, frames: pd.DataFrame, intervals: pd.DataFrame
) -> tuple[float, int, int]:
    """fps, and the frames [first, end) to draw."""
    fps = float(clips.at[clip, "fps_num"] / clips.at[clip, "fps_den"])
    end = int(frames.loc[frames["clip_id"] == clip, "frame"].max()) + 1
    window = int(LONGEST_S * fps)
    if end <= window:
        return fps, 0, end
    own = intervals[intervals["clip_id"] == clip]
    starts = range(0, end - window + 1, max(1, int(fps)))

    def richness(start: int) -> tuple[int, int]:
        inside = own[(own["start_frame"] < start + window) & (own["end_frame"] > start)]
        return inside["action"].nunique(), len(inside)

    start = max(starts, key=lambda s: (*richness(s), -s))
    return fps, start, start + window


def _picture(
    clip: str,
    span: tuple[float, int, int],
    longest_s: float,
    intervals: pd.DataFrame,
    frames: pd.DataFrame,
    truth: pd.DataFrame | None,
    absent: Mapping[str, list[str]],
    part: str,
    album: Album,
) -> Picture:
    fps, start, end = span
    x = Scale(start, start + longest_s * fps, LEFT, WIDTH - RIGHT)
    own = intervals[intervals["clip_id"] == clip]
    marks = frames[frames["clip_id"] == clip]
    true = truth[truth["clip_id"] == clip] if truth is not None else frames[:0]
    rows = []
    for place, track in enumerate(TRACKS):
        known = track_codes(marks, track, absent[track]) >= 0
        silent = marks[list(track_actions(track))].isna().all(axis=None)
        measured = "none" if silent else "all" if known.all() else "part"
        drawn = [
            _stretch(row.action, row.start_frame, row.end_frame, span, x, _facts(row))
            for row in own[own["track"] == track].itertuples()
            if row.start_frame < end and row.end_frame > start
        ]
        shown = within(stretches(true, track), span, x, "truth")
        gaps = within(stretches(marks, track, absent[track], gaps=True), span, x, UNKNOWN)
        name = words.TRACK_NAMES[track]
        without = "" if silent else words.listing([words.short(a) for a in absent[track]])
        rows.append(Row(name, TOP + place * ROW, measured, drawn, shown, gaps, without))
    seconds = (end - start) / fps
    whole = int(marks["frame"].max()) + 1
    about = f"{seconds:.1f} s at {fps:g} frames per second"
    if whole > end - start:
        about = f"seconds {start / fps:.0f} to {end / fps:.0f} of {whole / fps:.0f}, {fps:g} fps"
    about += f", {PARTS.get(part, part)} part"
    ticks = [(x(s * fps), f"{s:g}") for s in second_ticks(start / fps, end / fps)]
    height = TOP + len(TRACKS) * ROW
    strip = [(place, album.ask(clip, place.frame)) for place in places(start, end, x)]
    return Picture(clip, about, rows, ticks, height, x(end), len(true) > 0, strip)


def within(
    runs: list[tuple[str, int, int]], span: tuple[float, int, int], x: Scale, facts: str
) -> list[Stretch]:
    """The runs (action, first frame, end frame) that reach into span: fps and frames [first, end).

    facts: what the titles say after name and length.
    """
    _, start, end = span
    return [_stretch(*run, span, x, facts) for run in runs if run[1] < end and run[2] > start]


def _facts(row) -> str:
    if pd.isna(row.cluster):
        return "by a limit" if row.source == "threshold" else f"by {row.source}"
    sure = "" if pd.isna(row.confidence) else f", confidence {row.confidence:.2f}"
    return f"cluster {row.cluster}{sure}"


def _stretch(
    action: str, first: int, stop: int, span: tuple[float, int, int], x: Scale, facts: str
) -> Stretch:
    fps, start, end = span
    a, b = x(max(first, start)), x(min(stop, end))
    label = words.short(action) if action in ACTIONS else ""
    fits = b - a > len(label) * LETTER + 8
    long = f"frames {first}–{stop - 1}, {(stop - first) / fps:.2f} s"
    name = words.spaced(action) if action in ACTIONS else UNKNOWN
    title = f"{name}: {long}" + (f"; {facts}" if facts != name else "")
    return Stretch(action, a, round(max(b - a, 1.0), 1), label if fits else "", title)


def stretches(
    frames: pd.DataFrame, track: str, unmeasured: Collection[str] = (), gaps: bool = False
) -> list[tuple[str, int, int]]:
    """(action, first frame, end frame) of each run of an action on a track.

    frames: the `frames` table of a clip, sorted. gaps: the runs that are not known, instead, but
    for what is unmeasured throughout.
    """
    if frames.empty:
        return []
    names = np.array(["", *track_actions(track), GAP], dtype=object)
    code = track_codes(frames, track, unmeasured)  # -1 is the last name, that of a gap
    rows = run_starts(frames, code)
    lengths = np.diff([*rows, len(frames)])
    first = frames["frame"].to_numpy("int64")[rows]
    runs = zip(names[code[rows]], first, lengths, strict=True)
    return [
        (str(name), int(a), int(a + n)) for name, a, n in runs if name and (name == GAP) == gaps
    ]
