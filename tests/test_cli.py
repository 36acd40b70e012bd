import re
import subprocess
import sys
from pathlib import Path

import pytest


def test_config_writes_the_defaults_and_their_schema(mimeline, tmp_path):
    assert mimeline("config", tmp_path / "new")[0] == 0
    assert {path.name for path in (tmp_path / "new").iterdir()} == {
        "config.yaml",
        "config.schema.json",
    }


def test_the_version_is_told_without_loading_what_a_run_needs():
    code = "import sys; from mimeline import cli; cli._parser().format_help(); print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.partition(".")[0] for name in found.stdout.split()}
    assert "mimeline" in loaded and not loaded & {"pandas", "numpy", "torch", "pydantic"}


def test_a_path_where_nothing_is_ends_with_one_line(mimeline, tmp_path):
    code, said, complaint = mimeline("inspect", tmp_path / "no\nwhere")
    assert (code, said) == (1, "")
    assert complaint.startswith("mimeline: ") and len(complaint.splitlines()) == 1


def test_a_name_cannot_steer_the_terminal(mimeline, tmp_path):
    (tmp_path / "a\x1b[2Jb.json").write_text('{"x": {"ytb_id": "v", "duration": {}, "bbox": {}}}')
    (tmp_path / "c\x1b[2Jd.txt").write_text("words")
    for path in [tmp_path, *tmp_path.iterdir()]:
        code, said, complaint = mimeline("inspect", path)
        assert "\x1b" not in f"{said}{complaint}" and code in (0, 1)


def test_the_page_names_every_option(mimeline):
    page = (Path(__file__).parents[1] / "docs" / "inspect.md").read_text(encoding="utf-8")
    help = mimeline("inspect", "--help")[1]
    assert set(re.findall(r"--\w+", page)) == set(re.findall(r"--\w+", help)) - {"--help"}


@pytest.mark.parametrize("text", ["nonsense=1", "fps", "openface.stride=2", "fps=fast"])
def test_a_key_that_cannot_be_set_ends_with_what_can_be(mimeline, tmp_path, text):
    code, _, complaint = mimeline("inspect", tmp_path, "--set", text)
    assert code == 1 and complaint.startswith("mimeline: --set")
    assert "expected" in complaint
    if text in ("nonsense=1", "fps"):
        for key in ("angle_unit", "bad_values", "max_loss", "max_missing", "mirrored"):
            assert f"{key}," in complaint


def test_a_format_that_nobody_knows_ends_with_those_that_there_are(mimeline, tmp_path):
    code, _, complaint = mimeline("inspect", tmp_path, "--format", "foo")
    assert code == 1 and complaint.startswith("mimeline: --format: found 'foo'")
    assert "livelink" in complaint and "openface" in complaint


def test_colours_are_for_terminals_that_want_them(mimeline, tmp_path, monkeypatch):
    (tmp_path / "a.json").write_text('{"x": {"ytb_id": "v", "duration": {}, "bbox": {}}}')
    assert "\x1b[" not in mimeline("inspect", tmp_path / "a.json")[1]
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[" in mimeline("inspect", tmp_path / "a.json")[1]
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[" not in mimeline("inspect", tmp_path / "a.json")[1]
