import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.thresholds import Limits, threshold_actions
from mimeline.vocabulary import HEAD, track_actions

LIMITS = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 10.0, "hysteresis": 0.0, "min_frames": 1}
OPPOSITES = ("gaze_h", "gaze_v", "head_h", "head_v")


def marks(motion_of, limits=LIMITS, **channels):
    """The actions of one clip, by name; float32 as a `motion` table has it."""
    rows = max(np.size(values) for values in channels.values())
    motion = motion_of({"a": rows}, **channels)
    numbers = motion.columns[3:]
    return threshold_actions(motion.astype(dict.fromkeys(numbers, "float32")), Limits(**limits))


def test_the_exact_limit_counts_as_on_and_what_is_below_does_not(motion_of):
    blink = np.array([0.5, 0.499, 0.501])
    found = marks(motion_of, eyeBlinkLeft=blink, eyeBlinkRight=blink)
    assert found["EyeClose"].tolist() == [True, False, True]


@pytest.mark.parametrize("degrees", [5.0, 7.3, 8.0, 9.0, 12.0, 20.0, 33.3])
def test_an_angle_at_the_limit_counts_whatever_its_rounding(motion_of, degrees):
    yaw = np.radians([degrees, -degrees, degrees - 0.01])
    found = marks(motion_of, LIMITS | {"head_deg": degrees}, head_yaw_left=yaw)
    assert found["HeadLeft"].tolist() == [True, False, False]
    assert found["HeadRight"].tolist() == [False, True, False]


def test_each_angle_moves_its_own_two_actions(motion_of):
    cases = {
        "gaze_left": ("GazeLeft", "GazeRight"),
        "gaze_up": ("GazeUp", "GazeDown"),
        "head_yaw_left": ("HeadLeft", "HeadRight"),
        "head_pitch_up": ("HeadUp", "HeadDown"),
    }
    angles = dict.fromkeys([*cases, HEAD[-1]], 0.0)
    for channel, (positive, negative) in cases.items():
        found = marks(motion_of, **angles | {channel: np.radians([15.0, -15.0, 3.0])})
        on = {name: found[name].tolist() for name in found if found[name].any()}
        assert on == {positive: [True, False, False], negative: [False, True, False]}


def test_both_eyes_count_by_their_mean(motion_of):
    found = marks(motion_of, eyeBlinkLeft=np.array([1.0, 0.7]), eyeBlinkRight=np.array([0.25, 0.2]))
    assert found["EyeClose"].tolist() == [True, False]


def test_what_is_not_measured_is_unknown_and_not_off(motion_of):
    gaps = np.array([0.4, np.nan])
    found = marks(motion_of, eyeBlinkLeft=0.9, eyeBlinkRight=gaps, gaze_left=gaps)
    assert found.loc[0, ["EyeClose", "GazeLeft", "GazeRight"]].tolist() == [True, True, False]
    assert found.loc[1, ["EyeClose", "GazeLeft", "GazeRight"]].isna().all()
    assert found[["GazeUp", "GazeDown", "HeadLeft", "HeadUp"]].isna().all(axis=None)
    assert all(isinstance(kind, pd.BooleanDtype) for kind in found.dtypes)


def test_an_action_that_has_begun_lasts_until_it_falls_below_the_lower_limit(motion_of):
    blink = np.array([0.39, 0.4, 0.5, 0.4, 0.42, 0.39, 0.45, 0.6])
    found = marks(motion_of, LIMITS | {"hysteresis": 0.2}, eyeBlinkLeft=blink, eyeBlinkRight=blink)
    on = [False, False, True, True, True, False, False, True]
    assert found["EyeClose"].tolist() == on


