import pytest

from mimeline.errors import BadFile
from mimeline.tracking.readers import READERS, Tracker


def tracker(data, format: str, **options) -> Tracker:
    return Tracker.of(data, format, {"folder": ".", "fps": "30"} | options, "fail")


def test_takes_are_the_files_of_the_formats_ending_and_no_others(tmp_path):
    for name in ("b.csv", "a.CSV", "notes.txt", ".hidden.csv", "a.mp4", "b.loss.csv"):
        (tmp_path / name).touch()
    (tmp_path / "folder.csv").mkdir()
    assert [path.name for path in tracker(tmp_path, "livelink").takes()] == ["a.CSV", "b.csv"]


def test_takes_of_folders_are_the_folders_that_hold_the_tracker_s_files(tmp_path):
    (tmp_path / "one.v2" / "checkpoint").mkdir(parents=True)
    (tmp_path / "one.v2" / "checkpoint" / "00000.frame").touch()
    (tmp_path / "pictures").mkdir()
    (tmp_path / "notes.txt").touch()
    found = tracker(tmp_path, "metrical_tracker", face=None)
    assert [path.name for path in found.takes()] == ["one.v2"]
    assert found.result("one.v2") == tmp_path / "one.v2"
    assert found.result("notes.txt") is None


def test_a_result_is_found_by_its_name_whatever_the_case_of_its_ending(tmp_path):
    (tmp_path / "a.CSV").touch()
    assert tracker(tmp_path, "livelink").result("a") == tmp_path / "a.CSV"
    assert tracker(tmp_path, "livelink").result("b") is None


def test_a_folder_that_is_not_there_holds_no_takes(tmp_path):
    assert tracker(tmp_path, "livelink", folder="nowhere").takes() == []


def test_a_face_model_lies_under_the_data_folder(tmp_path):
    found = tracker(tmp_path, "flame", face="flame.npz")
    assert found.reading["face"] == tmp_path / "flame.npz"
    assert tracker(tmp_path, "flame", face=None).reading["face"] is None
    for name in ("flame.npz", "take.npz"):
        (tmp_path / name).touch()
    assert [path.name for path in found.takes()] == ["take.npz"]


@pytest.mark.parametrize("format", READERS)
def test_every_reader_declares_its_format_and_refuses_an_empty_file(tmp_path, format):
    reader = READERS[format]
    told = reader.convention
    for text in (told.title, told.files, told.coefficients, told.sides, told.gap, told.evidence):
        assert text
    path = tmp_path / f"empty{reader.endings[0] if reader.endings else ''}"
    path.touch() if reader.endings else path.mkdir()
    assert not reader.holds(path)
    from mimeline.config import Config

    block = getattr(Config().ingest, format).model_dump(exclude={"folder"})
    with pytest.raises(BadFile):
        reader.read(path, bad_values="fail", **block)
