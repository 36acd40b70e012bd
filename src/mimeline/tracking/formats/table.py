"""Any table with a header, CSV or Parquet, and a mapping from its columns to our channels."""

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from mimeline.atomic import whole
from mimeline.errors import BadFile, MissingColumn, unreadable
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.columns import (
    EXPRESSION_RANGE,
    line_of,
    names_of,
    numbers,
    read_columns,
)
from mimeline.tracking.take import MOST_FRAMES, Origin, Take, assemble
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, canonical

OTHERS = frozenset(("Timecode", "FaceScore", "_neutral"))  # of formats that bear the same names
MOST_NAMED = 12  # columns of a file, in a message
TRUTHS = {"true": 1.0, "false": 0.0}

ENDINGS = (".csv", ".parquet")
CONVENTION = Convention(
    title="generic table",
    files="<name>.csv or <name>.parquet, a row per frame",
    coefficients="columns that bear a channel's name, or are mapped to one",
    axes="none: angles are named by meaning",
    rotation="head_yaw_left, head_pitch_up, head_tilt_left: turn, then lift, then tilt",
    angle_unit="ingest.table.angle_unit",
    sides="the subject's",
    first_frame=None,
    gap="the column that ingest.table.valid names is 0, a frame that is left out, an empty row",
    never="what no column tells",
    evidence="the table's own names; scale: -1 turns a sign",
    meanings={name: "as the channel's name says" for name in CHANNELS if name not in EXPRESSIONS},
)


def holds(path: Path) -> bool:
    """Whether the file's header has a channel's name, and nothing of another format."""
    names = frozenset(_names(path))
    return any(canonical(name) for name in names) and not OTHERS & names


def read(
    path: Path,
    bad_values: str,
    fps: str,
    channels: Mapping[str, Mapping[str, Any]],
    angle_unit: str,
    frame: str | None,
    first_frame: int,
    valid: str | None,
    confidence: str | None,
    loss: str | None,
) -> Take:
    """Read a table. Channels come from columns of their name, and from those that are mapped.

    bad_values: "fail" or "mask". fps: its rate. channels: channel → column and scale (a factor).
    angle_unit: "radians" or "degrees", of head and gaze once scaled. frame, valid, confidence,
    loss: names of columns, None where there is none; without `frame`, rows are frames.
    first_frame: the number of the first frame. An empty cell is a value that is not given; a loss
    of NaN is infinite: it came to nothing.
    Raises BadFile, MissingColumn.
    """
    mapped = {channel: (m["column"], float(m["scale"])) for channel, m in channels.items()}
    asides = {"frame": frame, "valid": valid, "confidence": confidence, "loss": loss}
    keys = {f"channels.{channel}": column for channel, (column, _) in mapped.items()}
    keys |= {key: column for key, column in asides.items() if column is not None}
    _check_named(keys, path)
    needed = tuple(dict.fromkeys(keys.values()))
    table = _table(path, needed, text=tuple({confidence, loss} - {None}))
    own = {n: (c, 1.0) for c in table if (n := canonical(c)) and c not in needed}
    if twice := sorted(set(own) & set(mapped)):
        raise BadFile(
            path,
            place=f"column {own[twice[0]][0]}",
            found=f"{twice[0]}, which ingest.table.channels takes from {mapped[twice[0]][0]}",
            expected="each channel once",
            remedy="Take the mapping or the column out.",
        )
    sources = {name: (own | mapped)[name] for name in CHANNELS if name in own | mapped}
    if not sources:
        raise BadFile(
            path,
            found=_listed(_names(path)),
            expected="a column with a channel's name",
            remedy="Name its columns under ingest.table.channels.",
        )
    if table.empty:
        raise BadFile(
            path, found="no row", expected="at least a frame", remedy="Export the table again."
        )
    table, index = _clock(table, frame, first_frame, path, bad_values)
    told = _flags(table, valid, path, bad_values)
    values = _values(table, sources, told, angle_unit, path, bad_values)
    found = values.notna().any(axis=1).to_numpy()
    sure = np.nan if confidence is None else _floats(table, confidence, path, bad_values)
    motion = assemble(index, told & found, values, sure, path)
    if loss is not None:
        losses = pd.Series(_losses(table, loss, path, bad_values), index)
        motion["tracker_loss"] = losses.reindex(motion["frame"]).to_numpy()
    return Take(
        motion,
        Fraction(fps),
        origins={name: _origin(*source) for name, source in sources.items()},
        loss="" if loss is None else f"column {loss}",
        first_frame=None if frame is None else int(index[0]) + first_frame,
        numbered=frame is not None,
    )


