"""Sentences as people type them: read as they are meant, or refused with the word."""

from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline.directions.gestures import FILLERS, KINDS, PLAIN
from mimeline.directions.sentences import MOST_CHARACTERS, NotUnderstood, read
from mimeline.vocabulary import TRACKS

FPS = Fraction(100)
FILE = Path(__file__).with_name("sentences.txt")
LINES = [line for line in FILE.read_text(encoding="utf-8").splitlines() if "|" in line]
OF_TIME = "from to at for until the end twice first last 1 2.5 s frames half a - in seconds"
JOINTS = "and then while as before but , . ; not @0"
WORDS = sorted({*PLAIN, *FILLERS, *OF_TIME.split(), *JOINTS.split()})


def told(text: str, **more) -> str:
    timeline, _ = read(text, FPS, **more)
    ordered = sorted(timeline, key=lambda own: (own.start, own.end, own.action))
    return ", ".join(
        f"{own.action}{f' {own.side}' if own.side else ''} {own.start / 100:g}-{own.end / 100:g}"
        for own in ordered
    )


def refused(text: str, **more) -> str:
    with pytest.raises(NotUnderstood) as caught:
        read(text, FPS, **more)
    return str(caught.value)


@pytest.mark.parametrize("line", [line for line in LINES if line[0] != "!"])
def test_a_sentence_is_read_as_it_is_meant_or_refused(line):
    text, _, meant = (part.strip() for part in line.partition("|"))
    if meant:
        assert told(text) == meant
    else:
        assert "the text" in refused(text)


@pytest.mark.parametrize(
    "text",
    [
        "While smiling, she looks left",
        "As she smiles, she looks left.",
        "Smiling, she looks left",
        "Then, while she smiles, she looks left",
        "smile and look left",
        "smile & look left",
        "smile but look left",
        "She smiles, looking left",
        "smile; meanwhile look left",
        "“Smile” (and look left)",
    ],
)
def test_what_is_joined_goes_together(text):
    assert told(text) == "GazeLeft 0.5-2, Smile 0.5-2"


@pytest.mark.parametrize(
    "text",
    [
        "smile, then look left",
        "smile, look left",
        "smile. Look left!",
        "smile before looking left",
        "first smile, after that look left",
        "smile followed by a look left",
    ],
)
def test_what_follows_comes_a_pause_later(text):
    assert told(text) == "Smile 0.5-2, GazeLeft 2.25-3.75"


def test_of_a_length_that_is_known_the_end_is_known():
    assert told("smile until the end", n_frames=800) == "Smile 0.5-8"
    assert told("smile for 2 s until the end", n_frames=800) == "Smile 6-8"
    assert told("smile, then look up until the end", n_frames=800) == "Smile 0.5-2, GazeUp 2.25-8"
    assert told("smile, then look up until 5 s") == "Smile 0.5-2, GazeUp 2.25-5"
    assert told("smile until 0.3 s") == "Smile 0-0.3"
    assert "reversed" in refused("smile, then look up until 2 s")
    assert told("nod until the end", n_frames=300).startswith("HeadDown 1.8-")
    assert told("at 2 s smile until the end", n_frames=800) == "Smile 2-8"
    assert told("smile in the last second", n_frames=800) == "Smile 7-8"
    assert read("smile", FPS, 800)[0].n_frames == 800
    assert "Smile on mouth" in refused("smile from 7 to 9 s", n_frames=800)


def test_times_are_shared_and_counts_are_not():
    assert told("look left for 1 s and right for 2 s") == "GazeLeft 0.5-1.5, GazeRight 1.75-3.75"
    assert told("look left and right for 2 s") == "GazeLeft 0.5-1.5, GazeRight 1.5-2.5"
    assert told("at 1 s smile and look up for 1 s") == "GazeUp 1-2, Smile 1-2.5"
    assert told("blink twice and smile") == "EyeClose 0.5-0.7, Smile 0.5-2, EyeClose 0.95-1.15"
    assert told("Smile, for 2 seconds") == told("Smile. For 2 seconds.") == "Smile 0.5-2.5"
    assert told("Smile, then, at 3 s, look left") == "Smile 0.5-2, GazeLeft 3-4.5"


