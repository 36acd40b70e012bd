"""Names of clusters: the proposed ones, overridden by a person's file, never silently stale."""

import logging
import shlex
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.annotation.fits import recall
from mimeline.annotation.fitted import is_fitted, read_fingerprint
from mimeline.annotation.label_file import (
    Answer,
    RegionAnswers,
    kept_copy,
    read_label_file,
    root,
    write_label_file,
)
from mimeline.annotation.moving import move
from mimeline.errors import BadLabels
from mimeline.vocabulary import NEUTRAL, series_actions

log = logging.getLogger(__name__)

STILL_OPEN = "it lost its name in a refit and has no other yet"
MOST_REASONS = 4  # told when the run stops
NAMES_HEADER = """\
# The clusters' names as they hold in this run, proposals among them: a copy is a label file to
# start from by hand. In a copy every line counts as yours: remove those you do not vouch for.
"""


@dataclass(frozen=True)
class Settled:
    """How a person's answers hold on the present fit of a region.

    model: that fit's fingerprint. answers: that hold, a person's own or moved. moved: of those that
    were moved from another fit, the share of the cluster's known frames that bore the name. unsafe:
    clusters that no name could be moved to, and why. kept: share of the frames known from before
    whose name is the same (None: nothing had to be moved). known: share of the region's frames that
    were known.
    """

    model: str
    answers: dict[int, Answer] = field(default_factory=dict)
    moved: dict[int, float] = field(default_factory=dict)
    unsafe: dict[int, str] = field(default_factory=dict)
    kept: float | None = None
    known: float | None = None


def settle(
    file: str,
    given: RegionAnswers | None,
    region: str,
    fingerprint: str,
    clusters: pd.DataFrame,
    fits: Path,
    min_agreement: float,
) -> Settled:
    """What a person's answers are worth on the present fit; names of another fit are moved.

    file: the label file, for complaints. given: its answers on the region. clusters: the present
    fit's `clusters` table; fits: the folder of all fits' segments. min_agreement: share of a new
    cluster's known frames that must have borne one name.
    Raises BadLabels where an answer names what the region or the fit does not have.
    """
    if given is None:
        return Settled(fingerprint)
    _check_actions(file, region, given)
    if given.model == fingerprint:
        _check_clusters(file, region, given, clusters["cluster"].unique().tolist())
        still = dict.fromkeys(sorted(given.open), STILL_OPEN)
        return Settled(fingerprint, dict(given.clusters), unsafe=still)
    if not given.clusters and not given.open:
        return Settled(fingerprint)
    before = recall(fits, region, given.model)
    if before is not None:
        _check_clusters(file, region, given, before["cluster"].unique().tolist())
    n_names = len(series_actions(region)) + 1
    found = move(given, before, clusters, n_names, min_agreement)
    return Settled(fingerprint, found.answers, found.shares, found.unsafe, found.kept, found.known)


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
    clusters that it leaves out keep their proposal. min_agreement: see `settle`.
    Raises BadLabels where the file names an unknown region, cluster or action, or was made for
    another fit and cannot be moved.
    """
    rows = tables.read(tables.LABELS, proposed)
    given = read_label_file(file) if file else {}
    if unknown := [region for region in given if region not in models]:
        raise BadLabels(
            file,
            found=f"region {unknown[0]!r}",
            expected=f"one of {', '.join(models)}",
            remedy="Correct the region's name.",
        )
    results = Path(proposed).parent.parent
    named, written, unsafe = [], {}, {}
    for region, folder in models.items():
        if not is_fitted(folder):
            if region in given:
                log.warning("%s is not segmented, so its names in %s are not used", region, file)
            continue
        assigned = tables.read(tables.CLUSTERS, clusters[region])
        settled = settle(
            file or "",
            given.get(region),
            region,
            read_fingerprint(folder),
            assigned,
            results / "label" / "fits",
            min_agreement,
        )
        if settled.unsafe:
            unsafe[region] = settled
            continue
        own = rows[rows["region"] == region]
        _warn_of_others(region, own, settled)
        named.append(_named(own, settled))
        _tell(region, given.get(region), settled, named[-1], len(assigned))
        written[region] = RegionAnswers(
            settled.model, {row.cluster: _answer(row) for row in named[-1].itertuples()}
        )
    if unsafe:
        raise _stale(file, results, given, unsafe)
    write_label_file(names, written, NAMES_HEADER)
    rows = pd.concat(named) if named else tables.empty(tables.LABELS)
    tables.write(tables.LABELS, rows, labels, tables.reason(proposed))


def _named(rows: pd.DataFrame, settled: Settled) -> pd.DataFrame:
    """A region's proposed rows with the answers in them."""
    named = rows.set_index("cluster", drop=False)
    proposed = named.copy()
    for cluster in settled.answers:
        whose = root(settled.answers, cluster)
        if whose not in settled.answers:  # merged into one that nobody named: its proposal holds
            columns = ["action", "note", "source", "confidence", "why"]
            named.loc[cluster, columns] = proposed.loc[whose, columns]
            continue
        answer = settled.answers[whose]
        named.loc[cluster, "action"] = pd.NA if answer.action is None else answer.action
        named.loc[cluster, "note"] = pd.NA if answer.note is None else answer.note
        named.loc[cluster, "why"] = "not sure" if answer.action is None else pd.NA
        named.loc[cluster, "source"] = "moved" if cluster in settled.moved else "human"
        named.loc[cluster, "confidence"] = settled.moved.get(cluster, float("nan"))
    return named.set_index(rows.index)


