import os
import signal
import struct
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from mimeline.errors import BadFile, NoSuchFile
from mimeline.media.limits import Limits, Refused
from mimeline.media.probe import probe

SECOND = [Fraction(number, 30) for number in range(30)]


@pytest.fixture(scope="module")
def second(make_video, tmp_path_factory):
    return make_video(tmp_path_factory.mktemp("second") / "second.mp4", SECOND)


def test_a_video_is_known_by_what_it_shows(make_video, limits, tmp_path):
    sound = np.zeros(16_000)
    video = probe(make_video(tmp_path / "a.mkv", SECOND, sound=sound), limits)
    assert (video.container, video.codec) == ("matroska", "h264")
    assert (video.width, video.height, video.rate) == (64, 48, 30)
    assert video.has_sound and not video.variable
    assert video.n_frames == 30
    np.testing.assert_allclose(video.times, np.arange(30) / 30, atol=0.0006)
    assert video.duration_s == pytest.approx(1.0, abs=0.002)


def test_times_keep_the_offset_of_the_first_frame_and_their_unevenness(
    make_video, limits, tmp_path
):
    times = [Fraction(n, 100) for n in (50, 53, 60, 61, 80)]
    video = probe(make_video(tmp_path / "a.mp4", times), limits)
    np.testing.assert_allclose(video.times, [0.5, 0.53, 0.6, 0.61, 0.8])
    assert video.variable


