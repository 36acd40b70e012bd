"""The JSON that docs/catalogues.md shows is what the readers read."""

import json
import re
from pathlib import Path

import pytest

from mimeline.clips.catalogues import celebvhq, celebvtext

PAGE = Path(__file__).parents[3] / "docs" / "catalogues.md"


@pytest.fixture
def shown(tmp_path) -> Path:
    blocks = re.findall(r"```json\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    for file, block in zip(("info.json", "told.json", "hq.json"), blocks, strict=True):
        json.loads(block)
        (tmp_path / file).write_text(block)
    return tmp_path


def test_what_the_page_shows_of_celebv_text_is_read(shown):
    (row,), bad = celebvtext.read(shown, "info.json", "told.json")
    assert not bad and not row["notes"] and row["source_id"] == "aB3-x_Yz012"
    assert [action["name"] for action in row["actions"]] == ["talk", "smile"]
    assert row["attributes"] == ["lighting:frontal"]


def test_what_the_page_shows_of_celebv_hq_is_read(shown):
    (row,), bad = celebvhq.read(shown, "hq.json")
    assert not bad and row["attributes"] == ["female", "eyeglasses"]
    assert [action["name"] for action in row["actions"]] == ["talk"]
    assert [emotion["name"] for emotion in row["emotions"]] == ["happy"]
