"""The clusters of each region: their names, and a few of their intervals as pictures and curves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.series import dead_channels, sequences
from mimeline.reporting.album import Album, Shot
from mimeline.reporting.drawing import Scale, curve, second_ticks
from mimeline.vocabulary import ACTIONS, NEUTRAL, series_channels

KINDS = ("medoid", "longest", "border", "random")  # the order in which they are shown
WIDTH, HEIGHT = 176, 74  # of the curves
GAP, LEADERS = 3, 9  # between the pictures above; height of the lines up to them
CONTEXT_FRAMES, CONTEXT_SHARE = 12, 0.3  # shown before and after an interval
MOST_POINTS = 120  # longer curves are thinned


@dataclass(frozen=True)
class Exemplar:
    """A small picture: one path per channel, whole and within the interval [x0, x1].

    shots: the interval's first, middle and last frame, filmed where there is a video, and drawn;
    leader: a line from each to the curves.
    """

    clip_id: str
    kind: str
    text: str
    paths: list[str]
    x0: float
    x1: float
    seconds: list[float]
    shots: list[Shot]
    leader: str


@dataclass(frozen=True)
class Cluster:
    number: int
    action: str
    share: float
    source: str
    note: str
    exemplars: list[Exemplar]


@dataclass(frozen=True)
class Region:
    """reason: why there is no cluster. top: the largest value of the pictures' scale.

    left_out: the channels that hardly move, which the clusters were fitted without.
    """

    name: str
    channels: tuple[str, ...]
    left_out: list[str]
    clusters: list[Cluster]
    top: float
    reason: str


def regions(
    series: Mapping[str, str | Path],
    clusters: Mapping[str, str | Path],
    labels: str | Path,
    exemplars: str | Path,
    fps: Mapping[str, float],
    side: str,
    wanted: int,
    album: Album,
) -> list[Region]:
    """One entry per series region.

    series, clusters: tables by region; fps: by clip; wanted: exemplars drawn per cluster; album:
    is asked for their pictures.
    """
    names = tables.read(tables.LABELS, labels)
    shown = tables.read(tables.EXEMPLARS, exemplars)
    return [
        _region(
            region,
            path,
            clusters[region],
            names[names["region"] == region],
            shown[shown["region"] == region],
            fps,
            side,
            wanted,
            album,
            tables.reason(labels),
        )
        for region, path in series.items()
    ]


def _region(
    region: str,
    series: str | Path,
    clusters: str | Path,
    names: pd.DataFrame,
    shown: pd.DataFrame,
    fps: Mapping[str, float],
    side: str,
    wanted: int,
    album: Album,
    why: str,
) -> Region:
    channels = series_channels(region, side)
    if names.empty:
        reason = tables.reason(clusters) or tables.reason(series) or why or "no cluster was found"
        return Region(region, channels, [], [], 1.0, reason)
    needed = set(shown["clip_id"])
    rows, _ = sequences(tables.read(tables.SERIES[region, side], series))
    left_out = dead_channels(rows[list(channels)])
    rows = rows[rows["clip_id"].isin(needed)]
    top = _top(rows[list(channels)].to_numpy("float64"))
    by_clip = dict(iter(rows.groupby("clip_id")))
    found = []
    for name in _ordered(names).itertuples():
        own = shown[shown["cluster"] == name.cluster]
        drawn = [
            _exemplar(row, by_clip[row.clip_id], channels, fps.get(row.clip_id), top, album)
            for row in _distinct(own).head(wanted).itertuples()
            if row.clip_id in by_clip
        ]
        note = "" if pd.isna(name.note) else name.note
        source = "named by a person" if name.source == "human" else "proposed by the rule"
        found.append(Cluster(name.cluster, name.action, name.share, source, note, drawn))
    return Region(region, channels, left_out, found, top, "")


def _ordered(names: pd.DataFrame) -> pd.DataFrame:
    """By action, Neutral last; the more frequent cluster first."""
    place = names["action"].map([*ACTIONS, NEUTRAL].index)
    return names.assign(place=place).sort_values(["place", "share"], ascending=[True, False])


def _distinct(exemplars: pd.DataFrame) -> pd.DataFrame:
    """An interval that was chosen for several reasons appears once, with all of them as kind."""
    place = exemplars["kind"].map(KINDS.index)
    ordered = exemplars.assign(place=place).sort_values("place", kind="stable")
    keys = ["clip_id", "start_frame", "end_frame"]
    kinds = ordered.groupby(keys)["kind"].agg(lambda kinds: ", ".join(dict.fromkeys(kinds)))
    return ordered.drop_duplicates(keys).drop(columns="kind").join(kinds, on=keys)


def _top(values: np.ndarray) -> float:
    """The scale's end: the largest value, rounded up to a quarter."""
    if not len(values):
        return 1.0
    return float(max(0.25, np.ceil(np.nanquantile(values, 0.999) * 4) / 4))


def _exemplar(
    row,
    frames: pd.DataFrame,
    channels: tuple[str, ...],
    fps: float | None,
    top: float,
    album: Album,
) -> Exemplar:
    context = CONTEXT_FRAMES + round(CONTEXT_SHARE * (row.end_frame - row.start_frame))
    number = frames["frame"].to_numpy("int64")
    near = (number >= row.start_frame - context) & (number < row.end_frame + context)
    frames, number = frames[near], number[near]
    start = max(row.start_frame - context, int(number[0]))
    stop = min(row.end_frame + context, int(number[-1]) + 1)
    dense = np.full((stop - start, len(channels)), np.nan)  # a frame that is masked stays a gap
    dense[number - start] = frames[list(channels)].to_numpy("float64")
    step = max(1, len(dense) // MOST_POINTS)
    x, y = Scale(start, stop - 1, 0, WIDTH), Scale(0, top, HEIGHT - 2, 3)
    at = np.arange(start, stop)[::step]
    length = row.end_frame - row.start_frame
    seconds = f"{length / fps:.2f} s" if fps else f"{length} frames"
    ticks = [x(s * fps) for s in second_ticks(start / fps, stop / fps, most=20)] if fps else []
    views = (None, row.region) if row.clip_id in album.media else (row.region,)
    shown = [row.start_frame, (row.start_frame + row.end_frame - 1) // 2, row.end_frame - 1]
    return Exemplar(
        row.clip_id,
        row.kind,
        f"{seconds}, frames {row.start_frame}–{row.end_frame - 1}",
        [curve(at, values[::step].clip(max=top), x, y) for values in dense.T],
        max(0.0, x(row.start_frame - 0.5)),
        min(float(WIDTH), x(row.end_frame - 0.5)),
        [t for t in ticks if 0 <= t <= WIDTH],
        [album.ask(row.clip_id, frame, region=view) for view in views for frame in shown],
        _leader([x(frame) for frame in shown]),
    )


def _leader(places: Sequence[float]) -> str:
    """From under the middle of each picture, which fill the width, down to its place."""
    edge = (WIDTH - GAP * (len(places) - 1)) / len(places)
    middles = [edge / 2 + (edge + GAP) * number for number in range(len(places))]
    lines = zip(middles, places, strict=True)
    return "".join(f"M{a:.1f} {-LEADERS}L{b:g} 0V{HEIGHT - 1}" for a, b in lines)
