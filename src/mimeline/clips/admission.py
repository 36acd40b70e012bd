"""Which records may become clips: names, times, boxes and paths that lead to no harm."""

import math
import re
from collections.abc import Iterable
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

from mimeline.clips.failure import spelt_out

SAFE_ID = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,199}")  # a plain file name
DEVICE = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)  # of Windows
LONGEST_ID = 200
LONGEST_SOURCE_S = 604_800.0  # a week; what is said to last longer is no time
LARGEST_SHARE = 2.0  # of a box in shares of the picture; one in pixels has an edge above it
LARGEST_PX = 1e6  # of a box's edge
SIDES = ("bbox_top", "bbox_bottom", "bbox_left", "bbox_right")

Fault = dict[str, Any]  # rule and facts, as Ledger.fail takes them


def fault_of(row: dict) -> Fault | None:
    """Why a row of `clips` may not become a clip; None where it may."""
    return (
        path_fault(row.get("video"))
        or _bad_id(row["clip_id"])
        or _bad_id(row["source_id"])
        or _bad_times(row["start_s"], row["end_s"])
        or _bad_box(row)
    )


def path_fault(video: str | None) -> Fault | None:
    """Why a path is none below data_dir, wherever the links in it lead; None where it is one."""
    if not isinstance(video, str):
        return None
    path = PurePosixPath(video)
    if not video.isprintable():
        what = "cannot be printed: rename it"
    elif ".." in path.parts or path.is_absolute() or not path.name or PureWindowsPath(video).drive:
        what = "leads out of data_dir: give a path below it, with /"
    elif "\\" in video:
        what = "holds a backslash: give a path below data_dir, with /"
    else:
        return None
    return {"rule": "unsafe_path", "detail": f"'{shown(video)}' {what}"}


def size_of_box(top: float, bottom: float, left: float, right: float) -> dict[str, int]:
    """width and height of a box in pixels, right of and below the picture's corner.

    Empty for a box in shares of the picture, and for one without an inside.
    """
    edges = (top, bottom, left, right)
    if not all(map(math.isfinite, edges)) or max(edges) <= LARGEST_SHARE:
        return {}
    width, height = round(right - max(left, 0)), round(bottom - max(top, 0))
    return {"width": width, "height": height} if min(width, height) > 0 else {}


def shown(clip_id: str) -> str:
    """The id as the ledger and a terminal may show it."""
    text = spelt_out(clip_id)
    return text if len(text) <= LONGEST_ID else f"{text[:LONGEST_ID]}…"


def judged(entries: Iterable[tuple[str, dict]]) -> list[tuple[str, dict]]:
    """Records under the names that tell them apart, with their rows or faults.

    entries: the id that a record gives itself, and its row or what is wrong with it. Of an id that
    repeats the first record without a fault counts, as of ids that differ in capitals alone.
    """
    entries = sorted(entries, key=lambda entry: "rule" in entry[1])
    names = _told_apart([shown(clip_id) for clip_id, _ in entries])
    found, first, capitals = [], {}, {}
    for (clip_id, entry), name in zip(entries, names, strict=True):
        if "rule" in entry:
            pass
        elif name != clip_id:
            entry = {"rule": "repeated_id", "detail": _repeated(clip_id, first[clip_id], entry)}
        elif (other := capitals.setdefault(clip_id.casefold(), clip_id)) != clip_id:
            detail = f"differs from {other} in capitals alone: files may not. Rename one"
            entry = {"rule": "case_collision", "detail": detail}
        first.setdefault(clip_id, entry)
        found.append((name, entry))
    return found


def _repeated(clip_id: str, first: dict, entry: dict) -> str:
    """How two records come to share an id: by their videos, where they tell of two."""
    videos = [shown(row["video"]) for row in (first, entry) if row.get("video")]
    if len(set(videos)) < 2:
        return f"{clip_id} stands in the catalogue before: the first one counts. Rename one"
    return f"{' and '.join(videos)} are both {clip_id}: the first one counts. Rename one"


def _told_apart(ids: list[str]) -> list[str]:
    """The ids, of which the second of a name ends in #2, the third in #3 and so on."""
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
    return {"rule": "unsafe_id", "detail": f"'{shown(name)}' {what}"}


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
    if all(edge is None for edge in edges):
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
