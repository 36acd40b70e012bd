"""How well annotated intervals meet the true ones, and how far apart their edges lie.

The intervals of a track are its runs of one action over the frames that count (`scores.Judged`); a
frame that does not count neither belongs to an interval nor ends it. A found interval meets a true
one of the same action in the same clip where they share at least `overlap` of the frames that
either has (intersection over union). Each is met once: what is met besides counts as found in
vain, as in the segmental F1@k of Lea et al. 2017 ("Temporal Convolutional Networks for Action
Segmentation and Detection", 5.1).

The error of an edge is its frame as found less its frame in truth, of intervals that meet. It is
not judged beside a frame that does not count, nor where truth has the edge at the clip's own
border: that is where the clip was cut, not where the action began or ended.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from mimeline.annotation.scores import REGION_TRACKS, Judged, of_region

WITHIN = 2  # frames: an edge is met that lies no further off


@dataclass(frozen=True)
class Edges:
    """The judged edges of intervals that meet. clip (n,) their number · error (n,) frames, positive
    where the edge is found late."""

    clip: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class SegmentCounts:
    """A track's intervals. true, found, met (n_clips,): how many each clip has in truth, how many
    were found in it, and how many of these meet."""

    true: np.ndarray
    found: np.ndarray
    met: np.ndarray
    starts: Edges
    ends: Edges


@dataclass(frozen=True)
class Draws:
    """A score on the clips of each row of `resampled`. values (1 + resamples,), NaN where it has
    none · n of what it is a mean, on all clips."""

    values: np.ndarray
    n: int


def segment_counts(tracks: Mapping[str, Judged], overlap: float) -> dict[str, SegmentCounts]:
    """Each track's intervals. overlap: least intersection over union, in (0, 1]."""
    return {track: _counts(own, overlap) for track, own in tracks.items()}


def segment_draws(
    counts: Mapping[str, SegmentCounts], weights: np.ndarray
) -> dict[str, dict[str, Draws]]:
    """Region → score → its draws; the intervals of a region's tracks count together.

    weights: of `scores.resampled`. segment_precision, segment_recall: the share of the found and of
    the true intervals that meet one; segment_f1: their harmonic mean. Of the errors of edges e,
    boundary_ (both), start_ and end_: mean |e|, median |e|, bias (mean e, late is positive) in
    frames, and within_2, the share of |e| <= 2.
    """
    scores = {}
    for region in REGION_TRACKS:
        own = of_region(region, counts)
        if not own:
            continue
        true, found, met = np.sum([(c.true, c.found, c.met) for c in own], axis=0)
        starts, ends = [c.starts for c in own], [c.ends for c in own]
        scores[region] = {
            "segment_f1": Draws(_ratio(weights, 2 * met, true + found), int(true.sum())),
            "segment_precision": Draws(_ratio(weights, met, found), int(found.sum())),
            "segment_recall": Draws(_ratio(weights, met, true), int(true.sum())),
        }
        for name, edges in (("boundary", starts + ends), ("start", starts), ("end", ends)):
            scores[region] |= {f"{name}_{k}": v for k, v in _errors(edges, weights).items()}
    return scores


def _errors(edges: list[Edges], weights: np.ndarray) -> dict[str, Draws]:
    clip = np.concatenate([own.clip for own in edges])
    error = np.concatenate([own.error for own in edges])
    far = np.abs(error)
    clips = weights.shape[1]

    def mean(values: np.ndarray) -> np.ndarray:
        sums = np.bincount(clip, values, minlength=clips)
        return _ratio(weights, sums, np.bincount(clip, minlength=clips))

    shape = (clips, int(far.max(initial=0)) + 1)
    histogram = csr_array((np.ones(len(far)), (clip, far)), shape)  # of |e|, per clip
    draws = {
        "mean": mean(far),
        "median": _medians(weights @ histogram),
        "bias": mean(error),
        f"within_{WITHIN}": mean(far <= WITHIN),
    }
    return {name: Draws(values, len(far)) for name, values in draws.items()}


