import re
from fractions import Fraction
from pathlib import Path

import mimeline

DOCS = Path(__file__).parents[2] / "docs" / "video.md"
CODE = Path(mimeline.__file__).parent


def test_the_example_of_the_page_runs_and_cuts_a_clip(
    make_video, numbers_in, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    make_video(tmp_path / "talk.mov", [Fraction(number, 30) for number in range(240)])
    (example,) = re.findall(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    names = {}
    exec(compile(example, str(DOCS), "exec"), names)
    assert numbers_in(tmp_path / "clip.mp4")[:3] == [60, 61, 62]
    assert [number for number, _ in names["pictures"]] == [0, 75, 149]


def test_the_page_names_every_rule_that_fails_a_clip():
    stage = [CODE / "clips" / f"{name}.py" for name in ("fetch", "piece", "film", "download")]
    files = [*(CODE / "media").glob("*.py"), *stage]
    rules = {r for file in files for r in re.findall(r'rule ?= ?"(\w+)"', file.read_text())}
    listed = set(re.findall(r"^\| `(\w+)` \|", DOCS.read_text(encoding="utf-8"), re.MULTILINE))
    assert len(rules) > 5 and rules | {"no_video", "resampled", "unreadable"} == listed