def write(path: Path, motion: pd.DataFrame) -> None:
    """Write a motion table's frames as CSV: frame, valid, confidence, tracker_loss, channels.

    motion: a take's, one row per frame. Channels that are NaN throughout were not measured and are
    left out; other NaN are empty cells. `read` with frame, valid, confidence and loss named gives
    the same numbers back.
    """
    given = [name for name in CHANNELS if name in motion and motion[name].notna().any()]
    cells = motion[["frame"]].assign(valid=motion["valid"].astype(int))
    for name in ("confidence", "tracker_loss"):
        cells[name] = [_exact(number) for number in motion[name]]
    cells[given] = motion[given].astype(float)
    with whole(path) as temporary:
        cells.to_csv(temporary, index=False, float_format="%.9g", lineterminator="\n")


def _exact(number: float) -> str:
    return "" if np.isnan(number) else repr(float(number))


def _check_named(keys: Mapping[str, str], path: Path) -> None:
    """Raises MissingColumn where the file has not what a key of ingest.table names."""
    names = _names(path)
    there = set(names) if _is_parquet(path) else {name.casefold() for name in names}
    for key, column in keys.items():
        if names and (column if _is_parquet(path) else column.casefold()) not in there:
            raise MissingColumn(
                path,
                found=f"no column {column}; the file has {_listed(names)}",
                expected=f"the column that ingest.table.{key} names",
                remedy=f"Correct ingest.table.{key}.",
            )


def _listed(names: list[str]) -> str:
    more = ", …" if len(names) > MOST_NAMED else ""
    return ", ".join(name[:40] for name in names[:MOST_NAMED]) + more


def _names(path: Path) -> list[str]:
    """The file's columns; none where it cannot be read."""
    return _parquet_names(path) if _is_parquet(path) else names_of(path)


def _is_parquet(path: Path) -> bool:
    return path.suffix.lower() == ".parquet"


def _table(path: Path, needed: tuple[str, ...], text: tuple[str, ...]) -> pd.DataFrame:
    if _is_parquet(path):
        return _parquet(path, needed)
    return read_columns(path, text, tuple(name for name in needed if name not in text))


def _parquet(path: Path, needed: tuple[str, ...]) -> pd.DataFrame:
    """The columns that are needed or bear a channel's name, and `frame`."""
    try:
        with pq.ParquetFile(path) as file:
            names = file.schema_arrow.names
            used = [name for name in names if name in needed or canonical(name)]
            meant = [canonical(name) or name for name in used]
            if twice := next((name for name in meant if meant.count(name) > 1), None):
                raise BadFile(
                    path,
                    found=f"column {twice} twice",
                    expected="each column once",
                    remedy="Export the table again.",
                )
            if file.metadata.num_rows > MOST_FRAMES:
                raise BadFile(
                    path,
                    found=f"{file.metadata.num_rows} rows",
                    expected=f"at most {MOST_FRAMES} frames in a take",
                    remedy="Split the table into takes.",
                )
            for name in used:
                _check_kind(file.schema_arrow.field(name).type, name, path)
            counted = (name for name in dict.fromkeys(names) if name.casefold() == "frame")
            used += [
                name
                for name in counted
                if name not in used and _counts(file.schema_arrow.field(name).type)
            ]
            arrow = file.read(columns=used)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise unreadable(
            path, error, expected="a Parquet table", remedy="Export the table again."
        ) from error
    columns = {name: _plain(arrow.column(name)) for name in used}
    return pd.DataFrame(columns, index=pd.RangeIndex(arrow.num_rows))


def _counts(kind: pa.DataType) -> bool:
    return pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)


def _check_kind(kind: pa.DataType, name: str, path: Path) -> None:
    if not _counts(kind):
        raise BadFile(
            path,
            place=f"column {name}",
            found=str(kind),
            expected="numbers",
            remedy="Export the column as numbers.",
        )


def _plain(column: pa.ChunkedArray) -> pd.Series:
    """Numbers and truth values as floats, "" for null where there is one."""
    series = column.cast(pa.float64(), safe=False).to_pandas()  # integers beyond 2**53 are rounded
    if column.null_count:
        series = series.astype(object).mask(np.asarray(column.is_null()), "")
    return series


def _parquet_names(path: Path) -> list[str]:
    try:
        return pq.read_schema(path).names
    except (OSError, ValueError, pa.ArrowException):
        return []


def _clock(
    table: pd.DataFrame, frame: str | None, first_frame: int, path: Path, bad_values: str
) -> tuple[pd.DataFrame, np.ndarray]:
    """The rows in the order of frames, and their frames from 0."""
    if frame is None:
        _check_gapless(table, path)
        return table, np.arange(len(table))
    number, bad = numbers(table, [frame], path, bad_values)
    number = number.loc[~bad, frame] - first_frame
    wrong = (number < 0) | (number % 1 != 0) | number.duplicated()
    if wrong.any() or number.empty:
        found = f"{number[wrong.idxmax()] + first_frame:.10g}" if wrong.any() else "no number"
        raise BadFile(
            path,
            place=f"column {frame}",
            found=found,
            expected=f"whole numbers from {first_frame} on, each once",
            remedy="Set ingest.table.first_frame, or keep one face and one take to a table.",
        )
    number = np.minimum(number, MOST_FRAMES).astype("int64").sort_values()
    return table.loc[number.index], number.to_numpy()


