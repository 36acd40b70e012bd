"""A person's label file: YAML, a line per cluster, to be read and merged in git."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from mimeline.annotation.plain_yaml import Writer, read_yaml
from mimeline.atomic import whole
from mimeline.errors import BadLabels

NOT_SURE = "not sure"
OPEN = "open"
MOST_CHARACTERS = 200  # of a note
HEADER = """\
# Names of clusters: `mimeline label` writes them, an editor may. A cluster is named by an action of
# its region or Neutral, by {action: BrowUp, note: strong}, {same_as: 3} or not sure.
# One that is open has lost its name in a refit and stops a run until it has another.
# `model` tells which fit the names belong to; `shown`, which intervals the person saw.
"""
START = "A run without label.file writes one to start from: label/labels.yaml in its results."

_NUMBER = re.compile(r"0|[1-9][0-9]{0,8}")
_MODEL = re.compile(r"[0-9A-Za-z]{1,64}")  # it becomes a part of a file's name


@dataclass(frozen=True)
class Answer:
    """What a person says of a cluster: an action of its region or Neutral, perhaps finer by a note;
    that it is the same as another cluster; or, with neither, that they are not sure."""

    action: str | None = None
    note: str | None = None
    same_as: int | None = None


@dataclass(frozen=True)
class RegionAnswers:
    """model: the fit's fingerprint. clusters: by number. shown: cluster → (clip_id, start_frame,
    end_frame) of the intervals that the answer rests on. open: clusters that no name of an earlier
    fit could be moved to, and that nobody answered for since."""

    model: str
    clusters: Mapping[int, Answer] = field(default_factory=dict)
    shown: Mapping[int, tuple[tuple[str, int, int], ...]] = field(default_factory=dict)
    open: frozenset[int] = frozenset()


def kept_copy(path: str | Path, region: str, model: str) -> Path:
    """Where the file is kept as it was before a region's names of a fit gave way to another's."""
    return Path(f"{path}.{region}-{model}.bak")


def root(clusters: Mapping[int, Answer], number: int) -> int:
    """The cluster that a cluster is, at last, the same as; itself where it is nobody's."""
    while (answer := clusters.get(number)) is not None and answer.same_as is not None:
        number = answer.same_as
    return number


def read_label_file(path: str | Path) -> dict[str, RegionAnswers]:
    """The answers by region. Raises BadLabels for what is no label file.

    Whether regions, clusters and actions are known is told by `labels`.
    """
    content = read_yaml(path)
    content = {} if content is None else content
    if not isinstance(content, dict):
        raise BadLabels(
            path,
            found=_called(content),
            expected="regions, each with the keys model and clusters",
            remedy=START,
        )
    return {region: _region(path, region, block) for region, block in content.items()}


