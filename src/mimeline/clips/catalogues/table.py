"""A table with a row per clip as a catalogue: CSV or Parquet, its columns those of `clips`."""

import difflib
import logging
import math
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

from mimeline.clips.admission import path_fault, size_of_box
from mimeline.clips.catalogues.cells import (
    interval_list,
    name_list,
    plain_text,
    text_list,
    verbatim,
)
from mimeline.clips.catalogues.films import film_facts
from mimeline.clips.catalogues.folder import Bad
from mimeline.clips.catalogues.json_records import name as name_of
from mimeline.clips.catalogues.rows import Row, header_and_rows
from mimeline.clips.intervals import outside_clip, over
from mimeline.errors import BadFile, MimelineError, MissingColumn
from mimeline.media.limits import Limits
from mimeline.progress import told

log = logging.getLogger(__name__)

IDS = ("clip_id", "source_id", "video")
NUMBERS = ("start_s", "end_s", "bbox_top", "bbox_bottom", "bbox_left", "bbox_right")
SIDES = NUMBERS[2:]
SIZES = ("width", "height")
LISTS = ("actions", "emotions", "attributes", "texts")
KNOWN = (*IDS, "subject_id", *NUMBERS, *SIZES, "emotion", *LISTS)
CUTS = ("video", "start_s", "end_s")  # without them a clip would be another one
MEANT = {"id": "clip_id", "clip": "clip_id", "start": "start_s", "end": "end_s"}
LARGEST_SIZE = 1 << 20  # pixels
LARGEST = 1e9  # of any other number


def read(data: Path, file: str, limits: Limits) -> tuple[list[dict], Bad]:
    """Each row of the table <data>/<file> as a clip, and the rows that are none.

    file: .csv in UTF-8 with commas, semicolons or tabs between the cells, or .parquet. Columns bear
    the names of the `clips` table; needed are clip_id and one of video (a path relative to data)
    and source_id. Ids stay the text that they are. A cell without content says nothing. Without
    start_s a clip starts with its video, without end_s it ends with it. limits: of a video.
    Returns rows with what the table tells, and with the video's size where there is neither box nor
    size; notes tell of intervals outside of their clip. Raises BadFile for a file that is no such
    table, MissingColumn without a needed column or with a misspelt one that tells what is cut.
    """
    path = Path(data) / file
    header, table = header_and_rows(path)
    _check_header(header, path)

    @cache
    def film(video: str) -> dict | MimelineError:
        try:
            return film_facts(Path(data) / video, Path(data), limits)
        except MimelineError as error:
            return error

    rows, bad = [], []
    for row in told(table, "rows", log):
        try:
            rows.append(_clip(row, path, film))
        except MimelineError as error:
            bad.append((_id_of(row), error))
    return rows, bad


def _check_header(header: list[str], path: Path) -> None:
    """Say which columns are not used. Raises MissingColumn, BadFile for one that stands twice."""
    twice = [name for name in dict.fromkeys(header) if name and header.count(name) > 1]
    if twice:
        raise BadFile(
            path,
            found=f"column {twice[0]} {header.count(twice[0])} times",
            expected="a column once",
            remedy="Rename or delete the others.",
        )
    others = [name for name in header if name not in KNOWN]
    near = {name: _nearest(name) for name in others}
    if "clip_id" not in header or not {"video", "source_id"} & set(header):
        missing = "video and no column source_id" if "clip_id" in header else "clip_id"
        hints = [name for name, known in near.items() if known and known in missing.split()]
        raise MissingColumn(
            path,
            found=f"no column {missing}" + (f", but {', '.join(hints)}" if hints else ""),
            expected="clip_id, and video or source_id",
            remedy="Name the columns as docs/catalogues.md does.",
        )
    for name, known in near.items():
        if known in CUTS and known not in header:
            raise MissingColumn(
                path,
                found=f"a column {name}",
                expected=f"{known}, or neither",
                remedy=f"Is it {known}? Rename it, or delete it.",
            )
        if known and known not in header:
            log.warning("%s: column %s is not used: is it %s?", path.name, name, known)
    unused = [name for name, known in near.items() if name and (not known or known in header)]
    if unused:
        log.info("%s: columns not used: %s", path.name, ", ".join(unused))


def _nearest(name: str) -> str | None:
    """The known column that a name is probably meant to be."""
    folded = "_".join(name.casefold().replace("-", " ").split())
    found = difflib.get_close_matches(folded, KNOWN, n=1, cutoff=0.8)
    return MEANT.get(folded) or (found[0] if found else None)


