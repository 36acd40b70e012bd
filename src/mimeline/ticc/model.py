"""TICC: Toeplitz inverse covariance-based clustering of multivariate sequences.

Source: Hallac, Vare, Boyd, Leskovec, KDD 2017. Every frame gets the cluster whose block-Toeplitz
Gaussian explains the window around it best, and switching clusters has a price.
"""

import hashlib
import inspect
import json
import logging
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from .descent import Fit, Setting, descend, trellis
from .frames import ArrayFrames, Frames, Separated, moments
from .likelihood import Costs, Gaussians
from .start import excerpt, starts
from .windows import ALIGNMENTS, Windows

log = logging.getLogger(__name__)

FORMAT = 2
OUTCOME = ("objective_", "n_iter_", "converged_")
LEARNED = ("means_", "precisions_", "center_", "scale_", "labels_")
CHOICES = {
    "boundary": ("mask", "paper"),
    "alignment": tuple(ALIGNMENTS),
    "cost": ("penalised", "likelihood"),
}
RACE_FRAMES, RACE_PIECE = 12_000, 2_000  # frames that starts are compared on, longest piece
RACE_STEPS, FINALISTS, REPEATS = 3, 2, 2  # iterations of each, how many go on, starts per span


class TICC:
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

        start (T,): labels to begin from, as labels_ of another fit; without them several starts
        are tried on an excerpt.
        """
        self._check_parameters()
        frames = _source(X, lengths)
        self._check_amount(frames.lengths)
        if start is not None:
            known = self.n_clusters + int(self._separates(frames))  # labels_ may hold the null's
            start = _check_start(start, frames.lengths, known)
        self.center_, deviation = moments(frames)
        self.scale_ = deviation if self.standardise else np.ones_like(deviation)
        with threadpool_limits(1):  # on matrices this small threads only wait for each other
            fit = self._learn(frames, start)
            self.n_iter_, self.converged_ = fit.iterations, fit.converged
            units = np.tile(self.scale_, self.window)  # (wn,)
            self.means_ = fit.gaussians.means * units + np.tile(self.center_, self.window)
            self.precisions_ = fit.gaussians.precisions / np.multiply.outer(units, units)
            path, real = self._path(frames)
        self.labels_, self.objective_ = path.labels[real], path.objective
        return self

    def _learn(self, frames: Frames, start) -> Fit:
        separates = self._separates(frames)
        n_clusters = self.n_clusters + int(separates)
        windows, real = self._view(frames, separates)
        if start is None:
            found = self._search(frames)
            labels = trellis(windows, found, self._setting(len(found))).labels
        else:
            labels = _between_nulls(start, real, self.n_clusters)
        fit = descend(windows, labels, self._setting(n_clusters, self.max_iter))
        if separates:
            null = int(np.bincount(fit.labels[~real]).argmax())
            order = [k for k in range(self.n_clusters + 1) if k != null] + [null]
            found = fit.gaussians
            fit.gaussians = Gaussians(found.means[order], found.precisions[order])
        return fit

    def _search(self, frames: Frames) -> Gaussians:
        """Clusters from the start whose descent comes lowest, on an excerpt of the frames.

        Several starts are worth their time: runs that end lower lie nearer to known states.
        """
        rng = np.random.default_rng(self.seed)
        begins, pieces = excerpt(frames.lengths, RACE_FRAMES, RACE_PIECE, rng)
        read = [frames.read(b, b + size) for b, size in zip(begins, pieces, strict=True)]
        part = ArrayFrames(np.concatenate(read), pieces)
        separates = self._separates(frames)  # pieces of one sequence are no sequences of their own
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

    def score(self, X, lengths=None) -> float:
        """Mean log-likelihood, nats, of each frame's window in its cluster; higher is better."""
        frames = self._check_fitted(X, lengths)
        windows, real = self._view(frames, self._separates(frames))
        costs, total = Costs(self._gaussians(), windows.reach), 0.0
        seen = np.full(windows.n_frames, self.window)  # frames that a window holds
        seen[windows.cut] -= windows.lacks.sum(axis=1)
        with threadpool_limits(1):
            labels = self._path(frames)[0].labels
            for begin, end in windows.blocks():
                block = costs.of(windows, begin, end)
                own = block[np.arange(end - begin), labels[begin:end]]
                total += own[real[begin:end]].sum()
        volume = np.log(self.scale_).sum() * seen[real].sum()  # costs are in units of the scale
        return -float(total + volume) / np.count_nonzero(real)

    def get_params(self) -> dict:
        """The constructor's arguments by name."""
        return {name: _plain(getattr(self, name)) for name in inspect.signature(TICC).parameters}

    def fingerprint(self) -> str:
        """16 hex digits that change with a parameter or with the cluster of a frame.

        Learned numbers differ in their last digits from one processor to another; labels do not.
        """
        self._require_fit()
        facts = {"format": FORMAT, "parameters": self.get_params()}
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
        facts = json.loads((folder / "model.json").read_text())
        if facts.get("format") != FORMAT:
            raise ValueError(
                f"{folder / 'model.json'}: found format {facts.get('format')}, expected {FORMAT}"
            )
        model = cls(**facts["parameters"])
        for name in OUTCOME:
            setattr(model, name, facts["fit"][name])
        with np.load(folder / "model.npz", allow_pickle=False) as arrays:
            for name in LEARNED:
                setattr(model, name, arrays[name])
        return model

    def _facts(self) -> dict:
        fit = {name: getattr(self, name) for name in OUTCOME}
        return {"format": FORMAT, "parameters": self.get_params(), "fit": fit}

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
        return self.boundary == "paper" and len(frames.lengths) > 1

    def _gaussians(self) -> Gaussians:
        units = np.tile(self.scale_, self.window)  # (wn,)
        means = (self.means_ - np.tile(self.center_, self.window)) / units
        return Gaussians(means, self.precisions_ * np.multiply.outer(units, units))

    def _path(self, frames: Frames):
        windows, real = self._view(frames, self._separates(frames))
        gaussians = self._gaussians()
        return trellis(windows, gaussians, self._setting(len(gaussians))), real

    def _require_fit(self):
        if not hasattr(self, "means_"):
            raise ValueError("this TICC is not fitted; call fit or load first")

    def _check_fitted(self, X, lengths) -> Frames:
        self._require_fit()
        frames = _source(X, lengths)
        expected = self.means_.shape[1] // self.window
        if frames.n_channels != expected:
            raise ValueError(f"X: found {frames.n_channels} channels, expected {expected}")
        return frames

    def _check_parameters(self):
        for name in ("n_clusters", "window", "max_iter", "null_length"):
            if int(getattr(self, name)) != getattr(self, name) or getattr(self, name) < 1:
                raise ValueError(f"{name}: found {getattr(self, name)}, expected 1, 2, 3, ...")
        for name in ("beta", "sparsity"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name}: found {getattr(self, name)}, expected 0 or more")
        for name, known in CHOICES.items():
            if getattr(self, name) not in known:
                raise ValueError(f"{name}: found {getattr(self, name)!r}, expected one of {known}")

    def _check_amount(self, lengths):
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


def _plain(value):
    return value.item() if isinstance(value, np.generic) else value


def _check_start(start, lengths, n_clusters: int) -> np.ndarray:
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


def _source(X, lengths) -> Frames:
    """X as a source of frames, found sound."""
    if hasattr(X, "read"):
        if lengths is not None:
            raise ValueError("lengths: found some beside a source of frames, which has its own")
        return X
    X = np.asarray(X)
    if X.ndim != 2 or not X.size or X.dtype.kind not in "fiub":
        raise ValueError(
            f"X: found shape {X.shape} of {X.dtype}, expected numbers (frames, channels), "
            f"both above 0"
        )
    lengths = np.array([len(X)] if lengths is None else lengths)
    if lengths.ndim != 1 or lengths.dtype.kind not in "iu" or (lengths < 1).any():
        raise ValueError(f"lengths: found {lengths.tolist()}, expected whole numbers above 0")
    if lengths.sum() != len(X):
        raise ValueError(f"lengths: found a sum of {lengths.sum()}, expected {len(X)}, as X has")
    return ArrayFrames(X, lengths.astype(np.int64))
