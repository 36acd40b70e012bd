"""What the annotation takes for what: per track, how the frames of each true action were named."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from mimeline import tables
from mimeline.reporting import words
from mimeline.vocabulary import NEUTRAL, TRACKS, track_actions

VARIANT = "named"  # the timelines as written


@dataclass(frozen=True)
class Cell:
    """share: of the true action's frames, 0-1 · text, spread: it and its interval in per cent,
    empty where there is none · title: all of it in words · right: found as what it is."""

    share: float
    text: str
    spread: str
    title: str
    right: bool


@dataclass(frozen=True)
class Row:
    """A true action, its frames, and a cell per found action."""

    action: str
    frames: int
    cells: list[Cell]


@dataclass(frozen=True)
class Matrix:
    """names: the found actions, Neutral first, as the rows are."""

    track: str
    names: list[str]
    rows: list[Row]


def matrices(confusion: str | Path) -> list[Matrix]:
    """One per track that was scored; true actions without a frame are left out.

    confusion: the `confusion` table.
    """
    shares = tables.read(tables.CONFUSION, confusion)
    shares = shares[shares["variant"] == VARIANT]
    found = []
    for track in TRACKS:
        names = [NEUTRAL, *track_actions(track)]
        own = shares[shares["track"] == track].set_index(["truth", "found"])
        rows = [_row(name, names, own.loc[name]) for name in names if name in own.index]
        if rows:
            found.append(Matrix(track, names, rows))
    return found


def _row(action: str, names: list[str], shares) -> Row:
    frames = int(shares["frames"].sum())
    return Row(action, frames, [_cell(action, name, shares.loc[name], frames) for name in names])


def _cell(action: str, name: str, own, frames: int) -> Cell:
    low, high = 100 * own["low"], 100 * own["high"]
    known = isfinite(low) and isfinite(high)
    taken = "found" if action == name else f"taken for {words.spaced(name)}"
    of = f"{words.percent(own['share'])} of {words.plural(frames, 'frame')}"
    return Cell(
        share=float(own["share"]),
        text=words.percent(own["share"]) if own["frames"] else "",
        spread="–".join(map(_short, (low, high))) if own["frames"] and known else "",
        title=f"{words.spaced(action)}, {taken}: {of}"
        + (f", 95 % interval {low:.1f} to {high:.1f} %" if known else ""),
        right=action == name,
    )


def _short(per_cent: float) -> str:
    if 99.5 <= per_cent < 100:
        return f"{min(per_cent, 99.9):.1f}"
    return f"{per_cent:.{0 if per_cent >= 9.95 else 1}f}"
