"""Motion and timelines at another rate."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline.motion.resampling import at_rate, resampled
from mimeline.timeline.timeline import Interval, Timeline

RATE = st.fractions(1, 240, max_denominator=1001)


def test_the_same_rate_is_the_same_motion(moving):
    motion = moving()
    assert resampled(motion, motion.fps) is motion
    assert at_rate(motion.timeline, motion.fps) is motion.timeline


@pytest.mark.parametrize("fps", [24, 25, 60, 120, Fraction(24_000, 1001)])
def test_a_slow_wave_stays_what_it_was(moving, fps):
    motion = moving(90, Fraction(30))
    wave = np.sin(np.arange(90) / 30 * 2 * np.pi) * 0.4 + 0.5
    motion.frames["mouthPucker"] = wave
    motion.frames["valid"] = True
    found = resampled(motion, Fraction(fps))
    assert len(found) == round(3 * fps) and found.fps == fps
    seconds = np.arange(len(found)) / float(fps)
    inside = seconds <= 89 / 30
    now = found.frames["mouthPucker"].to_numpy(float)[inside]
    np.testing.assert_allclose(now, np.sin(seconds[inside] * 2 * np.pi) * 0.4 + 0.5, atol=0.01)


def test_nothing_overshoots(moving):
    motion = moving(40)
    for fps in (Fraction(100), Fraction(17)):
        found = resampled(motion, fps)
        for name in motion.moved:
            was = motion.frames[name].to_numpy(float)
            now = found.frames[name].to_numpy(float)
            assert np.nanmin(now) >= np.nanmin(was) - 1e-6
            assert np.nanmax(now) <= np.nanmax(was) + 1e-6


def test_twice_the_rate_and_back_gives_the_frames_again(moving):
    motion = moving(40, Fraction(30))
    back = resampled(resampled(motion, Fraction(60)), Fraction(30))
    assert len(back) == 40
    for name in motion.moved:
        was, now = (m.frames[name].to_numpy(float) for m in (motion, back))
        np.testing.assert_array_equal(np.isnan(was), np.isnan(now))
        np.testing.assert_allclose(was, now, atol=1e-6)
    np.testing.assert_array_equal(motion.frames["valid"], back.frames["valid"])


def test_what_is_not_known_does_not_spread(moving):
    motion = moving(40, Fraction(30))  # jawOpen is known in the first half
    found = resampled(motion, Fraction(90))
    known = found.frames["jawOpen"].notna().to_numpy()
    assert known[:50].sum() >= 44 and not known[60:].any()
    assert found.frames["tongueOut"].isna().all()
    assert (~found.frames["valid"].to_numpy(bool)).sum() == 6  # two frames, three times as many


def test_a_length_can_be_told_to_the_frame(moving):
    motion = moving(25, Fraction(25))
    assert len(resampled(motion, Fraction(60), 61)) == 61
    assert len(resampled(motion, Fraction(25), 26)) == 26


@given(RATE, RATE, st.integers(1, 300), st.data())
def test_a_timeline_at_any_rate_is_one(fps, other, n, data):
    cuts = sorted(data.draw(st.sets(st.integers(0, n), max_size=8)))
    mouth = [
        Interval(("Smile", "MouthFrown")[i % 2], a, b) for i, (a, b) in enumerate(pairwise(cuts))
    ]
    timeline = Timeline("x", fps, n, {"mouth": mouth, "brow": []})
    found = at_rate(timeline, other)
    assert found.fps == other and list(found.tracks) == ["brow", "mouth"]
    assert abs(found.seconds - timeline.seconds) <= 0.5 / other + 1e-9 or found.n_frames == 1
    for own in found:
        assert any(
            abs(own.start / other - was.start / fps) <= 0.5 / other + 1e-9
            and own.action == was.action
            for was in mouth
        )


def test_actions_keep_their_seconds():
    smile = Interval("Smile", 30, 60, side="left", confidence=0.5)
    timeline = Timeline("x", Fraction(30), 90, {"mouth": [smile]})
    (found,) = at_rate(timeline, Fraction(25))
    assert (found.start, found.end, found.side, found.confidence) == (25, 50, "left", 0.5)
    assert at_rate(timeline, Fraction(25)).n_frames == 75
    assert at_rate(timeline, Fraction(30), 100).n_frames == 100
