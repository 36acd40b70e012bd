import subprocess
from fractions import Fraction

import imageio_ffmpeg
import numpy as np
import pytest

from mimeline.media.cut import cut
from mimeline.media.frames import read_frames
from mimeline.media.limits import Limits
from mimeline.media.probe import probe
from mimeline.media.remote import (
    Address,
    Declined,
    TurnedAway,
    Unreachable,
    fault,
    take_piece,
    told_by,
)

STARTS = (0.5, 11.3)
LIMITS = Limits(timeout_s=30.0)


@pytest.fixture(scope="module")
def rewrap(tmp_path_factory, film):
    """Puts the film's streams into a file of another kind."""
    folder = tmp_path_factory.mktemp("kinds")
    (folder / "film.mp4").write_bytes(film)

    def rewrap(name: str, *options: str, before: tuple[str, ...] = ()):
        ffmpeg = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-y", *before]
        source = ["-i", str(folder / "film.mp4"), "-c", "copy"]
        subprocess.run([*ffmpeg, *source, *options, str(folder / name)], check=True)
        return folder / name

    return rewrap


def shown(path, video, start_s, target):
    """The times of the source's frames that a second from start_s shows, and the pictures."""
    how = {"start_s": start_s, "n_frames": 25, "fps": Fraction(25), "box": None, "side_px": None}
    frames = cut(path, video, target, **how, limits=LIMITS)
    pictures = [picture for _, picture in read_frames(target, range(25))]
    numbers = None if video.first_frame is None else video.first_frame + frames
    return video.times[frames] - video.ahead_s, np.stack(pictures), numbers


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("film.mkv", ()),
        ("index-last.mp4", ()),
        ("fragments.mp4", ("-movflags", "frag_keyframe+empty_moov+default_base_moof")),
        ("silent.mp4", ("-an", "-video_track_timescale", "30")),
    ],
)
def test_a_piece_of_any_kind_equals_the_whole(rewrap, web, tmp_path, name, options):
    path = rewrap(name, *options)
    web.put(name, path.read_bytes())
    whole = probe(path, LIMITS)
    piece_of = tmp_path / "piece.nut"
    for start_s in STARTS:
        address = Address(web.address(name), {})
        piece, whole_s = take_piece(
            address.url, address, None, start_s, start_s + 1, piece_of, LIMITS, 5.0
        )
        assert whole_s == pytest.approx(whole.duration_s, abs=0.1)
        assert (piece.rate, piece.has_sound) == (whole.rate, whole.has_sound)
        times, pictures, numbers = shown(piece_of, piece, start_s, tmp_path / "a.mp4")
        same_times, same_pictures, same_numbers = shown(path, whole, start_s, tmp_path / "b.mp4")
        np.testing.assert_allclose(times, same_times, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(pictures, same_pictures)
        if numbers is not None:
            np.testing.assert_array_equal(numbers, same_numbers)
        tells = name.endswith(".mp4") and not name.startswith("fragments")
        assert (numbers is not None) == tells


def test_pictures_and_sound_may_lie_apart(rewrap, web, tmp_path):
    for name, option in (("pictures.mp4", "-an"), ("sound.m4a", "-vn")):
        web.put(name, rewrap(name, option).read_bytes())
    pictures, sound = (Address(web.address(name), {}) for name in ("pictures.mp4", "sound.m4a"))
    piece, _ = take_piece(
        pictures.url, pictures, sound, 11.0, 12.0, tmp_path / "piece.nut", LIMITS, 5.0
    )
    assert piece.has_sound and piece.first_frame is not None
    assert min(web.sent("pictures.mp4"), web.sent("sound.m4a")) > 0


@pytest.mark.parametrize(
    ("name", "how", "why"),
    [
        ("film.avi", {}, "AVI"),
        ("turned.mp4", {"before": ("-display_rotation", "90")}, "turned"),
        ("late.mp4", {"before": ("-ss", "0.35")}, "not shown"),
    ],
)
def test_what_a_piece_would_not_keep_is_declined(rewrap, web, tmp_path, name, how, why):
    web.put(name, rewrap(name, **how).read_bytes())
    with pytest.raises(Declined, match=why):
        address = Address(web.address(name), {})
        take_piece(address.url, address, None, 0.0, 1.0, tmp_path / "piece.nut", LIMITS, 5.0)


def test_a_file_that_points_to_files_is_not_followed(web, tmp_path, film):
    (tmp_path / "secret.mp4").write_bytes(film)
    playlist = f"ffconcat version 1.0\nfile {tmp_path}/secret.mp4\n".encode()
    web.put("list.mp4", playlist)
    manifest = b'<?xml version="1.0"?><MPD xmlns="urn:mpeg:dash:schema:mpd:2011"></MPD>'
    web.put("dash.mp4", manifest)
    web.put("hls.mp4", b"#EXTM3U\n#EXT-X-VERSION:3\n#EXTINF:9,\nfile:///etc/passwd\n")
    for name in ("list.mp4", "dash.mp4", "hls.mp4"):
        with pytest.raises((TurnedAway, Declined)):
            address = Address(web.address(name), {})
            take_piece(address.url, address, None, 0.0, 1.0, tmp_path / "piece.nut", LIMITS, 5.0)


def test_nobody_there_is_unreachable(web, tmp_path):
    with pytest.raises(Unreachable, match="refused"):
        address = Address("http://127.0.0.1:9/film.mp4", {})
        take_piece(address.url, address, None, 0.0, 1.0, tmp_path / "piece.nut", LIMITS, 5.0)
    for url in (f"file://{tmp_path}/film.mp4", "ftp://127.0.0.1/film.mp4"):
        with pytest.raises(Unreachable):
            take_piece(url, Address(url, {}), None, 0.0, 1.0, tmp_path / "piece.nut", LIMITS, 5.0)


@pytest.mark.parametrize(
    ("answers", "headers"),
    [
        ((302,), {"Location": f"http://{'a' * 70}.example/film.mp4"}),
        ((302,), {"Location": "http://[::1/film.mp4"}),
        ((429,), {"Retry-After": "²"}),
        ((429,), {"Retry-After": "Mon, 01 Jan 99999999999999999999 00:00:00 GMT"}),
        ((206,), {"Content-Range": "bytes 0-9/²"}),
        ((206,), {"Content-Range": f"bytes 0-9/{10**40}"}),
        ((206,), {"Content-Range": "bytes 700-709/800"}),
    ],
)
def test_headers_that_lie_are_a_fault_of_the_server_alone(web, tmp_path, answers, headers):
    web.put("film.mp4", b"0" * 800, answers=answers, headers=headers)
    url = web.address("film.mp4")
    with pytest.raises((Unreachable, Declined)) as raised:
        take_piece(url, Address(url, {}), None, 0.0, 1.0, tmp_path / "piece.nut", LIMITS, 5.0)
    assert "child that fails" not in str(raised.value)


def test_a_public_address_leads_a_piece_to_no_host_of_our_own(web, tmp_path, film, monkeypatch):
    for name in ("http_proxy", "https_proxy", "all_proxy"):
        monkeypatch.delenv(name, raising=False)
        monkeypatch.delenv(name.upper(), raising=False)
    web.put("film.mp4", film)
    address = Address(web.address("film.mp4"), {})
    with pytest.raises(Unreachable, match=r"private one \(127.0.0.1\)"):
        origin = "http://93.184.215.14/watch"
        take_piece(origin, address, None, 0.0, 1.0, tmp_path / "piece.nut", LIMITS, 5.0)
    assert web.asked == []


def test_what_a_server_says_is_told_in_short_and_without_its_signs():
    said = "\x1b]0;owned\x07" + "x" * 100_000
    assert "\x1b" not in str(error := fault("http://x/", LIMITS, "passing", said))
    assert len(str(error)) < 1000


def test_a_child_that_fails_is_a_fault_of_the_address(tmp_path):
    child = tmp_path / "child.py"
    child.write_text("raise KeyError('that')")
    with pytest.raises(TurnedAway, match="KeyError: 'that'"):
        told_by(str(child), {}, "http://x/", LIMITS)
