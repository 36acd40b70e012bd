import json
import subprocess
import sys
import time

import imageio_ffmpeg
import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.fetch import fetch
from mimeline.errors import BadConfig
from mimeline.media.frames import read_frames

KEYS = {
    "folder": None,
    "max_height": 1080,
    "attempts": 3,
    "stall_s": 0.7,
    "keep_sources": False,
    "fps": "30",
    "side_px": None,
    "max_pixels": 1_000_000,
    "max_source_s": 100.0,
    "max_mb": 10.0,
    "timeout_s": 30.0,
    "recipe": "one",
    "pause_s": 0.01,
}


LOST = 1 << 16  # bytes that came when a connection broke and are asked for again


@pytest.fixture
def run(tmp_path, web):
    """Fetches clips, given as rows, of what lies on the web server at <source_id>.mp4."""
    (tmp_path / "data").mkdir()

    def prepare(rows, **keys):
        defaults = {"source_id": "source", "start_s": 10.0, "end_s": 11.0, "actions": []}
        rows = [defaults | row for row in rows]
        clips = pd.DataFrame(rows, columns=tables.CLIPS.schema.names).assign(shard=0)
        clips["emotions"] = clips["attributes"] = clips["texts"] = [[]] * len(clips)
        tables.write(tables.CLIPS, clips, tmp_path / "in.parquet")
        files = (f"{name}.parquet" for name in ("kept", "times", "fingerprints", "ledger"))
        names = ("in.parquet", "data", *files, "media", "sources")
        paths = [tmp_path / name for name in names]
        return paths, KEYS | {"url": web.address("{source_id}.mp4")} | keys

    def run(rows, **keys):
        paths, keys = prepare(rows, **keys)
        fetch(*paths, **keys)
        return (
            tables.read(tables.CLIPS, paths[2]).set_index("clip_id"),
            tables.read(tables.SOURCE_TIMES, paths[3]),
            tables.read(tables.LEDGER, paths[5]).set_index("clip_id"),
        )

    run.prepare = prepare
    run.media, run.sources, run.data = (tmp_path / n for n in ("media", "sources", "data"))
    return run


def test_a_source_of_one_clip_gives_its_seconds_and_little_more(run, web, film):
    web.put("source.mp4", film)
    kept, _, ledger = run([{"clip_id": "a"}])
    assert kept.loc["a", "n_frames"] == 30 and kept["audio"].notna().all()
    assert ledger.loc["a", "status"] == "kept"
    assert {status for status, *_ in web.requests("source.mp4")} == {206}
    assert web.sent("source.mp4") < 0.6 * len(film)
    assert list(run.sources.iterdir()) == []


@pytest.mark.parametrize("start_s", [0.0, 10.37])
def test_a_piece_and_the_whole_show_the_same_frames_at_the_same_times(run, web, film, start_s):
    web.put("source.mp4", film)
    row = {"clip_id": "a", "start_s": start_s, "end_s": start_s + 1.0}
    kept, piece, _ = run([row])
    pictures = [frame for _, frame in read_frames(kept.loc["a", "media"], range(30))]
    (run.data / "videos").mkdir()
    (run.data / "videos" / "source.mp4").write_bytes(film)
    kept, whole, _ = run([row], folder="videos")
    pd.testing.assert_frame_equal(piece, whole)  # source_frame and source_s, exactly
    for (_, frame), of_piece in zip(
        read_frames(kept.loc["a", "media"], range(30)), pictures, strict=True
    ):
        np.testing.assert_array_equal(frame, of_piece)


def test_a_source_of_several_clips_is_taken_once_and_given_back(run, web, film):
    web.put("source.mp4", film)
    rows = [{"clip_id": f"{n}", "start_s": 5.0 * n, "end_s": 5.0 * n + 1} for n in range(4)]
    kept, times, _ = run(rows)
    assert len(kept) == 4 and kept["media"].notna().all()
    assert times.groupby("clip_id")["source_frame"].min().tolist() == [0, 150, 300, 450]
    assert web.requests("source.mp4") == [[200, 0, len(film)]]
    assert list(run.sources.iterdir()) == []


