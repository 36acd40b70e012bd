"""The tables' contract: each declared once, cast and checked on write and on read.

A table is Parquet. It is written beside its target and moved into place, so a file that exists is
whole. An empty table may carry the reason why it is empty.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pandera
import pyarrow as pa
import pyarrow.parquet as pq

from mimeline.atomic import whole
from mimeline.errors import BadFile, MissingColumn
from mimeline.vocabulary import (
    ACTIONS,
    CHANNELS,
    EXPRESSIONS,
    NEUTRAL,
    SERIES_REGIONS,
    TRACKS,
    series_channels,
)

REASON = b"mimeline.reason"


@dataclass(frozen=True)
class Table:
    """A table's columns with their types, the checks on their values and the order of its rows."""

    name: str
    schema: pa.Schema
    checks: pandera.DataFrameSchema
    order: tuple[str, ...]


def _table(
    name: str, columns: dict, order: Sequence[str], frame_checks=None, key: Sequence[str] = ()
) -> Table:
    """columns: name → (pyarrow type, nullable, pandera checks). key: no two rows share these."""
    schema = pa.schema([pa.field(n, t, nullable=null) for n, (t, null, _) in columns.items()])
    checks = pandera.DataFrameSchema(
        {n: pandera.Column(checks=c, nullable=null) for n, (_, null, c) in columns.items()},
        checks=frame_checks,
        strict=True,
        ordered=True,
        unique=list(key) or None,
    )
    return Table(name, schema, checks, tuple(order))


def _isin(values: Iterable[str]) -> list[pandera.Check]:
    return [pandera.Check.isin(list(values))]


def _at_least(least: float) -> list[pandera.Check]:
    return [pandera.Check.ge(least)]


_S = pa.string()
_TEXT, _NAME = (_S, False, None), (_S, True, None)
_INT, _COUNT = (pa.int64(), False, None), (pa.int64(), False, _at_least(0))
_REAL = (pa.float64(), True, None)
_INTERVAL = pandera.Check(
    lambda t: t["end_frame"] > t["start_frame"], name="half-open interval of at least a frame"
)

CLIPS = _table(
    "clips",
    {
        "clip_id": _TEXT,
        "source_id": _TEXT,
        "subject_id": _NAME,
        "start_s": (pa.float64(), False, _at_least(0)),
        "end_s": (pa.float64(), False, None),
        "fps_num": (pa.int64(), True, _at_least(1)),
        "fps_den": (pa.int64(), True, _at_least(1)),
        "n_frames": (pa.int64(), True, _at_least(0)),
        "width": (pa.int64(), True, _at_least(1)),
        "height": (pa.int64(), True, _at_least(1)),
        "bbox_top": _REAL,
        "bbox_bottom": _REAL,
        "bbox_left": _REAL,
        "bbox_right": _REAL,
        "actions": (
            pa.list_(pa.struct({"name": _S, "start_s": pa.float64(), "end_s": pa.float64()})),
            False,
            None,
        ),
        "emotion": _NAME,
        "texts": (pa.list_(pa.string()), False, None),
        "audio": _NAME,
        "media": _NAME,
        "shard": _COUNT,
    },
    order=["clip_id"],
    key=["clip_id"],
)

LEDGER = _table(
    "ledger",
    {
        "clip_id": _TEXT,
        "stage": _TEXT,
        "status": (pa.string(), False, _isin(["kept", "dropped", "failed"])),
        "rule": _NAME,
        "value": _REAL,
        "limit": _REAL,
        "unit": _NAME,
        "first_frame": (pa.int64(), True, None),
        "last_frame": (pa.int64(), True, None),
        "detail": _NAME,
    },
    order=["stage", "clip_id"],
    key=["stage", "clip_id"],
)

