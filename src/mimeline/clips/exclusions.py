"""The list of clips that people left out by hand, and why."""

import csv
from collections.abc import Mapping
from pathlib import Path

from mimeline.atomic import whole
from mimeline.errors import BadFile, MissingColumn, unreadable

COLUMNS = ("clip_id", "reason")
# What a person looks for in the clips (Höll 2024, 5.1); any other text is a reason too.
OCCLUSION, WRONG_CROP, LOW_QUALITY = REASONS = ("occlusion", "wrong_crop", "low_quality")
FILM = ".mp4"  # of the keys in published files, which clip ids lack
EXPECTED = "a CSV of clip_id and reason"


def read_exclusions(path: str | Path) -> dict[str, str]:
    """clip_id → reason, from a CSV with these two columns; others are passed over.

    Commas, semicolons or tabs part the cells, as the first line shows; a byte order mark is
    welcome. Of an id that occurs more than once, the reasons that differ are joined.
    Raises BadFile, with the line, for what is no such table; MissingColumn.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            header = file.readline()
            file.seek(0)
            cells = csv.reader(file, delimiter=_delimiter(header), strict=True)
            rows = [(cells.line_num, row) for row in cells if any(map(str.strip, row))]
    except UnicodeDecodeError as error:
        raise BadFile(
            path, found="text that is no UTF-8", expected=EXPECTED, remedy="Save it as CSV UTF-8."
        ) from error
    except csv.Error as error:
        raise BadFile(
            path,
            place=f"line {cells.line_num}",
            found=str(error),
            expected=EXPECTED,
            remedy="Close the quotation marks of a cell; write one within it twice.",
        ) from error
    except (OSError, ValueError) as error:
        raise unreadable(
            path, error, expected=EXPECTED, remedy="Write it, or set select.exclusions to null."
        ) from error
    names = [name.strip() for name in rows[0][1]] if rows else []
    if missing := [name for name in COLUMNS if name not in names]:
        raise MissingColumn(
            path,
            found=f"columns {', '.join(names)}" if names else "an empty file",
            expected=", ".join(missing),
            remedy="Head the two columns clip_id,reason.",
        )
    clip_id, reason = map(names.index, COLUMNS)
    reasons: dict[str, list[str]] = {}
    for line, row in rows[1:]:
        if len(row) > len(names) or not (row[clip_id : clip_id + 1] or [""])[0].strip():
            raise _bad_line(path, line, row, len(names))
        cell = row[reason] if reason < len(row) else ""
        known = reasons.setdefault(row[clip_id].strip(), [])
        if (text := " ".join(cell.split())) and text not in known:
            known.append(text)
    return {name: "; ".join(texts) for name, texts in reasons.items()}


def write_exclusions(path: str | Path, exclusions: Mapping[str, str]) -> None:
    """Write clip_id → reason as that CSV, by id; the file is always whole."""
    with whole(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerows([COLUMNS, *sorted(exclusions.items())])


def _delimiter(header: str) -> str:
    return max(",;\t", key=header.count)


def _bad_line(path: str | Path, line: int, row: list[str], columns: int) -> BadFile:
    if len(row) > columns:
        return BadFile(
            path,
            place=f"line {line}",
            found=f"{len(row)} cells",
            expected=f"{columns}, as in the first line",
            remedy='Put a reason that holds commas in quotes: "glasses, and a mask".',
        )
    return BadFile(
        path,
        place=f"line {line}",
        found="a reason without a clip_id",
        expected=EXPECTED,
        remedy="Write the id before it, or delete the line.",
    )
