from fractions import Fraction

import av
import numpy as np
import pytest

from mimeline.errors import BadFile, NoSuchFile
from mimeline.media.film import write_film
from mimeline.media.frames import read_frames


@pytest.fixture(scope="module")
def film(picture_of, tmp_path_factory):
    """150 numbered frames at 29.97 per second."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    write_film(path, map(picture_of, range(150)), Fraction(30_000, 1001))
    return path


def test_every_frame_is_found_by_its_number_alone(film, number_of):
    for number in range(150):
        assert [number_of(picture) for _, picture in read_frames(film, [number])] == [number]


def test_frames_come_once_each_and_in_order(film, number_of):
    frames = list(read_frames(film, [149, 0, 75, 75, 29, 30, 31, 148]))
    assert all(frame.shape == (48, 64, 3) and frame.dtype == np.uint8 for _, frame in frames)
    assert [number for number, _ in frames] == [0, 29, 30, 31, 75, 148, 149]
    assert [number_of(frame) for _, frame in frames] == [0, 29, 30, 31, 75, 148, 149]
    assert list(read_frames(film, [])) == []


def test_frames_are_read_as_they_are_taken(film, number_of):
    frames = read_frames(film, [3, 7, 150])
    assert [number_of(next(frames)[1]) for _ in range(2)] == [3, 7]
    with pytest.raises(BadFile, match="no frame 150"):
        next(frames)


def test_a_frame_that_is_not_there_is_named(film, tmp_path):
    with pytest.raises(BadFile, match="no frame 150"):
        list(read_frames(film, [3, 150]))
    with pytest.raises(ValueError, match="-1"):
        list(read_frames(film, [-1]))
    with pytest.raises(NoSuchFile):
        list(read_frames(tmp_path / "absent.mp4", [0]))
    (tmp_path / "page.mp4").write_text("<html>")
    with pytest.raises(BadFile, match="page.mp4"):
        list(read_frames(tmp_path / "page.mp4", [0]))
    write_film_without_pictures(tmp_path / "sound.mp4")
    with pytest.raises(BadFile, match="no film"):
        list(read_frames(tmp_path / "sound.mp4", [0]))


def write_film_without_pictures(path):
    with av.open(str(path), "w") as file:
        audio = file.add_stream("aac", rate=16_000, layout="mono")
        samples = np.zeros((1, 16_000), np.float32)
        frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout="mono")
        frame.sample_rate = 16_000
        file.mux([*audio.encode(frame), *audio.encode(None)])
