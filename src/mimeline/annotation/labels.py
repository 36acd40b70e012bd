"""Names of clusters: the proposed ones, overridden by a person's file, never silently stale."""

import logging
from pathlib import Path

import yaml

from mimeline import tables
from mimeline.annotation.fitted import is_fitted, read_fingerprint
from mimeline.errors import BadLabels
from mimeline.vocabulary import NEUTRAL, series_actions

log = logging.getLogger(__name__)


def label(proposed: Path, models: dict[str, Path], labels: Path, file: str | None) -> None:
    """Name every cluster: as proposed, or as a person's file says.

    proposed, labels: `labels` tables in and out. models: folders by region. file: a person's YAML;
    clusters that it leaves out keep their proposal.
    Raises BadLabels where the file names an unknown region, cluster or action, or was made for
    another model.
    """
    rows = tables.read(tables.LABELS, proposed)
    given = read_labels(file) if file else {}
    if unknown := sorted(set(given) - set(models), key=str):
        raise BadLabels(
            file,
            found=f"region {unknown[0]!r}",
            expected=f"one of {', '.join(models)}",
            remedy="Correct the region's name.",
        )
    for region, folder in models.items():
        if not is_fitted(folder):
            continue
        own = rows["region"] == region
        if region in given:
            known = rows.loc[own, "cluster"].tolist()
            human = _checked(file, region, given[region], read_fingerprint(folder), known)
            for cluster, entry in human.items():
                at = own & (rows["cluster"] == cluster)
                rows.loc[at, ["action", "note"]] = entry["action"], entry["note"]
                rows.loc[at, "source"] = "human"
        by_person = int((rows.loc[own, "source"] == "human").sum())
        log.info("%s: %d of %d clusters named by a person", region, by_person, own.sum())
    for region in set(given) - set(rows["region"]):
        log.warning("%s is not segmented, so its names in %s go unused", region, file)
    tables.write(tables.LABELS, rows, labels, tables.reason(proposed))


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


def read_labels(path: str) -> dict[str, dict]:
    """A person's label file: region → {model, clusters: {number: name or {action, note}}}.

    Raises BadLabels for what is no such file.
    """
    try:
        content = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        raise BadLabels(
            path,
            found="no such file" if missing else str(error),
            expected="a label file",
            remedy="Copy the names of the last run there, or set label.file to null.",
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
        shaped = isinstance(block, dict) and set(block) == {"model", "clusters"}
        if not shaped or not isinstance(block["clusters"], dict):
            raise BadLabels(
                path,
                place=f"region {region}",
                found=repr(block),
                expected="the keys model and clusters",
                remedy="Start from the label file that the last run wrote.",
            )
    return content


def _checked(
    file: str, region: str, block: dict, fingerprint: str, clusters: list[int]
) -> dict[int, dict]:
    """A region's names, each {action, note}, once they are known to fit this model."""
    if str(block["model"]) != fingerprint:
        raise BadLabels(
            file,
            place=f"region {region}",
            found=f"names for model {block['model']}",
            expected=f"names for model {fingerprint}",
            remedy="The clusters were fitted anew, so these names may mean other clusters: look at "
            "the exemplars, start from the labels.yaml that was written beside them, and name the "
            "clusters again.",
        )
    names = {}
    for cluster, name in block["clusters"].items():
        entry = name if isinstance(name, dict) else {"action": name}
        place = f"region {region}, cluster {cluster}"
        if cluster not in clusters:
            raise BadLabels(
                file,
                place=place,
                found="no such cluster",
                expected=f"one of {', '.join(map(str, clusters))}",
                remedy="Remove the entry.",
            )
        allowed = (*series_actions(region), NEUTRAL)
        if entry.get("action") not in allowed or set(entry) - {"action", "note"}:
            raise BadLabels(
                file,
                place=place,
                found=repr(name),
                expected=f"one of {', '.join(allowed)}",
                remedy="Name the cluster by one of these, or {action: ..., note: ...}.",
            )
        note = entry.get("note")
        names[cluster] = {"action": entry["action"], "note": None if note is None else str(note)}
    return names
