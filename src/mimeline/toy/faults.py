"""The planted faults: what is wrong with a clip, and what ought to become of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mimeline.toy.livelink import SHAPES
from mimeline.toy.plan import FPS, Event, PlannedClip

OUTSIDE = "../../outside"
LOST_SHARE, ABSENT_FRAMES = 0.25, 9


@dataclass(frozen=True)
class Fault:
    """A fault, the stage that ought to decide on it and the status that it ought to give.

    planned: changes the plan of the clip. written: changes the text of its Live Link file, lines
    with the header first; None: leaves the file out.
    """

    name: str
    stage: str
    status: str
    planned: Callable[[PlannedClip], PlannedClip] = lambda clip: clip
    written: Callable[[list[str], np.random.Generator], list[str]] | None = lambda lines, rng: lines


def _lasting(seconds: float) -> Callable[[PlannedClip], PlannedClip]:
    return lambda clip: replace(clip, n_frames=round(seconds * FPS))


def _doing(action: str) -> Callable[[PlannedClip], PlannedClip]:
    return lambda clip: replace(clip, catalogue_actions=(action,))


def _small(clip: PlannedClip) -> PlannedClip:
    top, _, left, _ = clip.bbox
    return replace(clip, bbox=(top, top + 300, left, left + 300))


def _turning(clip: PlannedClip) -> PlannedClip:
    turn = Event("HeadLeft", clip.n_frames // 3, attack=12, hold=25, release=12, amplitude=0.85)
    return replace(clip, extra=(turn,))


def _absent(rows: Callable[[int], int]) -> Callable[[list[str], np.random.Generator], list[str]]:
    """Leaves out one run of rows, neither the first nor the last row."""

    def leave_out(lines: list[str], rng: np.random.Generator) -> list[str]:
        count = rows(len(lines) - 1)
        first = int(rng.integers(2, len(lines) - count - 1))
        return lines[:first] + lines[first + count :]

    return leave_out


def _cell(text: str) -> Callable[[list[str], np.random.Generator], list[str]]:
    def spoil(lines: list[str], rng: np.random.Generator) -> list[str]:
        row = int(rng.integers(1, len(lines)))
        cells = lines[row].split(",")
        cells[int(rng.integers(2, 2 + len(SHAPES)))] = text  # no reader may skip a coefficient
        return [*lines[:row], ",".join(cells), *lines[row + 1 :]]

    return spoil


def _cut_off(lines: list[str]) -> list[str]:
    """As a full disk leaves it: the file ends in the middle of a row."""
    half = len(lines) // 2
    return [*lines[:half], lines[half][: len(lines[half]) // 2]]


FAULTS: tuple[Fault, ...] = (
    Fault("too_short", "select", "dropped", planned=_lasting(3.4)),
    Fault("tracking_lost", "ingest", "dropped", written=_absent(lambda n: int(n * LOST_SHARE))),
    Fault("unsafe_id", "catalogue", "failed", planned=lambda clip: replace(clip, clip_id=OUTSIDE)),
    Fault("turned", "pose", "dropped", planned=_turning),
    Fault("rows_absent", "ingest", "kept", written=_absent(lambda n: ABSENT_FRAMES)),
    Fault("no_header", "ingest", "failed", written=lambda lines, rng: lines[1:]),
    Fault("too_long", "select", "dropped", planned=_lasting(12.7)),
    Fault("excluded_action", "select", "dropped", planned=_doing("turn")),
    Fault("excluded_action", "select", "dropped", planned=_doing("shake_head")),
    Fault("excluded_action", "select", "dropped", planned=_doing("head_wagging")),
    Fault("too_small", "select", "dropped", planned=_small),
    Fault("text_cell", "ingest", "failed", written=_cell("n/a")),
    Fault("nan_cell", "ingest", "failed", written=_cell("nan")),
    Fault("missing_file", "ingest", "failed", written=None),
    Fault("truncated", "ingest", "failed", written=lambda lines, rng: _cut_off(lines)),
    Fault(
        "leading_dash",
        "catalogue",
        "kept",
        planned=lambda clip: replace(
            clip, source=f"-{clip.source[1:]}", clip_id=f"-{clip.source[1:]}_0_0"
        ),
    ),
)


def spread(clips: int, rng: np.random.Generator) -> dict[int, Fault]:
    """Which clips have which fault, by position: every fault once, in at most half of the clips.

    A small world has the first ones of FAULTS.
    """
    planted = FAULTS[: clips // 2]
    at = sorted(rng.choice(clips, len(planted), replace=False).tolist())
    return dict(zip(at, planted, strict=True))