def _check_gapless(table: pd.DataFrame, path: Path) -> None:
    """Raises BadFile where a column of frames does not count the rows; blank cells may be any."""
    column = next((name for name in table if name.casefold() == "frame"), None)
    if column is None or table.empty:
        return
    told, bad = numbers(table, [column], path, "mask", blank_ok=True)
    number = told[column].to_numpy()
    begins = number - np.arange(len(table))  # the first row's number, by each row's
    given = ~np.isnan(number)
    wrong = bad | (given & (begins != begins[given.argmax()]))
    if wrong.any():
        row = int(wrong.argmax())
        raise BadFile(
            path,
            place=f"column {column}",
            found=f"{table[column].iloc[row] if bad[row] else int(number[row])} in row {row + 1}",
            expected="each row's number one more than the last's",
            remedy=f"Set ingest.table.frame: {column} to count by it, or take the column out.",
        )


def _flags(table: pd.DataFrame, valid: str | None, path: Path, bad_values: str) -> np.ndarray:
    """Rows (n,) bool that the table calls valid; an empty cell is no."""
    if valid is None:
        return np.ones(len(table), bool)
    cells = table[[valid]]
    if cells[valid].dtype == object or isinstance(cells[valid].dtype, pd.StringDtype):
        words = cells[valid].astype(str).str.strip().str.lower()
        cells = words.map(TRUTHS).astype(object).fillna(cells[valid]).to_frame(valid)
    flags, _ = numbers(cells, [valid], path, bad_values, blank_ok=True)
    return flags[valid].fillna(0).to_numpy() != 0


def _values(
    table: pd.DataFrame,
    sources: Mapping[str, tuple[str, float]],
    told: np.ndarray,
    angle_unit: str,
    path: Path,
    bad_values: str,
) -> pd.DataFrame:
    """The channels, scaled, in radians; NaN where not given, and in rows that are not told."""
    columns = list(dict.fromkeys(column for column, _ in sources.values()))
    cells, bad = numbers(table[told], columns, path, bad_values, blank_ok=True)
    cells = cells[~bad].reindex(table.index)
    values = pd.DataFrame(
        {name: scale * cells[column] for name, (column, scale) in sources.items()}
    )
    turns = [name for name in values if name not in EXPRESSIONS]
    if angle_unit == "degrees":
        values[turns] = np.radians(values[turns])
    _check_ranges(values, cells, sources, path)
    return values


def _check_ranges(
    values: pd.DataFrame, cells: pd.DataFrame, sources: Mapping[str, tuple[str, float]], path: Path
) -> None:
    """Raises BadFile, with the file's own number, for a coefficient or an angle out of range."""
    low, high = EXPRESSION_RANGE
    for channel in values:
        expressive = channel in EXPRESSIONS
        of = values[channel].to_numpy()
        beyond = (of < low) | (of > high) if expressive else np.abs(of) > np.pi
        if not beyond.any():
            continue
        row, (column, scale) = int(beyond.argmax()), sources[channel]
        at = cells.index[row]
        line = f"row {at + 1}" if _is_parquet(path) else f"line {line_of(path, at)}"
        own = f"{cells[column].iat[row]:g}" + (f" x {scale:g}" if scale != 1 else "")
        key = f"ingest.table.channels.{channel}"
        raise BadFile(
            path,
            place=f"{line}, column {column}",
            found=own if expressive else f"{own}, an angle of {np.degrees(of[row]):.4g} degrees",
            expected="a coefficient between 0 and 1" if expressive else "angles within half a turn",
            remedy=f"Where it is in per cent, set {key}: {{column: {column}, scale: 0.01}}."
            if expressive
            else f"Set ingest.table.angle_unit, or the scale of {key}.",
        )


def _floats(table: pd.DataFrame, column: str, path: Path, bad_values: str) -> np.ndarray:
    values, _ = numbers(table, [column], path, bad_values, blank_ok=True)
    return values[column].to_numpy()


def _losses(table: pd.DataFrame, column: str, path: Path, bad_values: str) -> np.ndarray:
    """The loss of each row (n,): NaN where the cell is blank, infinite where it came to nothing."""
    cells = table[column].astype(str).str.strip()
    nothing = cells.str.fullmatch(r"(?i)[+-]?(nan|inf|infinity)", na=True)
    values, bad = numbers(table[~nothing], [column], path, bad_values, blank_ok=True)
    losses = values[column].mask(bad, np.inf)
    return losses.reindex(table.index, fill_value=np.inf).to_numpy()


def _origin(column: str, scale: float) -> Origin:
    return Origin(f"column {column}" if scale == 1 else f"column {column} x {scale:g}")
