import os
import shutil

import pytest

from mimeline.errors import BadFile, NoSuchFile


@pytest.fixture(scope="module")
def mead(tmp_path_factory, put):
    """Two people, as the archives unpack and as tools flatten them, with what lies about."""
    return put(
        tmp_path_factory.mktemp("mead"),
        "M003/video/front/angry/level_1/001.mp4",
        "M003/video/left_30/angry/level_1/001.mp4",
        "M003/audio/angry/level_1/001.mp4",
        "M003/video/front/angry/level_4/001.mp4",
        "M003/video/front/.hidden/level_1/001.mp4",
        "W009_video/video/front/disgusted/level_3/010.mp4",
        "W009_front_sad_level2_002.mp4",
        "._W009_front_sad_level2_002.mp4",
    )


def test_a_path_tells_person_view_emotion_and_intensity(mead, catalogued):
    clips = catalogued(mead, "mead").clips
    assert clips.index.tolist() == [
        "M003_front_angry_level_1_001",
        "W009_front_disgusted_level_3_010",
        "W009_front_sad_level_2_002",
    ]
    clip = clips.loc["W009_front_disgusted_level_3_010"]
    assert clip[["subject_id", "emotion", "start_s", "end_s", "width", "height"]].tolist() == [
        *("W009", "disgusted", 0.0, 3.0, 96, 64)
    ]
    (emotion,) = clip["emotions"]
    assert (emotion["name"], emotion["start_s"], emotion["end_s"]) == ("disgusted", 0.0, 3.0)
    assert list(clip["attributes"]) == ["female", "intensity:3", "view:front"]
    assert clip["video"] == "W009_video/video/front/disgusted/level_3/010.mp4"
    assert list(clips.iloc[0]["attributes"]) == ["male", "intensity:1", "view:front"]


def test_a_name_that_does_not_fit_is_a_bad_record_and_an_audio_folder_is_none(mead, catalogued):
    ledger = catalogued(mead, "mead").ledger
    failed = ledger[ledger["status"] == "failed"]
    assert failed.index.tolist() == ["M003/video/front/angry/level_4/001.mp4"]
    assert "expected M003/video/front/angry/level_1/001.mp4" in failed["detail"].iloc[0]


def test_two_files_of_one_performance_are_both_named(tmp_path, put, catalogued):
    names = [f"M003_front_sad_level{between}2_007.mp4" for between in ("", "_")]
    found = catalogued(put(tmp_path / "data", *names), "mead")
    assert len(found.clips) == 1
    row = found.ledger.loc["M003_front_sad_level_2_007#2"]
    assert row["rule"] == "repeated_id" and all(name in row["detail"] for name in names)


def test_only_the_chosen_views_are_taken(mead, catalogued):
    clips = catalogued(mead, "mead", views=["left_30"]).clips
    assert clips.index.tolist() == ["M003_left_30_angry_level_1_001"]
    with pytest.raises(BadFile, match="views front, left_30 alone, expected some of top"):
        catalogued(mead, "mead", views=["top"])


def test_a_folder_of_something_else_stops_the_run(tmp_path, put, catalogued):
    put(tmp_path / "data", "a.mp4", "b.mp4")
    with pytest.raises(BadFile, match="none of 2 videos named as the format is"):
        catalogued(tmp_path / "data", "mead")
    with pytest.raises(NoSuchFile, match=r"catalogue\.mead\.folder"):
        catalogued(tmp_path / "data", "mead", folder="nowhere")
    (tmp_path / "packed").mkdir()
    (tmp_path / "packed" / "M003.tar").touch()
    with pytest.raises(BadFile, match=r"no video, but M003\.tar.*Unpack M003\.tar"):
        catalogued(tmp_path / "packed", "mead")


def test_links_are_followed_wherever_they_lead_and_circles_end(tmp_path, put, catalogued):
    data = put(tmp_path / "data", "disk/M003/video/front/sad/level_1/001.mp4")
    put(tmp_path / "away", "W009/video/front/sad/level_1/002.mp4", "film.mp4")
    (data / "mead").mkdir()
    (data / "mead" / "M003").symlink_to(data / "disk" / "M003")
    (data / "mead" / "again").symlink_to(data / "mead")
    (data / "mead" / "W009").symlink_to(tmp_path / "away" / "W009")
    (data / "mead" / "W011_front_sad_level_1_003.mp4").symlink_to(tmp_path / "away" / "film.mp4")
    found = catalogued(data, "mead", folder="mead")
    assert found.clips["video"].tolist() == [
        "mead/M003/video/front/sad/level_1/001.mp4",
        "mead/W009/video/front/sad/level_1/002.mp4",
        "mead/W011_front_sad_level_1_003.mp4",
    ]
    assert (found.ledger["status"] == "kept").all()


def test_a_folder_with_several_names_is_gone_into_once_by_its_own(tmp_path, put, catalogued):
    data = put(tmp_path / "data", "z/M003/video/front/sad/level_1/001.mp4")
    for link in ("a", "z/b"):
        (data / link).symlink_to(data / "z" / "M003")
    videos = catalogued(data, "mead").clips["video"].tolist()
    assert videos == ["z/M003/video/front/sad/level_1/001.mp4"]


def test_a_name_that_is_no_unicode_is_a_bad_record(tmp_path, put, catalogued):
    data = put(tmp_path / "data", "M003/video/front/sad/level_1/001.mp4")
    person = data / os.fsdecode(b"M\xff05")
    person.mkdir()
    (data / "M003").rename(person / "M003")
    put(data, "W009/video/front/sad/level_1/002.mp4")
    found = catalogued(data, "mead")
    assert found.clips.index.tolist() == ["W009_front_sad_level_1_002"]
    (failed,) = found.ledger[found.ledger["status"] == "failed"].itertuples()
    assert failed.rule == "unsafe_path" and "cannot be printed" in failed.detail


def test_dreamtalks_clips_of_mead_are_read(real_data, tmp_path, catalogued):
    (tmp_path / "data").mkdir()
    for path in (real_data / "dreamtalk").glob("*_neutral_*.mp4"):
        shutil.copy(path, tmp_path / "data")
    clips = catalogued(tmp_path / "data", "mead").clips
    assert clips["subject_id"].tolist() == ["M030", "W009"]
    assert clips["emotion"].tolist() == ["neutral", "neutral"]
