"""Live Link Face CSV, written as the app writes it: 61 values, timecode in 60ths."""

import numpy as np
import pandas as pd

from mimeline.vocabulary import EXPRESSIONS

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

assert {shape[0].lower() + shape[1:] for shape in SHAPES} == set(EXPRESSIONS)

BASE = 60  # what the timecode counts in, per second
STEP = 2 - 0.00027  # 60ths between two frames at 30 fps: the phone's clock runs a little fast
VERGENCE = 0.03  # radians that each eye turns in


def timecode_start(rng: np.random.Generator) -> float:
    """A time of day at which a take may begin, in 60ths since midnight."""
    return float(rng.uniform(8 * 3600, 18 * 3600) * BASE)


def lines(motion: pd.DataFrame, start: float) -> list[str]:
    """The file's lines, header first, for one clip's rows of table `motion`.

    start: timecode of the first frame, in 60ths since midnight. Signs as in real takes: yaw to the
    subject's right, pitch down, roll to the left shoulder; radians.
    """
    shapes = motion[[shape[0].lower() + shape[1:] for shape in SHAPES]].to_numpy(float)
    yaw, pitch, roll = (
        motion[name].to_numpy(float)
        for name in ("head_yaw_left", "head_pitch_up", "head_tilt_left")
    )
    right, down = -motion["gaze_left"].to_numpy(float), -motion["gaze_up"].to_numpy(float)
    none = np.zeros(len(motion))
    head = (-yaw, -pitch, roll)
    eyes = (right + VERGENCE, down, none, right - VERGENCE, down, none)
    values = np.column_stack([shapes, *head, *eyes]) + 0.0  # no minus before a zero
    row = ",".join(["%.10f"] * values.shape[1])
    count = values.shape[1]
    return [
        ",".join(HEADER),
        *(
            f"{_timecode(start + frame * STEP)},{count},{row % tuple(numbers)}"
            for frame, numbers in zip(motion["frame"], values.tolist(), strict=True)
        ),
    ]


def _timecode(at: float) -> str:
    thousandths = round(at * 1000)
    seconds, rest = divmod(thousandths, BASE * 1000)
    hours, minutes = seconds // 3600, seconds // 60 % 60
    return f"{hours:02d}:{minutes:02d}:{seconds % 60:02d}:{rest // 1000:02d}.{rest % 1000:03d}"
