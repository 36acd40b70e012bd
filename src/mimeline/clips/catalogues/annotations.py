"""CelebV-Text's annotations: what is told of which clip, under names that do not quite fit."""

import logging
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from mimeline.archives.opcodes import Refused, unpickle
from mimeline.clips.catalogues.json_records import (
    AGAIN,
    clip_name,
    pairs_of,
    parsed,
    part,
    read_bytes,
)
from mimeline.errors import BadFile

log = logging.getLogger(__name__)

EXPECTED = "CelebV-Text's annotations: act and app, each with an entry per clip"
KINDS = ("act", "app", "emotion")
MOST_OPCODES = 16_000_000  # of annotations.pkl; 70,000 clips have some 7 million
PROTOCOL = b"\x80"  # what a pickle of protocol 2 and later begins with
NUMBERED = re.compile(r"(.+)_(\d{1,9})", re.ASCII | re.DOTALL)


def read_annotations(path: Path) -> dict[str, dict[str, Any]]:
    """act, app and emotion: clip's name → what is told of it, from JSON or from annotations.pkl.

    Of a name that stands twice the first entry counts. Of a pickle only plain containers, text and
    numbers are made; nothing in it is run. Raises BadFile.
    """
    raw = read_bytes(path, EXPECTED)
    pickled = raw.startswith(PROTOCOL) or path.suffix in (".pkl", ".pickle")
    content = _unpickled(raw, path) if pickled else parsed(raw, path, EXPECTED)
    try:
        told = {kind: entries for kind, entries in part(content).items() if kind in KINDS}
    except ValueError as error:
        raise BadFile(path, found=str(error), expected=EXPECTED, remedy=AGAIN) from error
    wrong = [kind for kind, entries in told.items() if not isinstance(entries, dict)]
    if wrong or not told:
        found = f"{wrong[0]} that is no object" if wrong else "none of act, app and emotion"
        raise BadFile(path, found=found, expected=EXPECTED, remedy=AGAIN)
    return {kind: _named(entries, f"{path.name}, {kind}") for kind, entries in told.items()}


def _named(entries: dict, place: str) -> dict[str, Any]:
    named: dict[str, Any] = {}
    repeated = 0
    for key, entry in pairs_of(entries):
        repeated += clip_name(str(key)) in named
        named.setdefault(clip_name(str(key)), entry)
    if repeated:
        log.warning("%s: %d names stand twice: the first entry counts", place, repeated)
    return named


def _unpickled(raw: bytes, path: Path) -> dict[str, Any]:
    try:
        content, _ = unpickle(raw, {}, most=MOST_OPCODES)
    except Refused as error:
        raise BadFile(path, found=str(error), expected=EXPECTED, remedy=AGAIN) from error
    if type(content) is not dict:
        found = type(content).__name__
        raise BadFile(path, found=found, expected=EXPECTED, remedy=AGAIN)
    return content


def match(
    names: Sequence[str], starts: Sequence[float], keys: Iterable[str]
) -> tuple[list[str | None], list[bool]]:
    """For each clip the key of its annotations, or None; and whether some were in doubt.

    names (n,): the clips' names, which repeat where two sets of clips share them. starts (n,):
    seconds. keys: the annotations' names. The same name goes first. Then one that differs by `-`
    and `_` at its beginning, where one clip and one key are left of it. Then `<name>_2` and
    `<name>_4` for the clips of that name, earlier clips first, where there are as many of both.
    """
    found: list[str | None] = [None] * len(names)
    doubtful = [False] * len(names)
    left = dict.fromkeys(keys)
    for of_name, of_key, several in (
        (str, str, False),
        (_bare, _bare, False),
        (str, _unnumbered, True),
    ):
        clips = _grouped((of_name(name), n) for n, name in enumerate(names) if found[n] is None)
        told = _grouped((of_key(key), key) for key in left)
        for group, numbers in clips.items():
            candidates = told.get(group, [])
            if len(candidates) != len(numbers) or (len(numbers) > 1 and not several):
                for n in numbers:
                    doubtful[n] |= bool(candidates)
                continue
            numbers.sort(key=lambda n: starts[n])
            candidates.sort(key=lambda key: (_number(key), key))
            for n, key in zip(numbers, candidates, strict=True):
                found[n] = key
                del left[key]
    return found, [doubt and key is None for doubt, key in zip(doubtful, found, strict=True)]


def _grouped(pairs: Iterable[tuple[str, Any]]) -> Mapping[str, list]:
    groups = defaultdict(list)
    for group, member in pairs:
        groups[group].append(member)
    return groups


def _bare(name: str) -> str:
    return name.lstrip("-_")


def _unnumbered(key: str) -> str:
    numbered = NUMBERED.fullmatch(key)
    return numbered[1] if numbered else ""


def _number(key: str) -> int:
    numbered = NUMBERED.fullmatch(key)
    return int(numbered[2]) if numbered else 0
