"""What motion is asked for: which actions in which frame, on either half of the face."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mimeline.errors import MimelineError
from mimeline.timeline.timeline import SIDES, Timeline, sides_meet
from mimeline.vocabulary import ACTIONS, CHANNELS, UNKNOWN


class BadRequest(MimelineError):
    """A request does not tell for each frame what becomes of the 16 actions."""


@dataclass(frozen=True)
class Request:
    """left, right: (L, 16) float32 in {0, 1}, -1 where the model may choose; subject's sides.
    known: channels whose motion is given, (L,) each in its unit, with which the others are to go.

    Raises BadRequest where there is no frame, the halves differ in shape, a value is another, or
    what is known is not a number for each frame of a channel.
    """

    left: np.ndarray
    right: np.ndarray
    known: Mapping[str, np.ndarray] = field(default_factory=dict)

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
        for channel, values in self.known.items():
            _check_known(channel, values, len(self))

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


def _check_known(channel: str, values: np.ndarray, frames: int) -> None:
    if channel not in CHANNELS:
        found = "a name that is no channel's"
    elif np.shape(values) != (frames,):
        found = f"an array of shape {np.shape(values)}"
    elif not np.isfinite(values).all():
        found = "a value that is no finite number"
    else:
        return
    raise BadRequest(
        "request",
        place=f"known {channel}",
        found=found,
        expected=f"a number for each of its {frames} frames",
        remedy="Leave out a channel that is not known throughout: the model makes it.",
    )


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
