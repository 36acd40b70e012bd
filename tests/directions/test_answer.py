"""A language model's answer: repaired where it is plain what was meant, else refused."""

import json
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline.directions.answer import MOST_INTERVALS, Refused, read
from mimeline.vocabulary import ACTIONS, TRACKS

FPS = Fraction(10)


def smile(**changes) -> dict:
    return {"action": "Smile", "start_s": 1, "end_s": 2} | changes


def answer(*actions, **more) -> str:
    return json.dumps({"seconds": 4, "actions": list(actions)} | more)


def told(text: str, n_frames: int | None = None) -> list[tuple]:
    timeline = read(text, FPS, n_frames).timeline
    return [(own.action, own.start, own.end, own.side) for own in timeline]


def refused(text: str, n_frames: int | None = None) -> str:
    with pytest.raises(Refused) as caught:
        read(text, FPS, n_frames)
    return str(caught.value)


def test_an_answer_is_a_timeline_with_every_track_told():
    found = read(answer(smile(side="left"), smile(action="GazeUp")), FPS, None)
    assert told(answer(smile(side="left"))) == [("Smile", 10, 20, "left")]
    assert found.timeline.n_frames == 40 and set(found.timeline.tracks) == set(TRACKS)
    assert found.repairs == ()


def test_without_a_length_the_clip_ends_a_second_after_the_last_action():
    assert read(answer(smile(), seconds=None), FPS, None).timeline.n_frames == 30
    assert read(answer(smile()), FPS, 25).timeline.n_frames == 25


@pytest.mark.parametrize(
    ("text", "repair"),
    [
        (f"Sure!\n```json\n{answer(smile())}\n```\nEnjoy.", "text around the JSON left out"),
        (answer(smile(action="smile")), '"smile" taken for Smile'),
        (answer(smile(action="SMILE ")), "taken for Smile"),
        (f"As {{asked}}: {answer(smile())}", "text around the JSON left out"),
        (answer(smile(action="Eyes Closed"), smile()), '"Eyes Closed" taken for EyeClose'),
        (answer(smile(), seconds=10**400), "a length of"),
        (answer(smile(side="Both"), smile(action="HeadLeft", side="left")), "HeadLeft has none"),
        (answer(smile(start_s="1 s")), '"1 s" taken for a number'),
        (answer(smile(), {"action": "Neutral", "start_s": 0, "end_s": 1}), "Neutral left out"),
        (answer(smile(), smile(action="GazeUp", start_s=9, end_s=10)), "after the clip's end"),
    ],
)
def test_what_is_plainly_meant_is_mended_and_told(text, repair):
    found = read(text, FPS, None)
    assert ("Smile", 10, 20) in [(own.action, own.start, own.end) for own in found.timeline]
    (told,) = found.repairs
    assert repair in told


def test_what_reaches_beyond_the_clip_or_the_next_action_is_cut():
    assert told(answer(smile(end_s=9))) == [("Smile", 10, 40, None)]
    both = answer(smile(end_s=3), smile(action="MouthFrown", start_s=2, end_s=3))
    assert told(both) == [("Smile", 10, 20, None), ("MouthFrown", 20, 30, None)]
    sides = answer(smile(end_s=3, side="left"), smile(start_s=2, end_s=3, side="right"))
    assert len(read(sides, FPS, None).repairs) == 0
    brief = answer(smile(start_s=1, end_s=1.01))
    assert told(brief) == [("Smile", 10, 11, None)]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no JSON object"),
        ("[]", "no JSON object"),
        (answer(smile(action="no smile")), "no smile.*none of"),
        (answer(smile(action="EyesLeft")), "EyesLeft.*none of"),
        (answer(smile(action="Smile" * 10_000)), "none of"),
        (answer(smile(start_s=10**400)), "not both seconds"),
        (answer(smile(), seconds=10**6), "a length of 1e"),
        ("{", "breaks off"),
        ('{"actions": NaN}', "NaN, which is no number"),
        ('{"actions": {}}', 'no list "actions"'),
        (answer(), "no action"),
        (answer("Smile"), "action 1.*no object"),
        (answer(smile(), {}), "action 2: no name"),
        (answer(smile(action="Juggle")), "Juggle.*none of BrowUp"),
        (answer(smile(start_s=None)), "not both seconds"),
        (answer(smile(start_s=True)), "not both seconds"),
        (answer(smile(start_s=-1)), "not both seconds"),
        (answer(smile(start_s=1e300)), "not both seconds"),
        (answer(smile(start_s=2)), "ends before it starts"),
        (answer(smile(side="top")), "side.*neither left nor right"),
        (answer(smile(), seconds=10**5), "a length of 100000 s"),
        (answer(*[smile()] * (MOST_INTERVALS + 1)), f"{MOST_INTERVALS + 1} actions"),
        (answer(smile(), smile()), "Smile"),
        (answer(smile(start_s=20, end_s=21)), "no action within the clip"),
    ],
)
def test_what_is_not_plain_is_refused_with_the_reason(text, reason):
    with pytest.raises(Refused, match=reason):
        read(text, FPS, None)


def test_an_action_in_the_clip_is_asked_for():
    assert refused(answer(smile()), 10) == "no action within the clip"


SHORT = st.text(max_size=8)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | SHORT,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(SHORT, inner, max_size=4),
    max_leaves=8,
)
TIMES = st.floats(0, 12) | st.integers(-2, 12) | st.sampled_from(["1", "2 s", "x", None]) | VALUES
ENTRIES = st.fixed_dictionaries(
    {"action": st.sampled_from([*ACTIONS, "Neutral", "smile"]), "start_s": TIMES, "end_s": TIMES},
    optional={"side": st.sampled_from(["left", "right", "both", None]) | VALUES},
)


@given(st.lists(ENTRIES | VALUES, max_size=6), TIMES, st.none() | st.integers(1, 60), SHORT)
def test_any_answer_is_a_timeline_of_the_length_or_refused(entries, seconds, n_frames, around):
    text = around + json.dumps({"seconds": seconds, "actions": entries}) + around
    try:
        found = read(text, FPS, n_frames)
    except Refused as error:
        assert str(error)
    else:
        assert [*found.timeline] and found.timeline.n_frames == (
            n_frames or found.timeline.n_frames
        )
        assert all(0 <= own.start < own.end <= found.timeline.n_frames for own in found.timeline)


@given(st.text() | VALUES.map(json.dumps))
def test_any_text_is_refused_or_read(text):
    try:
        read(text, FPS, None)
    except Refused as error:
        assert str(error)
