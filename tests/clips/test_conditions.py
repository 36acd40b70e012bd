import re
from pathlib import Path

import pandas as pd
import pytest
import yaml

from mimeline import tables
from mimeline.clips.conditions import COLUMNS, condition, facts
from mimeline.errors import BadConfig


def named(*names: str) -> list[dict]:
    return [{"name": name, "start_s": None, "end_s": None, "uncertainty_s": None} for name in names]


@pytest.fixture(scope="module")
def clips(tmp_path_factory) -> pd.DataFrame:
    """Three clips as a table holds them: a has everything, b little, c nothing."""
    rows = [
        {
            "clip_id": "a",
            "subject_id": "anna",
            "end_s": 6.5,
            "width": 640,
            "height": 600,
            "emotion": "happy",
            "actions": named("smile", "talk"),
            "attributes": ["female", "lighting:frontal"],
            "emotions": named("happy", "neutral"),
        },
        {"clip_id": "b", "end_s": 9.0, "width": 300, "height": 300, "actions": named("nod")},
        {"clip_id": "c", "source_id": "t", "end_s": 5.0},
    ]
    blank = dict.fromkeys(tables.CLIPS.schema.names) | {
        "source_id": "s",
        "start_s": 0.0,
        "shard": 0,
    }
    blank |= {"actions": [], "emotions": [], "attributes": [], "texts": []}
    path = tmp_path_factory.mktemp("clips") / "clips.parquet"
    tables.write(tables.CLIPS, pd.DataFrame([blank | row for row in rows]), path)
    return tables.read(tables.CLIPS, path)


@pytest.mark.parametrize(
    ("text", "expected"),  # of a, b and c: y, n or ? where a value is not known
    [
        ("emotion == 'happy'", "y??"),
        ("emotion != 'happy'", "n??"),
        ("emotion in ('happy', 'sad')", "y??"),
        ("emotion not in ['happy']", "n??"),
        ("emotion is not None", "ynn"),
        ("emotion is None", "nyy"),
        ("duration_s < 8 and side_px >= 512", "yn?"),
        ("duration_s < 8 or emotion == 'sad'", "y?y"),
        ("duration_s > 8 and side_px >= 512", "nnn"),
        ("not side_px < 512", "yn?"),
        ("5 < duration_s <= 6.5", "ynn"),
        ("width == height", "ny?"),
        ("width > -1 and width in {640, 300}", "yy?"),
        ("'smile' in actions", "ynn"),
        ("'smil' in actions", "nnn"),
        ("'nod' not in actions", "yny"),
        ("'female' in attributes or 'neutral' in emotions", "ynn"),
        ("clips_of_source == 2", "yyn"),
        ("subject_id == 'anna' or clip_id == \"c\"", "y?y"),
        (" (source_id == 's')\n", "yyn"),
    ],
)
def test_a_condition_holds_fails_or_cannot_be_told(clips, text, expected):
    asked = condition(text)
    holds = asked.holds(facts(clips, asked.columns))
    told = ["?" if pd.isna(value) else "ny"[int(value)] for value in holds]
    assert "".join(told) == expected


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "expected a comparison such as emotion == 'happy'"),
        ("emotion = 'happy'", "invalid syntax, expected a comparison such as emotion == 'happy'"),
        ("emotion == happy", "happy, which is no column"),
        ("emoton == 'happy'", "expected one of clip_id, source_id"),
        ("emotion", "expected a comparison"),
        ("duration_s", "expected a comparison"),
        ("emotion < 'happy'", "texts compared by == or !="),
        ("duration_s == 'long'", "a number and a text"),
        ("width == emotion", "a number and a text"),
        ("1 < 2", "a column in it"),
        ("emotion == True", "a number, a text in quotes, or a column"),
        ("emotion == None", "a number, a text in quotes, or a column"),
        ("actions == 'smile'", "'smile' in actions"),
        ("actions in ('smile', 'nod')", "a list of values"),
        ("duration_s in ()", "a list of values"),
        ("duration_s in (5, 'six')", "a list of values"),
        ("'smile' in emotion", "one of emotions, actions, attributes"),
        ("7 in actions", "a name in quotes"),
        ("actions in actions", "a value in its place"),
        ("duration_s is 5", "found duration_s is 5"),
        ("emotion == 'a' & width > 3", "expected"),
        ("(emotion == 'a') & (width > 3)", "expected and, or, not"),
        ("actions has 'smile'", "invalid syntax"),
        ("duration_s + 1 < 3", "a number, a text in quotes, or a column"),
        ("emotion.upper() == 'X'", "found emotion.upper()"),
        ("__import__('os').system('true') == 0", "found __import__"),
        ("[c for c in ()] == 3", "expected"),
        ("@emotion == 'happy'", "invalid syntax"),
        ("lambda: 1", "expected a comparison"),
        ("emotion == f'{clip_id}'", "expected"),
        ("emotion == 'a\0b'", "null bytes"),
        ("(" * 500 + "1" + ")" * 500, "expected a comparison"),
        ("not " * 100_000 + "1", "expected a comparison"),
    ],
)
def test_what_is_no_condition_is_refused_with_what_may_stand_there(text, told):
    with pytest.raises(BadConfig) as error:
        condition(text)
    assert told in str(error.value) and error.value.file == "select.conditions"


