"""A take: what one tracking result says, in the house's channels, signs and frame clock."""

import csv
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
from pandas.errors import EmptyDataError

from mimeline.errors import BadFile, MissingColumn, NoSuchFile
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, canonical

EXPRESSION_RANGE = (-1.0, 2.0)  # coefficients of [0, 1] overshoot a little
MOST_FRAMES = 1_000_000  # in a take: nine hours at 30 fps


@dataclass(frozen=True)
class Take:
    """motion: frame 0..n-1, valid, confidence, tracker_loss and every channel (NaN where not
    measured), one row per frame of the clock. fps: frames per second of that clock."""

    motion: pd.DataFrame
    fps: Fraction

    def cut(self, start: int, end: int) -> "Take":
        """Frames [start, end), counted from 0 anew."""
        part = self.motion[(self.motion["frame"] >= start) & (self.motion["frame"] < end)]
        return Take(part.assign(frame=part["frame"] - start).reset_index(drop=True), self.fps)

    def padded(self, n_frames: int) -> "Take":
        """At least n_frames frames; what the tracker did not give is not valid."""
        return Take(on_clock(self.motion, max(n_frames, len(self.motion))), self.fps)


def read_columns(path: Path, text: tuple[str, ...] = ()) -> pd.DataFrame:
    """A tracker's CSV as it stands: column names stripped, every cell text.

    text: columns that must be there, whatever they hold.
    Raises BadFile for a file that is no table or has no header, MissingColumn for a missing one.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            header = next(csv.reader(file), [])
        table = pd.read_csv(
            path,
            dtype=str,
            keep_default_na=False,
            skipinitialspace=True,
            encoding="utf-8-sig",
            index_col=False,
        )
    except FileNotFoundError as error:
        raise NoSuchFile(
            path,
            found="no such file",
            expected="a tracking result",
            remedy="Check data_dir and the folder in the ingest section.",
        ) from error
    except (ValueError, OSError, csv.Error) as error:
        raise BadFile(
            path,
            found="an empty file" if isinstance(error, EmptyDataError) else str(error),
            expected="a CSV table with a header",
            remedy="Export the take again.",
        ) from error
    names = [name.strip() for name in header]
    if len(names) == 1 and (other := next((c for c in ";\t" if c in names[0]), None)):
        raise BadFile(
            path,
            place="line 1",
            found=f"columns separated by {other!r}",
            expected="columns separated by ','",
            remedy="Save the table with commas, and points in its numbers.",
        )
    if not any(canonical(name) for name in names):
        raise BadFile(
            path,
            place="line 1",
            found=", ".join(name[:20] for name in names[:3] if name) + " ...",
            expected="a header with channel names",
            remedy="Export the take with its header: columns are known by name, never by position.",
        )
    meant = [canonical(name) or name for name in names]
    if repeated := sorted({name for name in meant if meant.count(name) > 1}):
        raise BadFile(
            path,
            place="line 1",
            found=f"column {repeated[0]} twice",
            expected="each column once",
            remedy="Export the take again.",
        )
    table.columns = names
    if missing := [name for name in text if name not in table]:
        raise MissingColumn(
            path,
            place="line 1",
            found="no such column",
            expected=", ".join(missing),
            remedy="Export the take with all its columns, or correct ingest.format.",
        )
    return table


def numbers(
    table: pd.DataFrame, columns: list[str], path: Path, bad_values: str, blank_ok: bool = False
) -> tuple[pd.DataFrame, np.ndarray]:
    """The columns as floats, and which rows held something else.

    bad_values: "fail" raises BadFile at the first bad cell, "mask" gives NaN and marks the row.
    blank_ok: an empty cell is a value that the tracker does not give, no bad one.
    """
    values = table[columns].apply(pd.to_numeric, errors="coerce").astype(float)
    bad = ~np.isfinite(values.to_numpy())
    if blank_ok:
        bad &= (table[columns] != "").to_numpy()
    if bad.any() and bad_values == "fail":
        row, column = np.argwhere(bad)[0]
        raise BadFile(
            path,
            place=f"line {table.index[row] + 2}, column {columns[column]}",
            found=repr(table[columns[column]].iloc[row]),
            expected="a number",
            remedy="Fix the cell, or set ingest.bad_values: mask to treat the frame as a gap.",
        )
    return values.where(np.isfinite(values)), bad.any(axis=1)


def expressions(values: pd.DataFrame, path: Path) -> pd.DataFrame:
    """The ARKit channels among the columns, by name. Raises BadFile far outside of [0, 1]."""
    named = values.rename(columns={c: n for c in values if (n := canonical(c)) in EXPRESSIONS})
    named = named[[name for name in EXPRESSIONS if name in named]]
    low, high = EXPRESSION_RANGE
    outside = ((named < low) | (named > high)).to_numpy()
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise BadFile(
            path,
            place=f"line {row + 2}, column {named.columns[column]}",
            found=f"{named.iat[row, column]:g}",
            expected="a coefficient between 0 and 1",
            remedy="Divide by 100 where the export is in per cent; else export the take again.",
        )
    return named


def angles(values: pd.DataFrame, unit: str, path: Path, remedy: str) -> pd.DataFrame:
    """Angles in radians; a column that is 0 wherever it is a number was never measured: NaN.

    unit: "radians" or "degrees". remedy: what to do where an angle is beyond half a turn.
    """
    values = values.copy()
    values.loc[:, ((values == 0) | values.isna()).all(axis=0)] = np.nan
    radians = np.radians(values) if unit == "degrees" else values
    if (radians.abs() > np.pi).to_numpy().any():
        raise BadFile(
            path,
            found=f"an angle of {float(np.nanmax(values.abs())):.3g} in {unit}",
            expected="angles within half a turn",
            remedy=remedy,
        )
    return radians


def on_clock(motion: pd.DataFrame, n_frames: int) -> pd.DataFrame:
    """One row per frame of the clock; frames without a row are not valid and hold no number."""
    motion = motion.set_index("frame").reindex(pd.RangeIndex(n_frames, name="frame"))
    motion["valid"] = motion["valid"].fillna(False).astype(bool)
    return motion.reset_index()


def assemble(
    frame: np.ndarray,
    valid: np.ndarray,
    channels: pd.DataFrame,
    confidence: np.ndarray | float,
    path: Path,
) -> pd.DataFrame:
    """Rows of a take in the motion table's columns; channels that are absent are NaN.

    frame: increasing whole numbers. Raises BadFile for a take that no memory holds.
    """
    if frame[-1] >= MOST_FRAMES:
        raise BadFile(
            path,
            found=f"frame {frame[-1]}",
            expected=f"less than {MOST_FRAMES} frames in a take",
            remedy="Mend the frame numbers or timecodes, or split the take.",
        )
    motion = channels.reindex(columns=list(CHANNELS)).astype("float32")
    motion[~np.asarray(valid)] = np.nan
    head = pd.DataFrame({"frame": frame, "valid": valid, "confidence": confidence})
    head["tracker_loss"] = np.nan
    return on_clock(pd.concat([head, motion.reset_index(drop=True)], axis=1), int(frame.max()) + 1)
