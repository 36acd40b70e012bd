"""Records of clips in a JSON file that nobody vouches for."""

import json
import re
import reprlib
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from mimeline.clips.admission import size_of_box
from mimeline.errors import BadFile, unreadable
from mimeline.media.signature import kind_of

LARGEST_FILE = 128 << 20  # bytes; CelebV-Text's have some 15 MB
MOST_TOLD = 1_000  # actions, emotions or attributes of a clip
LONGEST_NAME = 100  # of an action, an emotion or an attribute
TIME = re.compile(r"(\d{1,4}):(\d{1,2}):(\d{1,2}(?:\.\d{1,9})?)", re.ASCII)
GARBLED = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)
REMEDIES = {
    "a Git LFS pointer, not the file itself": "Fetch it with git lfs pull.",
    "an HTML page": "Download it again: a page came in its place, perhaps a download warning.",
    "a ZIP archive": "Unpack it.",
    "a gzip archive": "Unpack it.",
}
AGAIN = "Take the file again from where it was published."


class Repeating(dict):
    """A JSON object with a key that stands twice: every pair is in `pairs`, in their order."""

    def __init__(self, pairs: list[tuple[str, Any]]):
        super().__init__(pairs)
        self.pairs = pairs


def read_bytes(path: Path, expected: str) -> bytes:
    """A file of at most LARGEST_FILE. Raises BadFile, also where its beginning gives it away."""
    key = "Name the file in the catalogue's block of the configuration, or set data_dir."
    try:
        if path.exists() and not path.is_file():
            raise BadFile(path, found="no plain file", expected=expected, remedy=key)
        size = path.stat().st_size
        raw = path.read_bytes() if size <= LARGEST_FILE else b""
    except (OSError, ValueError) as error:
        raise unreadable(path, error, expected=expected, remedy=key) from error
    if size > LARGEST_FILE:
        raise BadFile(
            path,
            found=f"{size >> 20} MiB",
            expected=f"{expected}, of at most {LARGEST_FILE >> 20} MiB",
            remedy="Check that it is the catalogue, or leave out records that are not needed.",
        )
    if kind := kind_of(raw[:64]):
        remedy = REMEDIES.get(kind, AGAIN)
        raise BadFile(path, found=kind, expected=expected, remedy=remedy)
    return raw


def read_object(path: Path, expected: str) -> dict[str, Any]:
    """The object in a JSON file, Repeating where keys stand twice. Raises BadFile."""
    return parsed(read_bytes(path, expected), path, expected)


def parsed(raw: bytes, path: Path, expected: str) -> dict[str, Any]:
    """The object in JSON that was read from path, as read_object gives it. Raises BadFile."""
    try:
        content = json.loads(raw.decode("utf-8-sig"), object_pairs_hook=_object)
    except RecursionError as error:
        raise BadFile(path, found="deep nesting", expected=expected, remedy=AGAIN) from error
    except UnicodeDecodeError as error:
        found = f"byte {error.start + 1} that is no UTF-8"
        raise BadFile(path, found=found, expected=expected, remedy=AGAIN) from error
    except ValueError as error:
        raise unreadable(path, error, expected=expected, remedy=AGAIN) from error
    if not isinstance(content, dict):
        found = type(content).__name__
        raise BadFile(path, found=found, expected=expected, remedy=AGAIN)
    return content


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    return content if len(content) == len(pairs) else Repeating(pairs)


def pairs_of(content: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """The keys with their values; a key that stands twice comes twice."""
    return iter(content.pairs if isinstance(content, Repeating) else content.items())


def clip_name(key: str) -> str:
    """A clip's name without its file's endings: published keys have none, .mp4 or .mp4.mp4."""
    while key.endswith(".mp4"):
        key = key.removesuffix(".mp4")
    return key


def unfit(path: Path, key: str, error: Exception, expected: str) -> BadFile:
    """What is wrong with a record that could not be read. error: one of GARBLED."""
    what = f"no {error}" if isinstance(error, KeyError) else str(error)
    return BadFile(
        path,
        place=f"record {key[:LONGEST_NAME]}",
        found=what[:300],
        expected=expected,
        remedy="Mend the record, or take the file again from where it was published.",
    )


def whole_clip(record: dict[str, Any]) -> dict[str, Any]:
    """What CelebV's records have in common: source, seconds in it and the box of the face.

    The box stands as it is, in shares of the picture, which may overshoot a little, or in pixels;
    in pixels it tells width and height. Nothing is judged here. Raises one of GARBLED.
    """
    record = part(record)
    source, subject = record["ytb_id"], record.get("subject")
    if not isinstance(source, str) or not (subject is None or plain(subject)):
        raise TypeError(f"ytb_id {reprlib.repr(source)}, subject {reprlib.repr(subject)}")
    duration = part(record["duration"])
    if "start_frame" in duration and "start_sec" not in duration:
        raise ValueError(
            "start_frame and end_frame, but no frame rate; released files have start_sec and "
            "end_sec: rename the keys where they are seconds"
        )
    box = part(record["bbox"])
    edges = {side: number(box[side]) for side in ("top", "bottom", "left", "right")}
    return {
        "source_id": source,
        "subject_id": subject,
        "start_s": number(duration["start_sec"]),
        "end_s": number(duration["end_sec"]),
        **{f"bbox_{side}": edge for side, edge in edges.items()},
        **size_of_box(**edges),
    }


def part(value: Any) -> dict[str, Any]:
    """The value, an object that says each thing once. Raises TypeError or ValueError."""
    if not isinstance(value, dict):
        raise TypeError(f"{reprlib.repr(value)} where an object belongs")
    if isinstance(value, Repeating):
        keys = [key for key, _ in value.pairs]
        raise ValueError(f"key {next(k for k in keys if keys.count(k) > 1)!r} twice")
    return value


def few(values: Any) -> Sequence[Any]:
    """The value, a list of no more than MOST_TOLD. Raises TypeError or ValueError."""
    if not isinstance(values, list | tuple):
        raise TypeError(f"{reprlib.repr(values)} where a list belongs")
    if len(values) > MOST_TOLD:
        raise ValueError(f"a list of {len(values)}, more than {MOST_TOLD}")
    return values


def number(value: Any) -> float:
    """The value as a float, which may be NaN or infinite. Raises TypeError, OverflowError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{reprlib.repr(value)} where a number belongs")
    return float(value)


def name(value: Any) -> str:
    """A word of the catalogue as the tables have it: lower case, blanks as underscores."""
    if not isinstance(value, str) or not (word := _name(value)):
        raise TypeError(f"{reprlib.repr(value)} where a name belongs")
    return word


@lru_cache(maxsize=1024)
def _name(text: str) -> str:
    return "_".join(text.lower().split()) if plain(text) else ""


def plain(text: Any) -> bool:
    """Whether a value is text that a table and a page may show: short, no control characters."""
    return isinstance(text, str) and len(text) <= LONGEST_NAME and text.isprintable()


def seconds(time: Any) -> float:
    """h:mm:ss, with or without leading zeros, as seconds. Raises TypeError or ValueError."""
    if not isinstance(time, str):
        raise TypeError(f"{reprlib.repr(time)} where h:mm:ss belongs")
    return _seconds(time)


@lru_cache(maxsize=16_384)
def _seconds(time: str) -> float:
    if not (found := TIME.fullmatch(time)):
        raise ValueError(f"{reprlib.repr(time)} where h:mm:ss belongs")
    hours, minutes, rest = found.groups()
    return 3600 * int(hours) + 60 * int(minutes) + float(rest)
