"""Names of clusters: proposed by a rule, overridden by a person's file, never silently stale."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from mimeline import tables
from mimeline.annotation.exemplars import choose
from mimeline.annotation.exemplars import table as exemplar_rows
from mimeline.annotation.proposals import propose, read_proposals
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.series import sequences
from mimeline.errors import BadLabels
from mimeline.vocabulary import NEUTRAL, series_actions, series_channels

log = logging.getLogger(__name__)

HEADER = """\
# Names of the clusters. To change them, copy this file to config/labels/, edit it, and set
# label.file to it. A cluster is named by an action of its region or Neutral, or by
# {action: BrowUp, note: strong}. `model` tells which fitted model the names belong to.
"""


def label(
    series: dict[str, Path],
    clusters: dict[str, Path],
    models: dict[str, Path],
    proposals: Path,
    labels: Path,
    names: Path,
    exemplars: Path,
    side: str,
    file: str | None,
    n_random: int,
    seed: int,
) -> None:
    """Name every cluster of every region.

    series, clusters, models: by region. proposals: the table of rules. labels, exemplars: tables to
    write; names: the same names as YAML, to start from. file: a person's YAML, which overrides.
    Raises BadLabels where the file names an unknown region, cluster or action, or was made for
    another model.
    """
    given = read_labels(file) if file else {}
    rules = read_proposals(proposals)
    rows, shown, written = [], [], {}
    if unknown := sorted(set(given) - set(series), key=str):
        raise BadLabels(
            file,
            found=f"region {unknown[0]!r}",
            expected=f"one of {', '.join(series)}",
            remedy="Correct the region's name.",
        )
    for number, region in enumerate(series):
        assigned = tables.read(tables.CLUSTERS, clusters[region])
        if assigned.empty:
            if region in given:
                log.warning("%s is not segmented, so its names in %s go unused", region, file)
            continue
        frames, _ = sequences(tables.read(tables.SERIES[region, side], series[region]))
        values = frames[list(series_channels(region, side))].to_numpy("float64")
        assigned = assigned.merge(frames[["clip_id", "frame"]], how="right")  # in series order
        ids = assigned["cluster"].to_numpy("int64")
        fingerprint = RegionModel.load(models[region]).fingerprint()
        proposed = propose(region, values, ids, rules)
        human = {}
        if region in given:
            human = _checked(file, region, given[region], fingerprint, proposed)
        counts = np.bincount(ids)
        for cluster, action in proposed.items():
            named = human.get(cluster)
            rows.append(
                {
                    "region": region,
                    "cluster": cluster,
                    "action": named["action"] if named else action,
                    "note": named["note"] if named else None,
                    "source": "human" if named else "proposed",
                    "share": counts[cluster] / len(ids),
                }
            )
        written[region] = {"model": fingerprint, "clusters": _yaml_names(rows, region)}
        rng = np.random.default_rng([seed, number])  # one region's refit keeps the others' choice
        shown.append(exemplar_rows(region, choose(assigned, values, n_random, rng)))
        named_by = "a person" if human else "the rule"
        log.info("%s: %d clusters, named by %s", region, len(proposed), named_by)

    reason = "" if rows else "no region could be segmented"
    empty_rows = pd.DataFrame(columns=tables.LABELS.schema.names)
    tables.write(tables.LABELS, pd.DataFrame(rows) if rows else empty_rows, labels, reason)
    empty = tables.empty(tables.EXEMPLARS)
    tables.write(tables.EXEMPLARS, pd.concat(shown) if shown else empty, exemplars, reason)
    text = yaml.safe_dump(written, sort_keys=False) if written else "{}\n"
    Path(names).write_text(HEADER + text, encoding="utf-8")


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
        raise BadLabels(
            path, found=str(error), expected="YAML", remedy="Mend the file's syntax."
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
    file: str, region: str, block: dict, fingerprint: str, clusters: dict[int, str]
) -> dict[int, dict]:
    """A region's names, each {action, note}, once they are known to fit this model."""
    if str(block["model"]) != fingerprint:
        raise BadLabels(
            file,
            place=f"region {region}",
            found=f"names for model {block['model']}",
            expected=f"names for model {fingerprint}",
            remedy="The clusters were fitted anew, so these names may mean other clusters: look at "
            "the exemplars, start from the label file that this run writes without label.file, and "
            "name them again.",
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


def _yaml_names(rows: list[dict], region: str) -> dict:
    names = {}
    for row in rows:
        if row["region"] == region:
            noted = {"action": row["action"], "note": row["note"]}
            names[row["cluster"]] = noted if row["note"] else row["action"]
    return names
