"""What a cell of a table of clips means: texts, and lists of names with their times."""

import re
from collections.abc import Callable
from typing import Any

from mimeline.clips.catalogues.json_records import name
from mimeline.clips.intervals import over, placed

LONGEST_TEXT = 10_000  # characters
TIMED_KEYS = ("name", "start_s", "end_s", "uncertainty_s")
LONGEST_S = 1e6  # of a time, and by which it may be off
_SECONDS = r"(\d{1,6}(?:\.\d{1,9})?)"
TIMED = re.compile(rf"([^@]+)(?:@{_SECONDS}-{_SECONDS}(?:~{_SECONDS})?)?", re.ASCII)


def verbatim(value: Any) -> str:
    """A name as it stands, whether text or a whole number. Raises TypeError."""
    if isinstance(value, bool) or not isinstance(value, int | str):
        raise TypeError(repr(value)[:100])
    return str(value)


def plain_text(value: Any) -> str:
    """A text on one line. Raises TypeError, ValueError."""
    if not isinstance(value, str):
        raise TypeError(repr(value)[:100])
    if len(value) > LONGEST_TEXT:
        raise ValueError(f"{len(value)} characters")
    text = " ".join(value.split())
    if not text.isprintable():
        raise ValueError(repr(value)[:100])
    return text


def name_list(value: Any) -> list[str]:
    """Names with ; between, or a list of them. Raises TypeError, ValueError."""
    return [name(item) for item in _items(value, ";")]


def text_list(value: Any) -> list[str]:
    """Texts with | between, or a list of them. Raises TypeError, ValueError."""
    return [plain_text(item) for item in _items(value, "|")]


def interval_list(length_s: float) -> Callable[[Any], tuple[list[dict], list[str]]]:
    """What reads names with ; between as intervals of a clip of length_s seconds.

    A name alone holds throughout; name@1.5-3 from 1.5 s of the clip to 3 s; name@1.5-3~0.5 where
    either may be 0.5 s off. An item may also be one of the `clips` table's own. As `placed`, it
    returns the intervals, clamped to the clip, and in words those that lie outside of it.
    """

    def intervals(value: Any) -> tuple[list[dict], list[str]]:
        inside, outside = [], []
        for what, since, until, unsure in map(_told, _items(value, ";")):
            if since is None:
                inside.append(over(what, length_s))
                continue
            found, left_out = placed([(what, since, until)], length_s, unsure or 0.0)
            inside += [interval | {"uncertainty_s": unsure} for interval in found]
            outside += left_out
        return inside, outside

    return intervals


def _items(value: Any, separator: str) -> list:
    if isinstance(value, str):
        return [item.strip() for item in value.split(separator) if item.strip()]
    if not isinstance(value, list):
        raise TypeError(repr(value)[:100])
    return [item for item in value if item is not None]


def _told(item: Any) -> tuple[str, float | None, float | None, float | None]:
    """Name, begin, end and uncertainty in seconds of the clip; no times for what holds throughout.

    Raises TypeError, ValueError, KeyError.
    """
    if isinstance(item, dict):
        what, since, until, unsure = (item[key] for key in TIMED_KEYS)
    else:
        found = TIMED.fullmatch(plain_text(item))
        if not found:
            raise ValueError(repr(item)[:100])
        what, *times = found.groups()
        since, until, unsure = (None if time is None else float(time) for time in times)
        if since is None:
            return name(what), None, None, None
    if not -LONGEST_S <= since <= until <= LONGEST_S:
        raise ValueError(f"{what} from {since:g} to {until:g} s")
    if unsure is not None and not 0 <= unsure <= LONGEST_S:
        raise ValueError(f"{what} that may be {unsure} s off")
    return name(what), float(since), float(until), None if unsure is None else float(unsure)
