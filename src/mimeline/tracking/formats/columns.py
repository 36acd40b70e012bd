"""A tracker's CSV: columns known by name, numbers checked, angles in radians."""

import csv
import difflib
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from pandas.errors import DtypeWarning, ParserError, ParserWarning

from mimeline.errors import BadFile, MissingColumn, NoSuchFile
from mimeline.tracking.formats.cut_rows import mark, refuse_cut_off
from mimeline.tracking.take import MOST_FRAMES, Origin
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, canonical

LARGEST = 2**30  # bytes of a file: MOST_FRAMES rows of Live Link Face, of OpenFace an hour
LARGEST_BY_ROW = 2**26  # of one that is taken row by row, in many times its size of memory
MOST_ROWS = 4 * MOST_FRAMES  # with a row for each face of a frame
EXPRESSION_RANGE = (-1.0, 2.0)  # coefficients of [0, 1] overshoot a little


def read_columns(
    path: Path,
    text: tuple[str, ...] = (),
    needed: tuple[str, ...] = (),
    known: tuple[str, ...] = (),
) -> pd.DataFrame:
    """A tracker's CSV by its stripped column names, one row per row of the file.

    A column of numbers is read as numbers; where a single cell is none, all are text as they stand.
    text: columns that must be there and stay text. needed: others that must be there. known: others
    that may be. The file may write these names in any case; the table has them as they are here.
    Columns without a name are left out, as are the blank cells that a comma at a row's end makes.
    Where a row ends before the others do, `numbers` finds its last cell and those it lacks bad.
    Raises BadFile for a file that is no table, has no header or a row with more cells than that,
    MissingColumn for a missing column.
    """
    spelt = {name.casefold(): name for name in (*known, *needed, *text)}
    try:
        _check_size(path, LARGEST, "Split the take.")
        spaced = any(name.startswith(" ") for name in _first_row(path, spaced=False))
        names = [name.strip() for name in _first_row(path, spaced)]
        names = [spelt.get(name.casefold(), name) for name in names]
        _check_header(names, (*text, *needed), path)
        table = _parsed(path, names, text, spaced)
    except FileNotFoundError as error:
        raise NoSuchFile(
            path,
            found="no such file",
            expected="a tracking result",
            remedy="Check data_dir and the folder in the ingest section.",
        ) from error
    except (ValueError, OSError, csv.Error, OverflowError) as error:
        raise BadFile(
            path,
            found=str(error),
            expected="a CSV table with a header",
            remedy="Export the take again.",
        ) from error
    return table if all(names) else table.loc[:, [bool(name) for name in names]]


def header_of(path: Path) -> frozenset[str]:
    """The column names of a CSV, stripped; none where it cannot be read as one."""
    return frozenset(names_of(path))


