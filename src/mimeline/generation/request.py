"""What motion is asked for: which actions in which frame, on either half of the face."""

from dataclasses import dataclass

import numpy as np

from mimeline.timeline.timeline import SIDES, Timeline, sides_meet
from mimeline.vocabulary import ACTIONS, UNKNOWN


@dataclass(frozen=True)
class Request:
    """left, right: (L, 16) float32 in {0, 1}, -1 where the model may choose; subject's sides."""

    left: np.ndarray
    right: np.ndarray

    def __len__(self) -> int:
        return len(self.left)

    @classmethod
    def both_sides(cls, values: np.ndarray) -> "Request":
        """values (L, 16) on both halves of the face."""
        values = np.asarray(values, np.float32)
        return cls(values, values)

    @classmethod
    def of(cls, timeline: Timeline) -> "Request":
        """What a timeline tells; the model may choose on tracks that it does not measure."""
        halves = []
        for side in SIDES:
            values = np.full((timeline.n_frames, len(ACTIONS)), UNKNOWN, np.float32)
            for column, action in enumerate(ACTIONS.values()):
                if action.track in timeline.tracks:
                    values[:, column] = 0
            for interval in timeline:
                if sides_meet(interval.side, side):
                    values[interval.start : interval.end, list(ACTIONS).index(interval.action)] = 1
            halves.append(values)
        return cls(*halves)