SOURCE_TIMES = _table(
    "source_times",
    {
        "clip_id": _TEXT,
        "frame": _COUNT,
        "source_frame": _COUNT,
        "source_s": (pa.float64(), False, None),
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

_EXPRESSION = (pa.float32(), True, [pandera.Check.in_range(-1.0, 2.0)])
_ANGLE = (pa.float32(), True, [pandera.Check.in_range(-np.pi - 1e-3, np.pi + 1e-3)])

MOTION = _table(
    "motion",
    {
        "clip_id": _TEXT,
        "frame": _COUNT,
        "valid": (pa.bool_(), False, None),
        "confidence": _REAL,
        "tracker_loss": _REAL,
        **{name: _EXPRESSION if name in EXPRESSIONS else _ANGLE for name in CHANNELS},
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)


def _series(region: str, side: str) -> Table:
    channels = {name: (pa.float32(), False, None) for name in series_channels(region, side)}
    columns = {
        "position": _COUNT,
        "clip_id": _NAME,
        "frame": (pa.int64(), True, _at_least(0)),
        **channels,
    }
    return _table("series", columns, order=["position"])


SERIES: dict[tuple[str, str], Table] = {
    (region, side): _series(region, side) for region in SERIES_REGIONS for side in ("left", "right")
}

CLUSTERS = _table(
    "clusters",
    {
        "clip_id": _TEXT,
        "frame": _COUNT,
        "cluster": _COUNT,
        "margin": (pa.float32(), False, _at_least(0)),
    },
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

EXEMPLARS = _table(
    "exemplars",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "cluster": _COUNT,
        "clip_id": _TEXT,
        "start_frame": _COUNT,
        "end_frame": _COUNT,
        "kind": (pa.string(), False, _isin(["medoid", "border", "longest", "random"])),
    },
    order=["region", "cluster", "kind", "clip_id", "start_frame"],
    frame_checks=_INTERVAL,
)

INTERVALS = _table(
    "intervals",
    {
        "clip_id": _TEXT,
        "track": (pa.string(), False, _isin(TRACKS)),
        "action": (pa.string(), False, _isin(ACTIONS)),
        "start_frame": _COUNT,
        "end_frame": _COUNT,
        "side": (pa.string(), True, _isin(["left", "right"])),
        "source": (pa.string(), False, _isin(["ticc", "threshold", "human"])),
        "cluster": (pa.int64(), True, _at_least(0)),
        "confidence": (pa.float64(), True, [pandera.Check.in_range(0, 1)]),
    },
    order=["clip_id", "track", "start_frame"],
    frame_checks=_INTERVAL,
)

FRAMES = _table(
    "frames",
    {"clip_id": _TEXT, "frame": _COUNT, **{a: (pa.bool_(), True, None) for a in ACTIONS}},
    order=["clip_id", "frame"],
    key=["clip_id", "frame"],
)

LABELS = _table(
    "labels",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "cluster": _COUNT,
        "action": (pa.string(), False, _isin([*ACTIONS, NEUTRAL])),
        "note": _NAME,
        "source": (pa.string(), False, _isin(["proposed", "human"])),
        "share": (pa.float64(), False, [pandera.Check.in_range(0, 1)]),
    },
    order=["region", "cluster"],
    key=["region", "cluster"],
)

SPLIT = _table(
    "split",
    {
        "clip_id": _TEXT,
        "part": (pa.string(), False, _isin(["train", "val", "test"])),
        "group": _TEXT,
    },
    order=["clip_id"],
    key=["clip_id"],
)

STATISTICS = _table(
    "statistics",
    {
        "channel": (pa.string(), False, _isin(CHANNELS)),
        "measured": (pa.float64(), False, [pandera.Check.in_range(0, 1)]),
        "mean": _REAL,
        "std": _REAL,
        "low": _REAL,
        "high": _REAL,
    },
    order=[],
)

LOSSES = _table(
    "losses",
    {
        "step": _COUNT,
        "loss": (pa.float64(), False, None),
        "val_loss": _REAL,
        "learning_rate": (pa.float64(), False, None),
        "seconds": (pa.float64(), False, None),
    },
    order=["step"],
)

METRICS = _table(
    "metrics",
    {
        "model": _TEXT,
        "variant": _TEXT,
        "part": _TEXT,
        "metric": _TEXT,
        "value": _REAL,
        "low": _REAL,
        "high": _REAL,
        "n": _COUNT,
        "seed": (pa.int64(), True, None),
    },
    order=[],
)


SWEEP = _table(
    "sweep",
    {
        "region": (pa.string(), False, _isin(SERIES_REGIONS)),
        "n_clusters": (pa.int64(), False, _at_least(1)),
        "beta": (pa.float64(), False, _at_least(0)),
        "seed": _INT,
        "objective": (pa.float64(), False, None),
        "bic": (pa.float64(), False, None),
        "n_switches": _COUNT,
        "mean_frames": (pa.float64(), False, _at_least(1)),
        "used": (pa.int64(), False, _at_least(1)),
        "stability": (pa.float64(), True, [pandera.Check.in_range(-1, 1)]),
        "f1": (pa.float64(), True, [pandera.Check.in_range(0, 1)]),
    },
    order=["region", "n_clusters", "beta", "seed"],
    key=["region", "n_clusters", "beta", "seed"],
)


def empty(table: Table) -> pd.DataFrame:
    """The table with no row, every column of its type."""
    return _to_pandas(table.schema.empty_table())


def write(table: Table, rows: pd.DataFrame, path: str | Path, reason: str = "") -> None:
    """Cast, check, sort and write rows to path; a file under that name is always whole.

    reason: why the table is empty, kept in the file. Raises BadFile where a value is not allowed,
    MissingColumn where a column is absent.
    """
    path = Path(path)
    missing = [name for name in table.schema.names if name not in rows.columns]
    if missing:
        raise MissingColumn(
            path,
            found=f"no column {', '.join(missing)}",
            expected=f"the columns of table {table.name}",
            remedy="Fill the column before writing, with nulls where it may be missing.",
        )
    rows = rows[table.schema.names]
    if table.order:
        rows = rows.sort_values(list(table.order), kind="stable")
    try:
        arrow = table.schema.empty_table()
        if len(rows):
            arrow = pa.Table.from_pandas(rows, table.schema, preserve_index=False)
    except (pa.ArrowException, ValueError) as error:
        raise BadFile(
            path,
            place=f"table {table.name}",
            found=str(error),
            expected="values of the declared types",
            remedy="Fix the stage that makes the table.",
        ) from error
    _check(table, _to_pandas(arrow), path)
    if reason:
        arrow = arrow.replace_schema_metadata({REASON: reason.encode()})
    with whole(path) as temporary:
        pq.write_table(arrow, temporary, compression="zstd")


def read(table: Table, path: str | Path, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """Read and check a table; columns picks some of them (their values are then not checked)."""
    try:
        arrow = pq.read_table(path, columns=None if columns is None else list(columns))
    except FileNotFoundError as error:
        raise BadFile(
            path,
            found="no such file",
            expected=f"a {table.name} table",
            remedy="Run the stage that writes it.",
        ) from error
    except (pa.ArrowInvalid, OSError) as error:
        raise BadFile(
            path,
            found=str(error),
            expected=f"a {table.name} table in Parquet",
            remedy="Delete the file and run its stage again.",
        ) from error
    missing = [n for n in (columns or table.schema.names) if n not in arrow.column_names]
    if missing:
        raise MissingColumn(
            path,
            found=f"no column {', '.join(missing)}",
            expected=f"the columns of table {table.name}",
            remedy="Delete the file and run its stage again.",
        )
    if columns is not None:
        return _to_pandas(arrow)
    try:
        arrow = arrow.select(table.schema.names).cast(table.schema)
    except (pa.ArrowException, ValueError) as error:
        raise BadFile(
            path,
            place=f"table {table.name}",
            found=str(error),
            expected="columns of the declared types",
            remedy="Write the file with these types, or run its stage again.",
        ) from error
    rows = _to_pandas(arrow)
    _check(table, rows, path)
    return rows


def read_all(
    table: Table, paths: Iterable[str | Path], columns: Sequence[str] | None = None
) -> pd.DataFrame:
    """The rows of several files of one table, in the table's order."""
    parts = [part for path in paths if len(part := read(table, path, columns))]
    if not parts:
        rows = empty(table)
        return rows if columns is None else rows[list(columns)]
    rows = pd.concat(parts, ignore_index=True)
    order = [name for name in table.order if name in rows.columns]
    return rows.sort_values(order, kind="stable", ignore_index=True) if order else rows


def reason(path: str | Path) -> str:
    """Why the table at path is empty; the empty string where it says nothing."""
    metadata = pq.read_schema(path).metadata or {}
    return metadata.get(REASON, b"").decode()


def _to_pandas(arrow: pa.Table) -> pd.DataFrame:
    """Nullable integers and booleans stay integers and booleans, with pd.NA for null."""
    always = {pa.string(): pd.StringDtype(na_value=np.nan)}
    nullable = always | {pa.int64(): pd.Int64Dtype(), pa.bool_(): pd.BooleanDtype()}
    columns = {}
    for field in arrow.schema:
        dtypes = nullable if field.nullable else always
        columns[field.name] = arrow.column(field.name).to_pandas(types_mapper=dtypes.get)
    return pd.DataFrame(columns, copy=False)


def _check(table: Table, rows: pd.DataFrame, path: str | Path) -> None:
    try:
        table.checks.validate(rows, lazy=True)
    except pandera.errors.SchemaErrors as error:
        first = error.failure_cases.iloc[0].fillna("")
        raise BadFile(
            path,
            place=f"table {table.name}, column {first['column']}, row {first['index']}",
            found=repr(first["failure_case"]),
            expected=str(first["check"]),
            remedy=f"{len(error.failure_cases)} value(s) break the contract: mend their source.",
        ) from error
