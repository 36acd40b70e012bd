"""Timelines of 16 actions: the clusters' names on three tracks, thresholds on the other five."""

import logging
from collections.abc import Collection
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.runs import run_starts
from mimeline.annotation.thresholds import Limits, threshold_actions
from mimeline.vocabulary import (
    NEUTRAL,
    SERIES_TRACK,
    TRACKS,
    series_actions,
    track_actions,
)

log = logging.getLogger(__name__)


def annotate(
    clips: Path,
    motion: Path,
    clusters: dict[str, Path],
    labels: Path,
    intervals: Path,
    frames: Path,
    closed: float,
    gaze_deg: float,
    head_deg: float,
    hysteresis: float,
    min_frames: int,
) -> None:
    """Write the timelines of a shard: `intervals` and `frames`.

    clips: the clips to annotate; clusters: by region, of all shards. The rest: see `Limits`.
    """
    kept = tables.read(tables.CLIPS, clips, ["clip_id"])["clip_id"]
    moving = tables.read(tables.MOTION, motion)
    moving = moving[moving["clip_id"].isin(kept)].reset_index(drop=True)
    assigned = {region: tables.read(tables.CLUSTERS, path) for region, path in clusters.items()}
    named = tables.read(tables.LABELS, labels)
    limits = Limits(closed, gaze_deg, head_deg, hysteresis, min_frames)
    marked = annotate_frames(moving, assigned, named, limits)
    found = intervals_of(marked, assigned)
    reason = "" if len(marked) else "no clip came through"
    tables.write(tables.FRAMES, marked, frames, reason)
    if not reason and found.empty:
        reason = "no action was found"
    tables.write(tables.INTERVALS, found, intervals, reason)
    log.info("%d clips, %d intervals", marked["clip_id"].nunique(), len(found))


def annotate_frames(
    motion: pd.DataFrame,
    clusters: dict[str, pd.DataFrame],
    labels: pd.DataFrame,
    limits: Limits,
) -> pd.DataFrame:
    """The 16 actions at each frame, pd.NA where it is not known whether the frame shows them.

    That is so where a track's channels were not measured, where the cluster has no name (one that
    fitting left without frames has none), for the actions that the labels call unmeasured (but
    where a person named a cluster so), and for all actions of a frame that is not valid.

    motion: the `motion` table, sorted by clip and frame. clusters: by region, the `clusters` table;
    labels: their names, and what is unmeasured where they have that column.
    """
    keys = motion[["clip_id", "frame"]].reset_index(drop=True)
    actions = threshold_actions(motion.reset_index(drop=True), limits)
    actions[~motion["valid"].to_numpy(bool)] = pd.NA
    for region in SERIES_TRACK:
        own = labels[labels["region"] == region]
        names = own.set_index("cluster")["action"]
        unmeasured = {name for absent in own.get("unmeasured", ()) for name in absent}
        assigned = clusters.get(region, tables.empty(tables.CLUSTERS))
        at = keys.merge(assigned[["clip_id", "frame", "cluster"]], how="left", validate="1:1")
        action = at["cluster"].map(names)  # (n_frames,), NaN where not measured or without a name
        for name in series_actions(region):
            shown = action == name
            untold = ~shown if name in unmeasured else action.isna()
            actions[name] = shown.astype("boolean").mask(untold)
    marked = pd.concat([keys, actions], axis=1)[tables.FRAMES.schema.names]
    return _without_short(marked, limits.min_frames) if limits.min_frames > 1 else marked


