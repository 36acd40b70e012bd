import errno
import wave
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from mimeline.atomic import whole
from mimeline.errors import BadFile
from mimeline.media.box import Box
from mimeline.media.cut import cut, cut_sound, frames_shown
from mimeline.media.frames import read_frames
from mimeline.media.limits import Limits, Refused
from mimeline.media.probe import probe

NTSC, FILM = Fraction(30_000, 1001), Fraction(24_000, 1001)
MS = Fraction(1, 1000)
PIECE = {"start_s": 0.0, "n_frames": 30, "fps": Fraction(30), "box": None, "side_px": None}


def steady(fps, length_s=6):
    return [number / Fraction(fps) for number in range(int(length_s * fps))]


def uneven():
    gaps = np.random.default_rng(0).choice([16, 33, 42, 100], 150)
    return [Fraction(int(ms), 1000) for ms in np.cumsum(gaps)]


VIDEOS = {
    "film.mp4": {"times": steady(FILM), "rate": FILM, "tick": 1 / FILM},
    "pal.mp4": {"times": steady(25), "rate": Fraction(25)},
    "ntsc.mp4": {"times": steady(NTSC), "rate": NTSC, "tick": 1 / NTSC},
    "in-milliseconds.mkv": {"times": steady(30), "tick": MS},
    "fast.mkv": {"times": steady(60), "rate": Fraction(60), "tick": MS},
    "uneven.mp4": {"times": uneven()},
    "uneven.mkv": {"times": uneven(), "tick": MS},
    "begins-late.mp4": {"times": [time + Fraction(7, 10) for time in steady(30)]},
    "begins-early.mp4": {"times": [time - Fraction(1, 2) for time in steady(30)]},
    "begins-early.mkv": {"times": [time - Fraction(1, 2) for time in steady(30)]},
    "reordered.mp4": {"times": steady(30), "options": {"bf": "3", "b-pyramid": "normal"}},
    "open.ts": {"times": steady(25), "options": {"bf": "3", "x264-params": "open-gop=1"}},
    "reordered.avi": {
        "times": steady(25),
        "rate": Fraction(25),
        "tick": Fraction(1, 25),
        "options": {"bf": "3"},
    },
    "old.avi": {"times": steady(25), "rate": Fraction(25), "tick": Fraction(1, 25)}
    | {"codec": "mpeg4", "options": {"bf": "2"}},
}


@pytest.fixture(scope="module")
def second(make_video, tmp_path_factory):
    """Two seconds of numbered frames at 30 frames per second."""
    return make_video(tmp_path_factory.mktemp("second") / "source.mp4", steady(30, 2))


@pytest.mark.parametrize("name", VIDEOS)
def test_each_frame_of_a_cut_is_the_one_it_is_said_to_be(
    name, make_video, numbers_in, limits, tmp_path
):
    source = make_video(tmp_path / name, **VIDEOS[name])
    video, target = probe(source, limits), tmp_path / "cut.mp4"
    skipped = 15 if name == "begins-early.mp4" else 0  # MP4 hides what lies before its zero
    for start_s, fps in ((0.0, Fraction(25)), (4.37, NTSC)):
        piece = PIECE | {"start_s": start_s, "fps": fps}
        shown = cut(source, video, target, **piece, limits=limits)
        assert [number - skipped for number in numbers_in(target)] == shown.tolist()
        due_s = (
            start_s + (np.arange(30) + 0.5) / float(fps) - 0.001_001
        )  # and what is due just then waits
        seconds = video.times - video.times[0]
        assert shown.tolist() == (np.searchsorted(seconds, due_s) - 1).tolist()
        facts = probe(target, limits)
        assert (facts.n_frames, facts.rate, facts.times[0]) == (30, fps, 0.0)


def test_at_its_own_rate_a_video_loses_and_doubles_no_frame(make_video, limits, tmp_path):
    for name in ("film.mp4", "pal.mp4", "ntsc.mp4", "in-milliseconds.mkv", "reordered.mp4"):
        video = probe(make_video(tmp_path / name, **VIDEOS[name]), limits)
        fps = VIDEOS[name].get("rate", Fraction(30))
        shown = frames_shown(video, tmp_path / name, 1.0, 100, fps)
        assert np.diff(shown).tolist() == [1] * 99


