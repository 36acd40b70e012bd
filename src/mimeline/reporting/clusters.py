"""The clusters of each region: their names, and a few of their intervals as pictures and curves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.series import dead_channels, sequences
from mimeline.reporting import words
from mimeline.reporting.album import Album, Shot
from mimeline.reporting.drawing import Scale, curve, second_ticks
from mimeline.vocabulary import ACTIONS, NEUTRAL, series_channels

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
    """action: None where its frames have none. source: proposed, moved or human; origin: that in
    words, or why there is no name. facts: lines about its size, purity and the closest cluster."""

    number: int
    action: str | None
    share: float
    source: str
    origin: str
    note: str
    facts: list[str]
    exemplars: list[Exemplar]


@dataclass(frozen=True)
class Region:
    """reason: why there is no cluster. top: the largest value of the pictures' scale.

    left_out: the channels that hardly move, which the clusters were fitted without; unmeasured: the
    actions that no other channel tells. kept: the share of frames that kept their name, of those
    whose names were moved from another fit; None where none was.
    """

    name: str
    channels: tuple[str, ...]
    left_out: list[str]
    clusters: list[Cluster]
    top: float
    reason: str
    unmeasured: list[str] = field(default_factory=list)
    kept: float | None = None

    @property
    def unnamed(self) -> list[Cluster]:
        return [cluster for cluster in self.clusters if cluster.action is None]


def regions(
    series: Mapping[str, str | Path],
    clusters: Mapping[str, str | Path],
    labels: str | Path,
    exemplars: str | Path,
    profiles: str | Path,
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
    known = tables.read(tables.PROFILES, profiles)
    return [
        _region(
            region,
            path,
            clusters[region],
            names[names["region"] == region],
            shown[shown["region"] == region],
            known[known["region"] == region].set_index("cluster"),
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
    profiles: pd.DataFrame,
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
    shown = shown.sort_values("rank").groupby("cluster").head(wanted)
    rows, _ = sequences(tables.read(tables.SERIES[region, side], series))
    left_out = dead_channels(rows[list(channels)])
    rows = rows[rows["clip_id"].isin(shown["clip_id"])]
    top = scale_end(rows[list(channels)].to_numpy("float64"))
    by_clip = dict(iter(rows.groupby("clip_id")))
    rate = float(np.median(list(fps.values()))) if fps else None
    called = dict(zip(names["cluster"], names["action"].map(_called), strict=True))
    found = []
    for name in _ordered(names).itertuples():
        drawn = [
            _exemplar(row, by_clip[row.clip_id], channels, fps.get(row.clip_id), top, album)
            for row in shown[shown["cluster"] == name.cluster].itertuples()
            if row.clip_id in by_clip
        ]
        facts = [f"{words.percent(name.share)} of frames"]
        if name.cluster in profiles.index:
            facts += _facts(profiles.loc[name.cluster], called, rate)
        action = None if pd.isna(name.action) else name.action
        note = "" if pd.isna(name.note) else name.note
        origin = _origin(name)
        found.append(
            Cluster(name.cluster, action, name.share, name.source, origin, note, facts, drawn)
        )
    unmeasured = list(dict.fromkeys(action for own in names["unmeasured"] for action in own))
    return Region(region, channels, left_out, found, top, "", unmeasured, _kept(names))


def _ordered(names: pd.DataFrame) -> pd.DataFrame:
    """By action, Neutral and what has no name last; the more frequent cluster first."""
    place = names["action"].map({action: i for i, action in enumerate([*ACTIONS, NEUTRAL])})
    return names.assign(place=place).sort_values(["place", "share"], ascending=[True, False])


def _called(action: str | None) -> str:
    return "no name" if pd.isna(action) else words.spaced(action)


def _origin(name) -> str:
    """Where a cluster's name is from, or why it has none; name: a row of `labels`."""
    if pd.isna(name.action):
        return "not sure" if pd.isna(name.why) else name.why
    sure = "" if pd.isna(name.confidence) else words.percent(name.confidence)
    if name.source == "moved":
        return "moved from the fit before" + (f", {sure} of its frames bore it" if sure else "")
    if name.source == "proposed":
        return "proposed by the rule" + (f", confidence {sure}" if sure else "")
    return "named by a person"


def _facts(profile: pd.Series, called: Mapping[int, str], rate: float | None) -> list[str]:
    """profile: a row of `profiles`. called: what each cluster is called; rate: frames a second."""
    typical = profile["median_frames"]
    length = f"{typical / rate:.1f} s" if rate else f"{typical:g} frames"
    intervals = f"{words.count(profile['n_intervals'])} interval"
    intervals += "" if profile["n_intervals"] == 1 else "s"
    facts = [f"{intervals} in {words.clips(profile['n_clips'])}, typically {length}"]
    if pd.notna(profile["purity"]):
        pure = (
            "nearly all" if profile["purity"] >= 0.995 else f"about {100 * profile['purity']:.0f} %"
        )
        facts.append(f"{pure} of it looks alike")
    if pd.notna(profile["nearest"]):
        nearest = int(profile["nearest"])
        facts.append(f"closest: {nearest} {called.get(nearest, 'no name')}")
        if pd.notna(profile["distance"]):
            facts[-1] += f", {profile['distance']:.1f} nats away"
    return facts


def _kept(names: pd.DataFrame) -> float | None:
    """The share of frames that kept their name, over the clusters whose names were moved."""
    moved = names[(names["source"] == "moved") & names["confidence"].notna()]
    if not moved["share"].sum():
        return None
    return float(np.average(moved["confidence"], weights=moved["share"]))


def scale_end(values: np.ndarray) -> float:
    """Where the curves' scale ends: the largest value but for outliers, up to a quarter.

    values: (n, channels), NaN where not measured.
    """
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
