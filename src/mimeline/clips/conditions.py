"""Conditions on clips that a user writes, such as `emotion == 'happy' and duration_s < 8`.

They are read as Python's comparisons and evaluated here, column by column: nothing is executed.
"""

import ast
import operator
import reprlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import reduce
from itertools import compress

import numpy as np
import pandas as pd

from mimeline.errors import BadConfig

TEXT, NUMBER, NAMES = "a text", "a number", "names"
COLUMNS: dict[str, str] = {
    "clip_id": TEXT,
    "source_id": TEXT,
    "subject_id": TEXT,
    "duration_s": NUMBER,
    "width": NUMBER,
    "height": NUMBER,
    "side_px": NUMBER,
    "clips_of_source": NUMBER,
    "emotion": TEXT,
    "emotions": NAMES,
    "actions": NAMES,
    "attributes": NAMES,
}
LONGEST = 200  # characters of a condition that a message quotes
SAME = {ast.Eq: operator.eq, ast.NotEq: operator.ne}
ORDER = {ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge}
SIGNS = {ast.USub: operator.neg, ast.UAdd: operator.pos}
EXAMPLES = "emotion == 'happy', 5 <= duration_s < 8, 'smile' in actions"

# What a part of a condition says of each clip: boolean, NA where a value is not known.
Truth = Callable[[pd.DataFrame], pd.Series]


@dataclass(frozen=True)
class Condition:
    """A condition as it was written, the columns it needs, and what it says of each clip."""

    text: str
    columns: tuple[str, ...]
    holds: Truth

    def values(self, known: pd.DataFrame, rows: np.ndarray) -> list[str]:
        """The condition, and what the clips in these rows have in the columns that it names."""
        known = known.iloc[rows]
        shown = [[f"{name} {_shown(value)}" for value in known[name]] for name in self.columns]
        return [f"{self.text}: {', '.join(texts)}" for texts in zip(*shown, strict=True)]

    def gaps(self, known: pd.DataFrame, rows: np.ndarray) -> list[str]:
        """That the condition was not applied to the clips in these rows, and for want of what."""
        absent = known.iloc[rows][list(self.columns)].isna().to_numpy()  # (m, columns)
        names = [", ".join(compress(self.columns, row)) for row in absent]
        return [f"not applied: {self.text}: the catalogue does not give {name}" for name in names]


class _Refused(Exception):
    """What stands in a condition and what may."""

    def __init__(self, found: str, expected: str):
        self.found, self.expected = found, expected


