"""What is called how: every line of the resource says what it does."""

import itertools
import re

import pytest

from mimeline.directions import gestures
from mimeline.directions.gestures import FILLERS, KINDS, PLAIN, UNSAYABLE, WAYS, matched
from mimeline.timeline.timeline import SIDES
from mimeline.vocabulary import ACTIONS

LINES = [
    (said, own) for kind in KINDS for own in gestures._TOLD[kind] for said in own["say"].split(", ")
]


def said_in_full(line: str) -> list[str]:
    """A line with its ways and sides, with and without what may be left out."""
    optional = re.split(r"(\[[^]]+\])", line)
    kept = [(part,) if part[:1] != "[" else (part[1:-1], "") for part in optional]
    texts = [" ".join("".join(parts).split()) for parts in itertools.product(*kept)]
    for text in texts[:]:
        if "{way}" in text:
            texts += [text.replace("{way}", way) for way in WAYS]
        if "{side}" in text:
            texts += [" ".join(text.replace("{side}", side).split()) for side in (*SIDES, "")]
    return [text for text in texts if "{" not in text]


@pytest.mark.parametrize(("line", "own"), LINES, ids=[line for line, _ in LINES])
def test_every_line_is_understood_as_what_it_does(line, own):
    for text in said_in_full(line):
        plain = [PLAIN.get(word, word) for word in text.split()]
        assert not [word for word in plain if word in FILLERS], "a filler is never looked up"
        found, unknown = matched(plain, None)
        assert len(found) == 1 and not unknown, text
        done = {action for step in found[0].steps for action in step}
        if "{way}" in line:
            ways = [way.capitalize() for way in WAYS if way in text.split()]
            assert done == {own["do"][0].replace("{way}", way) for way in ways}
        else:
            assert done == set(own["do"])
        if "{side}" in line:
            sides = [side for side in SIDES if side in text.split()]
            assert found[0].side == (sides[0] if sides else own.get("side"))


def test_every_action_can_be_said():
    sayable = {
        action.replace("{way}", way.capitalize())
        for _, own in LINES
        for action in own["do"]
        for way in WAYS
    }
    assert sayable == set(ACTIONS)


@pytest.mark.parametrize(
    ("form", "plain"),
    [("smiles", "smile"), ("smiling", "smile"), ("winked", "wink"), ("eyebrows", "brow"),
     ("nodding", "nod"), ("shook", "shake"), ("eye's", "eye"), ("upwards", "up")],
)  # fmt: skip
def test_words_stand_in_any_form(form, plain):
    assert PLAIN[form] == plain


def test_no_word_is_both_understood_and_called_unsayable():
    assert not set(UNSAYABLE) & FILLERS
    assert {PLAIN.get(word, word) for word in UNSAYABLE} & FILLERS == set()


def test_a_way_alone_goes_on_with_what_was_turned_last():
    (look,), _ = matched(["look", "up"], None)
    (left,), unknown = matched(["left"], look)
    assert left.steps == (("GazeLeft",),) and left.goes_on and not unknown
    assert matched(["left"], None) == ([], ["left"])
    (smile,), _ = matched(["smile"], None)
    assert matched(["left"], smile) == ([], ["left"])
    assert left.excludes(matched(["right"], look)[0][0]) and not left.excludes(look)