def _ratio(weights: np.ndarray, part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """(rows,) of per-clip numbers (n_clips,) as weighed; NaN where the whole is nothing."""
    over = weights @ whole
    return np.divide(weights @ part, over, out=np.full(len(over), np.nan), where=over > 0)


def _medians(histograms: np.ndarray) -> np.ndarray:
    """(rows, values from 0) of how often each occurs → (rows,) medians, NaN where none does."""
    below = np.cumsum(histograms, axis=1)
    total = below[:, -1]
    middle = [(below <= place[:, None]).sum(axis=1) for place in ((total - 1) // 2, total // 2)]
    return np.where(total > 0, np.mean(middle, axis=0), np.nan)


@dataclass(frozen=True)
class _Runs:
    """Stretches of one class. first, last (n_runs,) their rows · of (n_rows,) each row's run."""

    first: np.ndarray
    last: np.ndarray
    of: np.ndarray

    @classmethod
    def over(cls, changes: np.ndarray) -> "_Runs":
        first = np.flatnonzero(changes)
        return cls(first, np.append(first[1:], len(changes)) - 1, np.cumsum(changes) - 1)

    @property
    def length(self) -> np.ndarray:
        return self.last - self.first + 1


def _counts(track: Judged, overlap: float) -> SegmentCounts:
    rows = np.flatnonzero(track.counts)
    clip, frame, true, found = (
        values[rows] for values in (track.clip, track.frame, track.true, track.found)
    )
    begins = np.append(True, clip[1:] != clip[:-1])  # a clip's rows
    in_truth = _Runs.over(begins | np.append(True, true[1:] != true[:-1]))
    as_found = _Runs.over(begins | np.append(True, found[1:] != found[:-1]))
    i, j = _meeting(in_truth, as_found, true, found, overlap)

    follows = ~begins & np.append(False, frame[1:] == frame[:-1] + 1)
    opens = np.append(True, track.clip[1:] != track.clip[:-1])  # a clip, counted or not
    closes = np.append(opens[1:], True)
    starts = _Edge(frame, follows, opens[rows])
    ends = _Edge(frame, np.append(follows[1:], False), closes[rows])

    def per_clip(of: np.ndarray) -> np.ndarray:
        return np.bincount(clip[of], minlength=track.n_clips)

    t, f = in_truth.first, as_found.first
    return SegmentCounts(
        true=per_clip(t[true[t] > 0]),
        found=per_clip(f[found[f] > 0]),
        met=per_clip(t[i]),
        starts=starts.errors(clip, t[i], f[j]),
        ends=ends.errors(clip, in_truth.last[i], as_found.last[j]),
    )


def _meeting(
    in_truth: _Runs, as_found: _Runs, true: np.ndarray, found: np.ndarray, overlap: float
) -> tuple[np.ndarray, np.ndarray]:
    """The intervals that meet: their numbers in truth and as found, (n,) each.

    Overlaps are taken from the left, each that is free. As the intervals of a track do not cross,
    no other choice has more; beyond an overlap of .5 there is no other.
    """
    changes = np.zeros(len(true), dtype=bool)
    changes[in_truth.first] = changes[as_found.first] = True
    shared = _Runs.over(changes)
    same = (true[shared.first] == found[shared.first]) & (true[shared.first] > 0)
    i, j = in_truth.of[shared.first[same]], as_found.of[shared.first[same]]
    both = shared.length[same]
    enough = both / (in_truth.length[i] + as_found.length[j] - both) >= overlap
    i, j = i[enough], j[enough]
    taken = np.ones(len(i), dtype=bool)
    last = -1
    for k in np.flatnonzero((i[1:] == i[:-1]) | (j[1:] == j[:-1])) + 1:
        last = k - 1 if taken[k - 1] else last
        taken[k] = i[k] != i[last] and j[k] != j[last]
    return i[taken], j[taken]


@dataclass(frozen=True)
class _Edge:
    """Where edges may be told. frame (n_rows,) · seen (n_rows,): the row across the edge is the
    next frame of the clip · border (n_rows,): the clip has no frame across the edge."""

    frame: np.ndarray
    seen: np.ndarray
    border: np.ndarray

    def errors(self, clip: np.ndarray, true: np.ndarray, found: np.ndarray) -> Edges:
        """true, found (n,): the rows on this side of the edges."""
        told = self.seen[true] & (self.seen[found] | self.border[found])
        true, found = true[told], found[told]
        return Edges(clip[true], self.frame[found] - self.frame[true])
