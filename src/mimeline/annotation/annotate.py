"""Timelines of 16 actions: the clusters' names on three tracks, thresholds on the other five."""

import logging
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
    limits = Limits(closed, gaze_deg, head_deg, min_frames)
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
    """The 16 actions at each frame, pd.NA where a track's channels were not measured.

    Frames that are not valid are pd.NA throughout.

    motion: the `motion` table, sorted by clip and frame. clusters: by region, the `clusters` table;
    labels: their names.
    """
    keys = motion[["clip_id", "frame"]].reset_index(drop=True)
    actions = threshold_actions(motion.reset_index(drop=True), limits)
    actions[~motion["valid"].to_numpy(bool)] = pd.NA
    for region in SERIES_TRACK:
        names = labels.loc[labels["region"] == region].set_index("cluster")["action"]
        assigned = clusters.get(region, tables.empty(tables.CLUSTERS))
        at = keys.merge(assigned[["clip_id", "frame", "cluster"]], how="left", validate="1:1")
        action = at["cluster"].map(names)  # (n_frames,), NaN where not measured or without a name
        unknown = at["cluster"].isna() | names.empty  # a cluster that fitting left empty is neutral
        for name in series_actions(region):
            actions[name] = (action == name).astype("boolean").mask(unknown)
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


def track_codes(frames: pd.DataFrame, track: str) -> np.ndarray:
    """(n_frames,) int: 0 neutral, i the track's i-th action, -1 not measured."""
    codes = np.zeros(len(frames), dtype="int64")
    for number, action in enumerate(track_actions(track), start=1):
        marks = frames[action].to_numpy(dtype="float64", na_value=np.nan)
        codes[marks == 1] = number
        codes[np.isnan(marks)] = -1
    return codes


def _without_short(frames: pd.DataFrame, min_frames: int) -> pd.DataFrame:
    """Intervals shorter than min_frames become neutral."""
    frames = frames.copy()
    for track in TRACKS:
        runs = _runs(frames, track)
        short = runs[(runs["stop"] - runs["row"] < min_frames) & (runs["action"] != NEUTRAL)]
        for action, same in short.groupby("action"):
            frames.iloc[_rows(same)[0], frames.columns.get_loc(action)] = False
    return frames
