"""How fast Live Link Face takes are read on one core, beside pandas.read_csv on the same file.

python benchmarks/reading.py [--take FILE] [--frames 100000] [--repeats 5]

The take is read as it is, and repeated with timecodes that go on until it has so many frames;
without one, a take of smooth random channels is written in its place. Reading a take is all of it:
parsing, timecodes, checks of ranges, the motion table. pandas.read_csv only parses. Both take turns
on one core and in one thread; seconds are the processor's, the least of several runs.
"""

import argparse
import os
import tempfile
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.tracking.formats import livelink
from mimeline.vocabulary import CHANNELS

LIMIT = 100_000  # frames per second
OPTIONS = {"fps": "30", "timecode_base": 60, "angle_unit": "radians", "bad_values": "fail"}
TICKS_OF_A_DAY = 24 * 3600 * 60_000  # thousandths of 60ths


def smooth_take(path: Path, n_frames: int) -> None:
    """A take of channels that wander between -1 and 1, or 0 and 1."""
    turn = np.arange(n_frames)[:, None] / 30 + np.arange(len(CHANNELS))  # (n_frames, n_channels)
    motion = pd.DataFrame(0.5 + 0.5 * np.sin(turn), columns=list(CHANNELS))
    motion.insert(0, "frame", np.arange(n_frames))
    livelink.write(path, motion.assign(valid=True), Fraction(30), start=3600)


def repeated(take: Path, path: Path, n_frames: int) -> None:
    """The take over and over, with timecodes that go on."""
    header, *rows = take.read_text(encoding="utf-8-sig").splitlines()
    timecodes, cells = zip(*(row.split(",", 1) for row in rows if row), strict=True)
    ticks = np.array([_ticks(timecode) for timecode in timecodes])
    around, row = np.divmod(np.arange(n_frames), len(ticks))
    at = ticks[row] + around * (ticks[-1] - ticks[0] + 2000)
    told = [f"{_timecode(int(t))},{cells[r]}" for t, r in zip(at, row, strict=True)]
    path.write_text("\n".join([header, *told]) + "\n", encoding="utf-8", newline="")


def _ticks(timecode: str) -> int:
    hours, minutes, seconds, frame = timecode.split(":")
    whole = (int(hours) * 60 + int(minutes)) * 60 + int(seconds)
    return whole * 60_000 + round(float(frame) * 1000)


def _timecode(ticks: int) -> str:
    seconds, rest = divmod(ticks % TICKS_OF_A_DAY, 60_000)
    clock = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"
    return f"{clock}:{rest // 1000:02d}.{rest % 1000:03d}"


def seconds(works, repeats: int) -> list[float]:
    """Processor time of each of some works, which take turns; the first turn is not counted."""
    shortest = [np.inf] * len(works)
    for turn in range(repeats + 1):
        for at, work in enumerate(works):
            start = time.process_time()
            work()
            if turn:
                shortest[at] = min(shortest[at], time.process_time() - start)
    return shortest


def compare(path: Path, repeats: int) -> None:
    n_rows = len(pd.read_csv(path))
    ours, pandas = seconds(
        (lambda: livelink.read(path, **OPTIONS), lambda: pd.read_csv(path)), repeats
    )
    print(
        f"{path.name}: {n_rows} rows, {path.stat().st_size / 1e6:.1f} MB:  "
        f"take {n_rows / ours:8.0f} frames/s, {n_rows / ours / LIMIT:.1f} x the limit of {LIMIT}; "
        f"pandas.read_csv {n_rows / pandas:8.0f}, {ours / pandas:.1f} x as fast"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--take", type=Path)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    pd.set_option("mode.max_threads", 1)
    with tempfile.TemporaryDirectory() as folder:
        take = arguments.take
        if take is None:
            take = Path(folder) / "short.csv"
            smooth_take(take, 4000)
        compare(take, arguments.repeats)
        long = Path(folder) / "long.csv"
        repeated(take, long, arguments.frames)
        compare(long, arguments.repeats)


if __name__ == "__main__":
    main()
