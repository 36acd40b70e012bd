import numpy as np
import pandas as pd
import pytest

from mimeline.annotation.scores import confusions
from mimeline.evaluation.ablations import Asked, asked_draws, channels_of, of_recordings, scored
from mimeline.evaluation.coupling import FOLLOWS, LAG
from mimeline.evaluation.requests import as_frames, conflict
from mimeline.evaluation.variants import CONFLICT, EYES, NARROW, UNSEEN, WIDE
from mimeline.vocabulary import ACTIONS

from ..glances import followed, glances

CLIPS, LAW = 24, 0.15


@pytest.fixture(scope="module")
def asked() -> dict[str, pd.DataFrame]:
    rng = np.random.default_rng(5)
    drawn = {
        UNSEEN: [glances(rng) for _ in range(CLIPS)],
        CONFLICT: [conflict(160, rng) for _ in range(4)],
    }
    return {name: as_frames(name, own, set(ACTIONS)) for name, own in drawn.items()}


@pytest.fixture(scope="module")
def recorded(asked) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Motion and frames of the unseen clips and of as many others."""
    rng = np.random.default_rng(6)
    others = as_frames("other", [glances(rng) for _ in range(CLIPS)], set(ACTIONS))
    frames = pd.concat([asked[UNSEEN], others], ignore_index=True)
    return followed(frames, LAW, rng), frames


def others_of(frames) -> list[str]:
    return sorted(name for name in frames["clip_id"].unique() if name.startswith("other"))


def made(asked, law=LAW) -> dict[str, pd.DataFrame]:
    motions = {n: followed(own, LAW, np.random.default_rng(7)) for n, own in asked.items()}
    for name, far in EYES.items():  # all of the same noise
        own = followed(asked[UNSEEN], 0, np.random.default_rng(8))
        for gaze, head, _ in FOLLOWS.values():
            own[head] += np.random.default_rng(9).normal(size=len(own))
            own[gaze] *= far
            own[head] += law * np.roll(own[gaze], LAG)
        motions[name] = own
    return motions


def test_a_variant_that_does_as_asked_has_the_best_scores(asked, recorded):
    known = Asked.of(asked, recorded[0], 20, seed=0)
    draws = scored(known, made(asked), asked)
    for name in ("tas", "conflict", "conflict_tas"):
        np.testing.assert_array_equal(draws[name], 1.0)
    assert draws["drift"][0] == pytest.approx(LAW)
    assert draws["snd"][0] == pytest.approx(draws["fid_fm"][0] + draws["fid_delta_fm"][0])


@pytest.mark.parametrize("law", [0.0, 0.05, 0.4])
def test_head_drift_is_how_far_the_head_goes_with_eyes_that_are_given(asked, recorded, law):
    draws = scored(Asked.of(asked, recorded[0], 20, seed=0), made(asked, law), asked)
    np.testing.assert_allclose(draws["drift"], law, atol=1e-12)


def test_without_a_head_there_is_no_drift(asked, recorded):
    own = made(asked)
    for name in (NARROW, WIDE):
        own[name] = own[name].assign(head_yaw_left=np.nan, head_pitch_up=np.nan)
    assert "drift" not in scored(Asked.of(asked, recorded[0], 20, seed=0), own, asked)


def test_what_was_not_made_or_has_no_value_has_no_score(asked, recorded):
    known = Asked.of(asked, recorded[0], 20, seed=0)
    own = made(asked)
    gone = {name: table[:0] for name, table in own.items()}
    assert scored(known, gone, asked) == {}
    resting = {
        **asked,
        CONFLICT: asked[CONFLICT].assign(BrowUp=False, Smile=False, SoftSmile=False),
    }
    known = Asked.of(resting, recorded[0], 20, seed=0)
    assert "conflict" not in scored(known, own, resting)


def test_an_action_that_is_not_asked_for_halves_no_score_of_conflicts(asked):
    frames = asked[CONFLICT]
    found = frames.copy()
    found.loc[found.index[:3], "BrowDown"] = True
    found.loc[found.index[:3], "BrowUp"] = False
    counts = confusions(frames, found)
    assert asked_draws(counts, np.ones((1, 4)))[0] > 0.99
    assert asked_draws(confusions(frames, frames.assign(BrowUp=False)), np.ones((1, 4)))[0] < 0.8


def test_a_resample_without_an_action_is_not_scored_on_it(asked):
    frames = asked[CONFLICT].assign(Smile=False)
    first = frames["clip_id"] == "conflict-000"
    frames.loc[first, ["BrowUp", "SoftSmile"]] = False
    weights = np.array([[1.0, 1, 1, 1], [0, 2, 2, 0], [4, 0, 0, 0]])
    np.testing.assert_array_equal(asked_draws(confusions(frames, frames), weights), 1.0)


def test_real_clips_are_scored_on_the_channels_that_variants_make(asked, recorded):
    motion, frames = recorded
    known = Asked.of(asked, motion, 20, seed=0)
    channels = [name for name in channels_of(motion) if name != "tongueOut"]
    seldom = motion.assign(tongueOut=motion["tongueOut"].where(motion["clip_id"] == "other-003"))
    for table in (motion, seldom):
        draws, clips = of_recordings(known, table, frames, others_of(frames), channels, 0)
        assert set(draws) == {"var", "fid_fm", "fid_delta_fm", "snd", "drift"}
        assert clips["var"] == clips["snd"] == CLIPS
        assert clips["drift"] == 2 * CLIPS
        assert draws["drift"][0] == pytest.approx(LAW)
        assert draws["snd"][0] < 0.02  # of the same kind of motion


def test_without_clips_nothing_is_scored(asked, recorded):
    empty = {name: frames[:0] for name, frames in asked.items()}
    motion, frames = (table[:0] for table in recorded)
    known = Asked.of(empty, motion, 20, seed=0)
    assert of_recordings(known, motion, frames, [], [], 0) == ({}, {})
