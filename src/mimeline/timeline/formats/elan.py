"""ELAN's .eaf (3.0): a tier and a vocabulary per track, brow left and brow right where they differ.

Clip, frame rate and length are properties of the document, which ELAN keeps when it saves.
Source: EAF schema 3.0 (order of elements), ELAN manual; times are whole milliseconds.
"""

import mimetypes
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from xml.parsers.expat import errors as expat

import defusedxml
from defusedxml.ElementTree import fromstring

from mimeline.errors import BadFile
from mimeline.timeline.clock import frame_rate, milliseconds
from mimeline.timeline.draft import (
    Draft,
    DraftInterval,
    Problem,
    ignored,
    is_foreign,
    shown,
    split_tier,
    tier_name,
)
from mimeline.timeline.formats.text_file import read_bytes
from mimeline.timeline.timeline import SIDES, Interval, Timeline
from mimeline.vocabulary import TRACKS, track_actions

CLIP, FPS, FRAMES = "mimeline.clip", "mimeline.fps", "mimeline.frames"
LANGUAGE = "und"  # undetermined: actions are names, not words of a language

_BROKEN = {  # XML, in the parser's words and in plain ones
    expat.XML_ERROR_NO_ELEMENTS: "the end of the file, before its last element is closed",
    expat.XML_ERROR_UNCLOSED_TOKEN: "a tag that does not end",
    expat.XML_ERROR_INVALID_TOKEN: "a character or a tag that XML does not allow there",
    expat.XML_ERROR_TAG_MISMATCH: "an element that is closed though another one in it is open",
    expat.XML_ERROR_DUPLICATE_ATTRIBUTE: "an attribute for the second time",
    expat.XML_ERROR_UNDEFINED_ENTITY: "a name behind & that XML does not know",
    expat.XML_ERROR_JUNK_AFTER_DOC_ELEMENT: "more behind the end of the last element",
}
_COUNT = re.compile(r"[0-9]{1,12}")
_NOT_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def read(path: Path) -> list[Draft]:
    """The one draft that the file holds."""
    root = _root(path)
    reader = _Reader(_slots(root))
    for place, tier in enumerate(root.iterfind("TIER"), start=1):
        reader.read_tier(tier.get("TIER_ID", f"number {place}"), tier)
    reader.check_media(root)
    return [
        Draft(
            intervals=tuple(reader.intervals),
            in_seconds=True,
            tracks=tuple(reader.tracks),
            problems=tuple(reader.problems),
            **_facts(path, root),
        )
    ]


def _root(path: Path) -> ET.Element:
    content = read_bytes(path, "an ELAN file")
    try:
        root = fromstring(content, forbid_dtd=True)
    except ET.ParseError as error:
        line, column = error.position
        raise BadFile(
            path,
            place=f"line {line}, column {column + 1}",
            found=_BROKEN.get(words := str(error).partition(":")[0], words),
            expected="the XML of an ELAN file",
            remedy="See that it is whole and opens in ELAN.",
        ) from error
    except defusedxml.DefusedXmlException as error:
        raise BadFile(
            path,
            found="a document type, which may hold entities of its own",
            expected="an ELAN file, which has none",
            remedy="Do not open it: ELAN writes no such file. Ask where it comes from.",
        ) from error
    except (ValueError, LookupError) as error:
        raise BadFile(
            path,
            found=str(error),
            expected="the XML of an ELAN file in UTF-8",
            remedy="Open it in ELAN and save it anew.",
        ) from error
    if root.tag != "ANNOTATION_DOCUMENT":
        raise BadFile(
            path,
            found=f"XML of {shown(root.tag)}",
            expected="an ANNOTATION_DOCUMENT",
            remedy="See that it is the .eaf; templates and preferences (.etf, .pfsx) are not read.",
        )
    units = root.find("HEADER")
    if units is not None and units.get("TIME_UNITS", "milliseconds") != "milliseconds":
        raise BadFile(
            path,
            place="HEADER",
            found=f"times in {shown(units.get('TIME_UNITS'))}",
            expected="milliseconds",
            remedy="Open it in a current ELAN and save it anew.",
        )
    return root


def _facts(path: Path, root: ET.Element) -> dict:
    told = {p.get("NAME"): p.text or "" for p in root.iterfind("HEADER/PROPERTY")}
    facts = {"clip_id": told.get(CLIP) or None}
    try:
        if FPS in told:
            facts["fps"] = frame_rate(told[FPS])
        if FRAMES in told:
            if not _COUNT.fullmatch(told[FRAMES].strip()):
                raise ValueError(f"{shown(told[FRAMES])} is no number of frames")
            facts["n_frames"] = int(told[FRAMES])
    except ValueError as error:
        raise BadFile(
            path,
            place="HEADER, PROPERTY",
            found=str(error),
            expected=f"{FPS} like 30000/1001 and {FRAMES} like 300",
            remedy="Mend the property, or take it out and say --fps and --frames.",
        ) from error
    return facts