def test_a_kept_source_serves_later_clips(run, web, film):
    web.put("source.mp4", film)
    rows = [{"clip_id": "a"}, {"clip_id": "b", "start_s": 1.0, "end_s": 2.0}]
    run(rows, keep_sources=True)
    assert (run.sources / "source.d" / "whole.mp4").read_bytes() == film
    kept, _, _ = run([*rows, {"clip_id": "c", "start_s": 3.0, "end_s": 4.0}], keep_sources=True)
    assert kept["media"].notna().all() and len(web.asked) == 1


def test_what_was_cut_is_never_asked_for_again(run, web, film):
    for name in ("source.mp4", "other.mp4"):
        web.put(name, film)
    rows = [{"clip_id": "a"}, {"clip_id": "b"}, {"clip_id": "c", "source_id": "other"}]
    before = run(rows)
    asked = len(web.asked)
    for one, other in zip(before, run(rows), strict=True):
        pd.testing.assert_frame_equal(one, other)
    assert len(web.asked) == asked


def test_a_clip_that_its_download_cannot_serve_is_not_downloaded_for_again(run, web, film):
    web.put("source.mp4", film)
    rows = [{"clip_id": "a"}, {"clip_id": "late", "start_s": 23.5, "end_s": 30.0}]
    _, _, first = run(rows)
    _, _, again = run(rows)
    assert first.loc["late", "rule"] == "too_few_frames"
    detail = first.loc["late", "detail"]
    said = f"{web.address('source.mp4')}: found an end at 24 s, expected the 30 s that the clip"
    assert detail.startswith(said) and "sources" not in detail
    pd.testing.assert_frame_equal(first, again)
    assert len(web.asked) == 1


@pytest.mark.parametrize(("status", "n_clips"), [(404, 1), (410, 2)])
def test_what_is_gone_is_asked_for_once_and_never_again(run, web, status, n_clips):
    web.put("source.mp4", answers=(status,))
    rows = [{"clip_id": f"{n}"} for n in range(n_clips)]
    for _ in range(2):
        _, _, ledger = run(rows)
        assert ledger["status"].tolist() == ["failed"] * n_clips
        assert set(ledger["rule"]) == {"gone"}
        for detail in ledger["detail"]:
            assert f"the answer {status} (" in detail
            assert detail.count(f"delete {run.sources / 'source.json'} to ask again") == 1
        assert len(web.asked) == 1
    (run.sources / "source.json").unlink()
    run(rows)
    assert len(web.asked) == 2


@pytest.mark.parametrize("n_clips", [1, 2])
def test_a_page_in_place_of_a_video_is_asked_for_once_a_run(run, web, film, n_clips):
    web.put("source.mp4", b"<!doctype html><title>Sign in</title>" + b" " * 2000)
    rows = [{"clip_id": f"{n}"} for n in range(n_clips)]
    for n_runs in (1, 2):
        _, _, ledger = run(rows)
        assert set(ledger["rule"]) == {"unreachable"} and "HTML" in ledger["detail"].iloc[0]
        assert len(web.asked) == n_runs
    web.put("source.mp4", film)
    assert run(rows)[0]["media"].notna().all()