def test_half_the_rate_takes_every_second_frame_although_times_are_rounded(
    make_video, limits, tmp_path
):
    video = probe(make_video(tmp_path / "fast.mkv", **VIDEOS["fast.mkv"]), limits)
    shown = frames_shown(video, tmp_path / "fast.mkv", 0.0, 150, Fraction(30))
    assert shown.tolist() == list(range(0, 300, 2))


def test_a_source_that_lacks_one_frame_shows_its_last_one_longer(second, limits, tmp_path):
    video = probe(second, limits)
    piece = PIECE | {"start_s": 1.0, "n_frames": 31}
    shown = cut(second, video, tmp_path / "cut.mp4", **piece, limits=limits)
    assert shown.tolist() == [*range(30, 60), 59]


def test_a_source_that_lacks_more_is_refused_with_the_number_it_has(second, limits, tmp_path):
    video = probe(second, limits)
    piece = PIECE | {"start_s": 1.0, "n_frames": 32}
    with pytest.raises(Refused, match="an end at 2 s, expected the 2.07 s") as caught:
        cut(second, video, tmp_path / "cut.mp4", **piece, limits=limits)
    refused = caught.value
    assert (refused.rule, refused.value, refused.limit) == ("too_few_frames", 30, 32)
    assert list(tmp_path.iterdir()) == []


def test_a_box_is_cut_out_and_what_lies_outside_the_picture_is_left_away(
    make_video, limits, tmp_path
):
    def halves(number):
        picture = np.zeros((96, 128, 3), np.uint8)
        picture[:, 64:, 0] = 255  # the right half is red
        picture[48:, :, 2] = 255  # the lower half is blue
        return picture

    source = make_video(tmp_path / "halves.mp4", steady(30, 1), picture=halves)
    video = probe(source, limits)
    box = Box(top=50.4, bottom=200.0, left=65.0, right=99.9)
    cut(source, video, tmp_path / "cut.mp4", **PIECE | {"box": box}, limits=limits)
    picture = dict(read_frames(tmp_path / "cut.mp4", [3]))[3].astype(int)
    assert picture.shape == (46, 34, 3)
    inner = picture[4:-4, 4:-4]
    assert inner[..., 0].min() > 200 and inner[..., 1].max() < 50 and inner[..., 2].min() > 200


def test_a_box_is_even_and_inside_the_picture():
    assert Box(-5, 30.6, 3, 40).within(50, 40) == (3, 0, 36, 30)
    assert Box.of_shares(-0.1, 0.5, 0.25, 1.2, 200, 100).within(200, 100) == (50, 0, 150, 50)
    assert Box(60, 90, 0, 10).within(50, 40)[2:] == (10, 0)


def test_a_part_too_small_to_see_a_face_in_is_refused(second, make_video, limits, tmp_path):
    with pytest.raises(Refused, match="64 x 8 pixels to cut out of 64 x 48") as caught:
        piece = PIECE | {"box": Box(40, 80, 0, 64)}
        cut(second, probe(second, limits), tmp_path / "cut.mp4", **piece, limits=limits)
    assert caught.value.rule == "too_small"
    dot = make_video(
        tmp_path / "dot.mp4", steady(30, 1), picture=lambda n: np.zeros((2, 2, 3), np.uint8)
    )
    with pytest.raises(Refused, match="2 x 2 pixels"):
        cut(dot, probe(dot, limits), tmp_path / "cut.mp4", **PIECE, limits=limits)


def test_a_square_keeps_the_shape_and_fills_with_black(second, limits, tmp_path):
    piece = PIECE | {"side_px": 128}
    cut(second, probe(second, limits), tmp_path / "cut.mp4", **piece, limits=limits)
    picture = dict(read_frames(tmp_path / "cut.mp4", [0]))[0]
    assert picture.shape == (128, 128, 3)
    assert picture[:14].max() < 10 and picture[-14:].max() < 10
    assert picture[18:-18].min() > 10


