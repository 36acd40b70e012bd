"""CSV with the columns of the `intervals` table: a row per interval, in frames, clips together."""

import csv
import io
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.timeline.draft import Draft, DraftInterval, Problem, nearest, shown
from mimeline.timeline.formats.text_file import read_text
from mimeline.timeline.timeline import SIDES, SOURCES, Timeline

COLUMNS = (
    "clip_id",
    "track",
    "action",
    "start_frame",
    "end_frame",
    "side",
    "source",
    "cluster",
    "confidence",
)
NEEDED = COLUMNS[:5]
MOST_BYTES = 512 * 2**20  # the intervals of a whole data set

_WHOLE = re.compile(
    r"-?[0-9]{1,12}(?:\.0{1,9})?"
)  # spreadsheets and pandas write 3.0 where cells lack
_NOT_CSV = re.compile("[\0\r]")
_SHARE = re.compile(r"[0-9]{0,3}(?:\.[0-9]{0,40})?(?:[eE][+-]?[0-9]{1,3})?")


def read(path: Path) -> list[Draft]:
    """A draft per clip, in the order of their first rows."""
    text = read_text(path, "a CSV of intervals", MOST_BYTES)
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    by_clip: dict[str | None, tuple[list[DraftInterval], list[Problem]]] = {}
    try:
        header = [name.strip() for name in next(rows, [])]
        _check_header(path, header)
        for row in rows:
            if not any(cell.strip() for cell in row):
                continue  # spreadsheets write rows that were emptied
            place = f"line {rows.line_num}"
            cells = dict(zip(header, row, strict=False))
            intervals, problems = by_clip.setdefault(cells.get("clip_id") or None, ([], []))
            found = _problems(place, header, row, cells)
            problems += found
            if not found:
                intervals.append(_interval(place, cells))
    except csv.Error as error:
        raise BadFile(
            path,
            place=f"line {rows.line_num}",
            found=str(error),
            expected="a row of comma-separated cells",
            remedy="Mend the row's quotes.",
        ) from error
    return [
        Draft(clip, tuple(intervals), in_seconds=False, problems=tuple(problems))
        for clip, (intervals, problems) in by_clip.items()
    ]


def _check_header(path: Path, header: list[str]) -> None:
    missing = [name for name in NEEDED if name not in header]
    unknown = [name for name in header if name not in COLUMNS]
    doubled = [name for name, count in Counter(header).items() if count > 1]
    if not (missing or unknown or doubled):
        return
    if len(header) == 1 and ";" in header[0]:
        remedy = "Save it with commas, not semicolons, between the cells."
    elif unknown and (close := nearest(unknown[0], COLUMNS)):
        remedy = f"Did you mean {close} by column {shown(unknown[0])}?"
    else:
        remedy = f"The columns are {', '.join(COLUMNS)}; the last four may be left out."
    raise BadFile(
        path,
        place="line 1",
        found=f"no column {', '.join(missing)}"
        if missing
        else f"column {shown(', '.join(unknown or doubled))}",
        expected="each column of the intervals table once",
        remedy=remedy,
    )


def _problems(
    place: str, header: list[str], row: list[str], cells: dict[str, str]
) -> list[Problem]:
    if len(row) != len(header):
        return [Problem(place, f"{len(row)} cells", f"{len(header)}", "Mend the row.")]
    wrong = []
    if not cells["clip_id"]:
        wrong.append(Problem(place, "no clip_id", "the name of a clip", "Fill the cell."))
    for name in ("start_frame", "end_frame", "cluster"):
        value = cells.get(name, "").strip()
        if not _WHOLE.fullmatch(value) and (value or name in NEEDED):
            wrong.append(_cell(place, name, value, "a whole number"))
    if cells.get("cluster", "").strip().startswith("-"):
        wrong.append(_cell(place, "cluster", cells["cluster"], "0 or more"))
    confidence = cells.get("confidence", "").strip()
    if confidence and not (_SHARE.fullmatch(confidence) and _share(confidence) is not None):
        wrong.append(_cell(place, "confidence", confidence, "a share of 0 to 1"))
    for name, known in (("side", SIDES), ("source", SOURCES)):
        value = cells.get(name, "").strip()
        if value and value not in known:
            wrong.append(_cell(place, name, value, f"one of {', '.join(known)}, or nothing"))
    return wrong


def _cell(place: str, column: str, value: str, expected: str) -> Problem:
    found = shown(value) if value else "an empty cell"
    return Problem(f"{place}, column {column}", found, expected, "Mend the cell.")


def _whole(text: str) -> int:
    return int(text.partition(".")[0])


def _share(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0 <= value <= 1 else None


def _interval(place: str, cells: dict[str, str]) -> DraftInterval:
    cells = {name: value.strip() for name, value in cells.items()}
    start, end = (_whole(cells[name]) for name in ("start_frame", "end_frame"))
    cluster, confidence = cells.get("cluster"), cells.get("confidence")
    return DraftInterval(
        place,
        cells["track"],
        cells["action"],
        start,
        end,
        side=cells.get("side") or None,
        source=cells.get("source") or "human",
        cluster=_whole(cluster) if cluster else None,
        confidence=float(confidence) if confidence else None,
    )


def write(timelines: Sequence[Timeline]) -> str:
    """A row per interval, track by track. Raises ValueError for a name that no text can hold."""
    for timeline in timelines:
        if wrong := _NOT_CSV.search(timeline.clip_id):
            raise ValueError(f"a clip's name with {wrong.group()!r}, which CSV cannot hold")
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for timeline in timelines:
        for interval in timeline:
            rows.writerow(
                (
                    timeline.clip_id,
                    interval.track,
                    interval.action,
                    interval.start,
                    interval.end,
                    interval.side,
                    interval.source,
                    interval.cluster,
                    None if interval.confidence is None else float(interval.confidence),
                )
            )
    return text.getvalue()