def write_label_file(
    path: str | Path, answers: Mapping[str, RegionAnswers], header: str = HEADER
) -> None:
    """Write the answers, whole or not at all.

    A line per cluster, and an empty one between: git takes changes of adjacent lines for a
    conflict.
    """
    text = header
    for region, own in answers.items():
        text += f"{region}:\n  model: {_flow(own.model)}\n"
        said = {n: _said(answer) for n, answer in own.clusters.items()}
        text += _block("clusters", dict.fromkeys(own.open, OPEN) | said)
        if own.shown:
            text += _block("shown", {n: [list(i) for i in rows] for n, rows in own.shown.items()})
    with whole(Path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _block(key: str, entries: Mapping[int, object]) -> str:
    if not entries:
        return f"  {key}: {{}}\n"
    lines = [f"    {number}: {_flow(entry)}\n" for number, entry in sorted(entries.items())]
    return f"  {key}:\n" + "\n".join(lines)


def _said(answer: Answer):
    if answer.same_as is not None:
        return {"same_as": answer.same_as}
    if answer.action is None:
        return NOT_SURE
    return {"action": answer.action, "note": answer.note} if answer.note else answer.action


def _flow(value) -> str:
    text = yaml.dump(
        value,
        Dumper=Writer,
        default_flow_style=True,
        sort_keys=False,
        allow_unicode=True,
        width=float("inf"),
    )
    return text.removesuffix("...\n").strip()


def _region(path, region: str, block) -> RegionAnswers:
    place = f"region {region}"
    keys = set(block) if isinstance(block, dict) else set()
    if not {"model", "clusters"} <= keys <= {"model", "clusters", "shown"}:
        raise BadLabels(
            path,
            place=place,
            found=f"the keys {', '.join(block)}" if keys else _called(block),
            expected="the keys model and clusters, perhaps shown",
            remedy=START,
        )
    model = block["model"]
    if not isinstance(model, str) or not _MODEL.fullmatch(model):
        raise BadLabels(
            path,
            place=f"{place}, model",
            found=_called(model),
            expected="a fit's fingerprint",
            remedy=START,
        )
    entries = _numbered(path, place, "clusters", block["clusters"])
    clusters = {
        number: _answer(path, f"{place}, cluster {number}", entry)
        for number, entry in entries
        if entry != OPEN
    }
    for number in clusters:
        _refuse_circle(path, place, clusters, number)
    shown = {
        number: _shown(path, f"{place}, shown, cluster {number}", rows)
        for number, rows in _numbered(path, place, "shown", block.get("shown"))
    }
    return RegionAnswers(model, clusters, shown, frozenset(n for n, e in entries if e == OPEN))


def _numbered(path, place: str, key: str, block) -> list[tuple[int, object]]:
    """What a block says, by cluster."""
    block = {} if block is None else block
    if not isinstance(block, dict):
        raise BadLabels(
            path,
            place=f"{place}, {key}",
            found=_called(block),
            expected="clusters by their numbers",
            remedy="Write a line per cluster, such as `0: Neutral`.",
        )
    for number in block:
        if not _NUMBER.fullmatch(number):
            raise BadLabels(
                path,
                place=f"{place}, {key}",
                found=f"cluster {number}",
                expected="a cluster's number, such as 0 or 12",
                remedy="Correct the number, or remove the entry.",
            )
    return [(int(number), entry) for number, entry in block.items()]


def _answer(path, place: str, said) -> Answer:
    entry = said if isinstance(said, dict) else {"action": said}
    if set(entry) == {"same_as"} and _is_number(entry["same_as"]):
        return Answer(same_as=int(entry["same_as"]))
    action, note = entry.get("action"), entry.get("note")
    if set(entry) - {"action", "note"} or not isinstance(action, str) or not action:
        raise BadLabels(
            path,
            place=place,
            found=_called(said),
            expected=f"an action, Neutral or {NOT_SURE}",
            remedy="Name the cluster by one of these, {action: ..., note: ...} or {same_as: ...}.",
        )
    fits = note is None or (isinstance(note, str) and len(note) <= MOST_CHARACTERS)
    if not fits or (note and (not note.isprintable() or action == NOT_SURE)):
        raise BadLabels(
            path,
            place=place,
            found=f"the note {_called(note)}",
            expected=f"one line of at most {MOST_CHARACTERS} characters, beside an action",
            remedy="Shorten the note, or leave it out.",
        )
    return Answer() if action == NOT_SURE else Answer(action, note or None)


def _refuse_circle(path, place: str, clusters: Mapping[int, Answer], start: int) -> None:
    been, number = [start], start
    while (answer := clusters.get(number)) is not None and answer.same_as is not None:
        number = answer.same_as
        if number in been:
            circle = ", which is the same as ".join(map(str, [*been, number]))
            raise BadLabels(
                path,
                place=f"{place}, cluster {start}",
                found=f"cluster {circle}",
                expected="clusters that end in one with a name of its own",
                remedy="Name one of them by an action.",
            )
        been.append(number)


def _shown(path, place: str, rows) -> tuple[tuple[str, int, int], ...]:
    for row in (rows := [] if rows is None else rows) if isinstance(rows, list) else [rows]:
        shaped = isinstance(row, list) and len(row) == 3 and all(isinstance(v, str) for v in row)
        clip, start, end = row if shaped else ("", "", "")
        if not (clip and _is_number(start) and _is_number(end) and int(start) < int(end)):
            raise BadLabels(
                path,
                place=place,
                found=_called(row),
                expected="[clip, first frame, frame after the last]",
                remedy="Correct the interval, or remove it: names are moved by it after a refit.",
            )
    return tuple((clip, int(start), int(end)) for clip, start, end in rows)


def _is_number(value) -> bool:
    return isinstance(value, str) and bool(_NUMBER.fullmatch(value))


def _called(value) -> str:
    """What a message calls a value that is none of those expected."""
    if isinstance(value, str):
        return repr(value if len(value) <= 60 else f"{value[:60]}…")
    if isinstance(value, (list, dict)):
        text = repr(value)
        return text if len(text) <= 60 else f"a {type(value).__name__} of {len(value)}"
    return "nothing"
