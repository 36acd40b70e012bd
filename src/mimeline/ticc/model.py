"""TICC: Toeplitz inverse covariance-based clustering of multivariate sequences.

Source: Hallac, Vare, Boyd, Leskovec, KDD 2017. Every frame gets the cluster whose block-Toeplitz
Gaussian explains the window around it best, and switching clusters has a price.
"""

import hashlib
import json
import logging
import zipfile
from numbers import Integral, Real
from pathlib import Path

import numpy as np
from sklearn.base import BaseEstimator, ClusterMixin
from threadpoolctl import threadpool_limits

from .descent import Fit, Setting, descend, trellis
from .frames import ArrayFrames, Frames, Separated, moments, require_finite, source
from .likelihood import Costs, Gaussians
from .start import excerpt, starts
from .windows import ALIGNMENTS, Windows

log = logging.getLogger(__name__)

FORMAT = 2
OUTCOME = ("objective_", "n_iter_", "converged_")
LEARNED = ("means_", "precisions_", "center_", "scale_", "labels_")
COUNTS = {"n_clusters": 1, "window": 1, "max_iter": 1, "null_length": 1, "seed": 0}  # least ones
NUMBERS = {"beta": 0, "sparsity": 0, "null_value": -np.inf}
MOST_NUMBERS = 1000  # of a window: precisions of more are out of reach, of memory and of data
CHOICES = {
    "standardise": (True, False),
    "boundary": ("mask", "paper"),
    "alignment": tuple(ALIGNMENTS),
    "cost": ("penalised", "likelihood"),
}
RACE_FRAMES, RACE_PIECE = 12_000, 2_000  # frames that starts are compared on, longest piece
RACE_STEPS, FINALISTS, REPEATS = 3, 2, 2  # iterations of each, how many go on, starts per span


