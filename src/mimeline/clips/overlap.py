"""Duplicates within a source: clips that share most of their time and of their picture."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

EDGES = ["bbox_top", "bbox_bottom", "bbox_left", "bbox_right"]
ROUNDING = 1e-9  # of a share: clips that follow each other share nothing


def duplicates(clips: pd.DataFrame, max_overlap: float) -> pd.DataFrame:
    """The clips that hold again what an earlier clip of their source holds.

    clips: rows of the `clips` table. max_overlap: share in [0, 1]. Two clips overlap by the lesser
    of two shares: that of the shorter clip's time and that of the smaller box's area which the
    other one covers. A clip without a box shows the whole picture. Clips of two people, of two
    sources or of two videos are no duplicates.
    The clips of a source are looked at by their start, then their id; one that overlaps a clip
    which stays by more than max_overlap goes.

    Returns clip_id, stays (the clip it overlaps most) and share, in the order of clips.
    """
    sides = _Sides.of(clips)
    found = [lost for rows in _crossing(clips) for lost in _sweep(sides, rows, max_overlap)]
    found = pd.DataFrame(sorted(found), columns=["row", "stays", "share"])
    ids = clips["clip_id"].to_numpy(object)
    return pd.DataFrame(
        {
            "clip_id": ids[found["row"].to_numpy(int)],
            "stays": ids[found["stays"].to_numpy(int)],
            "share": found["share"].to_numpy(float),
        }
    )


@dataclass(frozen=True)
class _Sides:
    """What clips are compared by. box: (n, 4), NaN: the whole picture. person: -1: not known."""

    start: np.ndarray
    end: np.ndarray
    box: np.ndarray
    person: np.ndarray

    @classmethod
    def of(cls, clips: pd.DataFrame) -> "_Sides":
        box = clips[EDGES].to_numpy(float, na_value=np.nan)  # (n, 4)
        start, end = (clips[name].to_numpy(float) for name in ("start_s", "end_s"))
        return cls(start, end, box, pd.factorize(clips["subject_id"])[0])


def _crossing(clips: pd.DataFrame) -> list[np.ndarray]:
    """Rows of the clips of a source that reach into each other, by start and id."""
    times = clips[["source_id", "video", "start_s", "end_s", "clip_id"]].reset_index(drop=True)
    times["source"] = times.groupby(["source_id", "video"], dropna=False).ngroup()
    times = times.sort_values(["source", "start_s", "clip_id"], kind="stable")
    reach = times.groupby("source")["end_s"].cummax().groupby(times["source"]).shift()
    apart = ~(times["start_s"] < reach).to_numpy()  # (n,) nothing before reaches into this clip
    runs = np.split(times.index.to_numpy(), np.flatnonzero(apart))
    return [rows for rows in runs if len(rows) > 1]


def _sweep(sides: _Sides, rows: np.ndarray, max_overlap: float) -> Iterator[tuple[int, int, float]]:
    """The rows of clips that go, of those that stay in their place, and the share of overlap.

    rows: (m,), by start.
    """
    start, end, person = sides.start, sides.end, sides.person
    kept = np.empty_like(rows)
    since = count = 0  # kept[since:count] may still reach into what comes
    for row in rows:
        while since < count and end[kept[since]] <= start[row]:
            since += 1
        others = kept[since:count]
        known = (person[others] >= 0) & (person[row] >= 0)
        others = others[~known | (person[others] == person[row])]
        shares = np.minimum(
            _time(start[row], end[row], start[others], end[others]),
            _area(sides.box[row], sides.box[others]),
        )
        most = int(shares.argmax()) if len(shares) else -1
        if most >= 0 and shares[most] > max_overlap + ROUNDING:
            yield int(row), int(others[most]), float(shares[most])
        else:
            kept[count] = row
            count += 1


def _time(start: float, end: float, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Share of the shorter clip that the other covers, for each of the others (m,)."""
    shared = np.minimum(ends, end) - np.maximum(starts, start)
    return np.maximum(shared, 0) / np.minimum(ends - starts, end - start)


def _area(box: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Share of the smaller box that the other covers. box: (4,), boxes: (m, 4); NaN: all."""
    high = np.minimum(boxes[:, 1], box[1]) - np.maximum(boxes[:, 0], box[0])
    wide = np.minimum(boxes[:, 3], box[3]) - np.maximum(boxes[:, 2], box[2])
    areas = (boxes[:, 1] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 2])
    smaller = np.minimum(areas, (box[1] - box[0]) * (box[3] - box[2]))
    share = np.maximum(high, 0) * np.maximum(wide, 0) / smaller
    return np.where(np.isnan(share), 1.0, share)
