"""What motion is asked for: which actions in which frame, on either half of the face."""

from dataclasses import dataclass

import numpy as np

from mimeline.errors import MimelineError
from mimeline.timeline.timeline import SIDES, Timeline, sides_meet
from mimeline.vocabulary import ACTIONS, UNKNOWN


class BadRequest(MimelineError):
    """A request does not tell for each frame what becomes of the 16 actions."""


@dataclass(frozen=True)
class Request:
    """left, right: (L, 16) float32 in {0, 1}, -1 where the model may choose; subject's sides.

    Raises BadRequest where there is no frame, the halves differ in shape, or a value is another.
    """

    left: np.ndarray
    right: np.ndarray

    def __post_init__(self):
        shapes = {side: np.shape(getattr(self, side)) for side in SIDES}
        for side, shape in shapes.items():
            if len(shape) != 2 or not shape[0] or shape[1] != len(ACTIONS):
                raise _bad(side, f"an array of shape {shape}")
            values = np.asarray(getattr(self, side), np.float32)
            strange = values[~np.isin(values, (0, 1, UNKNOWN))]
            if len(strange):
                raise _bad(side, f"the value {strange[0]:g}")
            object.__setattr__(self, side, values)
        if shapes["left"] != shapes["right"]:
            raise _bad("right", f"{len(self.right)} frames where the left has {len(self.left)}")

    def __len__(self) -> int:
        return len(self.left)

    @classmethod
    def both_sides(cls, values: np.ndarray) -> "Request":
        """values (L, 16) on both halves of the face."""
        return cls(values, values)

    @classmethod
    def of(cls, timeline: Timeline) -> "Request":
        """What a timeline tells; the model may choose on tracks that it does not measure."""
        halves = {side: np.full((timeline.n_frames, len(ACTIONS)), UNKNOWN) for side in SIDES}
        for column, action in enumerate(ACTIONS.values()):
            if action.track in timeline.tracks:
                for values in halves.values():
                    values[:, column] = 0
        for interval in timeline:
            column = list(ACTIONS).index(interval.action)
            for side, values in halves.items():
                if sides_meet(interval.side, side):
                    values[interval.start : interval.end, column] = 1
        return cls(**halves)


def _bad(side: str, found: str) -> BadRequest:
    return BadRequest(
        "request",
        place=f"{side} half of the face",
        found=found,
        expected=f"a row per frame, one at least, and in it 1, 0 or -1 for each of the "
        f"{len(ACTIONS)} actions",
        remedy="1 asks for an action, 0 forbids it, -1 lets the model choose; in the order of "
        f"{', '.join(ACTIONS)}.",
    )
