import logging

import pytest

from mimeline.clips.catalogues import ravdess
from mimeline.errors import BadFile
from mimeline.media.limits import Limits


@pytest.fixture(scope="module")
def data(tmp_path_factory, put):
    """An actor's folder, a flat file and what lies about."""
    return put(
        tmp_path_factory.mktemp("ravdess"),
        "Actor_12/01-01-06-01-02-01-12.mp4",
        "Actor_12/02-01-06-01-02-01-12.mp4",
        "Actor_12/03-01-06-01-02-01-12.mp4",
        "02-02-01-01-01-02-11.mp4",
        "01-09-01-01-01-01-01.mp4",
        "01-01-01-01-01-01-25.mp4",
        "holiday.mp4",
    )


def test_a_name_tells_actor_emotion_intensity_and_statement(data, catalogued):
    clips = catalogued(data, "ravdess").clips
    fearful, neutral = clips.loc["01-01-06-01-02-01-12"], clips.loc["02-02-01-01-01-02-11"]
    assert fearful[["subject_id", "emotion", "end_s"]].tolist() == ["Actor_12", "fearful", 3.0]
    assert fearful["emotions"][0]["end_s"] == 3.0
    assert list(fearful["attributes"]) == [
        *("female", "intensity:normal", "statement:dogs", "channel:speech", "repetition:1")
    ]
    assert list(neutral["attributes"]) == [
        *("male", "intensity:normal", "statement:kids", "channel:song", "repetition:2")
    ]
    assert fearful["video"] == "Actor_12/01-01-06-01-02-01-12.mp4"


def test_the_same_pictures_are_taken_once_and_sound_alone_not_at_all(data, caplog):
    with caplog.at_level(logging.INFO):
        rows, _ = ravdess.read(data, ".", Limits())
    assert [row["clip_id"] for row in rows] == ["02-02-01-01-01-02-11", "01-01-06-01-02-01-12"]
    assert "1 videos without sound (02-...) passed over" in caplog.text
    assert "1 files of sound alone (03-...) passed over" in caplog.text


def test_a_performance_that_lies_in_two_folders_is_told_with_both(tmp_path, put, catalogued):
    names = [f"{folder}/01-01-06-01-02-01-12.mp4" for folder in ("Actor_12", "again")]
    found = catalogued(put(tmp_path / "data", *names), "ravdess")
    row = found.ledger.loc["01-01-06-01-02-01-12#2"]
    assert row["rule"] == "repeated_id" and all(name in row["detail"] for name in names)


def test_a_name_that_does_not_fit_is_a_bad_record(data, catalogued):
    ledger = catalogued(data, "ravdess").ledger
    failed = ledger[ledger["status"] == "failed"]
    assert set(failed.index) == {"01-09-01-01-01-01-01", "01-01-01-01-01-01-25", "holiday"}
    assert failed["detail"].str.contains("expected 01-01-06-01-02-01-12").all()


def test_a_folder_of_other_videos_stops_the_run(tmp_path, put, catalogued):
    with pytest.raises(BadFile, match="named as the format is"):
        catalogued(put(tmp_path / "data", "a.mp4"), "ravdess")