def test_an_action_without_a_length_gives_way_to_the_next_on_its_track():
    assert told("look right at 1 s, look left at 2 s") == "GazeRight 1-2, GazeLeft 2-3.5"
    sides = "raise left brow at 1 s, raise right brow at 2 s"
    assert told(sides) == "BrowUp left 1-2.5, BrowUp right 2-3.5"
    assert "GazeLeft" in refused("look right from 1 to 3 s, look left at 2 s")


def test_a_rest_takes_time_and_does_nothing():
    assert told("smile, then rest for 2 s, then frown") == "Smile 0.5-2, BrowDown 4.5-6"
    timeline, heard = read("neutral for 3 s", FPS)
    assert not [*timeline] and not heard and timeline.seconds == 4.5
    assert set(timeline.tracks) == set(TRACKS)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("don't smile", '"don\'t".*not to happen'),
        ("She doesn't smile", "doesn't"),
        ("smile without squinting", "without"),
        ("stop smiling", "stop"),
        ("tilt the head to the left", '"tilt".*to a side'),
        ("raise one eyebrow", "Say left or right"),
        ("raise an eyebrow", "Say left or right"),
        ("Before smiling, she looks down", '"before".*first is said first'),
        ("Smile. Before that, look left", "before"),
        ("smile and talk", '"talk".*speaks'),
        ("blink every two seconds", '"every".*how often'),
        ("smile 50%", '"50", "%"'),
        ("smile @ 2 s", '"@"'),
        ("smile/frown", '"/"'),
        ("smile 😀", "😀"),
        ("smile at 1 and 3 seconds", '"3", "seconds"'),
        ("smile for 2 to 3 seconds", '"2"'),
        ("smile 1,5 s", '"1"'),
        ("at 2 s", "no action"),
        ("at the beginning smile at 2 s", "two times"),
        (" \n", "an empty text"),
        ("...", "an empty text"),
        ("smile for 99999999999 s", "600 s at most"),
        ("smile " * 400, f"{MOST_CHARACTERS} at most"),
    ],
)
def test_what_is_not_understood_is_refused_with_the_word(text, named):
    with pytest.raises(NotUnderstood, match=named):
        read(text, FPS)


@given(st.one_of(st.text(max_size=60), st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join)))
def test_any_text_is_a_timeline_or_refused(text):
    try:
        timeline, heard = read(text, Fraction(30000, 1001))
    except NotUnderstood as error:
        assert "expected" in str(error)
    else:
        assert set(timeline.tracks) == set(TRACKS)
        assert len([*timeline]) == len(heard)
        assert all(0 <= own.start < own.end <= timeline.n_frames for own in timeline)


@given(st.lists(st.sampled_from(WORDS), max_size=10), st.integers(1, 300))
def test_a_length_that_is_asked_for_is_kept(words, n_frames):
    try:
        timeline, _ = read(" ".join(words), FPS, n_frames)
    except NotUnderstood:
        return
    assert timeline.n_frames == n_frames


@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=6), st.integers(0, 6))
def test_a_strange_word_anywhere_is_never_passed_over(words, at):
    words.insert(min(at, len(words)), "zebra")
    assert '"zebra"' in refused(" ".join(words))


def test_every_kind_of_gesture_is_read():
    assert KINDS == ("gestures", "feelings", "rests")


def test_a_blink_keeps_its_length_beside_what_lasts():
    assert told("blink and smile for 3 s") == "EyeClose 0.5-0.7, Smile 0.5-3.5"
    assert told("smile for 3 s while blinking twice").startswith("EyeClose 0.5-0.7, Smile 0.5-3.5")
    assert told("blink for 1 s") == "EyeClose 0.5-1.5"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("smile from 1 s to 2 s for 3 s", "two times"),
        ("blink 3000000 times", '"3000000"'),
        ("smile for " + "9" * 400 + " s", "400 digits"),
        ("smile at 1." + "9" * 400 + " s", "402 digits"),
    ],
)
@pytest.mark.parametrize("n_frames", [None, 600])
def test_numbers_that_cannot_be_meant_are_refused_at_once(text, named, n_frames):
    assert named in refused(text, n_frames=n_frames)