def _slots(root: ET.Element) -> dict[str, Fraction | None]:
    """Seconds of each time slot; None where it has no time."""
    slots = {}
    for slot in root.iterfind("TIME_ORDER/TIME_SLOT"):
        time = slot.get("TIME_VALUE", "")
        known = Fraction(int(time), 1000) if _COUNT.fullmatch(time) else None
        slots[slot.get("TIME_SLOT_ID", "")] = known
    return slots


@dataclass
class _Reader:
    """Collects intervals, measured tracks and problems, tier by tier."""

    slots: dict[str, Fraction | None]
    intervals: list[DraftInterval] = field(default_factory=list)
    tracks: dict[str, None] = field(default_factory=dict)  # in order
    problems: list[Problem] = field(default_factory=list)

    def read_tier(self, name: str, tier: ET.Element) -> None:
        notes = [note for annotation in tier.iterfind("ANNOTATION") for note in annotation]
        values = [note.findtext("ANNOTATION_VALUE", "").strip() for note in notes]
        if is_foreign(name, tuple(values)):
            self.problems += [ignored(f"tier {shown(name)}", len(notes))] if notes else []
            return
        track, side = split_tier(name)
        self.tracks[track] = None
        for note, value in zip(notes, values, strict=True):
            place = f"tier {name}, annotation {note.get('ANNOTATION_ID', '')}"
            times = self._times(place, note)
            if times is not None:
                self.intervals.append(DraftInterval(place, track, value, *times, side=side))

    def _times(self, place: str, note: ET.Element) -> tuple[Fraction, Fraction] | None:
        if note.tag != "ALIGNABLE_ANNOTATION":
            self._wrong(
                place,
                "an annotation without times, which hangs on another",
                "a tier whose annotations have times of their own",
                "In ELAN, give the tier a type without stereotype (Tier, Change tier attributes).",
            )
            return None
        times = []
        for number in (1, 2):
            reference = note.get(f"TIME_SLOT_REF{number}", "")
            time = self.slots.get(reference)
            if time is None:
                known = "without a time" if reference in self.slots else "that is not in the file"
                self._wrong(
                    place,
                    f"time slot {shown(reference)} {known}",
                    "a start and an end",
                    "In ELAN, set the edge in time, or delete the annotation.",
                )
                return None
            times.append(time)
        return times[0], times[1]

    def check_media(self, root: ET.Element) -> None:
        for media in root.iterfind("HEADER/MEDIA_DESCRIPTOR"):
            if media.get("TIME_ORIGIN", "0") not in ("0", ""):
                self.problems.append(
                    Problem(
                        "HEADER, MEDIA_DESCRIPTOR",
                        found=f"media that are moved by {shown(media.get('TIME_ORIGIN'))} ms",
                        expected="media that start with the clip",
                        remedy="Times are taken as they stand: see that they fit the clip.",
                        severity="warning",
                    )
                )

    def _wrong(self, place: str, found: str, expected: str, remedy: str) -> None:
        self.problems.append(Problem(place, found, expected, remedy))


def write(
    timelines: Sequence[Timeline], media: Path | None = None, folder: Path | None = None
) -> str:
    """The timeline as XML, the same for the same timeline whenever it is written.

    media: the clip's film; folder: the file's, for the film's path from there.
    Raises ValueError where milliseconds cannot tell frames apart or the clip's name is no XML.
    """
    (timeline,) = timelines
    if wrong := _NOT_XML.search(timeline.clip_id):
        raise ValueError(f"a clip's name with {wrong.group()!r}, which XML cannot hold")
    tiers = {name: _on(timeline, *split_tier(name)) for name in _tier_names(timeline)}
    notes = sum(map(len, tiers.values()))
    root = ET.Element(
        "ANNOTATION_DOCUMENT",
        {
            "AUTHOR": "mimeline",
            "DATE": "1970-01-01T00:00:00Z",  # needed by the schema; a real one would differ
            "FORMAT": "3.0",
            "VERSION": "3.0",
            "xmlns:xsi": "http://www.w3.org/2001/XMLSchema-instance",
            "xsi:noNamespaceSchemaLocation": "http://www.mpi.nl/tools/elan/EAFv3.0.xsd",
        },
    )
    header = ET.SubElement(root, "HEADER", {"MEDIA_FILE": "", "TIME_UNITS": "milliseconds"})
    if media is not None:
        ET.SubElement(header, "MEDIA_DESCRIPTOR", _media(media, folder or Path()))
    facts = {CLIP: timeline.clip_id, FPS: str(timeline.fps), FRAMES: str(timeline.n_frames)}
    for name, value in (facts | {"lastUsedAnnotationId": str(notes)}).items():
        ET.SubElement(header, "PROPERTY", {"NAME": name}).text = value
    _add_annotations(root, timeline.fps, tiers)
    _add_vocabularies(root)
    ET.indent(root, "    ")
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _tier_names(timeline: Timeline) -> Iterator[str]:
    for track, intervals in timeline.tracks.items():
        yield track
        used = {interval.side for interval in intervals}
        yield from (tier_name(track, side) for side in SIDES if side in used)