def test_every_column_can_be_asked_for(clips):
    assert list(facts(clips, COLUMNS)) == list(COLUMNS)
    for column in COLUMNS:
        assert condition(f"{column} is not None").columns == (column,)


def test_a_broken_condition_tells_what_the_clip_has(clips):
    asked = condition(
        "emotion == 'sad' and 'nod' in actions and side_px > 10 and 'x' in attributes"
    )
    first, second, _ = asked.values(facts(clips, asked.columns), [0, 1, 2])
    assert first.endswith(
        ": emotion happy, actions smile, talk, side_px 600, attributes female, lighting:frontal"
    )
    assert second.endswith(": emotion not known, actions nod, side_px 300, attributes none")


def test_a_condition_that_was_not_applied_tells_for_want_of_what(clips):
    asked = condition("emotion == 'sad' or side_px > 512")
    told = asked.gaps(facts(clips, asked.columns), [0, 1, 2])
    assert told[1].endswith("the catalogue does not give emotion")
    assert told[2].endswith("the catalogue does not give emotion, side_px")
    assert all(text.startswith("not applied: emotion == 'sad' or side_px > 512: ") for text in told)


def test_conditions_on_no_clip_hold_for_nobody(clips):
    none = clips.iloc[:0]
    for text in ("emotion == 'happy'", "'smile' in actions", "duration_s in (5, 6)", "width == 3"):
        asked = condition(text)
        known = facts(none, asked.columns)
        assert (
            len(asked.holds(known)) == 0 and asked.values(known, []) == asked.gaps(known, []) == []
        )


def test_the_page_has_every_column_and_its_conditions_are_some():
    page = (Path(__file__).parents[2] / "docs" / "selection.md").read_text(encoding="utf-8")
    section = page.split("## Conditions")[1].split("## Duplicates")[0]
    rows = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    assert {name for row in rows for name in re.findall(r"`(\w+)`", row)} == set(COLUMNS)
    (block,) = re.findall(r"```yaml\n(.*?)```", section, re.DOTALL)
    for text in yaml.safe_load(block)["select"]["conditions"]:
        assert condition(text).columns


@pytest.mark.parametrize("text", ["duration_s < 1" + "0" * 400, "width in (1, 1" + "0" * 400 + ")"])
def test_a_number_that_no_clip_can_have_is_refused_in_few_words(text):
    with pytest.raises(BadConfig, match="too large") as refused:
        condition(text)
    assert len(str(refused.value)) < 500