@pytest.fixture(scope="module")
def cut_off(film):
    """The film without its last third, the index at its start or lost with its end."""
    return {"first": film[: 2 * len(film) // 3], "lost": film.replace(b"moov", b"junk", 1)}


@pytest.mark.parametrize("n_clips", [1, 2])
def test_what_is_broken_where_it_lies_is_taken_once_a_run(run, web, film, cut_off, n_clips):
    web.put("source.mp4", cut_off["lost"])
    rows = [{"clip_id": f"{n}"} for n in range(n_clips)]
    for n_runs in (1, 2):
        _, _, ledger = run(rows)
        assert set(ledger["rule"]) == {"unreadable"}
        for detail in ledger["detail"]:
            assert detail.startswith(web.address("source.mp4")) and "(moov)" in detail
        wholes = [sent for *_, sent in web.requests("source.mp4") if sent == len(film)]
        assert len(wholes) == n_runs and list(run.sources.glob("*.d")) == []
    web.put("source.mp4", film)
    assert run(rows)[0]["media"].notna().all()


def test_what_is_cut_off_where_it_lies_gives_what_is_there(run, web, cut_off):
    web.put("source.mp4", cut_off["first"])
    _, _, ledger = run([{"clip_id": "late", "start_s": 15.0, "end_s": 17.0}])
    assert ledger.loc["late", "rule"] == "too_few_frames"
    assert "found an end at 15.9 s" in ledger.loc["late", "detail"]
    wholes = [sent for *_, sent in web.requests("source.mp4") if sent == len(cut_off["first"])]
    assert len(wholes) == 1
    assert run([{"clip_id": "early", "start_s": 2.0, "end_s": 3.0}])[0]["media"].notna().all()


def test_what_was_taken_up_and_does_not_play_is_taken_anew(run, web, film):
    web.put("source.mp4", film, cut_off_at=len(film) // 2, faults=1)
    rows = [{"clip_id": "a"}, {"clip_id": "b"}]
    run(rows, attempts=1)
    part = run.sources / "source.d" / "video.mp4.part"
    part.write_bytes(b"0" * part.stat().st_size)  # of another film
    assert run(rows)[0]["media"].notna().all()
    assert [status for status, *_ in web.requests("source.mp4")] == [200, 206, 200]


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"answers": (500,)}, "the answer 500 (Internal Server Error)"),
        ({"stalls": True}, "a server that stayed silent"),
        ({}, "a server that broke off after 1000 of 50000 bytes"),
    ],
    ids=["500", "stalls", "breaks off"],
)
@pytest.mark.parametrize("path", ["source.mp4", "watch/source"])
def test_what_stands_in_the_way_is_said_in_plain_words(run, web, how, said, path):
    if path.startswith("watch"):
        web.put(path, b'<!doctype html><title>A talk</title><video src="/source.mp4"></video>')
    web.put("source.mp4", b"\0" * 50_000, cut_off_at=1000, faults=9, **how)
    rows = [{"clip_id": "a"}, {"clip_id": "b"}]
    url = web.address(path.replace("source", "{source_id}"))
    _, _, ledger = run(rows, url=url, attempts=1)
    assert set(ledger["rule"]) == {"unreachable"}
    assert f"{web.address(path)}: found {said}" in ledger.loc["a", "detail"]


@pytest.mark.parametrize("path", ["{source_id}.mp4", "watch/{source_id}"])
@pytest.mark.parametrize(
    ("host", "said"),
    [
        ("127.0.0.1:9", "a server that refused the connection"),
        ("nobody.invalid", "host"),
    ],
)
def test_a_host_that_is_not_there_is_told_in_plain_words(run, path, host, said):
    _, _, ledger = run([{"clip_id": "a"}], url=f"http://{host}/{path}", attempts=1)
    detail = ledger.loc["a", "detail"]
    assert ledger.loc["a", "rule"] == "unreachable" and said in detail.partition("found ")[2]
    assert not any(raw in detail for raw in ("Errno", "urlopen", "HTTPConnection", "[download]"))


@pytest.mark.parametrize("status", [403, 302])
def test_what_is_refused_is_asked_for_once_a_run_and_never_held_for_gone(run, web, film, status):
    web.put("source.mp4", film, answers=(status, 200))
    _, _, ledger = run([{"clip_id": "a"}])
    assert ledger.loc["a", "rule"] == "unreachable" and len(web.asked) == 1
    assert run([{"clip_id": "a"}])[0]["media"].notna().all()


def test_an_error_of_the_server_is_tried_as_often_as_asked_for(run, web):
    web.put("source.mp4", answers=(500,))
    _, _, ledger = run([{"clip_id": "a"}])
    assert ledger.loc["a", "rule"] == "unreachable" and len(web.asked) == 3
    run([{"clip_id": "a"}], attempts=1)  # and in the next run again
    assert len(web.asked) == 4


def test_a_server_that_recovers_is_forgiven(run, web, film):
    web.put("source.mp4", film, answers=(500, 503, 200))
    kept, _, _ = run([{"clip_id": "a"}, {"clip_id": "b"}])
    assert kept["media"].notna().all()
    assert [status for status, *_ in web.requests("source.mp4")] == [500, 503, 200]


def test_a_server_that_asks_to_wait_is_given_time_within_reason(run, web, film):
    web.put("source.mp4", film, answers=(429, 200), headers={"Retry-After": "1"})
    kept, _, _ = run([{"clip_id": "a"}, {"clip_id": "b"}])
    assert kept["media"].notna().all() and len(web.asked) == 2
    web.put("other.mp4", film, answers=(429, 200), headers={"Retry-After": "86400"})
    _, _, ledger = run([{"clip_id": "c", "source_id": "other"}])
    assert ledger.loc["c", "rule"] == "unreachable" and len(web.asked) == 3