def _tell(
    region: str, given: RegionAnswers | None, settled: Settled, rows: pd.DataFrame, n_frames: int
) -> None:
    by_person = int((rows["source"] != "proposed").sum())
    log.info("%s: %d of %d clusters named by a person", region, by_person, len(rows))
    if settled.kept is not None:
        log.info(
            "%s: names moved from fit %s: %.0f %% of %s frames keep theirs",
            region,
            given.model,
            100 * settled.kept,
            f"{round(settled.known * n_frames):,}",
        )


def _warn_of_others(region: str, proposed: pd.DataFrame, settled: Settled) -> None:
    """A part of a cluster has its name even where it shows something else."""
    for row in proposed.itertuples():
        moved = settled.answers.get(row.cluster) if row.cluster in settled.moved else None
        if moved and moved.action and pd.notna(row.action) and moved.action != row.action:
            log.warning(
                "%s %d is %s by the names moved to it, %s by its frames: look at it",
                region,
                row.cluster,
                moved.action,
                row.action,
            )


def _answer(row) -> Answer:
    if pd.isna(row.action):
        return Answer()
    return Answer(row.action, None if pd.isna(row.note) else row.note)


def _stale(
    file: str, results: Path, given: Mapping[str, RegionAnswers], unsafe: Mapping[str, Settled]
) -> BadLabels:
    """The complaint about names that cannot be moved to the present clusters."""
    command = shlex.join(["mimeline", "label", "--results", str(results), "--file", str(file)])
    copies = [kept_copy(file, region, own.model) for region, own in unsafe.items()]
    models = ", ".join(f"{given[region].model} ({region})" for region in unsafe)
    alike: dict[tuple[str, str], list[int]] = {}
    for region, settled in unsafe.items():
        for cluster, why in settled.unsafe.items():
            alike.setdefault((region, why), []).append(cluster)
    reasons = [f"{r} {', '.join(map(str, n))}: {why}" for (r, why), n in alike.items()]
    if len(reasons) > MOST_REASONS:
        reasons[MOST_REASONS:] = [f"and {len(reasons) - MOST_REASONS} more, which the page tells"]
    return BadLabels(
        file,
        place=f"region {', '.join(unsafe)}",
        found=f"clusters that no name of model {models} can be moved to: {'; '.join(reasons)}",
        expected="clusters whose frames bore one name before",
        remedy=f"Name these clusters: {command}{''.join(map(_or_take, copies))}",
    )


def _or_take(copy: Path) -> str:
    return f", or take the names that this very fit had: {copy}" if copy.exists() else ""


def _check_actions(file: str, region: str, given: RegionAnswers) -> None:
    allowed = (*series_actions(region), NEUTRAL)
    for cluster, answer in given.clusters.items():
        if answer.action not in (*allowed, None):
            raise BadLabels(
                file,
                place=f"region {region}, cluster {cluster}",
                found=repr(answer.action),
                expected=f"one of {', '.join(allowed)}",
                remedy="Name the cluster by one of these, or {action: ..., note: ...}.",
            )


def _check_clusters(
    file: str, region: str, given: RegionAnswers, clusters: Collection[int]
) -> None:
    named = [(n, n) for n in (*given.clusters, *given.open)]
    named += [(n, a.same_as) for n, a in given.clusters.items() if a.same_as is not None]
    for cluster, meant in named:
        if meant not in clusters:
            raise BadLabels(
                file,
                place=f"region {region}, cluster {cluster}",
                found="no such cluster" if meant == cluster else f"no such cluster as {meant}",
                expected=f"one of {', '.join(map(str, sorted(clusters)))}",
                remedy="Remove the entry.",
            )