def condition(text: str) -> Condition:
    """Read a condition over COLUMNS.

    Comparisons (==, !=, <, <=, >, >=), `in` a list of values, a name `in` a column of names, `is
    None`, and these joined by and, or, not. Raises BadConfig for anything else.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        columns = dict.fromkeys(n.id for n in ast.walk(tree) if isinstance(n, ast.Name))
        return Condition(text.strip(), tuple(columns), _truth(tree))
    except _Refused as refused:
        raise _bad(text, refused.found, refused.expected) from None
    except (SyntaxError, ValueError, OverflowError, MemoryError, RecursionError) as error:
        found = getattr(error, "msg", "") or str(error) or type(error).__name__
        raise _bad(text, found, f"a comparison such as {EXAMPLES}") from None


def facts(clips: pd.DataFrame, columns: Iterable[str]) -> pd.DataFrame:
    """Some of COLUMNS of each clip, from the `clips` table: nullable values, sets of names."""
    return pd.DataFrame({name: _fact(clips, name) for name in columns}, index=clips.index)


def _fact(clips: pd.DataFrame, name: str) -> pd.Series | list[frozenset]:
    match name:
        case "duration_s":
            return clips["end_s"] - clips["start_s"]
        case "width" | "height":
            return clips[name].astype("Float64")
        case "side_px":
            return clips[["width", "height"]].astype("Float64").min(axis=1, skipna=False)
        case "clips_of_source":
            return clips.groupby("source_id")["clip_id"].transform("size")
        case "actions" | "emotions":
            return [frozenset(item["name"] for item in items) for items in clips[name]]
        case "attributes":
            return [frozenset(items) for items in clips[name]]
    return clips[name].astype(pd.StringDtype(na_value=pd.NA))


def _shown(value) -> str:
    if isinstance(value, frozenset):
        return ", ".join(sorted(value)) or "none"
    if pd.isna(value):
        return "not known"
    return value if isinstance(value, str) else f"{value:.6g}"


def _truth(node: ast.expr) -> Truth:
    match node:
        case ast.BoolOp(op, values):
            join = operator.and_ if isinstance(op, ast.And) else operator.or_
            parts = [_truth(value) for value in values]
            return lambda known: reduce(join, (part(known) for part in parts))
        case ast.UnaryOp(ast.Not(), operand):
            inner = _truth(operand)
            return lambda known: ~inner(known)
        case ast.Compare(left, ops, others):
            sides = [left, *others]
            parts = [_compared(a, op, b) for a, op, b in zip(sides, ops, others, strict=False)]
            return lambda known: reduce(operator.and_, (part(known) for part in parts))
        case ast.BinOp(op=ast.BitAnd() | ast.BitOr()):
            raise _Refused("& or |", "and, or, not")
    raise _Refused(ast.unparse(node), f"a comparison such as {EXAMPLES}")


def _compared(left: ast.expr, op: ast.cmpop, right: ast.expr) -> Truth:
    wrote = ast.unparse(ast.Compare(left, [op], [right]))
    match op, right:
        case ((ast.Is() | ast.IsNot()), ast.Constant(None)):
            return _whether_known(_column(left), isinstance(op, ast.IsNot))
        case ((ast.In() | ast.NotIn()), (ast.Tuple() | ast.List() | ast.Set())):
            return _one_of(_column(left), [_value(item) for item in right.elts], op, wrote)
        case ((ast.In() | ast.NotIn()), _):
            return _among(_value(left), _column(right), op, wrote)
    sides = [side if isinstance(side, ast.Name) else _value(side) for side in (left, right)]
    kinds = [_kind(side) for side in sides]
    compare = (SAME | ORDER).get(type(op))
    if NAMES in kinds:
        raise _Refused(wrote, f"a name in quotes, in {ast.unparse(right)}, as 'smile' in actions")
    if compare is None or kinds[0] != kinds[1] or (kinds[0] == TEXT and type(op) in ORDER):
        expected = "texts compared by == or !=, numbers by any sign; a text stands in quotes"
        raise _Refused(f"{wrote} ({kinds[0]} and {kinds[1]})", expected)
    if not any(isinstance(side, ast.Name) for side in sides):
        raise _Refused(wrote, f"a column in it: {', '.join(COLUMNS)}")
    left, right = sides

    def holds(known: pd.DataFrame) -> pd.Series:
        a, b = (known[s.id] if isinstance(s, ast.Name) else s for s in (left, right))
        return compare(a, b).astype("boolean")

    return holds


def _whether_known(column: str, is_known: bool) -> Truth:
    return lambda known: (known[column].notna() == is_known).astype("boolean")


def _one_of(column: str, values: list, op: ast.cmpop, wrote: str) -> Truth:
    """The column's value is one of these."""
    if not values or any(_kind(value) != COLUMNS[column] for value in values):
        raise _Refused(wrote, f"a list of values, each {COLUMNS[column]}, as {column} is")
    inside = isinstance(op, ast.In)

    def holds(known: pd.DataFrame) -> pd.Series:
        truth = (known[column].isin(values) == inside).astype("boolean")
        return truth.mask(known[column].isna(), pd.NA)

    return holds


def _among(name, column: str, op: ast.cmpop, wrote: str) -> Truth:
    """The name is one of those that the column lists."""
    if COLUMNS[column] != NAMES or not isinstance(name, str):
        lists = ", ".join(c for c, kind in COLUMNS.items() if kind == NAMES)
        raise _Refused(wrote, f"a name in quotes, in one of {lists}")
    inside = isinstance(op, ast.In)

    def holds(known: pd.DataFrame) -> pd.Series:
        found = np.fromiter((name in names for names in known[column]), bool, len(known))
        return pd.Series(found == inside, known.index, "boolean")

    return holds


def _column(node: ast.expr) -> str:
    if not isinstance(node, ast.Name):
        raise _Refused(ast.unparse(node), f"a column: {', '.join(COLUMNS)}")
    _kind(node)
    return node.id


def _value(node: ast.expr) -> str | float:
    match node:
        case ast.Constant(str() as value):
            return value
        case ast.Constant(int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case ast.UnaryOp(op=sign, operand=ast.Constant(int() | float() as value)):
            if type(sign) in SIGNS:
                return SIGNS[type(sign)](float(value))
        case ast.Name(id):
            _kind(node)
            raise _Refused(id, "a value in its place: a number, or a text in quotes")
    raise _Refused(ast.unparse(node), "a number, a text in quotes, or a column")


def _kind(side: ast.Name | str | float) -> str:
    if not isinstance(side, ast.Name):
        return TEXT if isinstance(side, str) else NUMBER
    if side.id not in COLUMNS:
        columns = ", ".join(COLUMNS)
        raise _Refused(f"{side.id}, which is no column", f"one of {columns}, or a text in quotes")
    return COLUMNS[side.id]


def _bad(text: str, found: str, expected: str) -> BadConfig:
    return BadConfig(
        "select.conditions",
        place=reprlib.repr(text) if len(text) > LONGEST else repr(text),
        found=found if len(found) <= LONGEST else f"{found[:LONGEST]}…",
        expected=expected,
        remedy="docs/selection.md tells what a condition may say.",
    )