def intervals_of(frames: pd.DataFrame, clusters: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """The `intervals` table of annotated frames.

    An interval of a clustered track tells the cluster that most of its frames belong to, and as
    confidence the mean of 1 / (1 + exp(-margin)) over them.
    """
    parts = []
    for track in TRACKS:
        runs = _runs(frames, track)
        runs = runs[runs["action"] != NEUTRAL]
        region = next((r for r, t in SERIES_TRACK.items() if t == track), None)
        facts = {"track": track, "side": None, "cluster": pd.NA, "confidence": np.nan}
        runs = runs.assign(source="ticc" if region else "threshold", **facts)
        if len(runs) and region in clusters:
            at = frames[["clip_id", "frame"]].merge(clusters[region], how="left")
            rows, number = _rows(runs)
            within = at.iloc[rows]
            sure = 1 / (1 + np.exp(-within["margin"].to_numpy("float64")))
            runs["confidence"] = np.bincount(number, sure) / np.bincount(number)
            ids = within["cluster"].to_numpy("int64")
            votes = np.zeros((len(runs), ids.max() + 1), dtype="int64")
            np.add.at(votes, (number, ids), 1)
            runs["cluster"] = votes.argmax(axis=1)
        parts.append(runs)
    found = pd.concat([part for part in parts if len(part)] or parts[:1])
    return found[tables.INTERVALS.schema.names]


def _runs(frames: pd.DataFrame, track: str) -> pd.DataFrame:
    """Stretches of one action or of none on a track, within a clip and measured.

    Returns clip_id, action, start_frame, end_frame and the rows [row, stop) of frames.
    """
    names = np.array([NEUTRAL, *track_actions(track)], dtype=object)
    code = track_codes(frames, track)
    row = run_starts(frames, code)
    stop = np.append(row, len(frames))[1:]
    frame = frames["frame"].to_numpy("int64")[row]
    runs = pd.DataFrame(
        {
            "clip_id": frames["clip_id"].to_numpy()[row],
            "action": names[np.maximum(code[row], 0)],
            "start_frame": frame,
            "end_frame": frame + stop - row,
            "row": row,
            "stop": stop,
        }
    )
    return runs[code[row] >= 0]


def _rows(runs: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """The rows of frames that runs cover, end to end, and the number of each row's run."""
    first, length = runs["row"].to_numpy(), (runs["stop"] - runs["row"]).to_numpy()
    number = np.repeat(np.arange(len(runs)), length)
    within = np.arange(len(number)) - (np.cumsum(length) - length)[number]
    return first[number] + within, number


def track_codes(frames: pd.DataFrame, track: str, unmeasured: Collection[str] = ()) -> np.ndarray:
    """(n_frames,) int: i where the track's i-th action is true, 0 neutral, -1 not known.

    A frame is neutral where every action is known to be absent; unmeasured: but for these.
    """
    marks = frames[list(track_actions(track))].to_numpy("float64", na_value=np.nan)  # (n, actions)
    asked = [name not in unmeasured for name in track_actions(track)]
    codes = -np.isnan(marks[:, asked]).any(axis=1).astype("int64")
    rows, shown = np.nonzero(marks == 1)
    codes[rows] = shown + 1
    return codes


def unmeasured_actions(frames: pd.DataFrame, track: str) -> list[str]:
    """The track's actions that are unknown wherever they are not true."""
    marks = frames[list(track_actions(track))]
    return [name for name in marks if marks[name].isna().any() and marks[name].all()]


def _without_short(frames: pd.DataFrame, min_frames: int) -> pd.DataFrame:
    """Intervals shorter than min_frames become neutral.

    One beside a frame of which the action is not known becomes unknown: it may be longer.
    """
    frames = frames.copy()
    begins = np.zeros(len(frames), dtype=bool)
    begins[run_starts(frames)] = True
    for track in TRACKS:
        runs = _runs(frames, track)
        short = runs[(runs["stop"] - runs["row"] < min_frames) & (runs["action"] != NEUTRAL)]
        for action, same in short.groupby("action"):
            column = frames.columns.get_loc(action)
            unknown = frames[action].isna().to_numpy()
            first, after = same["row"].to_numpy(), same["stop"].to_numpy() % len(frames)
            beside = (unknown[first - 1] & ~begins[first]) | (unknown[after] & ~begins[after])
            frames.iloc[_rows(same[~beside])[0], column] = False
            frames.iloc[_rows(same[beside])[0], column] = pd.NA
    return frames
