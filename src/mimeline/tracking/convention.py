"""What a reader declares of its format: axes, order, sign, side and unit.

`docs/conventions.md` shows these declarations; readers take their signs from them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Convention:
    """A format's conventions, for people and for its reader.

    title: its name. files: what a take is. coefficients: how many of what, and how they are named.
    axes: which way the axes point that angles are about, "" where it has none. rotation: order of
    the angles, or how a rotation is written. angle_unit: "radians", "degrees" or which key tells.
    sides: whose left and right. first_frame: the number of a video's first frame, None where frames
    are counted row by row. gap: how a frame without a face is told. never: what it never measures.
    signs: column → (channel, +1 or -1) for every angle that is read as it stands; meanings: channel
    → in words, for those that are not. evidence: how the signs were found.
    """

    title: str
    files: str
    coefficients: str
    axes: str
    rotation: str
    angle_unit: str
    sides: str
    first_frame: int | None
    gap: str
    never: str
    evidence: str
    signs: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    meanings: Mapping[str, str] = field(default_factory=dict)
