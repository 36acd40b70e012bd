"""The formats that timelines are kept in: what each is called, who opens it, what it loses."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.timeline.draft import Draft, nearest, shown
from mimeline.timeline.formats import csv_file, elan, json_file, praat, stmc, webvtt

SOURCE, CLUSTER, CONFIDENCE = "source", "cluster", "confidence"
FPS, N_FRAMES, NEUTRAL_TRACKS = "fps", "n_frames", "neutral tracks"
CLIP, EMPTY, MEDIA = "clip", "clips without intervals", "media"


@dataclass(frozen=True)
class Format:
    """A kind of file. program: what opens it. loses: what of a timeline it has no place for.

    several: whether a file may hold several clips.
    """

    name: str
    suffixes: tuple[str, ...]
    program: str
    loses: frozenset[str]
    several: bool
    read: Callable[[Path], list[Draft]]
    write: Callable[..., str]


_OF_INTERVALS = frozenset({SOURCE, CLUSTER, CONFIDENCE})

FORMATS: dict[str, Format] = {
    form.name: form
    for form in (
        Format(
            "json",
            (".json",),
            "a text editor, any program",
            frozenset({MEDIA}),
            True,
            json_file.read,
            json_file.write,
        ),
        Format(
            "csv",
            (".csv",),
            "a spreadsheet, pandas",
            frozenset({EMPTY, FPS, N_FRAMES, NEUTRAL_TRACKS, MEDIA}),
            True,
            csv_file.read,
            csv_file.write,
        ),
        Format(
            "webvtt",
            (".vtt",),
            "browsers and players, as subtitles",
            _OF_INTERVALS | {MEDIA},
            False,
            webvtt.read,
            webvtt.write,
        ),
        Format(
            "elan",
            (".eaf",),
            "ELAN",
            _OF_INTERVALS,
            False,
            elan.read,
            elan.write,
        ),
        Format(
            "praat",
            (".TextGrid",),
            "Praat",
            _OF_INTERVALS | {CLIP, FPS, MEDIA},
            False,
            praat.read,
            praat.write,
        ),
        Format(
            "stmc",
            (".txt",),
            "STMC and its kin",
            _OF_INTERVALS | {CLIP, EMPTY, FPS, N_FRAMES, NEUTRAL_TRACKS, MEDIA},
            True,
            stmc.read,
            stmc.write,
        ),
    )
}
SUFFIXES = tuple(suffix for form in FORMATS.values() for suffix in form.suffixes)


def format_of(path: str | Path, name: str | None = None) -> Format:
    """The format of that name, else of the file's ending. Raises BadFile for an unknown one."""
    if name is not None:
        if name in FORMATS:
            return FORMATS[name]
        close = nearest(name, FORMATS)
        raise BadFile(
            path,
            found=f"format {shown(name)}",
            expected=f"one of {', '.join(FORMATS)}",
            remedy=f"Did you mean {close}?" if close else "Say one of these.",
        )
    suffix = Path(path).suffix.casefold()
    for form in FORMATS.values():
        if suffix in (known.casefold() for known in form.suffixes):
            return form
    raise BadFile(
        path,
        found=f"a name that ends in {shown(suffix)}" if suffix else "a name without an ending",
        expected=f"one that ends in {', '.join(SUFFIXES)}",
        remedy="Name the file by its format.",
    )
