"""Small faces made for the tests."""

import numpy as np
import pytest

from mimeline.face.model import Face, Joint


def rotations(rng: np.random.Generator, n: int) -> np.ndarray:
    """Random rotations (n, 3, 3)."""
    turns, _ = np.linalg.qr(rng.normal(size=(n, 3, 3)))
    turns[np.linalg.det(turns) < 0, :, 0] *= -1
    return turns


def chained_face(seed: int = 0, **more) -> Face:
    """A face of random numbers: three joints in a chain, smooth weights, two identities."""
    rng = np.random.default_rng(seed)
    skin = rng.random((12, 3))
    values = {
        "neutral": rng.normal(size=(12, 3)),
        "triangles": rng.integers(0, 12, (7, 3)),
        "shapes": rng.normal(size=(2, 12, 3)),
        "shape_names": ["jawOpen", "eyeBlinkLeft"],
        "joints": [
            Joint("neck", None, rng.normal(size=3)),
            Joint("head", 0, rng.normal(size=3)),
            Joint("left_eye", 1, rng.normal(size=3)),
        ],
        "skin": skin / skin.sum(1, keepdims=True),
        "identities": rng.normal(size=(2, 12, 3)),
        "identity_names": ["wide", "long"],
        "correctives": rng.normal(size=(2, 2, 12, 3)),
    }
    return Face(**(values | more))


def ball(centre, radius: float, n: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and outward triangles of a sphere; no two vertices lie in one place."""
    down = np.linspace(0, np.pi, n)[1:-1, None]
    around = np.linspace(0, 2 * np.pi, 2 * n, endpoint=False)
    height = np.cos(down) + 0 * around
    rings = np.stack([np.sin(down) * np.sin(around), height, np.sin(down) * np.cos(around)], -1)
    points = np.concatenate([rings.reshape(-1, 3), [[0, 1, 0], [0, -1, 0]]])
    number = np.arange(2 * n * (n - 2)).reshape(n - 2, 2 * n)
    a, b = number[:-1], np.roll(number, -1, axis=1)[:-1]
    c, d = number[1:], np.roll(number, -1, axis=1)[1:]
    quads = np.stack([a, c, d, b], -1).reshape(-1, 4)
    first, last, top, bottom = number[0], number[-1], number.size, number.size + 1
    caps = [[top, x, y] for x, y in zip(first, np.roll(first, -1), strict=True)]
    caps += [[bottom, y, x] for x, y in zip(last, np.roll(last, -1), strict=True)]
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]], caps])
    return radius * points + np.asarray(centre), triangles


@pytest.fixture(scope="session")
def ball_face() -> Face:
    """A grey ball of a head with two eyeballs; it opens, winks and raises the halves of a brow."""
    parts = [
        ball((0, 0, 0), 0.1),
        ball((0.04, 0.03, 0.09), 0.015),
        ball((-0.04, 0.03, 0.09), 0.015),
    ]
    counts = [len(points) for points, _ in parts]
    starts = np.cumsum([0, *counts[:-1]])
    neutral = np.concatenate([points for points, _ in parts])
    triangles = np.concatenate([t + start for (_, t), start in zip(parts, starts, strict=True)])
    skin = np.repeat(np.eye(3), counts, axis=0)
    left = np.clip(neutral[:, 0] / 0.1, 0, 1)
    shapes = np.zeros((4, len(neutral), 3))
    shapes[0, : counts[0], 1] = -0.02 * (neutral[: counts[0], 1] < 0)
    shapes[1, : counts[0], 2] = 0.01 * left[: counts[0]]
    shapes[2, : counts[0], 1] = 0.01 * (neutral[: counts[0], 0] > 0)
    shapes[3, : counts[0], 1] = 0.01 * (neutral[: counts[0], 0] < 0)
    return Face(
        neutral=neutral,
        triangles=triangles,
        shapes=shapes,
        shape_names=["jawOpen", "eyeBlinkLeft", "browInnerUp_L", "browInnerUp_R"],
        joints=[
            Joint("head", None, np.zeros(3)),
            Joint("left_eye", 0, np.float32([0.04, 0.03, 0.09])),
            Joint("right_eye", 0, np.float32([-0.04, 0.03, 0.09])),
        ],
        skin=skin,
        colours=np.full((len(neutral), 3), 128, np.uint8),
    )
