import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.scores import interval, resampled
from mimeline.evaluation.coupling import FOLLOWS, drift, gazes
from mimeline.evaluation.requests import as_frames
from mimeline.toy import simulate
from mimeline.vocabulary import ACTIONS, track_actions

from ..glances import GAZES, followed, glances

CLIPS, LAW = 60, 0.15
NAMES = [f"glances-{number:03d}" for number in range(CLIPS)]


def slope(frames, motion, resamples=0):
    clips = sorted(frames["clip_id"].unique())
    weights = resampled(len(clips), resamples, np.random.default_rng(0))
    return drift(gazes(frames, motion), clips, weights)


@pytest.fixture(scope="module")
def asked():
    rng = np.random.default_rng(2)
    return as_frames("glances", [glances(rng) for _ in NAMES], set(ACTIONS))


def planted(law, rng) -> pd.DataFrame:
    """Gazes of any size, six of a clip, and a head that follows each by its share."""
    tracks = rng.choice(list(FOLLOWS), 6 * CLIPS)
    sign = rng.choice([1, -1], len(tracks))
    angle = sign * rng.uniform(0.2, 0.5, len(tracks))
    turned = np.where(sign == 1, 0.3, -0.1)  # what a timeline tells: the same for each gaze
    noise = rng.normal(size=len(tracks)) * np.where(tracks == "gaze_h", 0.02, 0.05)
    actions = [track_actions(track)[int(own < 0)] for track, own in zip(tracks, sign, strict=True)]
    rows = {"clip_id": np.repeat(NAMES, 6), "track": tracks, "action": actions, "gaze": angle}
    return pd.DataFrame(rows).assign(head=law * angle + turned + noise)


@pytest.mark.parametrize("law", [LAW, 0.0, 0.4])
def test_the_slope_is_that_by_which_the_head_follows_whatever_a_timeline_tells(law):
    weights = resampled(CLIPS, 100, np.random.default_rng(0))
    draws = [drift(planted(law, np.random.default_rng(n)), NAMES, weights) for n in range(30)]
    found = [own[0] for own in draws]
    error = np.std(found) / np.sqrt(len(found))
    assert np.mean(found) == pytest.approx(law, abs=3 * error)
    assert error < 0.004
    within = [low <= law <= high for _, low, high in map(interval, draws)]
    assert sum(within) >= 25  # of 30, 28 or 29 expected


def test_held_gazes_and_the_head_behind_them_are_measured_to_the_frame(asked):
    motion = followed(asked, LAW, np.random.default_rng(0))
    held = gazes(asked, motion)
    assert set(held["action"]) == {*GAZES}
    np.testing.assert_allclose(held["head"], LAW * held["gaze"])
    assert slope(asked, motion)[0] == pytest.approx(LAW)


@pytest.fixture(scope="module")
def world():
    return simulate(40, 160, seed=5)


@pytest.mark.parametrize("seen", ["clean", "motion"])
def test_the_toys_head_goes_with_its_eyes(world, seen):
    _, low, high = interval(slope(world.frames, getattr(world, seen), 200))
    assert 0.03 < low < 0.87 * LAW < high  # flatter than the law: a gaze's own wander moves no head


def test_a_head_that_does_not_follow_has_no_drift(world):
    still = world.clean.copy()
    for _, head, _ in FOLLOWS.values():  # heads of other clips, of the same frames
        still[head] = still.groupby("frame")[head].transform(lambda own: np.roll(own, 1))
    _, low, high = interval(slope(world.frames, still, 200))
    assert low < 0 < high


def test_gazes_count_only_while_the_head_rests_and_the_brow_does_for_looks_up_or_down(asked):
    motion = followed(asked, LAW, np.random.default_rng(0))
    assert set(gazes(asked.assign(HeadLeft=True), motion)["track"]) == {"gaze_v"}
    assert set(gazes(asked.assign(BrowUp=True), motion)["track"]) == {"gaze_h"}


def test_what_is_not_measured_is_no_rest(asked):
    motion = followed(asked, LAW, np.random.default_rng(0))
    unknown = asked.assign(BrowUp=pd.array([pd.NA] * len(asked), "boolean"))
    assert set(gazes(unknown, motion)["track"]) == {"gaze_h"}


@pytest.mark.parametrize("left", ["no clip", "no valid frame"])
def test_where_nothing_is_left_there_is_no_gaze(asked, left):
    motion = followed(asked, LAW, np.random.default_rng(0)).assign(valid=False)
    found = gazes(asked[:0] if left == "no clip" else asked, motion)
    assert found.empty
    assert drift(found, [], np.ones((1, 0))) is None


def test_without_a_head_or_enough_gazes_there_is_no_drift(asked):
    motion = followed(asked, LAW, np.random.default_rng(0))
    assert slope(asked, motion.assign(head_yaw_left=np.nan, head_pitch_up=np.nan)) is None
    assert slope(asked[asked["clip_id"] <= "glances-002"], motion) is None