class TICC(ClusterMixin, BaseEstimator):
    """Clusters the frames of sequences by the pattern of motion around them.

    n_clusters: K. window: frames per window, w. beta: price of a switch, in nats (the paper's unit;
    a beta of the original code is twice this); every frame counts in w windows, so beta grows with
    w and with the shortest interval that matters: 20 suits w = 5 and half a second at 30 fps.
    sparsity: weight of the precisions' l1 norm, the diagonal's too: that floors a quiet cluster's
    variance, and without it known states are found less well.

    boundary: "mask" keeps sequences apart: no window reaches over a border, and a switch there is
    free. Windows cut by a border are scored by the exact marginals of what they see and take no
    part in the estimates. "paper" joins the sequences to one, with null_length frames of null_value
    between each two; the cluster of the null sequences comes on top of n_clusters and is the last.
    alignment: of a window and its frame, "centred" or "trailing" (the paper), which puts every
    switch (w - 1) / 2 frames off. standardise: channels of unit variance inside fit, so that
    sparsity means the same whatever their unit. cost: of a frame in a cluster, "penalised" with its
    share of the cluster's l1 penalty, so that labels and estimates lower one objective, or its
    "likelihood" alone (the paper). max_iter: most iterations. seed: of the start.

    Learned: means_ (K, wn), a window's frames oldest first, and precisions_ (K, wn, wn),
    block-Toeplitz and positive definite, in the channels' own units; center_ (n,) and scale_ (n,),
    the channels' means and their deviations in fit (1 unless standardised); labels_ (T,) int64, as
    predict gives for the same frames; objective_, the labels' cost in nats with switches, of
    channels in units of scale_; n_iter_; converged_.

    Frames are given as X (T, n), sequences of lengths (S,) frames end to end, or as a source like
    those of `ticc.frames`, whose frames need not fit into memory.
    Raises ValueError with the place for what is not finite, constant or too little.
    """

    def __init__(
        self,
        n_clusters=9,
        window=5,
        beta=20.0,
        sparsity=0.11,
        *,
        boundary="mask",
        alignment="centred",
        standardise=True,
        cost="penalised",
        null_length=100,
        null_value=-1.0,
        max_iter=30,
        seed=0,
    ):
        self.n_clusters = n_clusters
        self.window = window
        self.beta = beta
        self.sparsity = sparsity
        self.boundary = boundary
        self.alignment = alignment
        self.standardise = standardise
        self.cost = cost
        self.null_length = null_length
        self.null_value = null_value
        self.max_iter = max_iter
        self.seed = seed

    def fit(self, X, lengths=None, start=None) -> "TICC":
        """Learn the clusters of X (T, n), sequences of lengths (S,) frames end to end.

        start: labels (T,) to begin from, or a fitted TICC whose clusters label the frames first;
        without it several starts are tried on an excerpt.
        """
        self._check_parameters()
        frames = source(X, lengths)
        require_finite(frames)
        separates = self.boundary == "paper" and len(frames.lengths) > 1
        self._check_amount(frames, separates)
        if start is not None:
            start = self._check_start(start, frames, self.n_clusters + int(separates))
        center, deviation = moments(frames)
        for name in (*LEARNED, *OUTCOME):
            vars(self).pop(name, None)  # what an earlier fit learned
        self.center_ = center
        self.scale_ = deviation if self.standardise else np.ones_like(deviation)
        with threadpool_limits(1):  # on matrices this small threads only wait for each other
            fit = self._learn(frames, separates, start)
            self.n_iter_, self.converged_ = fit.iterations, fit.converged
            units = np.tile(self.scale_, self.window)  # (wn,)
            self.means_ = fit.gaussians.means * units + np.tile(self.center_, self.window)
            self.precisions_ = fit.gaussians.precisions / np.multiply.outer(units, units)
            path, real = self._path(frames)
        self.labels_, self.objective_ = path.labels[real], path.objective
        if lost := np.count_nonzero(self.labels_ == self.n_clusters):
            log.warning("%d frames lie in the cluster of the null sequences", lost)
        return self

    def _learn(self, frames: Frames, separates: bool, start) -> Fit:
        n_clusters = self.n_clusters + int(separates)
        setting = self._setting(n_clusters, self.max_iter)
        windows, real = self._view(frames, separates)
        if start is None:
            labels = trellis(windows, self._search(frames, separates), setting).labels
        elif isinstance(start, TICC):
            labels = trellis(windows, self._clusters_of(start), setting).labels
        else:
            labels = _between_nulls(start, real, self.n_clusters)
        fit = descend(windows, labels, setting)
        if separates:
            null = int(np.bincount(fit.labels[~real]).argmax())
            order = [k for k in range(n_clusters) if k != null] + [null]
            found = fit.gaussians
            fit.gaussians = Gaussians(found.means[order], found.precisions[order])
        return fit

    def _search(self, frames: Frames, separates: bool) -> Gaussians:
        """Clusters from the start whose descent comes lowest, on an excerpt of the frames.

        Several starts are worth their time: runs that end lower lie nearer to known states.
        """
        rng = np.random.default_rng(self.seed)
        begins, pieces = excerpt(frames.lengths, self.window, RACE_FRAMES, RACE_PIECE, rng)
        read = [frames.read(b, b + size) for b, size in zip(begins, pieces, strict=True)]
        part = ArrayFrames(np.concatenate(read), pieces)
        windows, real = self._view(part, separates)
        features = (part.X - self.center_) / self.scale_
        count = self.n_clusters + int(separates)
        short, long = self._setting(count, RACE_STEPS), self._setting(count, self.max_iter)
        runs = [
            descend(windows, _between_nulls(labels, real, self.n_clusters), short)
            for labels in starts(features, pieces, self.n_clusters, self.window, REPEATS, rng)
        ]
        log.debug("starts: %s", [round(run.objective) for run in runs])
        best = sorted(runs, key=lambda run: run.objective)[:FINALISTS]
        finals = [descend(windows, run.labels, long) for run in best]
        return min(finals, key=lambda run: run.objective).gaussians

    def decode(self, X, lengths=None) -> tuple[np.ndarray, np.ndarray]:
        """The cheapest labels (T,) int64 of X (T, n), and their margins (T,) in nats.

        A frame's margin is how much dearer the whole cheapest path becomes when that frame must lie
        in another cluster; infinite where there is one cluster.
        """
        with threadpool_limits(1):
            path, real = self._path(self._check_fitted(X, lengths))
            return path.labels[real], path.margins()[real]

    def predict(self, X, lengths=None) -> np.ndarray:
        """The cheapest labels (T,) int64 of X (T, n)."""
        with threadpool_limits(1):
            path, real = self._path(self._check_fitted(X, lengths))
        return path.labels[real]

    def margins(self, X, lengths=None) -> np.ndarray:
        """The margins (T,) of `decode`."""
        return self.decode(X, lengths)[1]

    def mean_costs(self, X, labels, lengths=None) -> np.ndarray:
        """(K, K) nats per frame: what the frames of each cluster cost on average in every cluster.

        labels (T,): whose rows the frames of X (T, n) count for; a row of none is NaN. Costs are
        those that labels are chosen by, without switches.
        """
        frames = self._check_fitted(X, lengths)
        windows, real = self._view(frames, self._separates(frames))
        gaussians = self._clusters_of(self)
        costs = Costs(gaussians, windows, self.sparsity if self.cost == "penalised" else 0.0)
        own = np.full(windows.n_frames, -1)
        own[real] = labels
        totals = np.zeros((len(gaussians), len(gaussians)))
        with threadpool_limits(1):
            for begin, end in windows.blocks():
                given = own[begin:end] == np.arange(len(gaussians))[:, None]  # (K, B)
                totals += given.astype(np.float64) @ costs.of(begin, end)
        counts = np.bincount(labels, minlength=len(gaussians))[:, None]
        return np.divide(totals, counts, out=np.full_like(totals, np.nan), where=counts > 0)

    def score(self, X, lengths=None) -> float:
        """Mean log-likelihood, nats, of each frame's window in its cluster; higher is better."""
        frames = self._check_fitted(X, lengths)
        windows, real = self._view(frames, self._separates(frames))
        seen = np.full(windows.n_frames, self.window)  # frames that a window holds
        seen[windows.cut] -= windows.lacks.sum(axis=1)[windows.kind]
        with threadpool_limits(1):
            labels = self._path(frames)[0].labels
            total = Costs(self._clusters_of(self), windows).own(labels)[real].sum()
        volume = np.log(self.scale_).sum() * seen[real].sum()  # costs are in units of the scale
        return -float(total + volume) / np.count_nonzero(real)

    def fingerprint(self) -> str:
        """16 hex digits that change with a parameter or with the cluster of a frame.

        Learned numbers differ in their last digits from one processor to another; labels do not.
        """
        self._require_fit()
        facts = {"format": FORMAT, "parameters": self._parameters()}
        digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
        digest.update(np.ascontiguousarray(self.labels_, dtype="<i8").tobytes())
        return digest.hexdigest()[:16]

    def save(self, folder) -> None:
        """Write model.json and model.npz into a folder, made where there is none."""
        self._require_fit()
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(folder / "model.npz", **{name: getattr(self, name) for name in LEARNED})
        (folder / "model.json").write_text(json.dumps(self._facts(), indent=2) + "\n")

    @classmethod
    def load(cls, folder) -> "TICC":
        """The model that `save` wrote. Raises ValueError where the folder holds no such model."""
        folder = Path(folder)
        try:
            facts = json.loads((folder / "model.json").read_text())
            if facts["format"] != FORMAT:
                place = folder / "model.json"
                raise ValueError(f"{place}: found format {facts['format']}, expected {FORMAT}")
            model = cls(**facts["parameters"])
            for name in OUTCOME:
                setattr(model, name, facts["fit"][name])
            with np.load(folder / "model.npz", allow_pickle=False) as arrays:
                for name in LEARNED:
                    setattr(model, name, arrays[name])
        except (OSError, EOFError, KeyError, TypeError, zipfile.BadZipFile) as error:
            raise ValueError(f"{folder}: found no whole model of TICC: {error!r}") from error
        return model

    def _facts(self) -> dict:
        fit = {name: getattr(self, name) for name in OUTCOME}
        return {"format": FORMAT, "parameters": self._parameters(), "fit": fit}

    def _parameters(self) -> dict:
        """The constructor's arguments as JSON takes them."""
        given = self.get_params().items()
        return {name: v.item() if isinstance(v, np.generic) else v for name, v in given}

    def _setting(self, n_clusters: int, max_iter: int = 1) -> Setting:
        penalised = self.cost == "penalised"
        return Setting(n_clusters, float(self.beta), self.sparsity, max_iter, penalised)

    def _view(self, frames: Frames, separates: bool) -> tuple[Windows, np.ndarray]:
        """The windows that the model sees, and which of their frames (T,) are those of frames."""
        real = np.ones(int(frames.lengths.sum()), dtype=bool)
        if separates:
            frames = Separated(frames, self.null_length, self.null_value)
            real = frames.real
        reach = ALIGNMENTS[self.alignment](self.window)
        return Windows(frames, reach, self.center_, self.scale_), real

    def _separates(self, frames: Frames) -> bool:
        """Whether null sequences stand between frames: a fit of one sequence knows none."""
        return len(self.means_) > self.n_clusters and len(frames.lengths) > 1

    def _clusters_of(self, learned: "TICC") -> Gaussians:
        """What another fit learned, in this one's units of the channels."""
        units = np.tile(self.scale_, self.window)  # (wn,)
        means = (learned.means_ - np.tile(self.center_, self.window)) / units
        return Gaussians(means, learned.precisions_ * np.multiply.outer(units, units))

    def _path(self, frames: Frames):
        windows, real = self._view(frames, self._separates(frames))
        gaussians = self._clusters_of(self)
        return trellis(windows, gaussians, self._setting(len(gaussians))), real

    def _require_fit(self):
        if not hasattr(self, "means_"):
            raise ValueError("this TICC is not fitted; call fit or load first")

    def _check_fitted(self, X, lengths) -> Frames:
        self._require_fit()
        frames = source(X, lengths)
        expected = self.means_.shape[1] // self.window
        if frames.n_channels != expected:
            raise ValueError(f"X: found {frames.n_channels} channels, expected {expected}")
        require_finite(frames)
        return frames

    def _check_parameters(self):
        for name, least in COUNTS.items():
            value = getattr(self, name)
            if not isinstance(value, Integral) or value < least:
                raise ValueError(f"{name}: found {value!r}, expected a whole number from {least}")
        for name, least in NUMBERS.items():
            value = getattr(self, name)
            if not isinstance(value, Real) or not np.isfinite(value) or value < least:
                raise ValueError(f"{name}: found {value!r}, expected a number from {least}")
        for name, known in CHOICES.items():
            if getattr(self, name) not in known:
                raise ValueError(f"{name}: found {getattr(self, name)!r}, expected one of {known}")

    def _check_start(self, start, frames: Frames, n_clusters: int):
        if not isinstance(start, TICC):
            return _check_labels(start, frames.lengths, n_clusters)
        start._require_fit()
        found, expected = start.means_.shape, (n_clusters, self.window * frames.n_channels)
        if found != expected:
            raise ValueError(
                f"start: found a fit of {found[0]} clusters of {found[1]} numbers, "
                f"expected {expected[0]} of {expected[1]}"
            )
        return start

    def _check_amount(self, frames: Frames, separates: bool):
        numbers, lengths = self.window * frames.n_channels, frames.lengths
        if numbers > MOST_NUMBERS:
            raise ValueError(
                f"window: found {numbers} numbers in a window ({self.window} frames of "
                f"{frames.n_channels} channels), expected {MOST_NUMBERS} at most"
            )
        if separates:
            lengths = np.array([lengths.sum() + self.null_length * (len(lengths) - 1)])
        windows = int(np.maximum(lengths - self.window + 1, 0).sum())
        if windows < 2 * self.n_clusters:
            raise ValueError(
                f"X: found {windows} full windows of {self.window} frames in {len(lengths)} "
                f"sequences, expected at least {2 * self.n_clusters} for {self.n_clusters} clusters"
            )


def _between_nulls(labels, real, null: int) -> np.ndarray:
    """Labels of real frames (T,) bool set into a series whose other frames are labelled null."""
    series = np.full(len(real), null, dtype=np.int64)
    series[real] = labels
    return series


def _check_labels(start, lengths, n_clusters: int) -> np.ndarray:
    start, n_frames = np.asarray(start), int(lengths.sum())
    if start.shape != (n_frames,) or start.dtype.kind not in "iu":
        raise ValueError(
            f"start: found shape {start.shape} of {start.dtype}, "
            f"expected ({n_frames},) whole numbers"
        )
    if start.min() < 0 or start.max() >= n_clusters:
        raise ValueError(
            f"start: found labels {start.min()} to {start.max()}, expected 0 to {n_clusters - 1}"
        )
    return start
