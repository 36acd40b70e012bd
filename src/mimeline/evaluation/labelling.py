"""What a person's looks at exemplars are worth: labels spent against macro-F1."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.annotate import unmeasured_actions
from mimeline.annotation.queries import after, chances, classes, wrong
from mimeline.annotation.scores import cluster_votes, true_codes
from mimeline.annotation.timelines import read_truth
from mimeline.vocabulary import SERIES_TRACK

log = logging.getLogger(__name__)

UNSURE = -1  # an answer, and the name of a cluster that has none
TELLING = 30  # frames from which a longer interval tells no more
ORDERS = 100  # random orders of looking
BUDGETS = 40  # points of a curve, about


def evaluate_labelling(
    clips: Sequence[Path],
    ledgers: Sequence[Path],
    clusters: dict[str, Path],
    proposed: Path,
    exemplars: Path,
    truth: Path | None,
    metrics: Path,
    looks: int,
    seed: int,
) -> None:
    """Write the `metrics` of a simulated person who answers from truth.

    looks: most exemplars of a cluster that they see. n: labels spent, the intervals that they
    looked at, over all regions. Variants: "active" looks next where that is worth most, "random" at
    a random cluster (value: median of the orders; low, high: 95 % of them), "in_turn" at every
    cluster's first exemplar, then every second; the same three with "_unproposed" start without a
    name for any cluster. "proposed" is before any look, "person" after all, "oracle" names every
    cluster by all its frames. Macro-F1 is of frames under their clusters' names, before annotate
    leaves out what is short; frames without a name are missed. truth: of `read_truth`, or None:
    then the table is empty.
    """
    if truth is None:
        reason = "no truth is known for these recordings"
        tables.write(tables.METRICS, tables.empty(tables.METRICS), metrics, reason)
        return
    decisions = tables.read_all(tables.LEDGER, ledgers)
    true = read_truth(truth, tables.read_all(tables.CLIPS, clips), decisions)
    labels = tables.read(tables.LABELS, proposed)
    shown = tables.read(tables.EXEMPLARS, exemplars)
    found, unproposed = {}, {}
    for region, path in clusters.items():
        own = labels[labels["region"] == region]
        seen = shown[(shown["region"] == region) & (shown["rank"] < looks)]
        if own.empty or seen.empty:
            continue
        assigned, told = tables.read(tables.CLUSTERS, path), answers(seen, true, region)
        naming = Naming.of(assigned, own, told, true, region)
        if naming.votes.any():
            found[region] = naming
            nothing = own.assign(action=None, confidence=np.nan)
            unproposed[region] = Naming.of(assigned, nothing, told, true, region)
    rows = _rows(found, unproposed, seed) if found else []
    table = pd.DataFrame(rows, columns=tables.METRICS.schema.names)
    reason = "" if rows else "truth and clusters measure no frame in common"
    reason = "there are no exemplars" if shown.empty else reason
    tables.write(tables.METRICS, table, metrics, reason)


def answers(
    exemplars: pd.DataFrame,
    truth: pd.DataFrame,
    region: str,
    clear: float = 0.6,
    mistakes: float = 0.0,
    rng: np.random.Generator | None = None,
) -> pd.DataFrame:
    """What somebody who knows the truth calls each exemplar of a region.

    exemplars, truth: tables `exemplars` and `frames`. clear: the share of an interval's frames that
    one class must have, else they are not sure; frames whose eye is closed do not count for the
    eye. mistakes: chance, drawn by rng, that they name another class instead.
    Returns the exemplars by cluster and rank with `answer`, an index into `classes(region)` or
    UNSURE.
    """
    shown = exemplars.sort_values(["cluster", "rank"], ignore_index=True)
    length = (shown["end_frame"] - shown["start_frame"]).to_numpy()
    number = np.repeat(np.arange(len(shown)), length)
    within = np.arange(len(number)) - np.repeat(np.cumsum(length) - length, length)
    seen = pd.DataFrame(
        {
            "clip_id": shown["clip_id"].to_numpy()[number],
            "frame": shown["start_frame"].to_numpy()[number] + within,
            "number": number,
        }
    ).merge(truth, on=["clip_id", "frame"])
    track = SERIES_TRACK[region]
    codes = true_codes(seen, track, unmeasured_actions(truth, track))
    counts = cluster_votes(seen["number"].to_numpy(), codes, len(shown), track)
    told = counts.argmax(axis=1)  # (n_exemplars,)
    told[counts.max(axis=1) < clear * np.maximum(counts.sum(axis=1), 1)] = UNSURE
    if mistakes:
        other = (told + rng.integers(1, counts.shape[1], len(told))) % counts.shape[1]
        told = np.where((told >= 0) & (rng.random(len(told)) < mistakes), other, told)
    return shown.assign(answer=told)


@dataclass(frozen=True)
class Naming:
    """The clusters of a region, and what becomes of them look by look.

    votes (K, C): frames of each cluster in each true class · looks (K,): that there are · names
    (K, L + 1): after so many looks, UNSURE for none · gains (K, L): what the next look is worth
    after so many · region.
    """

    votes: np.ndarray
    looks: np.ndarray
    names: np.ndarray
    gains: np.ndarray
    region: str

    @classmethod
    def of(
        cls,
        clusters: pd.DataFrame,
        labels: pd.DataFrame,
        answered: pd.DataFrame,
        truth: pd.DataFrame,
        region: str,
    ) -> "Naming":
        """From a region's tables: `clusters`, its proposed `labels`, its `answers`, true `frames`.

        A cluster bears what most frames of the intervals seen were called, of each interval TELLING
        at most, and of two names alike the proposed one; at first, what is proposed.
        """
        track, names = SERIES_TRACK[region], classes(region)
        labels = labels.set_index("cluster", drop=False).sort_index()
        both = clusters.merge(truth, on=["clip_id", "frame"])
        number = labels.index.get_indexer(both["cluster"])
        codes = true_codes(both, track, unmeasured_actions(truth, track))
        votes = cluster_votes(number, codes, len(labels), track)

        proposed = pd.Categorical(labels["action"], names).codes.astype("int64")
        chance, share = chances(labels, region), labels["share"].to_numpy("float64")
        looks = answered["cluster"].value_counts().reindex(labels.index, fill_value=0).to_numpy()
        most = int(looks.max(initial=0))
        named = np.repeat(proposed[:, None], most + 1, axis=1)
        gains = np.zeros((len(labels), most))
        for row, cluster in enumerate(labels.index):
            own = answered[answered["cluster"] == cluster]
            belief, heard = chance[row], np.zeros(len(names))
            if proposed[row] != UNSURE:
                heard[proposed[row]] = 0.5  # frames: decides between two names alike
            for look, interval in enumerate(own.itertuples()):
                gains[row, look] = share[row] * wrong(belief)
                belief = after(belief, interval.answer)
                if interval.answer >= 0:
                    length = interval.end_frame - interval.start_frame
                    heard[interval.answer] += min(length, TELLING)
                    before = named[row, look]
                    if before == UNSURE or heard.max() > heard[before]:
                        named[row, look + 1 :] = heard.argmax()
        return cls(votes, looks, named, gains, region)

    def f1(self, spent: np.ndarray) -> np.ndarray:
        """(...) macro-F1 after spent (..., K) looks at each cluster."""
        return names_f1(self.votes, self.names[np.arange(len(self.votes)), spent])


def names_f1(votes: np.ndarray, names: np.ndarray) -> np.ndarray:
    """(...) macro-F1 of frames under their clusters' names.

    votes (K, C): frames of each cluster in each true class. names (..., K): class of each cluster;
    the frames of one without a name (UNSURE) are missed.
    """
    bears = names[..., None] == np.arange(votes.shape[1])  # (..., K, C)
    hits = (bears * votes).sum(axis=-2)  # (..., C)
    total = (bears * votes.sum(axis=1)[:, None]).sum(axis=-2) + votes.sum(axis=0)
    f1 = np.divide(2 * hits, total, out=np.zeros(total.shape), where=total > 0)
    return f1.sum(axis=-1) / np.maximum((total > 0).sum(axis=-1), 1)


def active_order(looks: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """(n,) clusters in the order in which a look at their next exemplar is worth most.

    looks (K,): exemplars of each cluster. gains (K, L): what the next look is worth after so many.
    """
    spent, order = np.zeros(len(looks), dtype="int64"), []
    waiting = np.column_stack([gains, np.zeros(len(gains))])  # (K, L + 1)
    for _ in range(looks.sum()):
        gain = waiting[np.arange(len(looks)), spent]
        cluster = int(np.argmax(np.where(spent < looks, gain, -np.inf)))
        spent[cluster] += 1
        order.append(cluster)
    return np.array(order, dtype="int64")


def order_in_turn(looks: np.ndarray) -> np.ndarray:
    """(n,) clusters in the order of their first exemplars, their second ones …; looks (K,)."""
    ranks = np.concatenate([np.arange(n) for n in looks])
    return np.repeat(np.arange(len(looks)), looks)[np.argsort(ranks, kind="stable")]


def spending(order: np.ndarray, n_clusters: int, budgets: np.ndarray) -> np.ndarray:
    """(B, K) how many of the first budgets (B,) looks of an order (n,) go to each cluster."""
    spent = np.zeros((len(order) + 1, n_clusters), dtype="int64")
    spent[np.arange(1, len(order) + 1), order] = 1
    return spent.cumsum(axis=0)[budgets]


def orders(
    found: Mapping[str, Naming], n_random: int, rng: np.random.Generator
) -> dict[str, list[np.ndarray]]:
    """Orders of looking at the clusters of all regions, end to end: active, in turn, random."""
    looks = np.concatenate([naming.looks for naming in found.values()])
    gains = np.zeros((len(looks), looks.max()))
    begin = 0
    for naming in found.values():
        gains[begin : begin + len(naming.looks), : naming.gains.shape[1]] = naming.gains
        begin += len(naming.looks)
    every = np.repeat(np.arange(len(looks)), looks)
    return {
        "active": [active_order(looks, gains)],
        "in_turn": [order_in_turn(looks)],
        "random": [rng.permutation(every) for _ in range(n_random)],
    }


def curves(
    found: Mapping[str, Naming], order: Sequence[np.ndarray], budgets: np.ndarray
) -> dict[str, np.ndarray]:
    """Macro-F1 (orders, B) by region, and "f1" their mean, after the first budgets (B,) looks.

    order: of looking at the clusters of all regions, as `orders` gives them.
    """
    sizes = [len(naming.votes) for naming in found.values()]
    spent = np.stack([spending(own, sum(sizes), budgets) for own in order])  # (orders, B, K)
    parts = np.split(spent, np.cumsum(sizes)[:-1], axis=-1)
    each = {
        f"f1_{region}": naming.f1(part)
        for (region, naming), part in zip(found.items(), parts, strict=True)
    }
    return {"f1": np.mean(list(each.values()), axis=0), **each}


def _rows(found: Mapping[str, Naming], unproposed: Mapping[str, Naming], seed: int) -> list[tuple]:
    every = sum(int(naming.looks.sum()) for naming in found.values())
    budgets = np.unique([0, *np.geomspace(1, every, BUDGETS).round()]).astype("int64")
    rows = []

    def add(variant, metric, n, values):
        spread = np.quantile(values, [0.025, 0.975]) if len(values) > 1 else (None, None)
        rows.append(("labelling", variant, "all", metric, np.median(values), *spread, n, seed))

    for start, regions in (("", found), ("_unproposed", unproposed)):
        for way, order in orders(regions, ORDERS, np.random.default_rng(seed)).items():
            for metric, values in curves(regions, order, budgets).items():
                for n, at in zip(budgets.tolist(), values.T, strict=True):
                    add(way + start, metric, n, at)
    in_turn = [order_in_turn(np.concatenate([naming.looks for naming in found.values()]))]
    for metric, values in curves(found, in_turn, np.array([0, every])).items():
        add("proposed", metric, 0, values[:, 0])
        add("person", metric, every, values[:, 1])
    best = {f"f1_{r}": names_f1(one.votes, one.votes.argmax(axis=1)) for r, one in found.items()}
    for metric, value in {"f1": np.mean(list(best.values())), **best}.items():
        add("oracle", metric, every, [value])
        log.info("%s: %.3f by an oracle", metric, value)
    return rows