def test_a_turned_video_is_cut_upright(make_video, limits, tmp_path):
    def top_left(number):
        picture = np.zeros((48, 96, 3), np.uint8)
        picture[:24, :24] = 255
        return picture

    source = make_video(tmp_path / "turned.mp4", steady(30, 1), picture=top_left, rotation=90)
    video = probe(source, limits)
    assert (video.width, video.height) == (48, 96)
    cut(source, video, tmp_path / "cut.mp4", **PIECE, limits=limits)
    picture = dict(read_frames(tmp_path / "cut.mp4", [0]))[0]
    assert picture.shape == (96, 48, 3)
    assert picture[80:90, 8:16].min() > 200 and picture[8:16, 8:16].max() < 50


def test_pixels_become_square(make_video, limits, tmp_path):
    shape = {"pixel_shape": Fraction(4, 3), "rotation": 90}
    source = make_video(tmp_path / "wide.mp4", steady(30, 1), **shape)
    video = probe(source, limits)
    assert (video.width, video.height) == (48, 85)
    cut(source, video, tmp_path / "cut.mp4", **PIECE, limits=limits)
    made = probe(tmp_path / "cut.mp4", limits)
    assert (made.width, made.height, made.pixel_shape) == (48, 84, 1)


def test_sound_stays_with_its_picture(make_video, limits, tmp_path):
    sound = np.zeros(16_000 * 3)
    sound[24_000:24_800] = 0.5 * np.sin(np.arange(800))  # a click at 1.5 s, on frame 45
    source = make_video(tmp_path / "click.mkv", steady(30, 3), sound=sound)
    video = probe(source, limits)
    piece = PIECE | {"start_s": 1.0}
    cut(source, video, tmp_path / "cut.mp4", **piece, limits=limits)
    for path, start_s in ((source, 1.0), (tmp_path / "cut.mp4", 0.0)):
        out = tmp_path / "out.wav"
        cut_sound(path, probe(path, limits), out, start_s=start_s, length_s=1.0, limits=limits)
        with wave.open(str(out)) as file:
            assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (1, 2, 16_000)
            samples = np.frombuffer(file.readframes(file.getnframes()), np.int16)
        assert len(samples) == 16_000
        assert abs(np.flatnonzero(np.abs(samples) > 3000)[0] - 8000) < 80  # 5 ms


def test_sound_of_a_video_that_begins_late_still_fits(make_video, limits, tmp_path):
    sound = np.zeros(16_000 * 3)
    sound[24_000:24_800] = 0.5 * np.sin(np.arange(800))
    times = [time + Fraction(1, 2) for time in steady(30, 2)]
    source = make_video(tmp_path / "late.mkv", times, sound=sound)
    video, out = probe(source, limits), tmp_path / "out.wav"
    cut_sound(source, video, out, start_s=0.5, length_s=1.0, limits=limits)
    with wave.open(str(out)) as file:
        samples = np.frombuffer(file.readframes(file.getnframes()), np.int16)
    assert abs(np.flatnonzero(np.abs(samples) > 3000)[0] - 8000) < 80


def test_a_video_without_sound_has_none_to_cut(second, limits, tmp_path):
    with pytest.raises(BadFile, match="without sound"):
        video = probe(second, limits)
        cut_sound(second, video, tmp_path / "x.wav", start_s=0, length_s=1, limits=limits)


