from fractions import Fraction

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
        assert number_of(read_frames(film, [number])[0]) == number


def test_frames_come_in_the_order_asked_for(film, number_of):
    numbers = [149, 0, 75, 75, 29, 30, 31, 148]
    pictures = read_frames(film, numbers)
    assert pictures.shape == (8, 48, 64, 3) and pictures.dtype == np.uint8
    assert [number_of(picture) for picture in pictures] == numbers
    assert read_frames(film, []).shape == (0, 48, 64, 3)


def test_a_frame_that_is_not_there_is_named(film, tmp_path):
    with pytest.raises(BadFile, match="no frame 150"):
        read_frames(film, [3, 150])
    with pytest.raises(ValueError, match="-1"):
        read_frames(film, [-1])
    with pytest.raises(NoSuchFile):
        read_frames(tmp_path / "absent.mp4", [0])
    (tmp_path / "page.mp4").write_text("<html>")
    with pytest.raises(BadFile, match="page.mp4"):
        read_frames(tmp_path / "page.mp4", [0])
