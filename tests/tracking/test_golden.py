"""Every format's reader against small takes that were made from the format's published geometry.

Of py-feat no axes are published, and those of a table are its user's: their takes repeat our own
reading and hold the reader to it, without proving it. What speaks for py-feat's signs is in
test_pyfeat.py, on the tables that py-feat publishes.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from mimeline.tracking.readers import READERS
from mimeline.tracking.take import Take
from mimeline.vocabulary import CHANNELS, GAZE, HEAD

GOLDEN = Path(__file__).parent / "golden"
BLINKS = ("eyeBlinkLeft", "eyeBlinkRight")
ANGLE, COEFFICIENT = 0.3, 0.9  # how far a take goes, radians and of a coefficient
AT_REST = 0.02  # of what else moves
MOVES = {  # name of a take → channels, and how far each goes in it
    "turns_left": {"head_yaw_left": ANGLE},
    "turns_right": {"head_yaw_left": -ANGLE},
    "lifts_head": {"head_pitch_up": ANGLE},
    "tilts_left": {"head_tilt_left": ANGLE},
    "tilts_right": {"head_tilt_left": -ANGLE},
    "looks_left": {"gaze_left": ANGLE},
    "looks_right": {"gaze_left": -ANGLE},
    "looks_up": {"gaze_up": ANGLE},
    "closes_left_eye": {"eyeBlinkLeft": COEFFICIENT},
    "closes_right_eye": {"eyeBlinkRight": COEFFICIENT},
}
LOOKS = {  # where the coefficients tell it
    "looks_left": {"eyeLookOutLeft": COEFFICIENT, "eyeLookInRight": COEFFICIENT},
    "looks_right": {"eyeLookInLeft": COEFFICIENT, "eyeLookOutRight": COEFFICIENT},
    "looks_up": {"eyeLookUpLeft": COEFFICIENT, "eyeLookUpRight": COEFFICIENT},
}
TWINS = (
    ("turns_left", "turns_right"),
    ("tilts_left", "tilts_right"),
    ("looks_left", "looks_right"),
    ("closes_left_eye", "closes_right_eye"),
)
# OpenFace's action unit 45 is one for both eyes.
CANNOT = {"openface": {"closes_left_eye", "closes_right_eye"}}


def takes() -> list[tuple[str, str]]:
    """Format and name of every golden take."""
    folders = (folder for folder in GOLDEN.iterdir() if folder.name in READERS)
    found = {
        (folder.name, path.stem)
        for folder in folders
        for path in folder.iterdir()
        if path.name != "options.yaml"
    }
    return sorted(found)


@cache
def golden(format: str, name: str) -> Take:
    options = yaml.safe_load((GOLDEN / format / "options.yaml").read_text())
    path = next((GOLDEN / format).glob(f"{name}*"))
    assert READERS[format].holds(path) or "channels" in options  # columns of any name
    return READERS[format].read(path, bad_values="fail", **options)


def moved(take: Take) -> pd.Series:
    """How far each channel goes from the first frame to the last; NaN where not measured."""
    frames = take.motion[list(CHANNELS)].astype(float)
    return frames.iloc[-1] - frames.iloc[0]


def expected(take: Take, name: str) -> dict[str, float]:
    """Channels that move in a take of that name, and how far."""
    told_by_looks = name in LOOKS and moved(take)[list(LOOKS[name])].abs().min() > 0.5
    return LOOKS[name] if told_by_looks else MOVES[name]


@pytest.mark.parametrize(("format", "name"), takes())
def test_what_the_subject_does_moves_its_channel_and_nothing_else(format, name):
    take = golden(format, name)
    assert take.motion["valid"].all()
    assert len(take.motion) == 5
    go = moved(take)
    for channel, amount in expected(take, name).items():
        assert go[channel] == pytest.approx(amount, rel=0.2), channel
    for channel, amount in MOVES[name].items():
        steps = np.diff(take.motion[channel].dropna().to_numpy(float)) * np.sign(amount)
        assert (steps > 0).all(), channel
    others = [c for c in (*HEAD, *GAZE, *BLINKS) if c not in MOVES[name]]
    still = take.motion[others].astype(float).dropna(axis=1)
    assert ((still.max() - still.min()) < AT_REST).all(), still


@pytest.mark.parametrize(
    ("format", "name", "twin"),
    [
        (format, *pair)
        for format in sorted({format for format, _ in takes()})
        for pair in TWINS
        if {(format, name) for name in pair} <= set(takes())
    ],
)
def test_a_mirrored_video_gives_the_mirrored_take(format, name, twin):
    channels = [*HEAD, *GAZE, *BLINKS]
    channels += [c for c in CHANNELS if c.startswith("eyeLook")]
    mirrored = golden(format, name).mirrored()
    np.testing.assert_allclose(
        golden(format, twin).motion[channels], mirrored.motion[channels], atol=2e-3
    )


@pytest.mark.parametrize("format", sorted(READERS))
def test_every_format_has_a_golden_take_of_all_that_it_can_express(format):
    named = {name for of, name in takes() if of == format}
    measured: set[str] = set()
    for name in named:
        measured |= set(moved(golden(format, name)).dropna().index)
    wanted = {
        name
        for name in MOVES
        if measured >= set(MOVES[name]) or measured >= set(LOOKS.get(name, {"nothing"}))
    }
    assert named
    assert named == wanted - CANNOT.get(format, set())