def wandering(motion_of, seed: int) -> pd.DataFrame:
    """Two clips whose values stay near the limits; frames are missing, not valid, not measured."""
    rng = np.random.default_rng(seed)
    lengths = {"a": 150, "b": 150}

    def walk(scale):
        values = scale * rng.normal(size=300)
        values = np.convolve(values, np.ones(4) / 4, mode="same").astype("float32")
        return np.where(rng.random(300) < 0.03, np.nan, values)

    angles = ("gaze_left", "gaze_up", "head_yaw_left", "head_pitch_up")
    motion = motion_of(
        lengths,
        **{name: walk(0.35) for name in angles},
        eyeBlinkLeft=0.5 + walk(0.3),
        eyeBlinkRight=0.5 + walk(0.3),
    )
    numbers = motion.columns[3:]
    motion = motion.assign(valid=rng.random(300) > 0.05).astype(dict.fromkeys(numbers, "float32"))
    return motion[rng.random(300) > 0.03].reset_index(drop=True)


def one_by_one(motion, values, limit, hysteresis) -> list:
    """What a loop over frames says; the limits in the table's precision."""
    upper, lower = np.float32(limit), np.float32(limit * (1 - hysteresis))
    found, on, before = [], False, None
    for clip, frame, valid, value in zip(
        motion["clip_id"], motion["frame"], motion["valid"], values, strict=True
    ):
        follows = before == (clip, frame - 1)
        before = (clip, frame) if valid and not np.isnan(value) else None
        on = bool(value >= upper or (on and follows and value >= lower))
        found.append(pd.NA if np.isnan(value) else on)
    return found


@pytest.mark.parametrize("hysteresis", [0.0, 0.1, 0.35, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_hysteresis_is_that_of_a_loop_over_frames(motion_of, hysteresis, seed):
    motion = wandering(motion_of, seed)
    limits = LIMITS | {"hysteresis": hysteresis}
    found = threshold_actions(motion, Limits(**limits))
    blink = motion[["eyeBlinkLeft", "eyeBlinkRight"]].mean(axis=1, skipna=False).to_numpy("float32")
    angles = {"Gaze": ("gaze_left", "gaze_up", 8.0), "Head": ("head_yaw_left", "head_pitch_up", 10)}
    wanted = {"EyeClose": one_by_one(motion, blink, 0.5, hysteresis)}
    for name, (left, up, degrees) in angles.items():
        for words, channel in ((("Left", "Right"), left), (("Up", "Down"), up)):
            for word, sign in zip(words, (1, -1), strict=True):
                values = sign * motion[channel].to_numpy()
                wanted[name + word] = one_by_one(motion, values, np.radians(degrees), hysteresis)
    valid = motion["valid"].to_numpy()  # annotate takes the others away
    for name, values in wanted.items():
        own = pd.array(values, dtype="boolean")
        assert found[name][valid].equals(pd.Series(own)[valid].rename(name)), name


@pytest.mark.parametrize("seed", range(3))
def test_a_mirrored_take_swaps_the_directions_whatever_the_hysteresis(motion_of, seed):
    motion = wandering(motion_of, seed)
    mirrored = motion.assign(gaze_left=-motion["gaze_left"], head_yaw_left=-motion["head_yaw_left"])
    limits = Limits(**LIMITS | {"hysteresis": 0.4})
    found, swapped = threshold_actions(motion, limits), threshold_actions(mirrored, limits)
    for name in ("Gaze", "Head"):
        assert found[f"{name}Left"].tolist() == swapped[f"{name}Right"].tolist()
        assert found[f"{name}Right"].tolist() == swapped[f"{name}Left"].tolist()
        assert found[f"{name}Up"].tolist() == swapped[f"{name}Up"].tolist()


@pytest.mark.parametrize("seed", range(3))
def test_more_hysteresis_takes_no_frame_away_and_opposite_directions_exclude_each_other(
    motion_of, seed
):
    motion = wandering(motion_of, seed)
    before = None
    for hysteresis in (0.0, 0.1, 0.3, 0.6, 1.0):
        found = threshold_actions(motion, Limits(**LIMITS | {"hysteresis": hysteresis}))
        shown = found.fillna(False)
        if before is not None:
            assert not (before & ~shown).any(axis=None)
            assert shown.sum().sum() > before.sum().sum()
        for track in OPPOSITES:
            assert not shown[list(track_actions(track))].all(axis=1).any()
        before = shown