def names_of(path: Path) -> list[str]:
    """`header_of` in the order of the file."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            line = file.readline(1_000_000)
        return [name.strip() for name in next(csv.reader([line], skipinitialspace=True))]
    except (OSError, ValueError, csv.Error, StopIteration):
        return []


def numbers(
    table: pd.DataFrame,
    columns: list[str],
    path: Path,
    bad_values: str,
    blank_ok: bool | np.ndarray = False,
) -> tuple[pd.DataFrame, np.ndarray]:
    """The columns as floats, and which rows held something else.

    bad_values: "fail" raises BadFile at the first bad cell, "mask" gives NaN and marks the row.
    blank_ok: an empty cell is a value that the tracker does not give, no bad one. An array says so
    cell by cell, (n_rows or 1, n_columns or 1); a column without any number is then never given.
    """
    chosen = table[list(columns)]
    if all(dtype.kind in "iuf" for dtype in chosen.dtypes):
        values = chosen.to_numpy(float)
    else:
        values = chosen.apply(pd.to_numeric, errors="coerce").to_numpy(float, na_value=np.nan)
    finite = np.isfinite(values)
    bad = ~finite
    if blank_ok is not False and bad.any():
        given = chosen.apply(lambda column: column.astype(str).str.strip() != "").to_numpy()
        bad &= given | ~(blank_ok | ~finite.any(axis=0))
    if bad.any() and bad_values == "fail":
        row, column = np.argwhere(bad)[0]
        cell, line = chosen.iat[row, column], line_of(path, table.index[row])
        refuse_cut_off(cell, path, line)
        raise BadFile(
            path,
            place=f"line {line}, column {columns[column]}",
            found=repr(cell) if isinstance(cell, str) else str(cell),
            expected="a number",
            remedy="Fix the cell, or set ingest.bad_values: mask to treat the frame as a gap.",
        )
    if bad.any():
        values = np.where(finite, values, np.nan)
    return pd.DataFrame(values, table.index, chosen.columns, copy=False), bad.any(axis=1)


def expressions(values: pd.DataFrame, path: Path) -> pd.DataFrame:
    """The ARKit channels among the columns, by name. Raises BadFile far outside of [0, 1]."""
    columns = {name: c for c in values if (name := canonical(c)) in EXPRESSIONS}
    columns = {name: columns[name] for name in EXPRESSIONS if name in columns}
    named = values[list(columns.values())].set_axis(list(columns), axis=1)
    low, high = EXPRESSION_RANGE
    coefficients = named.to_numpy()
    outside = (coefficients < low) | (coefficients > high)
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise BadFile(
            path,
            place=f"line {line_of(path, named.index[row])}, column {named.columns[column]}",
            found=f"{coefficients[row, column]:g}",
            expected="a coefficient between 0 and 1",
            remedy="Divide by 100 where the export is in per cent; else export the take again.",
        )
    return named


def angles(values: pd.DataFrame, unit: str, path: Path, remedy: str) -> pd.DataFrame:
    """Angles in radians; a column that is 0 wherever it is a number was never measured: NaN.

    unit: "radians" or "degrees". remedy: what to do where an angle is beyond half a turn.
    """
    given = values.to_numpy(float)
    idle = ((given == 0) | np.isnan(given)).all(axis=0)
    given = np.where(idle, np.nan, given)
    radians = np.radians(given) if unit == "degrees" else given
    beyond = np.abs(radians) > np.pi
    if beyond.any():
        row, column = np.argwhere(beyond)[0]
        raise BadFile(
            path,
            place=f"line {line_of(path, values.index[row])}, column {values.columns[column]}",
            found=f"an angle of {given[row, column]:.3g} in {unit}",
            expected="angles within half a turn",
            remedy=remedy,
        )
    return pd.DataFrame(radians, values.index, values.columns)


def by_channel(
    radians: pd.DataFrame, signs: Mapping[str, tuple[str, float]]
) -> tuple[pd.DataFrame, dict[str, Origin]]:
    """Angles by channel, each the mean of the columns that are signed for it, and their origins.

    radians: what `angles` gives of the columns that the file has. signs: as in Convention.signs.
    A channel one of whose columns is absent or NaN throughout is not measured, and left out.
    """
    values, position = radians.to_numpy(), {name: at for at, name in enumerate(radians)}
    never = dict(zip(radians, np.isnan(values).all(axis=0), strict=True))
    channels, origins = {}, {}
    for channel in dict.fromkeys(channel for channel, _ in signs.values()):
        named = {column: sign for column, (of, sign) in signs.items() if of == channel}
        absent = [column for column in named if column not in position]
        idle = [column for column in named if never.get(column)]
        if absent:
            origins[channel] = Origin(f"the file has no column {absent[0]}", measured=False)
        elif idle:
            origins[channel] = Origin(f"column {idle[0]} is 0 or empty throughout", measured=False)
        else:
            signed = values[:, [position[column] for column in named]] * list(named.values())
            channels[channel] = signed.mean(axis=1)
            terms = [column if sign > 0 else f"-{column}" for column, sign in named.items()]
            of = "column " if len(terms) == 1 else "mean of columns "
            origins[channel] = Origin(of + " and ".join(terms))
    return pd.DataFrame(channels, index=radians.index), origins


def all_origins(columns: list[str], angles: Mapping[str, Origin]) -> dict[str, Origin]:
    """Every channel's origin: the column that bears its name, the angle's own, or that it has none.

    columns: of the file; where none bears a channel's name, one that nearly does is named.
    angles: origins of head and gaze channels.
    """
    named = {canonical(column): Origin(f"column {column}") for column in columns}
    foreign = {column.casefold(): column for column in columns if not canonical(column)}
    return {
        name: angles.get(name) or named.get(name) or _absent(name, foreign) for name in CHANNELS
    }


def _absent(channel: str, foreign: Mapping[str, str]) -> Origin:
    near = difflib.get_close_matches(channel.casefold(), foreign, n=1, cutoff=0.8)
    hint = f" (it has {foreign[near[0]]})" if near else ""
    return Origin(f"the file has no such column{hint}", measured=False)


def line_of(path: Path, row: int) -> int:
    """The line on which a table's row ends, rows counted from 0 after the header."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            records = csv.reader(file)
            for _ in zip(range(row + 2), filter(None, records), strict=False):
                pass
            return records.line_num
    except (OSError, ValueError, csv.Error):
        return row + 2