def _on(timeline: Timeline, track: str, side: str | None) -> list[Interval]:
    return [interval for interval in timeline.tracks[track] if interval.side == side]


def _media(media: Path, folder: Path) -> dict[str, str]:
    """URLs as ELAN writes them: forward slashes, nothing escaped."""
    absolute = media.resolve().as_posix()
    attributes = {
        "MEDIA_URL": f"file:///{absolute.lstrip('/')}",
        "MIME_TYPE": mimetypes.guess_type(media.name)[0] or "unknown",
    }
    try:
        relative = Path(os.path.relpath(absolute, folder.resolve())).as_posix()
    except ValueError:  # another drive
        return attributes
    return attributes | {"RELATIVE_MEDIA_URL": relative if relative[0] == "." else f"./{relative}"}


def _add_annotations(root: ET.Element, fps: Fraction, tiers: dict[str, list[Interval]]) -> None:
    """Two slots per annotation, in the order of time, as ELAN has them."""
    notes = [(tier, interval) for tier, found in tiers.items() for interval in found]
    edges = sorted(
        (milliseconds(frame, fps), number, edge)
        for number, (_, interval) in enumerate(notes, start=1)
        for edge, frame in enumerate((interval.start, interval.end), start=1)
    )
    order = ET.SubElement(root, "TIME_ORDER")
    slots = {}
    for count, (time, number, edge) in enumerate(edges, start=1):
        slots[number, edge] = f"ts{count}"
        ET.SubElement(order, "TIME_SLOT", {"TIME_SLOT_ID": f"ts{count}", "TIME_VALUE": str(time)})
    number = 0
    for name, intervals in tiers.items():
        track, _ = split_tier(name)
        tier = ET.SubElement(root, "TIER", {"LINGUISTIC_TYPE_REF": track, "TIER_ID": name})
        for interval in intervals:
            number += 1
            annotation = ET.SubElement(
                ET.SubElement(tier, "ANNOTATION"),
                "ALIGNABLE_ANNOTATION",
                {
                    "ANNOTATION_ID": f"a{number}",
                    "CVE_REF": interval.action,
                    "TIME_SLOT_REF1": slots[number, 1],
                    "TIME_SLOT_REF2": slots[number, 2],
                },
            )
            ET.SubElement(annotation, "ANNOTATION_VALUE").text = interval.action


def _add_vocabularies(root: ET.Element) -> None:
    """A type and a vocabulary for every track, so that a person may add its tiers."""
    for track in TRACKS:
        ET.SubElement(
            root,
            "LINGUISTIC_TYPE",
            {
                "CONTROLLED_VOCABULARY_REF": track,
                "GRAPHIC_REFERENCES": "false",
                "LINGUISTIC_TYPE_ID": track,
                "TIME_ALIGNABLE": "true",
            },
        )
    ET.SubElement(
        root,
        "LANGUAGE",
        {
            "LANG_DEF": "http://cdb.iso.org/lg/CDB-00130975-001",
            "LANG_ID": LANGUAGE,
            "LANG_LABEL": "undetermined (und)",
        },
    )
    for track in TRACKS:
        vocabulary = ET.SubElement(root, "CONTROLLED_VOCABULARY", {"CV_ID": track})
        ET.SubElement(vocabulary, "DESCRIPTION", {"LANG_REF": LANGUAGE})
        for action in track_actions(track):
            entry = ET.SubElement(vocabulary, "CV_ENTRY_ML", {"CVE_ID": action})
            ET.SubElement(entry, "CVE_VALUE", {"LANG_REF": LANGUAGE}).text = action
