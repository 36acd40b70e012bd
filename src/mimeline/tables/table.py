"""What a table is: its columns with their types, the checks on their values, its order."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandera.pandas as pandera
import pyarrow as pa


@dataclass(frozen=True)
class Table:
    """A table's columns with their types, the checks on their values and the order of its rows."""

    name: str
    schema: pa.Schema
    checks: pandera.DataFrameSchema
    order: tuple[str, ...]

    @property
    def value_names(self) -> list[str]:
        """The columns that are not the clip and the frame."""
        return [name for name in self.schema.names if name not in ("clip_id", "frame")]


def declare(
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