def _check_size(path: Path, most_bytes: int, remedy: str) -> None:
    if path.exists() and not path.is_file():  # a device has no end
        raise BadFile(path, found="no plain file", expected="a CSV table", remedy="Name the file.")
    if (n_bytes := path.stat().st_size) > most_bytes:
        raise BadFile(
            path,
            found=f"{n_bytes / 2**20:.0f} MiB",
            expected=f"at most {most_bytes / 2**20:.0f} MiB",
            remedy=remedy,
        )


def _first_row(path: Path, spaced: bool) -> list[str]:
    with open(path, encoding="utf-8-sig", newline="") as file:
        return next(filter(None, csv.reader(file, skipinitialspace=spaced)), [])


def _check_header(names: list[str], needed: tuple[str, ...], path: Path) -> None:
    if not names:
        raise ValueError("an empty file")
    filled = [name for name in names if name]
    if len(filled) == 1 and (other := next((c for c in ";\t" if c in filled[0]), None)):
        raise BadFile(
            path,
            place="line 1",
            found=f"columns separated by {other!r}",
            expected="columns separated by ','",
            remedy="Save the table with commas, and points in its numbers.",
        )
    if not any(name in needed or canonical(name) for name in filled):
        remedy = "Name its columns under ingest.table.channels, or correct ingest.format."
        if not any(name[:1].isalpha() for name in filled):
            remedy = "Export the take with its header: columns are known by name alone."
        raise BadFile(
            path,
            place="line 1",
            found=", ".join(name[:20] for name in filled[:3]) + " ...",
            expected="a header with channel names",
            remedy=remedy,
        )
    times = Counter(canonical(name) or name for name in filled)
    if repeated := sorted(name for name, count in times.items() if count > 1):
        raise BadFile(
            path,
            place="line 1",
            found=f"column {repeated[0]} twice",
            expected="each column once",
            remedy="Export the take again.",
        )
    if missing := [name for name in needed if name not in filled]:
        raise MissingColumn(
            path,
            place="line 1",
            found="no such column",
            expected=", ".join(missing),
            remedy="Export the take with all its columns, or correct ingest.format.",
        )


def _parsed(path: Path, names: list[str], text: tuple[str, ...], spaced: bool) -> pd.DataFrame:
    """The rows below the header; columns of numbers as numbers, the others as text."""
    try:
        told = [names.index(name) for name in text]
        table = _read(path, names, told, spaced)
        # True and False, and numbers amid text: as they stand in the file.
        doubtful = [at for at, dtype in table.dtypes.items() if dtype in (bool, object)]
        if doubtful and len(table):
            table = _read(path, names, [*told, *doubtful], spaced)
    except (ParserWarning, ParserError):
        table = _by_row(path, len(names))
    if len(table) > MOST_ROWS:
        raise _too_many_rows(path)
    mark(table, path)
    return table.set_axis(names, axis=1)


def _too_many_rows(path: Path) -> BadFile:
    return BadFile(
        path,
        found=f"more than {MOST_ROWS} rows",
        expected=f"a take of at most {MOST_FRAMES} frames",
        remedy="Split the take.",
    )


def _read(path: Path, names: list[str], text: list[int], spaced: bool) -> pd.DataFrame:
    """The rows, columns numbered. Raises ParserWarning or ParserError where one is too wide."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", ParserWarning)
        warnings.simplefilter("ignore", DtypeWarning)
        return pd.read_csv(
            path,
            header=0,
            names=range(len(names)),
            index_col=False,
            dtype=dict.fromkeys(text, str),
            na_filter=False,
            nrows=MOST_ROWS + 1,
            skipinitialspace=spaced,  # slow
            encoding="utf-8-sig",
            compression=None,
        )


def _by_row(path: Path, width: int) -> pd.DataFrame:
    """The rows as text, columns numbered; blank cells beyond the width are cut off.

    Raises BadFile at the first row that holds something there.
    """
    _check_size(path, LARGEST_BY_ROW, "Take out what stands beyond the header's last column.")
    rows = []
    with open(path, encoding="utf-8-sig", newline="") as file:
        records = csv.reader(file, skipinitialspace=True, strict=True)
        next(filter(None, records))
        for cells in filter(None, records):
            if any(cell.strip() for cell in cells[width:]):
                raise BadFile(
                    path,
                    place=f"line {records.line_num}",
                    found=f"{len(cells)} cells",
                    expected=f"{width}, as many as the header has",
                    remedy="Export the take again; commas within numbers are not understood.",
                )
            if len(rows) == MOST_ROWS:
                raise _too_many_rows(path)
            rows.append(cells[:width] + [""] * (width - len(cells)))
    return pd.DataFrame(rows, columns=range(width), dtype=str)
