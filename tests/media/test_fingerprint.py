from fractions import Fraction

import numpy as np
import pytest

from mimeline.errors import BadFile
from mimeline.media.film import write_film
from mimeline.media.fingerprint import LEAST_CONTRAST, MIRRORED, bits_of, fingerprint


def scene(seed: int, side: int = 128) -> np.ndarray:
    """(side, side) uint8: a smooth picture, as of a face before a wall."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0 : 1 : 1j * side, 0 : 1 : 1j * side]
    picture = np.zeros((side, side))
    for _ in range(12):
        (u, v), (across, down) = rng.uniform(0, 4, 2), rng.uniform(0, 2 * np.pi, 2)
        wave = np.cos(np.pi * u * x + across) * np.cos(np.pi * v * y + down)
        picture += rng.normal() * wave
    picture -= picture.min()
    return (20 + 200 * picture / picture.max()).astype(np.uint8)


def distance(one: np.int64, other: np.int64) -> int:
    return int(np.bitwise_count((one ^ other).view(np.uint64)))


def test_a_picture_keeps_its_bits_when_it_is_scaled_brightened_or_noisy():
    rng = np.random.default_rng(0)
    for seed in range(5):
        picture = scene(seed)
        copies = {
            "half": picture[::2, ::2],
            "dark": (picture * 0.7).astype(np.uint8),
            "bright": np.minimum(picture * 1.1 + 10, 255).astype(np.uint8),
            "noisy": np.clip(picture + rng.normal(0, 5, picture.shape), 0, 255).astype(np.uint8),
        }
        distances = {n: distance(bits_of(picture), bits_of(copy)) for n, copy in copies.items()}
        assert max(distances.values()) <= 8, distances


def test_other_pictures_have_other_bits():
    bits = [bits_of(scene(seed)) for seed in range(12)]
    assert min(distance(a, b) for n, a in enumerate(bits) for b in bits[:n]) > 8


def test_a_mirrored_picture_changes_known_bits():
    picture = scene(1)
    mirrored = bits_of(picture[:, ::-1])
    assert distance(mirrored, bits_of(picture)) > 8
    assert distance(mirrored ^ MIRRORED, bits_of(picture)) <= 1


def test_a_flat_picture_has_no_bits():
    rng = np.random.default_rng(0)
    assert bits_of(np.full((64, 64), 7, np.uint8)) is None
    grain = 128 + rng.normal(0, LEAST_CONTRAST, (256, 256))
    assert bits_of(grain.astype(np.uint8)) is None


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """Three seconds at 30 / 1.001: a scene, black, another scene."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    seconds = [scene(1), np.zeros((128, 128), np.uint8), scene(2)]
    pictures = (np.repeat(s[..., None], 3, axis=2) for s in seconds for _ in range(30))
    write_film(path, pictures, Fraction(30_000, 1001))
    return path


def test_a_film_is_looked_at_about_once_a_second_and_black_is_left_out(film):
    frames, bits = fingerprint(film)
    assert frames.tolist() == [0, 60]
    assert frames.dtype == bits.dtype == np.int64
    seen = [distance(b, bits_of(scene(seed))) for b, seed in zip(bits, (1, 2), strict=True)]
    assert max(seen) <= 2
    for told, again in zip((frames, bits), fingerprint(film), strict=True):
        assert told.tolist() == again.tolist()


def test_what_is_no_film_is_an_error_that_names_it(tmp_path):
    path = tmp_path / "page.mp4"
    path.write_text("<!DOCTYPE html>")
    with pytest.raises(BadFile, match=r"page\.mp4"):
        fingerprint(path)
    with pytest.raises(BadFile, match="nowhere"):
        fingerprint(tmp_path / "nowhere.mp4")
