"""When something happens: the phrases of time, in seconds."""

from fractions import Fraction

import pytest

from mimeline.directions.times import BRIEF, LONG, When, taken

FPS = Fraction(25)


def said(text: str) -> tuple[str, list[When]]:
    rest, found = taken(text, FPS)
    return rest, list(found.values())


def seconds(value) -> Fraction:
    return Fraction(str(value))


@pytest.mark.parametrize(
    ("text", "start", "end"),
    [
        ("from 1 s to 2 s", 1, 2),
        ("from 1 to 2", 1, 2),
        ("1 - 2.5 s", 1, 2.5),
        ("between frames 10 and 40", 0.4, 1.6),
        ("from frame 10 to frame 40", 0.4, 1.6),
        ("from second 1 to second 3", 1, 3),
        ("from 200 ms to 1 second", 0.2, 1),
        ("in the first second", 0, 1),
        ("for the first two seconds", 0, 2),
    ],
)
def test_a_span_has_a_start_and_an_end(text, start, end):
    assert said(text) == ("@0", [When(start=seconds(start), end=seconds(end))])


@pytest.mark.parametrize(
    ("text", "when"),
    [
        ("for one and a half seconds", When(lasts=Fraction(3, 2))),
        ("for half a second", When(lasts=Fraction(1, 2))),
        ("over three seconds", When(lasts=Fraction(3))),
        ("for 10 frames", When(lasts=Fraction(2, 5))),
        ("2 seconds", When(lasts=Fraction(2))),
        ("at 3 s", When(start=Fraction(3))),
        ("after a second", When(start=Fraction(1))),
        ("after half a second", When(start=Fraction(1, 2))),
        ("at frame 50", When(start=Fraction(2))),
        ("until 2 s", When(end=Fraction(2))),
        ("until the end", When(until_end=True)),
        ("in the last two seconds", When(last=Fraction(2), until_end=True)),
        ("throughout", When(start=Fraction(0), until_end=True)),
        ("at the beginning", When(start=Fraction(0))),
        ("briefly", When(manner=BRIEF)),
        ("slowly", When(manner=LONG)),
        ("twice", When(times=2)),
        ("three times", When(times=3)),
    ],
)
def test_a_phrase_says_one_thing(text, when):
    assert said(text) == ("@0", [when])


@pytest.mark.parametrize(
    "text",
    [
        "as she smiles",  # not a second
        "for as long",
        "a second smile",
        "at 1 and 3 seconds",  # two moments, no span
        "in 2 seconds",  # after or within
        "every 2 seconds",
        "at a",
        "0 times",
        "half times",
    ],
)
def test_what_may_mean_something_else_is_left_in_the_text(text):
    rest, found = said(text)
    assert not any(when.lasts or when.end or when.times for when in found)
    assert rest == text or rest == "@0 and 3 seconds"


def test_a_number_is_taken_whole_or_not_at_all():
    assert said("at 0.5 s , 1.5 s") == ("@0 , 1.5 s", [When(start=Fraction(1, 2))])


def test_what_is_said_twice_must_agree_also_at_zero():
    zero, two = When(start=Fraction(0)), When(start=Fraction(2))
    assert zero.joined(two) is None and two.joined(zero) is None
    assert zero.joined(When(lasts=Fraction(1))) == When(start=Fraction(0), lasts=Fraction(1))
    assert When().joined(zero) == zero.joined(When()) == zero.joined(zero) == zero


def test_a_manner_and_a_count_are_an_action_s_own():
    twice = When(times=2, start=Fraction(1))
    assert When().beside(twice.shared) == When(start=Fraction(1))
    assert When(times=3).beside(twice.shared) == When(start=Fraction(1), times=3)
    assert When(lasts=Fraction(2)).beside(twice) == When(start=Fraction(1), lasts=Fraction(2))
    assert When(end=Fraction(2)).beside(twice) == When(end=Fraction(2))
