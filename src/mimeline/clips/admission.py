"""Which records may become clips: names, times, boxes and paths that lead to no harm."""

import math
import re
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from mimeline.clips.catalogues.folder import lies_in
from mimeline.clips.failure import printable

SAFE_ID = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,199}")  # a plain file name
DEVICE = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)  # of Windows
LONGEST_ID = 200
LONGEST_SOURCE_S = 604_800.0  # a week; what is said to last longer is no time
LARGEST_SHARE = 2.0  # of a box in shares of the picture; one in pixels has an edge above it
LARGEST_PX = 1e6  # of a box's edge
SIDES = ("bbox_top", "bbox_bottom", "bbox_left", "bbox_right")

Fault = dict[str, Any]  # rule and facts, as Ledger.fail takes them


def fault_finder(data: Path) -> Callable[[dict], Fault | None]:
    """What tells of a row of `clips` why it may not become a clip; None where it may.

    data: the folder that a row's video must lie in.
    """
    inside = _inside(data)

    def fault(row: dict) -> Fault | None:
        return (
            _bad_id(row["clip_id"])
            or _bad_id(row["source_id"])
            or _bad_times(row["start_s"], row["end_s"])
            or _bad_box(row)
            or _bad_path(row.get("video"), inside)
        )

    return fault


def shown(clip_id: str) -> str:
    """The id as the ledger and a terminal may show it."""
    text = printable(clip_id)
    return text if len(text) <= LONGEST_ID else f"{text[:LONGEST_ID]}…"


def told_apart(ids: Iterable[str]) -> list[str]:
    """The ids, of which the second of a name ends in #2, the third in #3 and so on."""
    ids = list(ids)
    taken, first, last = set(ids), set(), dict.fromkeys(ids, 1)
    names = []
    for clip_id in ids:
        name = clip_id
        while clip_id in first and name in taken:
            last[clip_id] += 1
            name = f"{clip_id}#{last[clip_id]}"
        first.add(clip_id)
        taken.add(name)
        names.append(name)
    return names


def _bad_id(name: str) -> Fault | None:
    if not SAFE_ID.fullmatch(name):
        what = "is no plain file name: rename it (a-z 0-9 . _ -)"
    elif name.endswith("."):
        what = "ends with a dot, which Windows drops: rename it"
    elif DEVICE.fullmatch(name):
        what = "is the name of a device on Windows: rename it"
    else:
        return None
    return {"rule": "unsafe_id", "detail": f"{shown(name)!r} {what}"}


def _bad_times(start: float, end: float) -> Fault | None:
    if 0 <= start < end <= LONGEST_SOURCE_S:
        return None
    expected = f"0 <= start < end <= {LONGEST_SOURCE_S:.0f}"
    return {
        "rule": "bad_times",
        "detail": f"from {start:g} to {end:g} s, expected {expected}: mend the record's times",
    }


def _bad_box(row: dict) -> Fault | None:
    edges = [row.get(side) for side in SIDES]
    if all(edge is None or math.isnan(edge) for edge in edges):
        return None
    told = ", ".join(f"{s[5:]} {e}" for s, e in zip(SIDES, edges, strict=True))

    def wrong(what: str) -> Fault:
        return {"rule": "box_outside", "detail": f"{told}: {what}"}

    if not all(edge is not None and abs(edge) <= LARGEST_PX for edge in edges):
        return wrong("four numbers make a box; leave all out where the face's place is unknown")
    top, bottom, left, right = edges
    if not (top < bottom and left < right):
        return wrong("expected top < bottom and left < right")
    limit = 1 if max(edges) <= LARGEST_SHARE else math.inf
    if bottom <= 0 or right <= 0 or top >= limit or left >= limit:
        return wrong("no part of it lies in the picture")
    if limit > 1 and min(bottom - max(top, 0), right - max(left, 0)) < 1:
        return wrong("less than a pixel of it lies in the picture")
    return None


def _bad_path(video: str | None, inside: Callable[[str], bool]) -> Fault | None:
    if not isinstance(video, str) or inside(video):
        return None
    detail = f"{shown(video)!r} leads out of data_dir: give a path below it, with /"
    return {"rule": "unsafe_path", "detail": detail}


def _inside(data: Path) -> Callable[[str], bool]:
    """Whether a relative path stays in a folder, wherever its links lead."""
    folder_inside = cache(lambda folder: lies_in(data / folder, data))

    def inside(video: str) -> bool:
        path = PurePosixPath(video)
        if not video.isprintable() or ".." in path.parts or path.is_absolute() or not path.name:
            return False
        if "\\" in video or PureWindowsPath(video).drive:
            return False
        if (data / path).is_symlink():
            return lies_in(data / path, data)
        return folder_inside(path.parent)

    return inside
