from pathlib import Path

import pytest

from mimeline.atomic import whole, whole_folder


def test_a_file_appears_when_it_is_whole(tmp_path):
    with whole(tmp_path / "new" / "a.txt") as temporary:
        temporary.write_text("whole")
        assert not (tmp_path / "new" / "a.txt").exists()
    assert (tmp_path / "new" / "a.txt").read_text() == "whole"
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["a.txt"]


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_what_stood_there_stays_when_writing_fails(tmp_path, error):
    (tmp_path / "a.txt").write_text("before")
    with pytest.raises(error), whole(tmp_path / "a.txt") as temporary:
        temporary.write_text("half")
        raise error
    assert (tmp_path / "a.txt").read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_folder_takes_the_place_of_the_one_before(tmp_path):
    for content in ("first", "second"):
        with whole_folder(tmp_path / "new" / "of") as temporary:
            (temporary / content).write_text(content)
            assert not (tmp_path / "new" / "of" / content).exists()
    assert [path.name for path in (tmp_path / "new").rglob("*")] == ["of", "second"]


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_the_folder_that_stood_there_stays_when_writing_fails(tmp_path, error):
    (tmp_path / "of").mkdir()
    (tmp_path / "of" / "before").touch()
    with pytest.raises(error), whole_folder(tmp_path / "of") as temporary:
        (temporary / "half").touch()
        raise error
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["before", "of"]


def test_the_folder_that_stood_there_comes_back_when_its_place_cannot_be_taken(
    tmp_path, monkeypatch
):
    (tmp_path / "of").mkdir()
    (tmp_path / "of" / "before").touch()
    replace = Path.replace

    def replaced(path, target):
        if path.suffix == ".tmp":
            raise OSError("the disk is gone")
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", replaced)
    with pytest.raises(OSError), whole_folder(tmp_path / "of"):
        pass
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["before", "of"]
