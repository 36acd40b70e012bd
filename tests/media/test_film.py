from fractions import Fraction

import av
import numpy as np
import pytest

from mimeline.media.cut import cut_sound
from mimeline.media.film import write_film
from mimeline.media.frames import read_frames
from mimeline.media.probe import probe

NTSC = Fraction(30_000, 1001)


def grey(levels):
    return [np.full((32, 48, 3), level, np.uint8) for level in levels]


def test_a_film_shows_its_pictures_at_its_rate(limits, tmp_path):
    levels = np.arange(90) * 2 + 20
    write_film(tmp_path / "a.mp4", iter(grey(levels)), NTSC)
    film = probe(tmp_path / "a.mp4", limits)
    assert (film.codec, film.width, film.height, film.rate) == ("h264", 48, 32, NTSC)
    np.testing.assert_allclose(film.times, np.arange(90) * 1001 / 30_000, atol=1e-9)
    assert not film.has_sound
    frames = read_frames(tmp_path / "a.mp4", range(90))
    seen = np.array([frame[..., 1].mean() for _, frame in frames])
    assert np.abs(seen - levels).max() < 2


def test_colours_survive(tmp_path):
    picture = np.zeros((32, 64, 3), np.uint8)
    picture[:, :32] = (200, 60, 40)
    picture[:, 32:] = (40, 90, 210)
    write_film(tmp_path / "a.mp4", [picture] * 3, Fraction(30))
    seen = dict(read_frames(tmp_path / "a.mp4", [1]))[1].astype(int)
    assert np.abs(seen[8:24, 8:24] - (200, 60, 40)).max() < 12
    assert np.abs(seen[8:24, 40:56] - (40, 90, 210)).max() < 12


def test_the_same_pictures_give_the_same_bytes(tmp_path):
    sound = np.random.default_rng(0).uniform(-0.5, 0.5, 16_000)
    for name in ("a.mp4", "b.mp4"):
        write_film(tmp_path / name, grey(range(30)), Fraction(30), sound)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_sound_fits_the_pictures(limits, tmp_path):
    sound = np.zeros(32_000)
    sound[16_000:16_400] = 0.6 * np.sin(np.arange(400))
    write_film(tmp_path / "a.mp4", grey(range(60)), Fraction(30), sound)
    film = probe(tmp_path / "a.mp4", limits)
    assert film.has_sound
    cut_sound(tmp_path / "a.mp4", film, tmp_path / "a.wav", start_s=0, length_s=2.0, limits=limits)
    samples = np.frombuffer((tmp_path / "a.wav").read_bytes()[44:], np.int16)
    assert abs(np.flatnonzero(np.abs(samples) > 3000)[0] - 16_000) < 80


def test_a_film_may_have_times_of_its_own(limits, tmp_path):
    times = [0.0, 0.05, 0.3, 0.31, 1.0]
    write_film(tmp_path / "a.mp4", grey(range(5)), Fraction(30), times=times)
    film = probe(tmp_path / "a.mp4", limits)
    np.testing.assert_allclose(film.times, times, atol=1e-5)
    assert film.variable


def test_a_browser_can_begin_before_the_end_has_come(tmp_path):
    write_film(tmp_path / "a.mp4", grey(range(30)), Fraction(30))
    content = (tmp_path / "a.mp4").read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")


def test_pictures_that_make_no_film_are_refused_and_leave_nothing(tmp_path):
    odd = [np.zeros((31, 48, 3), np.uint8)]
    changing = [np.zeros((32, 48, 3), np.uint8), np.zeros((32, 32, 3), np.uint8)]
    real = [*grey([1]), np.zeros((32, 48, 3))]
    for pictures, said in (
        (odd, "even"),
        (changing, "picture 1"),
        (real, "float64"),
        ([], "needs"),
    ):
        with pytest.raises(ValueError, match=said):
            write_film(tmp_path / "a.mp4", pictures, Fraction(30))
    for times in ([0.0, 0.0], [0.0], [0.0, 1.0, 2.0]):
        with pytest.raises(ValueError, match="times"):
            write_film(tmp_path / "a.mp4", grey(range(2)), Fraction(30), times=times)
    assert list(tmp_path.iterdir()) == []


def test_a_film_that_is_broken_off_leaves_the_one_before(tmp_path):
    def broken():
        yield from grey(range(5))
        raise KeyboardInterrupt

    write_film(tmp_path / "a.mp4", grey(range(3)), Fraction(30))
    before = (tmp_path / "a.mp4").read_bytes()
    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / "a.mp4", broken(), Fraction(30))
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]
    assert (tmp_path / "a.mp4").read_bytes() == before
    with av.open(str(tmp_path / "a.mp4")) as film:
        assert sum(1 for _ in film.decode(video=0)) == 3
