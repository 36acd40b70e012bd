"""Names of clusters: the proposed ones, overridden by a person's file, never silently stale."""

import logging
from pathlib import Path

from mimeline import tables
from mimeline.annotation.fitted import is_fitted, read_fingerprint
from mimeline.annotation.label_file import (
    Answer,
    RegionAnswers,
    read_label_file,
    write_label_file,
)
from mimeline.errors import BadLabels
from mimeline.vocabulary import NEUTRAL, series_actions

log = logging.getLogger(__name__)


def label(
    proposed: Path,
    clusters: dict[str, Path],
    models: dict[str, Path],
    labels: Path,
    names: Path,
    file: str | None,
    min_agreement: float,
) -> None:
    """Name every cluster: as proposed, or as a person's file says.

    proposed, labels: `labels` tables in and out. clusters, models: tables and folders by region.
    names: a label file of the names as they are, to start from. file: a person's label file;
    clusters that it leaves out keep their proposal.
    Raises BadLabels where the file names an unknown region, cluster or action, or was made for
    another fit and cannot be moved.
    """
    rows = tables.read(tables.LABELS, proposed)
    given = read_label_file(file) if file else {}
    if unknown := sorted(set(given) - set(models), key=str):
        raise BadLabels(
            file,
            found=f"region {unknown[0]!r}",
            expected=f"one of {', '.join(models)}",
            remedy="Correct the region's name.",
        )
    written = {}
    for region, folder in models.items():
        if not is_fitted(folder):
            continue
        own = rows["region"] == region
        fingerprint = read_fingerprint(folder)
        if region in given:
            _check(file, region, given[region], fingerprint, rows.loc[own, "cluster"].tolist())
            for cluster, answer in given[region].clusters.items():
                at = own & (rows["cluster"] == cluster)
                rows.loc[at, "action"], rows.loc[at, "note"] = answer.action, answer.note
                rows.loc[at, "source"] = "human"
        by_person = int((rows.loc[own, "source"] == "human").sum())
        log.info("%s: %d of %d clusters named by a person", region, by_person, own.sum())
        named = {r.cluster: Answer(r.action) for r in rows[own].itertuples()}
        written[region] = RegionAnswers(fingerprint, named)
    write_label_file(names, written)
    tables.write(tables.LABELS, rows, labels, tables.reason(proposed))


def _check(
    file: str, region: str, answers: RegionAnswers, fingerprint: str, clusters: list[int]
) -> None:
    if answers.model != fingerprint:
        raise BadLabels(
            file,
            place=f"region {region}",
            found=f"names for model {answers.model}",
            expected=f"names for model {fingerprint}",
            remedy="The clusters were fitted anew, so these names may mean other clusters: look at "
            "the exemplars, start from the labels.yaml that was written beside them, and name the "
            "clusters again.",
        )
    allowed = (*series_actions(region), NEUTRAL)
    for cluster, answer in answers.clusters.items():
        place = f"region {region}, cluster {cluster}"
        if cluster not in clusters:
            raise BadLabels(
                file,
                place=place,
                found="no such cluster",
                expected=f"one of {', '.join(map(str, clusters))}",
                remedy="Remove the entry.",
            )
        if answer.action not in (*allowed, None):
            raise BadLabels(
                file,
                place=place,
                found=repr(answer.action),
                expected=f"one of {', '.join(allowed)}",
                remedy="Name the cluster by one of these, or {action: ..., note: ...}.",
            )
