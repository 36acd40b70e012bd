from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline.timeline.clock import frame_rate, milliseconds, nearest_frame, seconds
from mimeline.timeline.timeline import Interval, Timeline, overlaps

from .drawn import RATES


def test_tracks_and_intervals_are_held_in_order():
    brow = [Interval("BrowDown", 9, 12), Interval("BrowUp", 0, 5)]
    timeline = Timeline("a", 30, 20, {"mouth": [], "brow": brow})
    assert list(timeline.tracks) == ["brow", "mouth"]
    assert [interval.action for interval in timeline] == ["BrowUp", "BrowDown"]
    assert timeline == Timeline("a", Fraction(30), 20, {"brow": brow[::-1], "mouth": []})
    assert timeline.seconds == 20 / 30


@pytest.mark.parametrize(
    "spoilt",
    [
        {"clip_id": ""},
        {"fps": Fraction(0)},
        {"n_frames": -1},
        {"tracks": {"eyebrow": []}},
        {"tracks": {"mouth": [Interval("BrowUp", 0, 5)]}},
        {"tracks": {"brow": [Interval("Brow", 0, 5)]}},
        {"tracks": {"brow": [Interval("BrowUp", 5, 5)]}},
        {"tracks": {"brow": [Interval("BrowUp", -1, 5)]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 21)]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 5, "both")]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 5, source="me")]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 5, confidence=2.0)]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 5, cluster=-1)]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 5), Interval("BrowDown", 4, 9)]}},
        {"tracks": {"brow": [Interval("BrowUp", 0, 5), Interval("BrowUp", 4, 9, "left")]}},
    ],
)
def test_what_is_no_timeline_cannot_be_made(spoilt):
    with pytest.raises(ValueError):
        Timeline(**({"clip_id": "a", "fps": Fraction(30), "n_frames": 20, "tracks": {}} | spoilt))


@given(
    st.lists(
        st.builds(
            lambda start, length, side: Interval("BrowUp", start, start + length, side),
            st.integers(0, 20),
            st.integers(1, 9),
            st.sampled_from([None, "left", "right"]),
        ),
        max_size=6,
    )
)
def test_overlaps_are_found_exactly_where_two_exclude_each_other(intervals):
    intervals.sort(key=lambda interval: (interval.start, interval.end))
    found = list(overlaps(intervals))
    assert all(a.excludes(b) for a, b in found)
    later = [
        number
        for number, interval in enumerate(intervals)
        if any(interval.excludes(earlier) for earlier in intervals[:number])
    ]
    assert len(found) == len(later)


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("25", Fraction(25)),
        (" 30000/1001 ", Fraction(30000, 1001)),
        ("29.97", Fraction(30000, 1001)),
        ("23.976", Fraction(24000, 1001)),
        ("12.5", Fraction(25, 2)),
    ],
)
def test_a_frame_rate_is_read_as_people_write_it(text, rate):
    assert frame_rate(text) == rate


@pytest.mark.parametrize(
    "text", ["", "0", "-25", "25/0", "0/3", "fast", "1e9", "9" * 30, "٣", "1/2/3"]
)
def test_what_is_no_frame_rate_is_refused(text):
    with pytest.raises(ValueError, match="is no frame rate: write 25 or 30000/1001"):
        frame_rate(text)


@given(st.sampled_from([*RATES, Fraction(999)]), st.integers(0, 10**8))
def test_milliseconds_lead_back_to_their_frame(fps, frame):
    assert nearest_frame(Fraction(milliseconds(frame, fps), 1000), fps) == frame


@given(st.sampled_from(RATES), st.integers(0, 10**8))
def test_a_double_leads_back_to_its_frame(fps, frame):
    assert nearest_frame(seconds(repr(float(frame / fps))), fps) == frame


@pytest.mark.parametrize("text", ["", "1:00", "nan", "inf", "1e999", "0x3", "1_0", "9" * 99, "."])
def test_what_is_no_number_of_seconds_is_refused(text):
    with pytest.raises(ValueError, match="is no number of seconds"):
        seconds(text)
