"""A pullover, so that a toy person is no bare head on a neck."""

from dataclasses import replace

import numpy as np

from mimeline.face.model import Face

AROUND = 32  # vertices of a ring
GLOSS = 0.0  # of wool
NECK = 0.03  # metres above the neck's end that the collar reaches
# Rings from the collar's top down: metres above the neck's end, and out from the neck's surface
# sideways, to the back and to the front.
RINGS = np.array(
    [
        (0.020, 0.000, 0.000, 0.000),
        (0.024, 0.004, 0.004, 0.004),
        (0.018, 0.008, 0.008, 0.009),
        (0.008, 0.014, 0.012, 0.014),
        (0.001, 0.034, 0.018, 0.020),
        (-0.006, 0.070, 0.024, 0.026),
        (-0.022, 0.106, 0.028, 0.032),
        (-0.050, 0.126, 0.030, 0.040),
        (-0.130, 0.134, 0.030, 0.050),
    ]
)


def dressed(face: Face, colour: tuple[int, int, int]) -> Face:
    """The face of a person, with a pullover of a colour that stays where the neck ends.

    face: without identities left; its first joint holds the end of the neck.
    """
    cloth, triangles = _pullover(face.neutral)
    count, first = len(cloth), len(face.neutral)
    held = np.zeros((count, len(face.joints)), np.float32)
    held[:, 0] = 1
    still = np.zeros((len(face.shapes), count, 3), np.float32)
    return replace(
        face,
        neutral=np.concatenate([face.neutral, cloth]),
        triangles=np.concatenate([face.triangles, triangles + first]),
        shapes=np.concatenate([face.shapes, still], axis=1),
        skin=np.concatenate([face.skin, held]),
        colours=np.concatenate([face.colours, np.tile(np.uint8(colour), (count, 1))]),
        gloss=np.concatenate([face.gloss, np.full(count, GLOSS, np.float32)]),
        identities=None,
    )


def _pullover(neutral: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (rings x AROUND, 3) and triangles about the neck of vertices (V, 3)."""
    end = neutral[:, 1].min()
    neck = neutral[neutral[:, 1] < end + NECK]
    low, high = neck.min(0), neck.max(0)
    middle, half = (low + high) / 2, (high - low) / 2
    angle = 2 * np.pi * np.arange(AROUND) / AROUND  # from the subject's left to the front
    side, front = np.cos(angle), np.sin(angle)
    rise, out, back, forth = (column[:, None] for column in RINGS.T)  # (rings, 1)
    cloth = np.stack(
        [
            middle[0] + (half[0] + out) * side,
            np.broadcast_to(end + rise, (len(RINGS), AROUND)),
            middle[2] + (half[2] + np.where(front < 0, back, forth)) * front,
        ],
        axis=-1,
    )  # (rings, AROUND, 3)
    number = np.arange(len(RINGS) * AROUND).reshape(len(RINGS), AROUND)
    here, below = number[:-1], number[1:]
    here_next, below_next = np.roll(here, -1, axis=1), np.roll(below, -1, axis=1)
    upper = np.stack([here, here_next, below], axis=-1).reshape(-1, 3)
    lower = np.stack([here_next, below_next, below], axis=-1).reshape(-1, 3)
    return cloth.reshape(-1, 3), np.concatenate([upper, lower])
