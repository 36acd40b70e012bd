import re
from pathlib import Path

import cv2

from mimeline.face.formats import shapes

DOCS = Path(__file__).parents[2] / "docs" / "face.md"


def test_the_example_of_the_page_runs_and_writes_a_film_and_a_strip(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(example, str(DOCS), "exec"), {})
    assert (tmp_path / "smile.mp4").stat().st_size > 1000
    assert cv2.imread(tmp_path / "smile.png").shape == (256, 4 * 256, 3)


def test_the_page_names_every_array_of_an_npz():
    page = DOCS.read_text(encoding="utf-8")
    for name in (*shapes.REQUIRED, *shapes.JOINTS, *shapes.OPTIONAL):
        assert f"`{name}`" in page