@pytest.mark.parametrize("stalls", [False, True], ids=["cuts off", "stalls"])
def test_a_download_that_breaks_goes_on_where_it_was(run, web, film, stalls):
    half = len(film) // 2
    web.put("source.mp4", film, cut_off_at=half, faults=1, stalls=stalls)
    kept, _, _ = run([{"clip_id": "a"}, {"clip_id": "b"}])
    assert kept["media"].notna().all()
    (first, _, sent), (second, since, rest) = web.requests("source.mp4")
    assert (first, second) == (200, 206)
    assert sent == half and since + rest == len(film)
    assert half - LOST <= since <= half  # what had come is not sent again


@pytest.mark.parametrize("stalls", [False, True], ids=["cuts off", "stalls"])
def test_a_piece_that_breaks_is_taken_anew(run, web, film, stalls):
    web.put("source.mp4", film, cut_off_at=len(film) // 2, faults=1, stalls=stalls)
    kept, times, _ = run([{"clip_id": "a", "start_s": 11.0, "end_s": 13.0}])
    assert kept.loc["a", "n_frames"] == 60 and times["source_frame"].tolist() == [*range(330, 390)]
    assert web.sent("source.mp4") < 1.3 * len(film)


def test_a_download_that_never_ends_well_is_unreachable_and_kept_for_later(run, web, film):
    half = len(film) // 2
    web.put("source.mp4", film, cut_off_at=half, faults=2)
    rows = [{"clip_id": "a"}, {"clip_id": "b"}]
    _, _, ledger = run(rows, attempts=2)
    assert set(ledger["rule"]) == {"unreachable"} and list(run.media.iterdir()) == []
    kept, _, _ = run(rows)
    assert kept["media"].notna().all() and web.sent("source.mp4") <= len(film) + 2 * LOST


@pytest.mark.parametrize("headers", [{}, {"Content-Range": "bytes 9-99/100"}])
def test_what_cannot_be_taken_up_is_begun_anew(run, web, film, headers):
    web.put("source.mp4", film, cut_off_at=len(film) // 2, faults=1)
    rows = [{"clip_id": "a"}, {"clip_id": "b"}]
    run(rows, attempts=1)
    part = run.sources / "source.d" / "video.mp4.part"
    part.write_bytes(b"0" * (len(film) + 1 if not headers else 1000))  # of another film
    web.put("source.mp4", film, headers=headers)
    kept, _, _ = run(rows)
    assert kept["media"].notna().all()
    assert [status for status, *_ in web.requests("source.mp4")][1:] == [
        206 if headers else 416,
        200,
    ]


def test_a_killed_run_goes_on_where_it_was(run, web, film):
    half = len(film) // 2
    web.put("source.mp4", film, cut_off_at=half, faults=1, stalls=True)
    rows = [{"clip_id": "a"}, {"clip_id": "b"}]
    paths, keys = run.prepare(rows, stall_s=60.0)
    code = "import json, sys; from pathlib import Path; from mimeline.clips.fetch import fetch\n"
    code += "paths, keys = json.loads(sys.argv[1]); fetch(*map(Path, paths), **keys)"
    told = json.dumps([[str(path) for path in paths], keys])
    with subprocess.Popen([sys.executable, "-c", code, told]) as killed:
        until = time.monotonic() + 60
        while time.monotonic() < until and killed.poll() is None:
            parts = [path.stat().st_size for path in run.sources.rglob("*.part")]
            if sum(parts) >= half - LOST:
                break
            time.sleep(0.02)
        killed.kill()
    kept, _, _ = run(rows)
    assert kept["media"].notna().all()
    (_, _, sent), (status, since, rest) = web.requests("source.mp4")
    assert status == 206 and since >= sent - LOST and since + rest == len(film)


def test_a_server_without_ranges_gives_the_whole_video(run, web, film):
    web.put("source.mp4", film, ranges=False)
    kept, times, _ = run([{"clip_id": "a"}])
    assert kept.loc["a", "n_frames"] == 30 and times["source_frame"].min() == 300
    assert len(web.asked) == 2  # the second gives all


def test_redirects_are_followed_and_never_to_files(run, web, film, tmp_path):
    secret = tmp_path / "secret.mp4"
    secret.write_bytes(film)
    web.put("source.mp4", answers=(302,), headers={"Location": web.address("there.mp4")})
    web.put("there.mp4", film)
    web.put("thief.mp4", answers=(302,), headers={"Location": f"file://{secret}"})
    for n_clips in (1, 2):
        rows = [{"clip_id": f"{n}", "start_s": 2.0 * n_clips} for n in range(n_clips)]
        kept, _, _ = run(rows)
        assert kept["media"].notna().all()
        thieves = [row | {"source_id": "thief"} for row in rows]
        _, _, ledger = run(thieves)
        assert (ledger["status"] == "failed").all()
        (run.sources / "thief.json").unlink(missing_ok=True)


@pytest.mark.parametrize("n_clips", [1, 2])
def test_limits_hold_for_downloads(run, web, film, n_clips):
    web.put("source.mp4", film)
    rows = [{"clip_id": f"{n}"} for n in range(n_clips)]
    _, _, ledger = run(rows, max_source_s=20.0)
    assert set(ledger["rule"]) == {"too_long_source"}
    asked = len(web.asked)
    run(rows, max_source_s=20.0)
    assert len(web.asked) == asked  # the same limit is not asked of it again
    kept, _, _ = run(rows)
    assert kept["media"].notna().all()  # another is


def test_a_download_ends_where_it_grows_too_large(run, web, film):
    web.put("source.mp4", film)
    _, _, ledger = run([{"clip_id": "a"}, {"clip_id": "b"}], max_mb=0.5)
    assert ledger["rule"].tolist() == ["too_many_bytes"] * 2
    assert ledger["limit"].tolist() == [0.5] * 2
    assert not [path for path in run.sources.rglob("*") if path.suffix != ".json"]


def test_ids_of_any_shape_are_asked_for_as_they_are(run, web, film):
    web.put("-rf.mp4", film)
    rows = [{"clip_id": "-a", "source_id": "-rf"}, {"clip_id": "-b", "source_id": "-rf"}]
    kept, _, _ = run(rows)
    assert kept["media"].notna().all() and [path for path, *_ in web.asked] == ["-rf.mp4"]
    kept, _, _ = run([{"clip_id": "-c", "source_id": "-rf"}])
    assert kept["media"].notna().all()


def test_local_videos_go_before_addresses(run, web, film):
    (run.data / "videos").mkdir()
    (run.data / "videos" / "source.mp4").write_bytes(film)
    kept, _, _ = run([{"clip_id": "a"}], folder="videos")
    assert kept["media"].notna().all() and web.asked == []


def test_nothing_is_downloaded_without_an_address(run, web):
    kept, _, ledger = run([{"clip_id": "a"}], url=None)
    assert kept["media"].isna().all() and ledger.loc["a", "rule"] == "no_video"
    assert web.asked == [] and not run.sources.exists()


def test_a_page_is_looked_through_for_its_video(run, web, film):
    page = '<!doctype html><title>A talk</title><video src="/files/{}.mp4"></video>'
    url = web.address("watch/{source_id}")
    web.put("watch/one", page.format("one").encode())
    web.put("files/one.mp4", film)
    kept, times, _ = run([{"clip_id": "a", "source_id": "one"}], url=url)
    assert kept.loc["a", "n_frames"] == 30 and times["source_frame"].min() == 300
    assert len(web.requests("watch/one")) == 1 and web.sent("files/one.mp4") < 0.7 * len(film)
    web.put("watch/none", b"<!doctype html><title>nothing here</title>")
    _, _, ledger = run([{"clip_id": "d", "source_id": "none"}], url=url)
    assert ledger.loc["d", "rule"] == "not_downloaded" and len(web.requests("watch/none")) == 1
    _, _, ledger = run([{"clip_id": "e", "source_id": "lost"}], url=url)
    assert ledger.loc["e", "rule"] == "gone"
    note = json.loads((run.sources / "lost.json").read_text())
    assert note["address"] == web.address("watch/lost") and len(web.requests("watch/lost")) == 1


def test_a_video_in_fragments_is_taken_whole_and_never_from_files(run, web, film, tmp_path):
    (tmp_path / "film.mp4").write_bytes(film)
    ffmpeg = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(tmp_path / "film.mp4")]
    subprocess.run([*ffmpeg, "-c", "copy", str(tmp_path / "film.ts")], check=True)
    fragment = (tmp_path / "film.ts").read_bytes()
    playlist = "#EXTM3U\n#EXT-X-TARGETDURATION:24\n#EXTINF:24,\n{}\n#EXT-X-ENDLIST\n"
    kind = {"Content-Type": "application/vnd.apple.mpegurl"}
    web.put("watch/good", playlist.format(web.address("1.ts")).encode(), headers=kind)
    web.put("watch/evil", playlist.format(f"file://{tmp_path}/film.ts").encode(), headers=kind)
    web.put("1.ts", fragment)
    url = web.address("watch/{source_id}")
    kept, _, _ = run([{"clip_id": "a", "source_id": "good"}], url=url)
    assert kept.loc["a", "n_frames"] == 30 and web.sent("1.ts") == len(fragment)
    evil = [{"clip_id": clip_id, "source_id": "evil"} for clip_id in "bc"]
    _, _, ledger = run(evil, url=url, attempts=1)
    assert (ledger["status"] == "failed").all() and "file:" in ledger.loc["b", "detail"]


def test_the_catalogue_may_name_a_file_that_is_read_before_any_other(run, web, film):
    (run.data / "deep" / "er").mkdir(parents=True)
    (run.data / "deep" / "er" / "take.mp4").write_bytes(film)
    (run.data / "videos").mkdir()
    (run.data / "videos" / "a.mp4").write_bytes(b"<html>")
    rows = [{"clip_id": "a", "video": "deep/er/take.mp4"}]
    kept, times, _ = run(rows, folder="videos")
    assert kept["media"].notna().all() and times["source_frame"].min() == 300
    (run.data.parent / "outside.mp4").write_bytes(film)
    _, _, ledger = run([{"clip_id": "b", "video": "../outside.mp4"}])
    assert ledger.loc["b", "status"] == "failed" and "data_dir" in ledger.loc["b", "detail"]
    assert web.asked == []


def test_films_have_fingerprints_also_when_they_are_taken_up_again(run, web, film):
    web.put("source.mp4", film)
    for _ in range(2):
        run([{"clip_id": "a", "end_s": 13.0}])
        table = tables.read(tables.FINGERPRINTS, run.data.parent / "fingerprints.parquet")
        assert set(table["clip_id"]) == {"a"} and 2 <= len(table) <= 5


def test_without_yt_dlp_one_error_says_what_to_install(run, web, film, monkeypatch):
    monkeypatch.setitem(sys.modules, "yt_dlp", None)
    monkeypatch.delitem(sys.modules, "mimeline.media.website", raising=False)
    monkeypatch.delattr("mimeline.media.website", raising=False)
    with pytest.raises(BadConfig, match=r"pip install 'mimeline\[download\]'"):
        run([{"clip_id": "a"}, {"clip_id": "b"}], url=web.address("watch/{source_id}"))
    web.put("source.mp4", film)
    for rows in ([{"clip_id": "a"}], [{"clip_id": "b"}, {"clip_id": "c"}]):
        kept, _, _ = run(rows)  # the address of a file needs none
        assert kept["media"].notna().all()


def test_nothing_is_written_elsewhere(run, web, film, tmp_path, monkeypatch):
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)
    for name in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"):
        monkeypatch.setenv(name, str(empty))
    web.put("source.mp4", film)
    kept, _, _ = run([{"clip_id": "a"}, {"clip_id": "b"}])
    assert kept["media"].notna().all() and list(empty.iterdir()) == []
    assert list(run.sources.iterdir()) == []


def test_what_no_clip_needs_any_more_is_removed(run, web, film):
    web.put("source.mp4", film, cut_off_at=1000, faults=9)
    run([{"clip_id": "a"}, {"clip_id": "b"}], attempts=1)
    assert (run.sources / "source.d").is_dir()
    web.put("other.mp4", film)
    run([{"clip_id": "c", "source_id": "other"}])
    assert not (run.sources / "source.d").exists()