def test_frames_before_the_first_key_frame_do_not_count(make_video, limits, tmp_path):
    whole = make_video(tmp_path / "a.ts", [Fraction(n, 25) for n in range(60)])
    content = whole.read_bytes()
    whole.write_bytes(content[188 * (len(content) // 188 // 8) :])  # begins between key frames
    video = probe(whole, limits)
    with av.open(str(whole)) as file:
        decoded = [frame.time for frame in file.decode(video=0)]
    assert video.n_frames < 60
    np.testing.assert_allclose(video.times, decoded[-video.n_frames :])
    assert video.n_frames >= len(decoded) - 1


NO_VIDEOS = {
    "empty": (b"", "an empty file"),
    "page": (b"\n<!DOCTYPE html><title>Not found</title>", "an HTML page"),
    "pointer": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0", "a Git LFS pointer"),
    "playlist": (b"#EXTM3U\n#EXT-X-TARGETDURATION:9\nother.ts\n", "a playlist (HLS)"),
    "list": (b"ffconcat version 1.0\nfile second.mp4\n", "a playlist (ffconcat)"),
    "archive": (b"PK\x03\x04" + bytes(40), "a ZIP archive"),
    "wav": (b"RIFF\x24\0\0\0WAVEfmt ", "sound without pictures (WAV)"),
    "text": (b"frame,yaw\n" * 90, "a file of another kind|no video that can be opened"),
    "noise": (bytes(np.random.default_rng(0).bytes(100_000)), "no video that can be opened"),
}


@pytest.mark.parametrize("name", NO_VIDEOS)
def test_what_is_no_video_is_called_what_it_is(name, limits, tmp_path):
    content, kind = NO_VIDEOS[name]
    (tmp_path / "clip.mp4").write_bytes(content)
    with pytest.raises(BadFile, match=kind.replace("(", r"\(").replace(")", r"\)")):
        probe(tmp_path / "clip.mp4", limits)


def test_a_picture_or_sound_under_a_videos_name_is_no_video(limits, tmp_path):
    for kind, called in (("png", "PNG"), ("jpg", "JPEG"), ("webp", "WebP")):
        picture = cv2.imencode(f".{kind}", np.zeros((8, 8, 3), np.uint8))[1]
        (tmp_path / "clip.mp4").write_bytes(picture.tobytes())
        with pytest.raises(BadFile, match=f"a picture .{called}"):
            probe(tmp_path / "clip.mp4", limits)
    with av.open(str(tmp_path / "sound.mp4"), "w") as file:
        audio = file.add_stream("aac", rate=16_000, layout="mono")
        frame = av.AudioFrame.from_ndarray(
            np.zeros((1, 16_000), np.float32), format="fltp", layout="mono"
        )
        frame.sample_rate = 16_000
        file.mux([*audio.encode(frame), *audio.encode(None)])
    with pytest.raises(BadFile, match="sound without pictures"):
        probe(tmp_path / "sound.mp4", limits)


def test_an_unusual_codec_is_named(make_video, limits, tmp_path):
    with pytest.raises(BadFile, match="the codec wmv2"):
        probe(make_video(tmp_path / "a.avi", SECOND, codec="wmv2"), limits)


def test_a_title_in_an_old_encoding_does_no_harm(make_video, limits, tmp_path):
    path = make_video(tmp_path / "a.mkv", SECOND, title="Gespr??ch")
    path.write_bytes(path.read_bytes().replace(b"Gespr??ch", b"Gespr\xe4\xfcch"))
    assert probe(path, limits).n_frames == 30


def test_a_file_cut_off_before_its_index_says_so(second, limits, tmp_path):
    content = second.read_bytes()
    (tmp_path / "a.mp4").write_bytes(content[: content.index(b"moov") - 100])
    with pytest.raises(BadFile, match="without its index"):
        probe(tmp_path / "a.mp4", limits)


def test_a_file_cut_off_after_its_index_has_the_frames_that_are_there(limits, tmp_path):
    from mimeline.media.film import write_film

    noise = np.random.default_rng(0).integers(0, 255, (60, 64, 64, 3), np.uint8)
    write_film(tmp_path / "a.mp4", noise, Fraction(30))
    content = (tmp_path / "a.mp4").read_bytes()
    (tmp_path / "a.mp4").write_bytes(content[: len(content) // 2])
    assert 20 < probe(tmp_path / "a.mp4", limits).n_frames < 40
    (tmp_path / "a.mp4").write_bytes(content[: content.index(b"mdat") + 50])
    with pytest.raises(BadFile, match="no picture can be decoded"):
        probe(tmp_path / "a.mp4", limits)


def test_a_header_that_promises_a_huge_picture_is_refused(limits, tmp_path):
    path = tmp_path / "huge.avi"
    with av.open(str(path), "w") as file:
        video = file.add_stream("rawvideo", rate=30)
        video.width, video.height, video.pix_fmt = 64, 48, "bgr24"
        frame = av.VideoFrame.from_ndarray(np.zeros((48, 64, 3), np.uint8), format="bgr24")
        file.mux(video.encode(frame))
    assert probe(path, limits).width == 64
    content = bytearray(path.read_bytes())
    size = content.index(b"strf") + 12  # width and height of the bitmap's header
    for side, said in ((16_000, "16000 x 16000"), (32_768, "an impossible one")):
        content[size : size + 8] = struct.pack("<II", side, side)
        path.write_bytes(content)
        with pytest.raises(BadFile, match=said) as caught:
            probe(path, limits)
        if side == 16_000:  # the larger one libav refuses by itself
            assert (caught.value.rule, caught.value.value) == ("too_large", side**2)


def test_a_picture_that_is_larger_than_its_header_says_is_not_decoded(limits, tmp_path):
    import zlib

    path = tmp_path / "bomb.mov"
    with av.open(str(path), "w") as file:
        video = file.add_stream("png", rate=30)
        video.width, video.height, video.pix_fmt = 64, 48, "rgb24"
        frame = av.VideoFrame.from_ndarray(np.zeros((48, 64, 3), np.uint8), format="rgb24")
        file.mux([*video.encode(frame), *video.encode(None)])
    assert probe(path, limits).n_frames == 1
    content = bytearray(path.read_bytes())
    header = content.index(b"IHDR")
    content[header + 4 : header + 12] = struct.pack(">II", 32_768, 32_768)
    checked = bytes(content[header : header + 17])
    content[header + 17 : header + 21] = struct.pack(">I", zlib.crc32(checked))
    path.write_bytes(content)
    with pytest.raises(BadFile, match="no picture can be decoded|too much memory|pixels"):
        probe(path, limits)


def test_ten_hours_are_too_long_whether_the_header_or_a_frame_claims_them(
    make_video, limits, tmp_path
):
    times = [Fraction(0), Fraction(1, 30), Fraction(36_000)]
    for name in ("long.mp4", "long.mkv"):
        with pytest.raises(Refused, match="36000 s") as caught:
            probe(make_video(tmp_path / name, times, tick=Fraction(1, 1000)), limits)
        assert (caught.value.rule, caught.value.unit) == ("too_long_source", "s")
    content = bytearray(make_video(tmp_path / "short.mkv", SECOND).read_bytes())
    duration = content.index(b"\x44\x89\x88") + 3  # Matroska's Duration, a double in ms
    content[duration : duration + 8] = struct.pack(">d", 36_000_000.0)
    (tmp_path / "short.mkv").write_bytes(content)
    with pytest.raises(Refused, match="36000 s"):
        probe(tmp_path / "short.mkv", limits)


def test_limits_of_size_bytes_and_time_are_kept_and_named(second):
    for limit, rule in (
        ({"max_pixels": 64 * 48 - 1}, "too_large"),
        ({"max_source_s": 0.9}, "too_long_source"),
        ({"max_mb": 0.001}, "too_many_bytes"),
        ({"timeout_s": 0.001}, "timed_out"),
    ):
        with pytest.raises(Refused) as caught:
            probe(second, Limits(**limit))
        assert caught.value.rule == rule
        assert f"raise fetch.{next(iter(limit))}" in caught.value.remedy
    assert probe(second, Limits(max_pixels=64 * 48, max_source_s=1.0)).n_frames == 30


def test_what_is_no_regular_file_is_not_waited_for(limits, tmp_path):
    os.mkfifo(tmp_path / "pipe.mp4")
    (tmp_path / "folder.mp4").mkdir()
    for name in ("pipe.mp4", "folder.mp4"):
        with pytest.raises(BadFile, match="no regular file"):
            probe(tmp_path / name, limits)
    with pytest.raises(NoSuchFile):
        probe(tmp_path / "absent.mp4", limits)


@pytest.fixture
def another_av(tmp_path, monkeypatch):
    """Puts a package av before the installed one, for children."""

    def another_av(code):
        (tmp_path / "av").mkdir(exist_ok=True)
        (tmp_path / "av" / "__init__.py").write_text(code)
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    return another_av


def test_a_broken_installation_is_not_blamed_on_the_file(second, limits, another_av):
    another_av("raise ImportError('libavcodec.so: no such file')")
    with pytest.raises(RuntimeError, match="libavcodec.so: no such file"):
        probe(second, limits)


def test_a_child_that_the_decoder_kills_is_the_files_fault(second, limits, another_av):
    another_av(f"import os; os.kill(os.getpid(), {signal.SIGSEGV.value})")
    with pytest.raises(BadFile, match="the decoder breaks on .SIGSEGV"):
        probe(second, limits)


def test_real_files_that_are_broken_say_how(real_data, limits):
    with pytest.raises(BadFile, match="an empty file"):
        probe(real_data / "corrupt" / "empty.mp4", limits)
    with pytest.raises(BadFile, match="without its index"):
        probe(real_data / "corrupt" / "single_face_truncated_100k.mp4", limits)
