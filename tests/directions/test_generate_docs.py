"""docs/generate.md: what it says is understood is understood, and nothing is left out."""

import re
from fractions import Fraction
from pathlib import Path

import pytest

from mimeline.directions import gestures
from mimeline.directions.sentences import NotUnderstood, read
from mimeline.directions.text import in_words
from mimeline.vocabulary import ACTIONS

MANUAL = (Path(__file__).parents[2] / "docs" / "generate.md").read_text(encoding="utf-8")
SIMPLE = MANUAL.partition("## Simple sentences")[2].partition("\n## ")[0]
TABLE = [row.split("|")[1:3] for row in SIMPLE.splitlines() if row.startswith("| `")]
FPS = Fraction(30)


@pytest.mark.parametrize(("said", "done"), TABLE)
def test_what_a_row_says_is_done(said, done):
    named = {action for action in ACTIONS if re.search(rf"\b{action}\b", done)}
    found = set()
    for text in re.findall("`([^`]+)`", said):
        if text in ("slightly", "gently", "faintly"):
            text = f"smile {text}"
        found |= {heard.action for heard in read(text, FPS)[1]}
    assert found == named


def test_the_table_has_every_action_gesture_and_feeling():
    assert all(any(action in done for _, done in TABLE) for action in ACTIONS)
    texts = " ".join(said for said, _ in TABLE).replace("`", " ")
    for kind in gestures.KINDS:
        for own in gestures._TOLD[kind]:
            first_words = {said.split()[0] for said in own["say"].split(", ")}
            assert any(re.search(rf"\b{word}\b", texts) for word in first_words), own["say"]


def test_the_examples_are_what_comes_out():
    block = SIMPLE.partition("```\n")[2].partition("```")[0]
    for line in block.splitlines():
        text, told = re.split(r"  +", line, maxsplit=1)
        if told.startswith("refused: "):
            with pytest.raises(NotUnderstood) as caught:
                read(text, FPS)
            assert told.removeprefix("refused: ") in str(caught.value)
        else:
            assert in_words(read(text, FPS)[0]) == told
