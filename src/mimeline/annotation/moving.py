"""Names after a refit: each new cluster gets the name that its frames bore, where that is safe."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mimeline.annotation.label_file import Answer, RegionAnswers, root

LEAST_FRAMES = 50  # of a new cluster that were known before
LEAST_INTERVALS = 3  # of the fit before that these frames lie in: one may be an odd one
LEAST_SHARE = 0.05  # of a new cluster, where the whole fit before is known
SAME_LENGTH = 0.01  # of a clip; more, and its frames are others than they were

NOT_SURE = "?"
LOST = "!"  # frames whose cluster had lost its name in a refit before
MERGED = "="  # frames whose cluster was merged into one that nobody named
UNNAMED = Answer(action="")  # frames that nobody answered for: their cluster had its proposal


@dataclass(frozen=True)
class Moved:
    """answers: of the new clusters; one whose frames were left to its proposal has none. shares:
    how much of each answered one's known frames bore the name. unsafe: new cluster → why.
    kept: share of the known frames that have the same name as before (that of a proposal, where
    they had no other). known: share of all frames that were known."""

    answers: dict[int, Answer]
    shares: dict[int, float]
    unsafe: dict[int, str]
    kept: float
    known: float


def move(
    given: RegionAnswers,
    before: pd.DataFrame | None,
    clusters: pd.DataFrame,
    n_names: int,
    min_agreement: float,
) -> Moved:
    """Move names of one fit to the clusters of another by the frames that both have.

    before: the `segments` of the fit that the names are of; None where they were not kept: then
    the intervals that the person saw stand for it. clusters: the present `clusters` table.
    n_names: how many names there are; fewer clusters than that held several, and where there are
    more now, their parts may be any of these.
    min_agreement: share of a new cluster's known frames that must have borne one name; and, for any
    name to be moved, share of all known frames that keep theirs. A fit that keeps fewer told other
    things apart: its names mean little on the parts of its clusters, however well these agree.
    """
    told = {*given.clusters, *given.shown, *given.open}
    n_before = len(told) if before is None else before["cluster"].nunique()
    coarse = n_before < min(n_names, clusters["cluster"].nunique())
    whole = before is not None
    segments = before if whole else _seen(given)
    frames = _common_frames(segments, clusters, whole)
    meanings = {int(old): meaning(given.clusters, old) for old in frames["before"].unique()}
    borne = {old: _borne(given, old, own) for old, own in meanings.items()}
    frames = frames.assign(action=frames["before"].map(borne))
    notes = frames["before"].map({old: own.note or "" for old, own in meanings.items()})
    sizes = clusters["cluster"].value_counts()

    answers, shares, unsafe, same, judged = {}, {}, {}, 0, 0
    for cluster, size in sizes.sort_index().items():
        own = frames[frames["cluster"] == cluster]
        if why := _too_little(own, size, whole):
            unsafe[int(cluster)] = why
            continue
        judged += len(own)
        votes = own["action"].value_counts()
        if why := _too_mixed(votes, min_agreement):
            unsafe[int(cluster)] = why
            continue
        name = votes.index[0]
        same += int(votes.iloc[0])
        if name == UNNAMED.action:
            continue
        shares[int(cluster)] = float(votes.iloc[0] / len(own))
        counted = notes[own.index[own["action"] == name]].value_counts()
        agreed = counted.index[0] if counted.iloc[0] >= min_agreement * len(own) else ""
        answers[int(cluster)] = Answer() if name == NOT_SURE else Answer(name, agreed or None)
    known = len(frames) / max(len(clusters), 1)
    if judged and (coarse or same < min_agreement * judged):
        why = f"only {same / judged:.0%} of the frames would keep their names, as the fits differ"
        if coarse:
            why = f"{n_before} cluster(s) were known before, too few to tell {n_names} names apart"
        return Moved({}, {}, {int(n): unsafe.get(n, why) for n in sorted(sizes.index)}, 0.0, known)
    return Moved(answers, shares, unsafe, same / max(len(frames), 1), known)


def meaning(clusters: Mapping[int, Answer], number: int) -> Answer:
    """What a person's answers make of a cluster, mergers followed; UNNAMED where nothing."""
    return clusters.get(root(clusters, number), UNNAMED)


def _borne(given: RegionAnswers, number: int, own: Answer) -> str:
    if root(given.clusters, number) in given.open:
        return LOST
    if own is UNNAMED and number in given.clusters:
        return MERGED
    return NOT_SURE if own.action is None else own.action


def _seen(given: RegionAnswers) -> pd.DataFrame:
    rows = [
        (clip, start, end, number)
        for number, intervals in given.shown.items()
        for clip, start, end in intervals
    ]
    columns = ["clip_id", "start_frame", "end_frame", "cluster"]
    return pd.DataFrame(rows, columns=columns).drop_duplicates(columns[:3])


def _common_frames(segments: pd.DataFrame, clusters: pd.DataFrame, whole: bool) -> pd.DataFrame:
    """clip_id, frame, cluster, before (the old cluster) and interval (the old segment's number) of
    the frames that both fits have. Of a clip whose length is another, none has."""
    ends = clusters.groupby("clip_id")["frame"].max() + 1
    told = segments.groupby("clip_id")["end_frame"].max()
    told, now = told.align(ends, join="inner")
    if whole:
        alike = (told - now).abs() <= SAME_LENGTH * now
    else:  # one that ends too late tells of another frame rate, and that of all
        alike = told <= (1 + SAME_LENGTH) * now
        alike &= alike.all()
    segments = segments[segments["clip_id"].isin(alike.index[alike])].reset_index(drop=True)
    lengths = (segments["end_frame"] - segments["start_frame"]).to_numpy("int64")
    row = np.repeat(np.arange(len(segments)), lengths)  # (n_known,)
    first = np.cumsum(lengths) - lengths
    known = pd.DataFrame(
        {
            "clip_id": segments["clip_id"].to_numpy(object)[row],
            "frame": segments["start_frame"].to_numpy("int64")[row]
            + np.arange(lengths.sum())
            - first[row],
            "before": segments["cluster"].to_numpy("int64")[row],
            "interval": row,
        }
    )
    known = known.drop_duplicates(["clip_id", "frame"])
    now = clusters[["clip_id", "frame", "cluster"]].astype(
        {"clip_id": object, "frame": "int64", "cluster": "int64"}
    )
    return known.merge(now, on=["clip_id", "frame"])


def _too_little(own: pd.DataFrame, size: int, whole: bool) -> str:
    """Why a new cluster's known frames tell nothing of it; empty where they do."""
    if not len(own):
        return "none of its frames was known before: another frame rate, other clips, or a lost fit"
    intervals = own["interval"].nunique()
    few = len(own) < min(LEAST_FRAMES, size) or intervals < LEAST_INTERVALS
    if few or (whole and len(own) < LEAST_SHARE * size):
        return f"only {len(own)} of its {size} frames were known before, of {intervals} interval(s)"
    return ""


def _too_mixed(votes: pd.Series, min_agreement: float) -> str:
    if votes.index[0] not in (LOST, MERGED) and votes.iloc[0] >= min_agreement * votes.sum():
        return ""
    words = {
        UNNAMED.action: "no name",
        LOST: "a lost one",
        NOT_SURE: "not sure",
        MERGED: "that of an unnamed cluster",
    }
    shares = [f"{words.get(n, n)} {v / votes.sum():.0%}" for n, v in votes.iloc[:3].items()]
    return f"its frames bore {', '.join(shares)}"
