"""A person's label file: YAML, a line per cluster, to be read and merged in git."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from mimeline.atomic import whole
from mimeline.errors import BadLabels

NOT_SURE = "not sure"
HEADER = """\
# Names of clusters: `mimeline label` writes them, an editor may. A cluster is named by an action of
# its region or Neutral, by {action: BrowUp, note: strong}, {same_as: 3} or not sure.
# `model` tells which fit the names belong to; `shown`, which intervals the person saw.
"""


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
    end_frame) of the intervals that the answer rests on."""

    model: str
    clusters: Mapping[int, Answer] = field(default_factory=dict)
    shown: Mapping[int, tuple[tuple[str, int, int], ...]] = field(default_factory=dict)


def read_label_file(path: str | Path) -> dict[str, RegionAnswers]:
    """The answers by region. Raises BadLabels for what is no label file.

    Whether regions, clusters and actions are known is `labels.check`'s.
    """
    content = _content(path)
    return {
        str(region): RegionAnswers(
            str(block["model"]),
            {number: _answer(path, region, n, number) for number, n in block["clusters"].items()},
            {
                number: tuple((str(c), int(a), int(b)) for c, a, b in rows)
                for number, rows in block.get("shown", {}).items()
            },
        )
        for region, block in content.items()
    }


def write_label_file(path: str | Path, answers: Mapping[str, RegionAnswers]) -> None:
    """Write the answers, whole or not at all; a line per cluster."""
    lines = [HEADER]
    for region, own in answers.items():
        lines.append(f"{region}:\n  model: {_flow(own.model)}\n")
        lines.append("  clusters:\n" if own.clusters else "  clusters: {}\n")
        lines += [f"    {n}: {_flow(_said(a))}\n" for n, a in sorted(own.clusters.items())]
        if own.shown:
            lines.append("  shown:\n")
            rows = {n: [list(row) for row in rows] for n, rows in sorted(own.shown.items())}
            lines += [f"    {n}: {_flow(row)}\n" for n, row in rows.items()]
    with whole(Path(path)) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8")


def _said(answer: Answer):
    if answer.same_as is not None:
        return {"same_as": answer.same_as}
    if answer.action is None:
        return NOT_SURE
    return {"action": answer.action, "note": answer.note} if answer.note else answer.action


def _flow(value) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**6)
    return text.removesuffix("...\n").strip()


def _answer(path, region, name, cluster) -> Answer:
    entry = name if isinstance(name, dict) else {"action": name}
    if set(entry) == {"same_as"} and isinstance(entry["same_as"], int):
        return Answer(same_as=entry["same_as"])
    if set(entry) - {"action", "note"} or not isinstance(entry.get("action"), str):
        raise BadLabels(
            path,
            place=f"region {region}, cluster {cluster}",
            found=repr(name),
            expected=f"an action, Neutral or {NOT_SURE}",
            remedy="Name the cluster by one of these, {action: ..., note: ...} or {same_as: ...}.",
        )
    if entry["action"] == NOT_SURE:
        return Answer()
    note = entry.get("note")
    return Answer(entry["action"], None if note is None else str(note))


class _Loader(yaml.SafeLoader):
    """YAML that refuses a key given twice, of which the last would win in silence."""

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
            if isinstance(key, yaml.ScalarNode) and (key.tag, key.value) in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key.value} a second time", key.start_mark
                )
            seen.add((key.tag, str(key.value)))
        return super().construct_mapping(node, deep)


def _content(path: str | Path) -> dict[str, dict]:
    try:
        content = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        raise BadLabels(
            path,
            found="no such file" if missing else str(error),
            expected="a label file",
            remedy="Run mimeline label, or set label.file to null.",
        ) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        raise BadLabels(
            path,
            place=f"line {mark.line + 1}" if mark else "",
            found=getattr(error, "problem", None) or str(error),
            expected="YAML",
            remedy="Mend the file's syntax.",
        ) from error
    content = {} if content is None else content
    if not isinstance(content, dict):
        raise BadLabels(
            path,
            found=f"a {type(content).__name__}",
            expected="regions, each with the keys model and clusters",
            remedy="Start from the label file that the last run wrote.",
        )
    for region, block in content.items():
        shaped = isinstance(block, dict) and {"model", "clusters"} <= set(block)
        shaped = shaped and set(block) <= {"model", "clusters", "shown"}
        if not shaped or not isinstance(block["clusters"], dict):
            raise BadLabels(
                path,
                place=f"region {region}",
                found=repr(block),
                expected="the keys model and clusters",
                remedy="Start from the label file that the last run wrote.",
            )
    return content
