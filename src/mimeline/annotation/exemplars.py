"""What a person sees of every cluster before naming it, and the name that a rule proposes."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.choice import choose
from mimeline.annotation.fits import remember
from mimeline.annotation.fitted import read_fingerprint
from mimeline.annotation.profiles import profiles as profiles_of
from mimeline.annotation.proposals import propose, read_rules
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.series import sequences

log = logging.getLogger(__name__)


def exemplars(
    series: dict[str, Path],
    clusters: dict[str, Path],
    models: dict[str, Path],
    rules: Path,
    proposed: Path,
    exemplars: Path,
    profiles: Path,
    side: str,
    n_random: int,
    n_further: int,
    seed: int,
) -> None:
    """Propose a name for every cluster and choose what a person looks at before naming it.

    series, clusters, models: by region; one that could not be segmented is left out. rules: of the
    proposals. proposed: a `labels` table to write; exemplars, profiles: tables to write.
    """
    known, fits = read_rules(rules), Path(exemplars).with_name("fits")
    named, shown, described = [], [], []
    for number, region in enumerate(series):
        assigned = tables.read(tables.CLUSTERS, clusters[region])
        if assigned.empty:
            continue
        model = RegionModel.load(models[region])
        frames, _ = sequences(tables.read(tables.SERIES[region, side], series[region]))
        values = frames[list(model.channels)].to_numpy("float64")
        assigned = frames[["clip_id", "frame"]].merge(assigned, how="left")  # in series order
        rows = propose(region, assigned, values, model.channels, known)
        named.append(rows)
        rng = np.random.default_rng([seed, number])  # one region's refit keeps the others' choice
        shown.append(choose(assigned, values, n_random, n_further, rng).assign(region=region))
        described.append(profiles_of(region, assigned, values, model, known))
        remember(fits, region, read_fingerprint(models[region]), assigned)
        log.info(
            "%s: names proposed for %d of %d clusters", region, rows["action"].count(), len(rows)
        )

    reason = "" if named else "no region could be segmented"
    for table, parts, path in (
        (tables.LABELS, named, proposed),
        (tables.EXEMPLARS, shown, exemplars),
        (tables.PROFILES, described, profiles),
    ):
        tables.write(table, pd.concat(parts) if parts else tables.empty(table), path, reason)
