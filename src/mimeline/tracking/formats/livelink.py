"""Live Link Face CSV: 52 coefficients, head and eye rotations, a timecode per row."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from mimeline.atomic import whole
from mimeline.errors import BadFile, MissingColumn
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.columns import (
    all_origins,
    angles,
    by_channel,
    expressions,
    header_of,
    line_of,
    numbers,
    read_columns,
)
from mimeline.tracking.take import Take, assemble
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, GAZE, HEAD, canonical

DAY_S = 24 * 3600
TOO_FAST = 0.75  # frames between two rows, below which the take has another rate
FORGET = 0.5  # of what a row owes the clock, from row to row
TIMECODE = r"^(?P<h>\d\d?):(?P<m>[0-5]?\d):(?P<s>[0-5]?\d)(?P<drop>[:;])(?P<ticks>\d+(?:\.\d+)?)$"

SIDES = ("Left", "Right")
SHAPES: tuple[str, ...] = (
    *(
        f"Eye{part}{side}"
        for side in SIDES
        for part in ("Blink", "LookDown", "LookIn", "LookOut", "LookUp", "Squint", "Wide")
    ),
    *("JawForward", "JawRight", "JawLeft", "JawOpen"),
    *("MouthClose", "MouthFunnel", "MouthPucker", "MouthRight", "MouthLeft"),
    *(f"Mouth{part}{side}" for part in ("Smile", "Frown", "Dimple", "Stretch") for side in SIDES),
    *("MouthRollLower", "MouthRollUpper", "MouthShrugLower", "MouthShrugUpper"),
    *(f"Mouth{part}{side}" for part in ("Press", "LowerDown", "UpperUp") for side in SIDES),
    *("BrowDownLeft", "BrowDownRight", "BrowInnerUp", "BrowOuterUpLeft", "BrowOuterUpRight"),
    *("CheekPuff", "CheekSquintLeft", "CheekSquintRight", "NoseSneerLeft", "NoseSneerRight"),
    "TongueOut",
)
ROTATIONS = tuple(
    f"{part}{axis}" for part in ("Head", "LeftEye", "RightEye") for axis in ("Yaw", "Pitch", "Roll")
)
HEADER = ("Timecode", "BlendShapeCount", *SHAPES, *ROTATIONS)

ENDINGS = (".csv",)
CONVENTION = Convention(
    title="Live Link Face CSV",
    files="<name>.csv",
    coefficients="52 ARKit coefficients in [0, 1], PascalCase or camelCase, Left/Right or _L/_R, "
    "found by name; 51 where the export leaves TongueOut out",
    axes="a left-handed rotator: +X out of the back of the head, +Y to the subject's left, +Z up",
    rotation="yaw, then pitch, then roll, of the head and of each eye in the head",
    angle_unit="radians in takes of the app, degrees in some exports: ingest.livelink.angle_unit",
    sides="the subject's",
    first_frame=None,
    gap="a jump of the timecode",
    never="a head or eye column that is 0 throughout",
    evidence="eyes: yaw and pitch of a real take against the eyeLook coefficients (r below -.99 "
    "with looking left and up). Head: derived, from the rotator that gives the eyes their measured "
    "signs; no real take with a moving head was at hand, and users of other importers report "
    "inverted yaw and pitch from a phone held sideways.",
    signs={
        "HeadYaw": ("head_yaw_left", -1.0),
        "HeadPitch": ("head_pitch_up", -1.0),
        "HeadRoll": ("head_tilt_left", 1.0),
        "LeftEyeYaw": ("gaze_left", -1.0),
        "RightEyeYaw": ("gaze_left", -1.0),
        "LeftEyePitch": ("gaze_up", -1.0),
        "RightEyePitch": ("gaze_up", -1.0),
    },
)
SIGNS = dict(CONVENTION.signs.values())  # of each angle, the same for both eyes


def holds(path: Path) -> bool:
    """Whether the file's header is one of this format's."""
    names = header_of(path)
    timed = any(name.casefold() == "timecode" for name in names)
    return timed and any(canonical(name) for name in names)


def read(path: Path, fps: str, timecode_base: int, angle_unit: str, bad_values: str) -> Take:
    """Read a take; its frames are counted by timecode, so dropped ones leave a gap.

    fps: rate of the take, "30" or "30000/1001". timecode_base: what the timecode's last field
    counts in, frames per second. angle_unit: "radians" or "degrees". bad_values: "fail" or "mask".
    Raises BadFile or MissingColumn with line and column.
    """
    table = read_columns(path, text=("Timecode",), known=(*ROTATIONS, "BlendShapeCount"))
    if table.empty:
        raise BadFile(
            path, found="a header alone", expected="at least a frame", remedy="Export it again."
        )
    columns = [name for name in table if name not in ("Timecode", "BlendShapeCount")]
    if not any(canonical(name) in EXPRESSIONS or name in ROTATIONS for name in columns):
        raise MissingColumn(
            path,
            place="line 1",
            found="no column of a coefficient",
            expected="columns as EyeBlinkLeft",
            remedy="Export the take with all its columns, or correct ingest.format.",
        )
    if "BlendShapeCount" in table:
        _check_count(table, columns, path, bad_values)
    frame = _frames(table["Timecode"], Fraction(fps), timecode_base, path)
    values, bad = numbers(table, columns, path, bad_values)
    channels = expressions(values, path)
    remedy = "Set ingest.livelink.angle_unit: degrees."
    if angle_unit == "degrees":
        remedy = "Export the take again."
    rotations = [column for column in CONVENTION.signs if column in values]
    radians = angles(values[rotations], angle_unit, path, remedy)
    turns, origins = by_channel(radians, CONVENTION.signs)
    motion = assemble(frame, ~bad, channels.join(turns), np.nan, path)
    return Take(motion, Fraction(fps), origins=all_origins(columns, origins), numbered=True)


def write(
    path: Path, motion: pd.DataFrame, fps: Fraction, start: float = 0.0, timecode_base: int = 60
) -> list[str]:
    """Write a motion as a Live Link Face take, radians; reading it gives the motion again.

    motion: rows of table `motion`. Frames that are not valid are left out, which reading gives back
    as a gap, but for those before the first valid frame and after the last.
    fps: its rate. start: time of day of frame 0, seconds since midnight. timecode_base: what the
    timecode's last field counts in.
    Returns the channels that are not measured in some valid frame: the file cannot say so and has 0
    there (an angle that is 0 throughout is read as not measured). Raises BadFile for a motion
    without a valid frame.
    """
    valid = motion[motion["valid"].to_numpy(bool)]
    if valid.empty:
        raise BadFile(
            path,
            found="a motion without a valid frame",
            expected="at least one",
            remedy="Write a motion in which a face was tracked.",
        )
    unmeasured = [name for name in CHANNELS if valid[name].isna().any()]
    ticks = timecode_base / round(fps)
    known = valid.fillna(dict.fromkeys(unmeasured, 0.0))
    told = lines(known, start * timecode_base, ticks, timecode_base)
    with whole(path) as temporary:
        temporary.write_text("\n".join(told) + "\n", encoding="utf-8", newline="")
    return unmeasured


def lines(
    motion: pd.DataFrame, start: float, step: float, base: int = 60, vergence: float = 0.0
) -> list[str]:
    """The file's lines, header first, for the rows of a motion.

    motion: frame and every channel. start: timecode of frame 0, in ticks of 1/base s since
    midnight. step: ticks from frame to frame. vergence: radians that each eye turns in.
    """
    shapes = motion[[canonical(shape) for shape in SHAPES]].to_numpy(float)
    head = [SIGNS[name] * motion[name].to_numpy(float) for name in HEAD]
    yaw, pitch = (SIGNS[name] * motion[name].to_numpy(float) for name in GAZE)
    none = np.zeros(len(motion))
    eyes = (yaw + vergence, pitch, none, yaw - vergence, pitch, none)
    values = np.column_stack([shapes, *head, *eyes]) + 0.0  # no minus before a zero
    count = values.shape[1]
    row = ",".join(["%.10f"] * count)
    return [
        ",".join(HEADER),
        *(
            f"{_timecode(start + frame * step, base)},{count},{row % tuple(numbers)}"
            for frame, numbers in zip(motion["frame"], values.tolist(), strict=True)
        ),
    ]


def _timecode(at: float, base: int) -> str:
    thousandths = round(at * 1000) % (DAY_S * base * 1000)
    seconds, rest = divmod(thousandths, base * 1000)
    hours, minutes = seconds // 3600, seconds // 60 % 60
    return f"{hours:02d}:{minutes:02d}:{seconds % 60:02d}:{rest // 1000:02d}.{rest % 1000:03d}"


def _check_count(table: pd.DataFrame, columns: list[str], path: Path, bad_values: str) -> None:
    """BlendShapeCount counts the coefficients, or the rotations with them."""
    told, _ = numbers(table, ["BlendShapeCount"], path, bad_values, blank_ok=True)
    told = told["BlendShapeCount"].to_numpy()
    shapes = sum(canonical(name) in EXPRESSIONS for name in columns)
    wrong = ~np.isin(told, (shapes, len(columns))) & ~np.isnan(told)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise BadFile(
            path,
            place=f"line {line_of(path, row)}, column BlendShapeCount",
            found=f"{told[row]:g}",
            expected=f"{shapes} or {len(columns)}, the columns of the header",
            remedy="Export the take again, or remove the column where the header is right.",
        )


def _frames(timecodes: pd.Series, fps: Fraction, base: int, path: Path) -> np.ndarray:
    """Frame numbers from 0 of the rows, by their timecodes."""
    seconds, day = _seconds(timecodes, base, path)
    since_last = np.mod(np.diff(seconds), day)  # a take may cross midnight
    rate = round(fps)  # timecode counts whole frames: 30 for 30000/1001
    backward = (since_last <= 0) | (since_last > day / 2)
    median = float(np.median(since_last)) if len(since_last) else 1 / rate
    if backward.any() or median * rate < TOO_FAST:
        row = int(np.argmax(backward)) + 1
        remedy = "Export the take again, its frames in their order."
        if median == 0:
            remedy = "Most rows share their timecode: export the take again, with frames in it."
        elif median <= day / 2:
            remedy = (
                f"The rows come at about {1 / median:.0f} per second: where that is not so, set "
                "ingest.livelink.fps to the take's rate, or ingest.livelink.timecode_base to what "
                "the timecode counts in; else export the take again."
            )
        raise BadFile(
            path,
            place=f"line {line_of(path, row)}, column Timecode",
            found=f"{timecodes.iloc[row]!r} after {timecodes.iloc[row - 1]!r}",
            expected=f"a later frame at {fps} fps",
            remedy=remedy,
        )
    steps = _steps(since_last * rate)
    if len(steps) and (stride := int(np.quantile(steps, 0.1, method="lower"))) > 1:
        raise BadFile(
            path,
            place="column Timecode",
            found=f"a row every {stride} frames",
            expected=f"{fps} rows per second",
            remedy=f"Set ingest.livelink.fps to {rate / stride:g}, or "
            "ingest.livelink.timecode_base to what the timecode counts in.",
        )
    return np.concatenate([[0], np.cumsum(steps)])


def _seconds(timecodes: pd.Series, base: int, path: Path) -> tuple[np.ndarray, float]:
    """What has been counted since midnight, in seconds of `base` ticks, and what a day counts.

    HH:MM:SS:FF or HH:MM:SS:FF.sub; in HH:MM:SS;FF the first labels of a minute are left out but in
    every tenth (drop-frame counting, SMPTE ST 12-1): 2 of 30, 4 of 60.
    """
    parts = pc.extract_regex(pa.array(timecodes), TIMECODE)
    hours, minutes, seconds, ticks = (
        pc.struct_field(parts, name).cast("float64").to_numpy(zero_copy_only=False)
        for name in ("h", "m", "s", "ticks")
    )
    drops = pc.equal(pc.struct_field(parts, "drop"), ";").fill_null(False)
    drops = drops.to_numpy(zero_copy_only=False)
    dropped = base // 30 * 2 if drops[0] else 0
    left_out = (minutes % 10 != 0) & (seconds == 0) & (ticks < dropped)
    for wrong, expected, remedy in (
        (np.isnan(ticks), "HH:MM:SS:FF", "Export the take again."),
        (
            ~(ticks < base) | (hours >= 24),
            f"a time of day whose last field is below {base}",
            "Set ingest.livelink.timecode_base to what the timecode counts in.",
        ),
        (drops != drops[0], "the same mark before FF in every row", "Export the take again."),
        (
            left_out | (drops & (base % 30 != 0)),
            "drop-frame counting of 30 or 60, as ';' says",
            "Set ingest.livelink.timecode_base to what the timecode counts in, or write ':' "
            "where no label is left out.",
        ),
    ):
        if wrong.any():
            row = int(np.argmax(wrong))
            raise BadFile(
                path,
                place=f"line {line_of(path, row)}, column Timecode",
                found=repr(timecodes.iloc[row]),
                expected=expected,
                remedy=remedy,
            )
    minutes = 60 * hours + minutes
    ticks = ticks - dropped * (minutes - minutes // 10)
    return seconds + 60 * minutes + ticks / base, DAY_S - dropped * 24 * 54 / base


def _steps(elapsed: np.ndarray) -> np.ndarray:
    """Whole frames from row to row, of the frames that the timecode says have passed.

    Row by row: a phone's camera runs a little off its timecode, and a row may come half a frame
    early or late. What rounding left over is made up for by the next row, and soon forgotten.
    """
    steps, owed = np.empty(len(elapsed), dtype="int64"), 0.0
    for row, passed in enumerate(elapsed.tolist()):
        due = passed + owed
        steps[row] = step = max(1, round(due))
        owed = FORGET * min(0.5, max(-0.5, due - step))
    return steps
