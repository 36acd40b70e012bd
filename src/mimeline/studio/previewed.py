"""What a preview shows: the motion of a file, or the motions that its timelines ask for."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from mimeline.errors import BadFile, unreadable
from mimeline.exchange.reading import Reading
from mimeline.inspection.options import Options
from mimeline.inspection.recognise import format_of, recognised
from mimeline.motion import files as motion_files
from mimeline.motion.acted import acted
from mimeline.motion.motion import Motion
from mimeline.timeline import files
from mimeline.timeline.clock import nearest_frame
from mimeline.timeline.draft import Draft
from mimeline.timeline.formats.csv_file import NEEDED

EXPECTED = "a motion, a tracking result, or timelines"
REMEDY = "`mimeline inspect` says what it is; docs/preview.md what can be shown."
OURS = (".glb", ".npz", ".parquet")  # of motion, whoever wrote it
LOOKED_AT = 2**20  # bytes of a JSON, in which the word `tracks` stands where it is of timelines
CUT_SHORT = "The file does not tell how long the clip is: it is shown up to its last action."


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion to show. acted: it is no recording, but what its timeline says, by rule."""

    name: str
    motion: Motion
    acted: bool = False
    note: str = ""


@dataclass(frozen=True, eq=False)
class Previewed:
    """What a file holds. first: the clip that is shown first."""

    path: Path
    clips: Sequence[Clip]
    first: int = 0


def previewed(paths: Sequence[Path], options: Options, reading: Reading) -> list[Previewed]:
    """What the files hold, in their order.

    options: how tracking results are read. reading: what is said of timelines; the rate that
    neither says is that of a motion beside them.
    Raises NoSuchFile and BadFile, also for what is neither a motion nor a timeline.
    """
    told = [holds_timelines(Path(path), options) for path in paths]
    found: dict[int, Previewed] = {}
    for number in sorted(range(len(paths)), key=told.__getitem__):  # motions first: they have rates
        path = Path(paths[number])
        if told[number]:
            beside = next((own.clips[0].motion for own in found.values()), None)
            found[number] = _of_timelines(path, reading, beside)
        else:
            if (
                path.exists()
                and path.suffix.casefold() not in OURS
                and not format_of(path, options)
            ):
                raise _nothing(path, "nothing that moves a face or tells what one does")
            motion = motion_files.read(path, options)
            if not motion.moved or not motion.fps:
                lacking = "a number in any channel" if motion.fps else "a frame rate"
                raise _nothing(path, f"a motion without {lacking}")
            found[number] = Previewed(path, [Clip(path.resolve().name, motion)])
    return [found[number] for number in range(len(paths))]


def holds_timelines(path: Path, options: Options) -> bool:
    """Whether a file is one of timelines, by its content where motion has the same ending."""
    endings = {suffix.casefold() for suffix in files.SUFFIXES}
    ending = path.suffix.casefold()
    if options.named or not path.is_file() or ending not in endings or recognised(path, options):
        return False
    if ending not in (".csv", ".json"):
        return True
    try:
        with open(path, "rb") as file:
            start = file.read(LOOKED_AT)
    except OSError as error:
        raise unreadable(path, error, expected=EXPECTED, remedy="Check the path.") from error
    if not start.strip():
        raise _nothing(path, "an empty file")
    if ending == ".csv":
        line = start.partition(b"\n")[0].decode("utf-8-sig", "replace")
        header = {cell.strip() for cell in next(csv.reader([line.replace(";", ",")]), [])}
        if len(header & set(NEEDED)) > 1:
            return True
        raise _nothing(path, f"a table of {', '.join(sorted(header)[:4])}")
    if b'"tracks"' in start:
        return True
    raise _nothing(path, "JSON without the tracks of a timeline")


def _of_timelines(path: Path, reading: Reading, beside: Motion | None) -> Previewed:
    """Every clip of a file of timelines, acted; the named one first."""
    drafts = files.drafts(path, reading.format)
    if not drafts:
        raise _nothing(path, "no timeline")
    if reading.clip_id is not None:
        files.draft_of(path, reading.clip_id, reading.format)  # raises where it is not there
    fps = reading.fps or (beside.fps if beside else None)
    rates = _missing((name, fps) for name, draft in drafts if draft.fps is None or reading.fps)
    lengths = _missing((name, reading.n_frames) for name, _ in drafts)
    short = {}
    if reading.n_frames is None:
        whole = len(beside) if beside and len(drafts) == 1 else 0
        short = {name: _end(draft, draft.fps or fps) for name, draft in drafts if _endless(draft)}
        lengths |= {name: max(end, whole) for name, end in short.items() if end}
        short = {} if whole else short
    timelines = files.read_all(path, rates, lengths, reading.format)
    for timeline in timelines:
        if not timeline.n_frames:
            raise _nothing(path, f"a timeline of no frames, {timeline.clip_id}")
    clips = [
        Clip(t.clip_id, acted(t), acted=True, note=CUT_SHORT if t.clip_id in short else "")
        for t in timelines
    ]
    names = [clip.name for clip in clips]
    first = names.index(reading.clip_id) if reading.clip_id in names else 0
    return Previewed(path, clips, first)


def _missing(pairs: Iterable[tuple[str, object]]) -> dict:
    return {name: value for name, value in pairs if value is not None}


def _endless(draft: Draft) -> bool:
    return draft.n_frames is None and draft.seconds is None


def _end(draft: Draft, fps: Fraction | None) -> int:
    """The frame after the last interval; 0 where that is not to be told."""
    ends = [interval.end for interval in draft.intervals]
    if not ends or (draft.in_seconds and fps is None):
        return 0
    return nearest_frame(max(ends), fps) if draft.in_seconds else int(max(ends))


def _nothing(path: Path, found: str) -> BadFile:
    return BadFile(path, found=found, expected=EXPECTED, remedy=REMEDY)
