"""The failsafe of Höll 2024, 5.1, rule 4: a clip goes where a frame's tracking loss is too large.

The loss is the tracker's own, told beside its result, else how far the landmarks that it found in
the picture lie from where its head has them (reprojection.py).
"""

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, MissingColumn, unreadable
from mimeline.tracking.take import REPROJECTION, Take

OWN = "the tracker's own"
LEAST_COVERED = 0.9  # share of frames that a rule was applied to, below which the ledger says so
MOST_BYTES = 1 << 28  # of a sidecar; metrical-tracker's log has some 1.5 kB a frame
FRAME = re.compile("[0-9]{1,9}")
LOGGED = re.compile(r"\[frame (\d{1,9})\] = .*\ball_loss=([^\s]{1,32})")


def sidecar(path: Path) -> pd.Series | None:
    """The tracker's own loss beside a take, by frame from 0; None where there is none.

    Of a file: <name>.loss.csv beside it. Of a folder: loss.csv in it, else metrical-tracker's
    train.log in it or beside its folder `checkpoint`; the last that the log says of a frame counts.
    A loss of NaN is infinite: it came to nothing.
    Raises BadFile or MissingColumn for one that cannot be read.
    """
    path = Path(path)
    if not path.is_dir():
        table = path.with_name(f"{path.stem}.loss.csv")
        return _of_table(table) if table.is_file() else None
    if (table := path / "loss.csv").is_file():
        return _of_table(table)
    logs = [path / "train.log"]
    if path.name == "checkpoint":
        logs.append(path.parent / "train.log")
    return next((_of_log(log) for log in logs if log.is_file()), None)


def _of_table(path: Path) -> pd.Series:
    expected = "a CSV table with columns frame and loss"
    remedy = "Write it again, or take it away: then the rule on the tracking loss is not applied."
    _refuse_large(path, expected, remedy)
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = csv.reader(file, strict=True)
            header = [name.strip() for name in next(rows, [])]
            cells = [(rows.line_num, row) for row in rows if row]
    except (ValueError, OSError, csv.Error) as error:
        raise unreadable(path, error, expected=expected, remedy=remedy) from error
    if [header.count(name) for name in ("frame", "loss")] != [1, 1]:
        found = ", ".join(header)[:80] or "no header"
        raise MissingColumn(path, place="line 1", found=found, expected=expected, remedy=remedy)
    at = header.index("frame"), header.index("loss")
    losses: dict[int, float] = {}
    for line, row in cells:
        place = f"line {line}"
        frame, text = (row[column].strip() if column < len(row) else "" for column in at)
        if len(row) != len(header) or not FRAME.fullmatch(frame) or int(frame) in losses:
            raise BadFile(
                path,
                place=place,
                found=", ".join(row)[:80],
                expected="the header's columns, and whole numbers of frames from 0 on, each once",
                remedy=remedy,
            )
        losses[int(frame)] = _number(text, path, place, remedy) if text else math.nan
    return pd.Series(losses, dtype=float, name="loss").sort_index()


def _of_log(path: Path) -> pd.Series | None:
    """What metrical-tracker logs: its whole loss where the finest level of a frame begins."""
    expected, remedy = "metrical-tracker's log", "Take it away: then the rule is not applied."
    _refuse_large(path, expected, remedy)
    losses: dict[int, float] = {}
    try:
        with open(path, encoding="utf-8", errors="replace") as lines:
            for number, line in enumerate(lines, start=1):
                if told := LOGGED.search(line):
                    losses[int(told[1])] = _number(told[2], path, f"line {number}", remedy)
    except OSError as error:
        raise unreadable(path, error, expected=expected, remedy=remedy) from error
    return pd.Series(losses, dtype=float, name="loss").sort_index() if losses else None


def _number(text: str, path: Path, place: str, remedy: str) -> float:
    """The loss; one that came to nothing is infinite and breaks every limit."""
    try:
        loss = float(text)
    except ValueError as error:
        raise BadFile(
            path, place=place, found=repr(text), expected="a loss", remedy=remedy
        ) from error
    return loss if math.isfinite(loss) else math.inf


def _refuse_large(path: Path, expected: str, remedy: str) -> None:
    if (size := path.stat().st_size) > MOST_BYTES:
        raise BadFile(
            path,
            found=f"{size} bytes",
            expected=f"{expected} of at most {MOST_BYTES} bytes",
            remedy=remedy,
        )


def with_loss(take: Take, path: Path, max_loss: float | None) -> Take:
    """The take with the tracker's own loss, where a sidecar of the take at path tells it.

    A column of the take's wins over it; so does what was worked out from landmarks, unless the
    tracker's own has a limit. A frame that it leaves out or leaves blank has none.
    Raises BadFile where it tells more frames than the take has; one more is right, since a tracker
    that is stopped has logged a frame which it did not write.
    """
    if take.loss and (take.loss != REPROJECTION or max_loss is None):
        return take
    told = sidecar(path)
    if told is None:
        return take
    n_frames = len(take.motion)
    if len(told) and told.index[-1] > n_frames:
        raise BadFile(
            path,
            place="the tracking loss beside it",
            found=f"frame {told.index[-1]}",
            expected=f"frames 0 to {n_frames - 1}, as the result has",
            remedy="Put the loss of this very result beside it, its frames counted from 0.",
        )
    losses = told.reindex(take.motion["frame"]).to_numpy()
    return replace(take, motion=take.motion.assign(tracker_loss=losses), loss=OWN)


def broken(take: Take, max_loss: float | None, max_reprojection: float | None) -> dict | None:
    """Ledger facts where a frame's loss is beyond its limit, else None.

    max_loss: of the tracker's own loss; max_reprojection: of the landmarks'. None: no limit. The
    loss of a frame that is not valid counts, too.
    """
    limit = max_reprojection if take.loss == REPROJECTION else max_loss
    losses = take.motion["tracker_loss"].to_numpy(float)
    if not take.loss or limit is None or not (losses > limit).any():
        return None
    beyond = take.motion["frame"].to_numpy()[losses > limit]
    return {
        "value": float(np.nanmax(losses)),
        "limit": limit,
        "unit": "eye distances" if take.loss == REPROJECTION else "the tracker's unit",
        "first_frame": int(beyond[0]),
        "last_frame": int(beyond[-1]),
        "detail": take.loss,
    }


def not_applied(take: Take, max_loss: float | None, max_reprojection: float | None) -> str | None:
    """Why the rule could not be applied to a take, "not applied: ...", or to how many of its valid
    frames it was, where these are few; None where there is nothing to say.
    """
    told, valid = take.motion["tracker_loss"].notna(), take.motion["valid"]
    if not take.loss or not told.any():
        return f"not applied: {take.no_loss or 'the tracker gives no loss'}"
    if take.loss == REPROJECTION and max_reprojection is None:
        return "not applied: no limit is set: ingest.max_reprojection"
    if take.loss != REPROJECTION and max_loss is None:
        return "not applied: no limit is set: ingest.max_loss"
    if (covered := (told & valid).sum()) < LEAST_COVERED * valid.sum():
        return f"applied to the {covered} of {valid.sum()} frames with a loss"
    return None
