"""The planted faults: what is wrong with a clip, and what ought to become of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mimeline.archives.torch_saved import read_saved, write_saved
from mimeline.toy.plan import FPS, Event, PlannedClip
from mimeline.tracking.formats.livelink import SHAPES
from mimeline.tracking.formats.metrical_tracker import CHECKPOINT

OUTSIDE = "../../outside"
LOST_SHARE, ABSENT_FRAMES = 0.25, 9
SKIPPED = 0.35  # chance of a frame to be missing from a video of variable rate
STORED = 0.4  # share of its bytes that a video keeps which is cut off
HOSTILE = b"cposix\nsystem\n(S'true'\ntR."  # a pickle that calls a program
PAGE = b"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Video unavailable</title></head>
<body><h1>This video is no longer available</h1><p>The account behind it was closed.</p></body>
</html>
"""


@dataclass(frozen=True)
class Fault:
    """A fault, the stage that ought to decide on it and the status that it ought to give.

    planned: changes the plan of the clip. written: changes the text of its Live Link file, lines
    with the header first; None: leaves the file out. framed: spoils the clip's folder of .frame
    files, which holds the rows (n,) bool that the Live Link file has whole. needs_video: there is
    one whatever the share of clips that have. covered: something hides the face where the file
    lacks rows. shown: which frames the video has, of so many. stored: changes the bytes of its
    file.
    """

    name: str
    stage: str
    status: str
    planned: Callable[[PlannedClip], PlannedClip] = lambda clip: clip
    written: Callable[[list[str], np.random.Generator], list[str]] | None = lambda lines, rng: lines
    framed: Callable[[Path, np.ndarray], None] = lambda folder, tracked: None
    needs_video: bool = False
    covered: bool = False
    shown: Callable[[int, np.random.Generator], np.ndarray] = lambda n, rng: np.arange(n)
    stored: Callable[[bytes], bytes] = lambda film: film

    @property
    def ends_early(self) -> bool:
        """The clip is gone before anybody looks at its video."""
        return self.stage in ("catalogue", "select") and self.status != "kept"


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


def _frame(folder: Path, number: int) -> Path:
    return folder / CHECKPOINT / f"{number:05d}.frame"


def _hostile_frame(folder: Path, tracked: np.ndarray) -> None:
    _frame(folder, 0).write_bytes(HOSTILE)


def _frame_without_number(folder: Path, tracked: np.ndarray) -> None:
    number = int(tracked.argmin())
    content = read_saved(_frame(folder, int(tracked.argmax())), remedy="")
    content["flame"]["exp"] = np.full_like(content["flame"]["exp"], np.nan)
    write_saved(_frame(folder, number), content | {"frame_id": f"{number:05d}"})


def _frame_cut_off(folder: Path, tracked: np.ndarray) -> None:
    last = int(np.flatnonzero(tracked)[-1])
    content = _frame(folder, last).read_bytes()
    _frame(folder, last + 1).write_bytes(content[: len(content) // 2])


def _deserted(clip: PlannedClip) -> PlannedClip:
    return replace(clip, deserted=True, talks=False)


def _skipping(n_frames: int, rng: np.random.Generator) -> np.ndarray:
    """Some of the frames, irregularly; the first and the last are there."""
    there = rng.random(n_frames) >= SKIPPED
    there[[0, -1]] = True
    return np.flatnonzero(there)


FAULTS: tuple[Fault, ...] = (
    Fault("turned", "pose", "dropped", planned=_turning, needs_video=True),
    Fault(
        "tracking_lost",
        "ingest",
        "dropped",
        written=_absent(lambda n: int(n * LOST_SHARE)),
        needs_video=True,
        covered=True,
    ),
    Fault(
        "no_face",  # a tracker that finds no face writes no row
        "ingest",
        "failed",
        planned=_deserted,
        written=lambda lines, rng: lines[:1],
        needs_video=True,
    ),
    Fault(
        "video_cut_off",
        "fetch",
        "failed",
        needs_video=True,
        stored=lambda film: film[: int(STORED * len(film))],
    ),
    Fault("too_short", "select", "dropped", planned=_lasting(3.4)),
    Fault("unsafe_id", "catalogue", "failed", planned=lambda clip: replace(clip, clip_id=OUTSIDE)),
    Fault("rows_absent", "ingest", "kept", written=_absent(lambda n: ABSENT_FRAMES)),
    Fault(
        "no_header", "ingest", "failed", written=lambda lines, rng: lines[1:], framed=_hostile_frame
    ),
    Fault("video_variable_rate", "fetch", "kept", needs_video=True, shown=_skipping),
    Fault("video_is_a_page", "fetch", "failed", needs_video=True, stored=lambda film: PAGE),
    Fault("too_long", "select", "dropped", planned=_lasting(12.7)),
    Fault("excluded_action", "select", "dropped", planned=_doing("turn")),
    Fault(
        "leading_dash",
        "catalogue",
        "kept",
        planned=lambda clip: replace(
            clip, source=f"-{clip.source[1:]}", clip_id=f"-{clip.source[1:]}_0_0"
        ),
        needs_video=True,
    ),
    Fault("text_cell", "ingest", "failed", written=_cell("n/a"), framed=_frame_without_number),
    Fault("too_small", "select", "dropped", planned=_small),
    Fault("missing_file", "ingest", "failed", written=None),
    Fault(
        "truncated",
        "ingest",
        "failed",
        written=lambda lines, rng: _cut_off(lines),
        framed=_frame_cut_off,
    ),
    Fault("nan_cell", "ingest", "failed", written=_cell("nan"), framed=_frame_without_number),
    Fault("excluded_action", "select", "dropped", planned=_doing("shake_head")),
    Fault("excluded_action", "select", "dropped", planned=_doing("head_wagging")),
)


def spread(clips: int, rng: np.random.Generator, filmed: bool) -> dict[int, Fault]:
    """Which clips have which fault, by position: every fault once, in at most half of the clips.

    A small world has the first ones of FAULTS; one that is not filmed has none that lies in a
    video.
    """
    planted = [fault for fault in FAULTS if filmed or fault.stage != "fetch"][: clips // 2]
    at = sorted(rng.choice(clips, len(planted), replace=False).tolist())
    return dict(zip(at, planted, strict=True))