def test_the_same_cut_gives_the_same_bytes(second, limits, tmp_path):
    video = probe(second, limits)
    cut(second, video, tmp_path / "a.mp4", **PIECE, limits=limits)
    cut(second, video, tmp_path / "b.mp4", **PIECE, limits=limits)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_names_that_look_like_options_or_protocols_are_names(
    make_video, limits, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    for name in ("-x.mp4", "a:b.mp4", 'c %03d "é\n.mp4'):
        source = make_video(tmp_path / name, steady(30, 1)).relative_to(tmp_path)
        target = source.with_name("-cut" + name)
        assert len(cut(source, probe(source, limits), target, **PIECE, limits=limits)) == 30
        assert len(list(read_frames(target, [0, 29]))) == 2


def test_what_stood_there_stays_when_a_cut_fails(second, limits, tmp_path):
    video, target = probe(second, limits), tmp_path / "cut.mp4"
    target.write_text("before")
    spoilt = tmp_path / "spoilt.mp4"
    spoilt.write_bytes(second.read_bytes()[:2000])
    with pytest.raises(BadFile, match="ffmpeg stops"):
        cut(spoilt, video, target, **PIECE, limits=limits)
    with pytest.raises(Refused, match="more than 0.001 s of work") as caught:
        cut(second, video, target, **PIECE, limits=Limits(timeout_s=0.001))
    assert caught.value.rule == "timed_out"
    with pytest.raises(Refused, match="more than 0.0005 MB.*raise fetch.max_mb") as caught:
        cut(second, video, target, **PIECE, limits=Limits(max_mb=0.0005))
    assert caught.value.rule == "too_many_bytes"
    assert target.read_text() == "before"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.mp4", "spoilt.mp4"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_not_blamed_on_the_video_and_nothing_is_left(second, limits, tmp_path):
    video, target = probe(second, limits), tmp_path / "out" / "cut.mp4"
    with whole(target) as temporary:  # where cut writes
        temporary.write_text("before")
    temporary.symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left on device") as caught:
        cut(second, video, target, **PIECE, limits=limits)
    assert caught.value.errno == errno.ENOSPC
    assert [path.name for path in target.parent.iterdir()] == ["cut.mp4"]


def test_a_rotten_frame_is_named_and_nothing_is_left(make_video, limits, tmp_path):
    def noise(number):
        return np.random.default_rng(number).integers(0, 255, (64, 64, 3), np.uint8)

    source = make_video(tmp_path / "rotten.mp4", steady(30, 2), picture=noise, options={"bf": "0"})
    content = bytearray(source.read_bytes())
    middle = content.index(b"mdat") + len(content) // 2
    content[middle : middle + 20_000] = bytes(20_000)
    source.write_bytes(content)
    with pytest.raises(BadFile, match="frame .* cannot be decoded"):
        piece = PIECE | {"n_frames": 60}
        cut(source, probe(source, limits), tmp_path / "cut.mp4", **piece, limits=limits)
    assert [path.name for path in tmp_path.iterdir()] == ["rotten.mp4"]


def test_ffmpeg_follows_no_playlist(second, limits, tmp_path):
    playlists = {
        "concat.mp4": f"ffconcat version 1.0\nfile {second}\n",
        "hls.mp4": f"#EXTM3U\n#EXT-X-TARGETDURATION:2\n#EXTINF:2,\n{second}\n#EXT-X-ENDLIST\n",
    }
    for name, text in playlists.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(BadFile, match="ffmpeg stops"):
            video = probe(second, limits)
            cut(tmp_path / name, video, tmp_path / "cut.mp4", **PIECE, limits=limits)


def test_the_clips_of_a_published_data_set_keep_their_frames(real_data, limits, tmp_path):
    from scipy.io import loadmat

    for name in ("M030_front_happy_level3_001", "W009_front_fear_level3_001"):
        source = real_data / "dreamtalk" / f"{name}.mp4"
        frames = loadmat(source.with_suffix(".mat"))["coeff"].shape[0]
        video = probe(source, limits)
        assert (video.n_frames, video.rate) == (frames, 25)
        piece = PIECE | {"n_frames": frames, "fps": Fraction(25)}
        shown = cut(source, video, tmp_path / "cut.mp4", **piece, limits=limits)
        assert shown.tolist() == list(range(frames))


def test_a_phone_video_of_variable_rate_is_cut_evenly(real_data, limits, tmp_path):
    source = real_data / "video" / "face_noface.mov"
    video = probe(source, limits)
    assert video.variable and video.codec == "hevc" and video.has_sound
    piece = PIECE | {"start_s": 1.0, "n_frames": 60, "side_px": 64}
    shown = cut(source, video, tmp_path / "cut.mp4", **piece, limits=limits)
    assert not probe(tmp_path / "cut.mp4", limits).variable
    assert np.abs(video.times[shown] - video.times[0] - 1 - np.arange(60) / 30).max() < 0.07
