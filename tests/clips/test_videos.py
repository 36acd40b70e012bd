from fractions import Fraction

import numpy as np
import pytest

from mimeline import tables
from mimeline.clips.catalogue import catalogue
from mimeline.clips.catalogues.videos import read, videos_in
from mimeline.errors import BadFile, NoSuchFile
from mimeline.media.film import write_film
from mimeline.media.limits import Limits

OPTIONS = {"folder": "videos", "pattern": "*", "exclude": [], "subject": None}
LIMITS = Limits()


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Two videos, one that is none, and what lies about."""
    data = tmp_path_factory.mktemp("data")
    (data / "videos").mkdir()
    for name, frames in (("long.mp4", 75), ("short.MOV", 30)):
        pictures = [np.zeros((32, 48, 3), np.uint8)] * frames
        write_film(data / "videos" / name, pictures, Fraction(25))
    (data / "videos" / "page.mp4").write_text("<html>404</html>")
    (data / "videos" / "notes.txt").write_text("hello")
    return data


def test_each_video_is_a_source_as_long_as_itself(data):
    rows, bad = read(data, **OPTIONS | {"subject": "ann"}, limits=LIMITS)
    assert [(row["clip_id"], row["source_id"], row["subject_id"]) for row in rows] == [
        ("long", "long", "ann"),
        ("short", "short", "ann"),
    ]
    assert [(row["start_s"], row["end_s"]) for row in rows] == [(0.0, 3.0), (0.0, 1.2)]
    assert (rows[0]["width"], rows[0]["height"], rows[0]["actions"]) == (48, 32, [])
    assert [row["video"] for row in rows] == ["videos/long.mp4", "videos/short.MOV"]
    ((name, error),) = bad
    assert name == "page" and "an HTML page" in str(error)


def test_files_are_chosen_by_pattern_and_left_out_by_name(data):
    assert [
        row["clip_id"] for row in read(data, **OPTIONS | {"pattern": "l*"}, limits=LIMITS)[0]
    ] == ["long"]
    rows, bad = read(data, **OPTIONS | {"exclude": ["long.mp4", "page.mp4"]}, limits=LIMITS)
    assert [row["clip_id"] for row in rows] == ["short"] and bad == []


def test_a_folder_without_videos_is_refused(data, tmp_path):
    with pytest.raises(BadFile, match="no video, expected files that end in .mp4"):
        read(data, **OPTIONS | {"pattern": "*.txt"}, limits=LIMITS)
    for place, options in ((tmp_path, {}), (data, {"folder": "x"})):
        with pytest.raises(NoSuchFile, match="no such folder"):
            read(place, **OPTIONS | options, limits=LIMITS)
    for folder in ("..", str(tmp_path), "videos/.."):
        with pytest.raises(BadFile, match="a folder outside of data_dir"):
            read(data, **OPTIONS | {"folder": folder}, limits=LIMITS)


def test_a_videos_catalogue_can_be_cut_into_clips(data, tmp_path):
    clips, ledger = tmp_path / "clips.parquet", tmp_path / "ledger.parquet"
    catalogue(data, [clips], ledger, "videos", OPTIONS, cut_s=1.5, tracker=None, limits={})
    table = tables.read(tables.CLIPS, clips)
    assert table["clip_id"].tolist() == ["long_000", "long_001", "short"]
    assert table["end_s"].tolist() == [1.5, 3.0, 1.2]
    statuses = tables.read(tables.LEDGER, ledger).set_index("clip_id")["status"]
    assert statuses["page"] == "failed"


def test_a_video_that_breaks_a_limit_keeps_its_rule_and_numbers(data, tmp_path):
    clips, ledger = tmp_path / "clips.parquet", tmp_path / "ledger.parquet"
    limits = {"max_source_s": 2.0}
    catalogue(data, [clips], ledger, "videos", OPTIONS, cut_s=None, tracker=None, limits=limits)
    row = tables.read(tables.LEDGER, ledger).set_index("clip_id").loc["long"]
    assert row[["status", "rule", "value", "limit", "unit"]].tolist() == [
        *("failed", "too_long_source"),
        *(3.0, 2.0, "s"),
    ]
    assert "raise fetch.max_source_s" in row["detail"]


def test_a_catalogue_takes_one_video_of_a_name_and_no_hidden_file(data, tmp_path):
    videos = tmp_path / "videos"
    videos.mkdir()
    for name in ("a.mp4", "-b.mov"):
        (videos / name).write_bytes((data / "videos" / "long.mp4").read_bytes())
    for name in ("a.mov", "._a.mp4", ".hidden.mp4"):
        (videos / name).write_bytes(b"not looked at")
    rows, bad = read(tmp_path, **OPTIONS, limits=LIMITS)
    assert [row["clip_id"] for row in rows] == ["-b", "a"] and bad == []
    assert {path.name for path in videos_in(videos).values()} == {"a.mp4", "-b.mov"}


def test_a_pattern_may_look_into_folders_whose_names_tell_the_videos_apart(data, tmp_path):
    film = (data / "videos" / "short.MOV").read_bytes()
    for name in ("a/001.mp4", "b/001.mp4", "b/c/001.mp4", ".trash/001.mp4", "001.mp4"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(film)
    options = OPTIONS | {"folder": "."}
    rows, _ = read(tmp_path, **options | {"pattern": "*/*"}, limits=LIMITS)
    assert [(row["clip_id"], row["video"]) for row in rows] == [
        ("a_001", "a/001.mp4"),
        ("b_001", "b/001.mp4"),
    ]
    rows, _ = read(tmp_path, **options | {"pattern": "**/*.mp4"}, limits=LIMITS)
    assert [row["clip_id"] for row in rows] == ["001", "a_001", "b_001", "b_c_001"]


def test_links_to_another_disk_are_followed_and_circles_end(data, tmp_path):
    place = tmp_path / "data" / "videos"
    place.mkdir(parents=True)
    (place / "a.mp4").symlink_to(data / "videos" / "long.mp4")
    (place / "loop.mp4").symlink_to(place / "loop.mp4")
    (place / "lost.mp4").symlink_to(tmp_path / "nowhere.mp4")
    (place / "disk").symlink_to(data / "videos")
    (place / "back").symlink_to(place)
    rows, bad = read(tmp_path / "data", **OPTIONS | {"pattern": "**/*"}, limits=LIMITS)
    assert {row["clip_id"]: row["video"] for row in rows} == {
        "a": "videos/a.mp4",
        "disk_long": "videos/disk/long.mp4",
        "disk_short": "videos/disk/short.MOV",
    }
    assert [name for name, _ in bad] == ["disk_page", "loop", "lost"]
    rows, _ = read(tmp_path / "data", **OPTIONS | {"pattern": "*/l*"}, limits=LIMITS)
    assert [row["clip_id"] for row in rows] == ["disk_long"]


def test_the_folder_itself_may_be_a_link(data, tmp_path):
    (tmp_path / "videos").symlink_to(data / "videos")
    rows, _ = read(tmp_path, **OPTIONS, limits=LIMITS)
    assert [row["clip_id"] for row in rows] == ["long", "short"]


def test_of_two_videos_of_one_name_the_more_usual_ending_counts(tmp_path):
    for name in ("a.avi", "a.mp4", "b.MKV", "c.txt", "d.e.webm"):
        (tmp_path / name).touch()
    found = {stem: path.name for stem, path in videos_in(tmp_path).items()}
    assert found == {"a": "a.mp4", "b": "b.MKV", "d.e": "d.e.webm"}
    assert videos_in(tmp_path / "absent") == {}
