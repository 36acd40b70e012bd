"""Tables as Parquet files: cast and checked on write and on read, whole or not there at all."""

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pandera
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from mimeline.atomic import whole
from mimeline.errors import BadFile, MissingColumn
from mimeline.tables.table import Table

REASON, ABOUT = "mimeline.reason", "mimeline.about"


def empty(table: Table) -> pd.DataFrame:
    """The table with no row, every column of its type."""
    return _to_pandas(table.schema.empty_table())


def write(
    table: Table, rows: pd.DataFrame, path: str | Path, reason: str = "", about: str = ""
) -> None:
    """Cast, check, sort and write rows to path; a file under that name is always whole.

    reason: why the table is empty; about: what else is to be known of it; both kept in the file.
    Raises BadFile where a value is not allowed, MissingColumn where a column is absent.
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
    if notes := {key: note for key, note in ((REASON, reason), (ABOUT, about)) if note}:
        arrow = arrow.replace_schema_metadata(notes)
    with whole(path) as temporary:
        pq.write_table(arrow, temporary, compression="zstd")


def read(
    table: Table,
    path: str | Path,
    columns: Sequence[str] | None = None,
    clips: Collection[str] | None = None,
) -> pd.DataFrame:
    """Read and check a table; columns picks some of them (their values are then not checked).

    clips: only rows of these.
    """
    wanted = None if clips is None else pc.field("clip_id").isin(pa.array(clips, pa.string()))
    try:
        arrow = pq.read_table(
            path, columns=None if columns is None else list(columns), filters=wanted
        )
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
    return _note(path, REASON)


def about(path: str | Path) -> str:
    """What else is to be known of the table at path; the empty string where it says nothing."""
    return _note(path, ABOUT)


def _note(path: str | Path, key: str) -> str:
    metadata = pq.read_schema(path).metadata or {}
    return metadata.get(key.encode(), b"").decode(errors="replace")


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
