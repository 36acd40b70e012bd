"""Live Link Face CSV: 52 coefficients, head and eye rotations, a timecode per row.

Signs, measured on a real take by correlation with the eyeLook coefficients (|r| > .99): an eye's
yaw is positive toward the subject's right, its pitch positive downward. The head's three angles
come from the same rotator, in which roll is positive toward the subject's left shoulder.
"""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.tracking.columns import angles, expressions, numbers, read_columns
from mimeline.tracking.convention import Convention
from mimeline.tracking.take import Take, assemble

DAY_S = 24 * 3600
TOO_FAST = 0.75  # frames between two rows, below which the take has another rate
FORGET = 0.5  # of what a row owes the clock, from row to row
HEAD_SIGNS = {
    "HeadYaw": ("head_yaw_left", -1.0),
    "HeadPitch": ("head_pitch_up", -1.0),
    "HeadRoll": ("head_tilt_left", 1.0),
}
EYES = {"gaze_left": ("LeftEyeYaw", "RightEyeYaw"), "gaze_up": ("LeftEyePitch", "RightEyePitch")}

ENDINGS = (".csv",)
CONVENTION = Convention(
    title="Live Link Face CSV",
    files="<name>.csv",
    coefficients="",
    axes="",
    rotation="",
    angle_unit="radians",
    sides="the subject's",
    first_frame=None,
    gap="",
    never="",
    evidence="",
)


def holds(path: Path) -> bool:
    """Whether the file's header is one of this format's."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            return "Timecode" in file.readline(100_000)
    except (OSError, ValueError):
        return False


def read(path: Path, fps: str, timecode_base: int, angle_unit: str, bad_values: str) -> Take:
    """Read a take; its frames are counted by timecode, so dropped ones leave a gap.

    fps: rate of the take, "30" or "30000/1001". timecode_base: what the timecode's last field
    counts in, frames per second. angle_unit: "radians" or "degrees". bad_values: "fail" or "mask".
    Raises BadFile or MissingColumn with line and column.
    """
    table = read_columns(path, text=("Timecode",))
    if table.empty:
        raise BadFile(
            path, found="a header alone", expected="at least a frame", remedy="Export it again."
        )
    frame = _frames(table["Timecode"], Fraction(fps), timecode_base, path)
    columns = [name for name in table if name not in ("Timecode", "BlendShapeCount")]
    values, bad = numbers(table, columns, path, bad_values)
    channels = expressions(values, path)

    rotations = [
        name for name in values if name in (*HEAD_SIGNS, *EYES["gaze_left"], *EYES["gaze_up"])
    ]
    remedy = "Set ingest.livelink.angle_unit: degrees."
    if angle_unit == "degrees":
        remedy = "Export the take again."
    radians = angles(values[rotations], angle_unit, path, remedy)
    for column, (name, sign) in HEAD_SIGNS.items():
        if column in radians:
            channels[name] = sign * radians[column]
    for name, pair in EYES.items():
        if set(pair) <= set(radians):
            channels[name] = -radians[list(pair)].mean(axis=1, skipna=False)
    return Take(assemble(frame, ~bad, channels, np.nan, path), Fraction(fps))


def _frames(timecodes: pd.Series, fps: Fraction, base: int, path: Path) -> np.ndarray:
    """Frame numbers from 0. HH:MM:SS:FF or HH:MM:SS:FF.fff counts FF in `base` per second."""
    parts = timecodes.str.extract(r"^(\d+):(\d+):(\d+)[:;](\d+(?:\.\d+)?)$").astype(float)
    if parts.isna().to_numpy().any():
        row = int(parts.isna().any(axis=1).to_numpy().argmax())
        raise BadFile(
            path,
            place=f"line {row + 2}, column Timecode",
            found=repr(timecodes.iloc[row]),
            expected="HH:MM:SS:FF",
            remedy="Export the take again.",
        )
    hours, minutes, seconds, ticks = parts.to_numpy().T
    seconds += 3600 * hours + 60 * minutes + ticks / base
    since_last = np.mod(np.diff(seconds), DAY_S)  # a take may cross midnight
    rate = round(fps)  # timecode counts whole frames: 30 for 30000/1001
    backward = (since_last <= 0) | (since_last > DAY_S / 2)
    median = float(np.median(since_last)) if len(since_last) else 1 / rate
    if backward.any() or median * rate < TOO_FAST:
        row = int(np.argmax(backward)) + 1
        raise BadFile(
            path,
            place=f"line {row + 2}, column Timecode",
            found=f"{timecodes.iloc[row]!r} after {timecodes.iloc[row - 1]!r}",
            expected=f"a later frame at {fps} fps",
            remedy=f"The rows come at about {1 / max(median, 1e-3):.0f} per second: where that is "
            "not so, set ingest.livelink.fps to the take's rate, or ingest.livelink.timecode_base "
            "to what the timecode counts in; else export the take again.",
        )
    steps = _steps(since_last * rate)
    if len(steps) and (stride := int(np.median(steps))) > 1:
        raise BadFile(
            path,
            place="column Timecode",
            found=f"a row every {stride} frames",
            expected=f"{fps} rows per second",
            remedy=f"Set ingest.livelink.fps to {rate / stride:g}, or "
            "ingest.livelink.timecode_base to what the timecode counts in.",
        )
    return np.concatenate([[0], np.cumsum(steps)])


def _steps(elapsed: np.ndarray) -> np.ndarray:
    """Whole frames from row to row, of the frames that the timecode says have passed.

    Row by row: a phone's camera runs a little off its timecode, and a row may come half a frame
    early or late. What rounding left over is made up for by the next row, and soon forgotten.
    """
    steps, owed = np.empty(len(elapsed), dtype="int64"), 0.0
    for row, passed in enumerate(elapsed):
        steps[row] = max(1, round(passed + owed))
        owed = FORGET * float(np.clip(passed + owed - steps[row], -0.5, 0.5))
    return steps
