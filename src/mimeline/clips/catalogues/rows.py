"""The rows of a CSV or a Parquet file as they stand: no cell is guessed at."""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from mimeline.errors import BadFile, unreadable
from mimeline.media.signature import kind_of

SEPARATORS = (",", ";", "\t")
LARGEST = 1 << 28  # bytes
MOST_ROWS = 5_000_000
EXPECTED = "a table of clips, CSV in UTF-8 or Parquet"


@dataclass(frozen=True)
class Row:
    """A row: its cells by column, its place in the file, and what is wrong with it as a whole."""

    cells: dict[str, Any]
    place: str
    fault: str = ""


def header_and_rows(path: Path) -> tuple[list[str], list[Row]]:
    """The column names of a table, stripped, and its rows; an empty CSV row is none.

    CSV is in UTF-8, with commas, semicolons or tabs between the cells: whichever divides the header
    into most. Every cell of it is text, without the blanks around it.
    Raises BadFile where the file is no such table.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise _too_large(path, "a larger file", f"{LARGEST >> 20} MiB")
        with path.open("rb") as file:
            is_parquet = file.read(4) == b"PAR1" or path.suffix.lower() == ".parquet"
        return _parquet(path) if is_parquet else _csv(path)
    except (OSError, ValueError, csv.Error, pa.ArrowException) as error:
        remedy = "Check data_dir and catalogue.table.file, or save the table again."
        raise unreadable(path, error, expected=EXPECTED, remedy=remedy) from error


def _parquet(path: Path) -> tuple[list[str], list[Row]]:
    with pq.ParquetFile(path) as file:
        if file.metadata.num_rows > MOST_ROWS:
            raise _too_large(path, f"{file.metadata.num_rows} rows", f"{MOST_ROWS}")
        names = [name.strip() for name in file.schema_arrow.names]
        rows = [
            dict(zip(names, values, strict=True))
            for batch in file.iter_batches()
            for values in zip(*(column.to_pylist() for column in batch.columns), strict=True)
        ]
    return names, [Row(cells, f"row {number}") for number, cells in enumerate(rows, start=1)]


def _csv(path: Path) -> tuple[list[str], list[Row]]:
    text = _text(path)
    separator = max(SEPARATORS, key=io.StringIO(text).readline().count)
    lines = csv.reader(
        io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True, strict=True
    )
    header = [name.strip() for name in next(lines, [])]
    if not any(header):
        raise BadFile(
            path, found="no header", expected=EXPECTED, remedy="Name the columns in its first line."
        )
    rows = []
    start = lines.line_num + 1
    for cells in _readable(lines, path):
        if any(cell.strip() for cell in cells):
            fault = "" if len(cells) == len(header) else f"{len(cells)} cells"
            stripped = dict(zip(header, (cell.strip() for cell in cells), strict=False))
            rows.append(Row(stripped, f"line {start}", fault))
        start = lines.line_num + 1
    return header, rows


def _readable(lines: Any, path: Path) -> Iterator[list[str]]:
    """What a csv.reader reads. Raises BadFile, with the line, where it cannot go on."""
    start = lines.line_num + 1
    try:
        for cells in lines:
            yield cells
            start = lines.line_num + 1
    except csv.Error as error:
        raise BadFile(
            path,
            place=f"the row that begins in line {start}",
            found=str(error),
            expected="cells whose quotation marks are closed",
            remedy="Close them; a quotation mark within a cell in quotation marks stands twice.",
        ) from error


def _text(path: Path) -> str:
    raw = path.read_bytes()
    found = kind_of(raw[:64])
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        found = "UTF-16"
    if found is None:
        try:
            return raw.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = raw.count(b"\n", 0, error.start) + 1
            found = f"a byte in line {line} that is no UTF-8"
    raise BadFile(path, found=found, expected=EXPECTED, remedy="Save it as CSV UTF-8.")


def _too_large(path: Path, found: str, most: str) -> BadFile:
    remedy = "Leave out what tells nothing of the clips."
    return BadFile(path, found=found, expected=f"at most {most}", remedy=remedy)
