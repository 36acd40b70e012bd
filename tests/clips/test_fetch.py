import json
import os
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.fetch import fetch
from mimeline.media.film import write_film
from mimeline.media.frames import read_frames
from mimeline.media.limits import Limits
from mimeline.media.probe import probe

KEYS = {
    "folder": "videos",
    "url": None,
    "max_height": 1080,
    "attempts": 3,
    "stall_s": 5.0,
    "keep_sources": False,
    "fps": "30",
    "side_px": None,
    "max_pixels": 1_000_000,
    "max_source_s": 100.0,
    "max_mb": 10.0,
    "timeout_s": 30.0,
    "recipe": "one",
}


def picture(number: int) -> np.ndarray:
    """(64, 96, 3): brighter with its number; its left third red, its lower half darker."""
    picture = np.full((64, 96, 3), 60 + 2 * number, np.uint8)
    picture[:, :32, 1:] = 0
    picture[32:] //= 2
    return picture


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """The bytes of three seconds of film with sound, at 30 frames per second."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    write_film(path, map(picture, range(90)), Fraction(30), np.zeros(48_000))
    return path.read_bytes()


@pytest.fixture
def run(tmp_path):
    """Fetches clips, given as rows, of the videos in data/videos."""
    (tmp_path / "data" / "videos").mkdir(parents=True)

    def run(rows, **keys):
        defaults = {"source_id": "source", "start_s": 0.0, "end_s": 1.0, "actions": []}
        rows = [defaults | row for row in rows]
        clips = pd.DataFrame(rows, columns=tables.CLIPS.schema.names).assign(shard=0)
        clips["emotions"] = clips["attributes"] = clips["texts"] = [[]] * len(clips)
        tables.write(tables.CLIPS, clips, tmp_path / "in.parquet")
        names = ("kept", "times", "fingerprints", "ledger")
        kept, times, fingerprints, ledger = (tmp_path / f"{name}.parquet" for name in names)
        fetch(
            tmp_path / "in.parquet",
            tmp_path / "data",
            kept,
            times,
            fingerprints,
            ledger,
            tmp_path / "media",
            tmp_path / "sources",
            **KEYS | keys,
        )
        return (
            tables.read(tables.CLIPS, kept).set_index("clip_id"),
            tables.read(tables.SOURCE_TIMES, times),
            tables.read(tables.LEDGER, ledger).set_index("clip_id"),
        )

    run.videos, run.media, run.times = (
        tmp_path / name for name in ("data/videos", "media", "times.parquet")
    )
    return run


def test_a_clip_is_cut_from_its_source_at_its_seconds(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    kept, times, ledger = run([{"clip_id": "a", "start_s": 1.0, "end_s": 2.0}])
    clip = kept.loc["a"]
    assert (clip["fps_num"], clip["fps_den"], clip["n_frames"]) == (30, 1, 30)
    assert (clip["width"], clip["height"]) == (96, 64)
    assert clip["media"] == str(run.media / "a.mp4") and clip["audio"] == str(run.media / "a.wav")
    assert probe(run.media / "a.mp4", Limits()).n_frames == 30
    shown = np.array([frame[8, 60].mean() for _, frame in read_frames(clip["media"], [0, 29])])
    assert np.abs(shown - [60 + 2 * 30, 60 + 2 * 59]).max() < 4
    assert times["source_frame"].tolist() == list(range(30, 60))
    np.testing.assert_allclose(times["source_s"], np.arange(30, 60) / 30)
    assert ledger.loc["a", "status"] == "kept" and pd.isna(ledger.loc["a", "rule"])


def test_a_clip_that_is_cut_already_is_taken_whole_from_its_start(run, film):
    (run.videos / "source.mp4").write_bytes(b"<html>")
    (run.videos / "a.MOV").write_bytes(film)
    box = {"bbox_top": 0.0, "bbox_bottom": 0.5, "bbox_left": 0.0, "bbox_right": 0.5}
    kept, times, _ = run([{"clip_id": "a", "start_s": 50.0, "end_s": 52.0} | box])
    assert (kept.loc["a", "width"], kept.loc["a", "height"]) == (96, 64)
    assert times["source_frame"].tolist() == list(range(60))


@pytest.mark.parametrize(
    "box",
    [{"top": 0, "bottom": 0.5, "left": -0.1, "right": 1 / 3}, {"top": 0, "bottom": 32}],
    ids=["shares", "pixels"],
)
def test_a_box_is_in_shares_of_the_picture_or_in_pixels(run, film, box):
    (run.videos / "source.mp4").write_bytes(film)
    box = {"left": 0, "right": 32} | box
    kept, _, _ = run([{"clip_id": "a"} | {f"bbox_{side}": float(v) for side, v in box.items()}])
    assert (kept.loc["a", "width"], kept.loc["a", "height"]) == (32, 32)
    seen = dict(read_frames(kept.loc["a", "media"], [20]))[20].astype(int)
    assert np.abs(seen[4:28, 4:28] - [100, 0, 0]).max() < 12  # red, and not the darker half


def test_pictures_are_scaled_and_rates_are_exact(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    kept, times, _ = run([{"clip_id": "a"}], fps="24000/1001", side_px=32)
    clip = kept.loc["a"]
    assert (clip["fps_num"], clip["fps_den"], clip["n_frames"]) == (24_000, 1001, 24)
    assert (clip["width"], clip["height"]) == (32, 32)
    made = probe(clip["media"], Limits())
    assert (made.width, made.height, made.rate) == (32, 32, Fraction(24_000, 1001))
    assert (times["source_s"] - np.arange(24) * 1001 / 24_000).abs().max() <= 1 / 60 + 1e-9


def test_a_clip_without_video_is_kept_and_says_so(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    kept, times, ledger = run([{"clip_id": "a"}, {"clip_id": "b", "source_id": "other"}])
    assert pd.isna(kept.loc["b", ["media", "audio", "n_frames"]]).all()
    assert ledger.loc["b", ["status", "rule"]].tolist() == ["kept", "no_video"]
    assert set(times["clip_id"]) == {"a"}


def test_without_a_folder_every_clip_is_kept_without_video(run):
    for folder in (None, "absent"):
        kept, times, ledger = run([{"clip_id": "a"}, {"clip_id": "b"}], folder=folder)
        assert kept["media"].isna().all() and times.empty
        assert (ledger["rule"] == "no_video").all()
        assert "no clip has a video" in tables.reason(run.times)
    kept, _, ledger = run([], folder=None)
    assert kept.empty and ledger.empty


def test_each_bad_video_is_a_row_that_says_what_is_wrong(run, film):
    (run.videos / "page.mp4").write_text("<!doctype html>")
    (run.videos / "empty.mp4").write_bytes(b"")
    begin = film.index(b"mdat")
    (run.videos / "cut-off.mp4").write_bytes(film[: begin + (len(film) - begin) // 2])
    (run.videos / "good.mp4").write_bytes(film)
    (run.videos / "gone.mp4").symlink_to("nowhere.mp4")
    outside = {"bbox_top": 500.0, "bbox_bottom": 600.0, "bbox_left": 0.0, "bbox_right": 100.0}
    _, _, ledger = run(
        [
            {"clip_id": "page"},
            {"clip_id": "empty"},
            {"clip_id": "cut-off", "end_s": 3.0},
            {"clip_id": "late", "source_id": "good", "start_s": 2.5, "end_s": 4.0},
            {"clip_id": "outside", "source_id": "good"} | outside,
            {"clip_id": "endless", "source_id": "good", "end_s": float("inf")},
            {"clip_id": "gone"},
            {"clip_id": "fine", "source_id": "good"},
        ]
    )
    assert ledger["status"].drop("fine").eq("failed").all()
    assert ledger["status"]["fine"] == "kept"
    assert ledger["rule"].drop("fine").to_dict() == {
        "page": "unreadable",
        "empty": "unreadable",
        "cut-off": "too_few_frames",
        "late": "too_few_frames",
        "outside": "box_outside",
        "endless": "too_long",
        "gone": "unreadable",
    }
    assert "an HTML page" in ledger["detail"]["page"]
    assert ledger.loc["late", ["value", "limit", "unit"]].tolist() == [15.0, 45.0, "frames"]
    assert f"{run.videos / 'good.mp4'}: found an end at 3 s" in ledger.loc["late", "detail"]
    assert sorted(path.name for path in run.media.iterdir()) == [
        "fine.json",
        "fine.mp4",
        "fine.wav",
    ]


def test_limits_are_rules_with_numbers_also_for_what_was_cut_before(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    run([{"clip_id": "a"}])
    for keys, rule, value in (
        ({"max_pixels": 5000}, "too_large", 96 * 64),
        ({"max_source_s": 2.0}, "too_long_source", 3.0),
        ({"max_mb": 0.001}, "too_many_bytes", len(film) / 1e6),
        ({"timeout_s": 0.001, "fps": "25"}, "timed_out", 0.001),
    ):
        run([{"clip_id": "a"}])
        _, _, ledger = run([{"clip_id": "a"}], **keys)
        assert ledger.loc["a", ["status", "rule"]].tolist() == ["failed", rule]
        assert ledger.loc["a", "value"] == pytest.approx(value)


def test_what_is_there_is_not_cut_again(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    rows = [{"clip_id": "a"}, {"clip_id": "b", "start_s": 1.0, "end_s": 2.0}]
    before = run(rows)
    made = {path.name: path.stat().st_mtime_ns for path in run.media.iterdir()}
    (run.media / "b.json").unlink()  # the run was killed before b was done
    after = run(rows)
    changed = {p.name for p in run.media.iterdir() if p.stat().st_mtime_ns != made[p.name]}
    assert changed == {"b.mp4", "b.wav", "b.json"}
    for one, other in zip(before, after, strict=True):
        pd.testing.assert_frame_equal(one, other)


def test_a_film_that_was_cut_off_or_deleted_is_cut_anew(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    run([{"clip_id": "a"}])
    made = {name: (run.media / name).read_bytes() for name in ("a.mp4", "a.wav")}
    for name, content in made.items():
        (run.media / name).write_bytes(content[: len(content) // 2])
        run([{"clip_id": "a"}])
        assert (run.media / name).read_bytes() == content
        (run.media / name).unlink()
        run([{"clip_id": "a"}])
        assert (run.media / name).read_bytes() == content


def test_what_other_code_has_cut_is_cut_anew(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    run([{"clip_id": "a"}])
    made = (run.media / "a.mp4").stat().st_mtime_ns
    run([{"clip_id": "a"}])
    assert (run.media / "a.mp4").stat().st_mtime_ns == made
    run([{"clip_id": "a"}], recipe="another")
    assert (run.media / "a.mp4").stat().st_mtime_ns != made


def test_a_film_that_grows_too_large_is_refused_with_a_number(run):
    noise = np.random.default_rng(0).integers(0, 255, (30, 64, 64, 3), np.uint8)
    write_film(run.videos / "noise.mp4", noise, Fraction(30))
    limit_mb = (run.videos / "noise.mp4").stat().st_size / 1e6 * 1.05
    _, _, ledger = run([{"clip_id": "a", "source_id": "noise"}], max_mb=limit_mb, side_px=512)
    assert ledger.loc["a", ["status", "rule", "unit"]].tolist() == [
        "failed",
        "too_many_bytes",
        "MB",
    ]
    assert ledger.loc["a", "value"] == pytest.approx(limit_mb)
    assert list(run.media.iterdir()) == []
    kept, _, _ = run([{"clip_id": "a", "source_id": "noise"}], side_px=512)
    assert Path(kept.loc["a", "media"]).stat().st_size > limit_mb * 1e6
    _, _, ledger = run([{"clip_id": "a", "source_id": "noise"}], max_mb=limit_mb, side_px=512)
    assert ledger.loc["a", "rule"] == "too_many_bytes"


@pytest.mark.parametrize(
    "change",
    [{"fps": "25"}, {"side_px": 32}, {"end_s": 1.5}, {"start_s": 0.5}, {"bbox_left": 32.0}],
    ids=lambda change: next(iter(change)),
)
def test_a_changed_parameter_cuts_anew(run, film, change):
    (run.videos / "source.mp4").write_bytes(film)
    row = {"clip_id": "a", "end_s": 1.2}
    row |= {"bbox_top": 0.0, "bbox_bottom": 64.0, "bbox_left": 0.0, "bbox_right": 64.0}
    run([row])
    before = (run.media / "a.mp4").read_bytes()
    keys = {key: value for key, value in change.items() if key in KEYS}
    run([row | {key: value for key, value in change.items() if key not in KEYS}], **keys)
    assert (run.media / "a.mp4").read_bytes() != before


def test_a_changed_video_is_cut_anew_and_a_damaged_note_costs_only_time(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    run([{"clip_id": "a"}])
    made = (run.media / "a.mp4").stat().st_mtime_ns
    os.utime(run.videos / "source.mp4", ns=(1, 1))
    run([{"clip_id": "a"}])
    again = (run.media / "a.mp4").stat().st_mtime_ns
    assert again != made
    for damage in ("{", "[]", json.dumps({"key": {}})):
        (run.media / "a.json").write_text(damage)
        kept, _, _ = run([{"clip_id": "a"}])
        assert kept.loc["a", "n_frames"] == 30


def test_files_of_clips_that_are_gone_are_removed(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    run([{"clip_id": "a"}, {"clip_id": "b"}])
    (run.media / "b.mp4.tmp").write_text("half written")
    run([{"clip_id": "a"}])
    assert sorted(path.name for path in run.media.iterdir()) == ["a.json", "a.mp4", "a.wav"]


def test_a_linked_video_is_read_where_it_lies(run, film, tmp_path):
    (tmp_path / "elsewhere.mp4").write_bytes(film)
    (run.videos / "source.mp4").symlink_to(tmp_path / "elsewhere.mp4")
    kept, _, _ = run([{"clip_id": "a"}])
    assert kept.loc["a", "n_frames"] == 30


def test_clips_of_real_videos_come_through(run, real_data):
    for name in ("d10.mp4", "face_noface.mov"):
        (run.videos / name).symlink_to(real_data / "video" / name)
    (run.videos / "empty.mp4").symlink_to(real_data / "corrupt" / "empty.mp4")
    sources = [{"clip_id": f"{s}_0", "source_id": s} for s in ("d10", "face_noface", "empty")]
    kept, times, ledger = run([row | {"start_s": 2.0, "end_s": 4.0} for row in sources], side_px=64)
    assert kept["n_frames"].tolist() == [60, 60] and kept["audio"].notna().all()
    assert times.groupby("clip_id").size().tolist() == [60, 60]
    assert ledger.loc["empty_0", "status"] == "failed"


@pytest.mark.parametrize(("fps", "what"), [("60", "shown twice"), ("15", "left out")])
def test_a_film_at_another_rate_than_its_video_is_noted(run, film, fps, what):
    (run.videos / "source.mp4").write_bytes(film)
    _, _, ledger = run([{"clip_id": "a"}], fps=fps)
    row = ledger.loc["a"]
    assert row[["status", "rule", "value"]].tolist() == ["kept", "resampled", 30]
    assert row["limit"] == float(fps)
    assert what in row["detail"]


def test_thousandths_of_a_rate_are_not_worth_a_note(run, film):
    (run.videos / "source.mp4").write_bytes(film)
    _, _, ledger = run([{"clip_id": "a"}], fps="30000/1001")
    assert pd.isna(ledger.loc["a", "rule"])