def _clip(row: Row, path: Path, film: Callable[[str], dict | MimelineError]) -> dict:
    """The row as the `clips` table has it. film: what is known of a video. Raises BadFile."""

    def cell(column: str, kind: str, parse: Callable[[Any], Any]) -> Any:
        """The cell's meaning, None where it has no content."""
        value = row.cells.get(column)
        if value is None or value == "" or value != value:
            return None
        try:
            return parse(value)
        except (TypeError, ValueError, LookupError) as error:
            raise BadFile(
                path,
                place=f"{row.place}, column {column}",
                found=str(error),
                expected=kind,
                remedy="Mend the cell.",
            ) from error

    if row.fault:
        raise BadFile(
            path,
            place=row.place,
            found=row.fault,
            expected="as many cells as the header has",
            remedy="Mend the row: a text with a separator in it stands in quotation marks.",
        )
    clip: dict[str, Any] = {name: cell(name, "text", verbatim) for name in IDS}
    clip["subject_id"] = cell("subject_id", "a name", lambda value: plain_text(verbatim(value)))
    clip["emotion"] = cell("emotion", "a name", name_of)
    clip |= {name: cell(name, "a number, as 1.5", _number) for name in NUMBERS}
    clip |= {name: cell(name, "a number of pixels", _size) for name in SIZES}
    if clip["clip_id"] is None or (clip["source_id"] is None and clip["video"] is None):
        missing = "clip_id" if clip["clip_id"] is None else "source_id, and no video"
        raise _empty(path, row, f"no {missing}", "a clip_id, and a source_id or a video")
    if clip["source_id"] is None:
        video = PurePosixPath(clip["video"])
        clip["source_id"] = "_".join((*video.parent.parts, video.stem))
    if path_fault(clip["video"]):  # nobody looks there; `catalogue` says what is wrong
        return clip | {"start_s": math.nan, "end_s": math.nan}
    given = [side for side in SIDES if clip[side] is not None]
    if given and len(given) < len(SIDES):
        raise _empty(path, row, f"{', '.join(given)} alone", "all four edges of a box, or none")

    clip |= _times_and_size(clip, row, path, film)
    length_s = clip["end_s"] - clip["start_s"]
    if length_s <= 0:
        return clip  # `catalogue` says what is wrong with its times
    intervals, outside = interval_list(length_s), []
    for name in ("actions", "emotions"):
        told_of = cell(name, "names as smile or smile@1.5-3, with ; between", intervals)
        clip[name], beyond = told_of or ([], [])
        outside += beyond
    clip["notes"] = outside_clip(outside)
    clip["attributes"] = cell("attributes", "names with ; between", name_list) or []
    clip["texts"] = cell("texts", "texts with | between", text_list) or []
    if clip["emotion"] is not None and not clip["emotions"]:
        clip["emotions"] = [over(clip["emotion"], length_s)]
    return clip


def _times_and_size(clip: Mapping, row: Row, path: Path, film: Callable) -> dict[str, Any]:
    """start_s, end_s, width and height: the table's own, else those of the box or of the video."""
    told = {name: clip[name] for name in ("start_s", "end_s", *SIZES)}
    if told["start_s"] is None:
        told["start_s"] = 0.0
    if told["end_s"] is None:
        if clip["video"] is None:
            raise _empty(path, row, "no end_s, and no video", "one of them")
        if isinstance(found := film(clip["video"]), MimelineError):
            raise found
        told["end_s"] = found["end_s"]
        if clip["bbox_top"] is None and told["width"] is None and told["height"] is None:
            told |= {size: found[size] for size in SIZES}
    edges = [clip[side] for side in SIDES]
    size = {} if None in edges else size_of_box(*edges)
    return told | {name: px for name, px in size.items() if told[name] is None}


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise TypeError(repr(value))
    try:
        number = math.nan if "_" in str(value) else float(value)
    except ValueError:
        number = math.nan
    if not abs(number) <= LARGEST:
        raise ValueError(repr(value)[:100])
    return number


def _size(value: Any) -> int:
    number = _number(value)
    if number != int(number) or not 1 <= number <= LARGEST_SIZE:
        raise ValueError(repr(value)[:100])
    return int(number)


def _empty(path: Path, row: Row, found: str, expected: str) -> BadFile:
    return BadFile(
        path, place=row.place, found=found, expected=expected, remedy="Fill in the cells."
    )


def _id_of(row: Row) -> str:
    """What a row that is no clip is called: its id where it has one, else its place."""
    name = row.cells.get("clip_id")
    return name if isinstance(name, str) and name else row.place
