"""What a file says of a clip, before anybody judged it."""

from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from typing import Literal

from mimeline.errors import printable
from mimeline.timeline.timeline import SIDES
from mimeline.vocabulary import ACTIONS, NEUTRAL, TRACKS

LONGEST_SHOWN = 60  # characters of what stands in a file
ALIKE = 0.6  # how much two names share, of 1


@dataclass(frozen=True)
class Problem:
    """Something in a file that is wrong (an error) or looks like a slip (a warning)."""

    place: str
    found: str
    expected: str
    remedy: str
    severity: Literal["error", "warning"] = "error"

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        text = f"{where}found {self.found}, expected {self.expected}. {self.remedy}"
        return printable(" ".join(text.split()))


@dataclass(frozen=True)
class DraftInterval:
    """An interval as a file has it.

    place: where in the file. track: as written there; None: the action tells it. start, end: whole
    frames, or seconds, as its Draft says.
    """

    place: str
    track: str | None
    action: str
    start: int | Fraction
    end: int | Fraction
    side: str | None = None
    source: str = "human"
    cluster: int | None = None
    confidence: float | None = None


@dataclass(frozen=True)
class Draft:
    """A clip as a file has it; None stands for what the file does not tell.

    seconds: how long the clip lasts. in_seconds: whether its intervals are in seconds.
    tracks: the measured ones as written there, besides those of its intervals.
    problems: what its reader could not take.
    """

    clip_id: str | None
    intervals: tuple[DraftInterval, ...]
    in_seconds: bool
    fps: Fraction | None = None
    n_frames: int | None = None
    seconds: Fraction | None = None
    tracks: tuple[str, ...] = ()
    problems: tuple[Problem, ...] = ()


def tier_name(track: str, side: str | None) -> str:
    """What files call a track's tier: brow, brow left, brow right."""
    return f"{track} {side}" if side else track


def split_tier(name: str) -> tuple[str, str | None]:
    """Track and side of a tier as people write it (brow, Brow_Left); what is unknown stays."""
    words = name.casefold().split()
    folded = " ".join(words)
    for side in (None, *SIDES):
        for track in TRACKS:
            if folded in (tier_name(track, side), f"{track}_{side}", f"{track}-{side}"):
                return track, side
    return name, None


def is_foreign(tier: str, values: tuple[str, ...]) -> bool:
    """Whether a tier has nothing to do with facial actions: its name is near no track's, its values
    are no actions."""
    track, _ = split_tier(tier)
    if track in TRACKS or nearest(tier, TRACKS) is not None:
        return False
    return not any(value in ACTIONS or value == NEUTRAL for value in values)


def nearest(name: str, known) -> str | None:
    """The known name that a name may have been meant to be."""
    folded = {entry.casefold(): entry for entry in known}
    close = get_close_matches(name.casefold()[:LONGEST_SHOWN], folded, n=1, cutoff=ALIKE)
    return folded[close[0]] if close else None


def shown(value: object) -> str:
    """What stands in a file, quoted, for a message."""
    text = value if isinstance(value, str) else repr(value)
    text = text if len(text) <= LONGEST_SHOWN else f"{text[: LONGEST_SHOWN - 1]}…"
    return f'"{text}"'


def ignored(place: str, count: int) -> Problem:
    """The warning of a tier that has nothing to do with facial actions."""
    return Problem(
        place,
        found=f"{count} annotation{'s' if count != 1 else ''} of something else",
        expected=f"a track: {', '.join(TRACKS)}, perhaps with left or right behind it",
        remedy="They are left out; call it by a track's name if they are facial actions.",
        severity="warning",
    )
