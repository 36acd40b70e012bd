import numpy as np
import pandas as pd
import pytest

from mimeline.vocabulary import EXPRESSIONS


@pytest.fixture
def livelink_rows() -> pd.DataFrame:
    """Four rows at 30 fps whose timecode counts 60ths; the last comes a frame late."""
    rng = np.random.default_rng(0)
    values = {name[0].upper() + name[1:]: rng.uniform(0, 1, 4).round(4) for name in EXPRESSIONS}
    angles = {
        "HeadYaw": 0.1,
        "HeadPitch": 0.2,
        "HeadRoll": 0.3,
        "LeftEyeYaw": 0.1,
        "LeftEyePitch": -0.2,
        "LeftEyeRoll": 0.0,
        "RightEyeYaw": 0.3,
        "RightEyePitch": -0.4,
        "RightEyeRoll": 0.0,
    }
    times = [f"10:00:00:{tick:02d}.500" for tick in (56, 58)] + ["10:00:01:00.500", "10:00:01:04.5"]
    return pd.DataFrame({"Timecode": times, "BlendShapeCount": 61, **values, **angles})


@pytest.fixture
def pyfeat_rows() -> pd.DataFrame:
    """Three rows of every second frame, from frame 4 on."""
    rng = np.random.default_rng(1)
    names = [name for name in EXPRESSIONS if name != "tongueOut"]
    values = {name: rng.uniform(0, 1, 3).round(4) for name in ("_neutral", *names)}
    angles = {"Pitch": 0.1, "Roll": 0.2, "Yaw": 0.3, "gaze_pitch": 0.4, "gaze_yaw": 0.5}
    return pd.DataFrame(
        {"FaceScore": 0.9, **angles, **values, "input": "x.mp4", "frame": [4, 6, 8]}
    )
