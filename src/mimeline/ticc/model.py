"""TICC: Toeplitz inverse covariance-based clustering of multivariate sequences.

Source: Hallac, Vare, Boyd, Leskovec, KDD 2017. Every frame gets the cluster whose block-Toeplitz
Gaussian explains the window around it best, and switching clusters has a price.
"""

import hashlib
import json
import logging
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from .descent import descend
from .likelihood import frame_costs
from .start import excerpt, starts
from .viterbi import best_path, path_margins

log = logging.getLogger(__name__)

FORMAT = 1
OUTCOME = ("objective_", "n_iter_", "converged_")
LEARNED = ("means_", "precisions_", "scale_", "labels_")
RACE_FRAMES, RACE_PIECE = 12_000, 2_000  # frames that starts are compared on, longest piece
RACE_STEPS, FINALISTS, REPEATS = 3, 2, 2  # iterations of each, how many go on, starts per span


class TICC:
    """Clusters the frames of sequences by the pattern of motion around them.

    n_clusters: K. window: frames per window, w. beta: price of a switch, in nats (the paper's unit;
    a beta of the original code is twice this); every frame counts in w windows, so beta grows with
    w and with the shortest interval that matters: 20 suits w = 5 and half a second at 30 fps.
    sparsity: weight of the precisions' l1 norm, the diagonal's too. max_iter: most iterations.
    seed: of the start.

    Channels are brought to unit variance inside fit, so that sparsity means the same whatever their
    unit; what is learned is given in the channels' own units. The penalty holds the diagonal as
    well: that floors a quiet cluster's variance, and without it known states are found less well.

    Learned: means_ (K, wn), a window's frames oldest first; precisions_ (K, wn, wn), block-Toeplitz
    and positive definite; scale_ (n,), the channels' deviations in fit; labels_ (T,) int64, as
    predict gives for the same frames; objective_, the labels' cost in nats with penalty and
    switches; n_iter_; converged_.

    Two things differ from the original. A window is centred on its frame: windows to one side put
    every switch (w - 1) / 2 frames off. And a frame's cost in a cluster includes its share of the
    cluster's l1 penalty, so that labels and estimates lower one objective instead of two.

    Sequences are apart: no window reaches over a border and a switch there is free. Windows cut by
    a border are scored by the exact marginals of what they see and take no part in the estimates.
    Raises ValueError with the place for what is not finite, constant or too little.
    """

    def __init__(self, n_clusters=9, window=5, beta=20.0, sparsity=0.11, max_iter=30, seed=0):
        self.n_clusters = n_clusters
        self.window = window
        self.beta = beta
        self.sparsity = sparsity
        self.max_iter = max_iter
        self.seed = seed

    def fit(self, X, lengths=None) -> "TICC":
        """Learn the clusters of X (T, n), sequences of lengths (S,) frames end to end."""
        self._check_parameters()
        X, lengths = _check(X, lengths)
        self.scale_ = scale = self._check_amount(X, lengths)
        scaled = (X - X.mean(axis=0)) / scale
        given = (self.n_clusters, self.window, self.beta, self.sparsity)
        with threadpool_limits(1):  # on matrices this small threads only wait for each other
            labels = self._start(scaled, lengths, given)
            fit = descend(scaled, lengths, labels, *given, self.max_iter)
        self.n_iter_, self.converged_ = fit.iterations, fit.converged
        units = np.tile(scale, self.window)  # (wn,)
        self.means_ = fit.means * units + np.tile(X.mean(axis=0), self.window)
        self.precisions_ = fit.lasso.precisions / np.multiply.outer(units, units)
        self.labels_, self.objective_ = best_path(
            self._costs(X, lengths), lengths, float(self.beta)
        )
        return self

    def _start(self, X, lengths, given) -> np.ndarray:
        """Labels (T,) from the start whose descent comes lowest, on an excerpt of the data.

        Several starts are worth their time: runs that end lower lie nearer to known states.
        """
        rng = np.random.default_rng(self.seed)
        index, pieces = excerpt(lengths, RACE_FRAMES, RACE_PIECE, rng)
        part = X[index]
        runs = [
            descend(part, pieces, labels, *given, RACE_STEPS)
            for labels in starts(part, pieces, self.n_clusters, self.window, REPEATS, rng)
        ]
        best = sorted(runs, key=lambda run: run.objective)[:FINALISTS]
        finals = [descend(part, pieces, run.labels, *given, self.max_iter) for run in best]
        winner = min(finals, key=lambda run: run.objective)
        log.debug("starts: %s", [round(run.objective) for run in runs])
        costs = frame_costs(X, lengths, winner.means, winner.lasso.precisions, self.sparsity)
        return best_path(costs, lengths, float(self.beta))[0]

    def decode(self, X, lengths=None) -> tuple[np.ndarray, np.ndarray]:
        """The cheapest labels (T,) int64 of X (T, n), and their margins (T,) in nats.

        A frame's margin is how much dearer the whole cheapest path becomes when that frame must lie
        in another cluster; infinite where there is one cluster.
        """
        X, lengths = self._check_fitted(X, lengths)
        costs = self._costs(X, lengths)
        labels, _ = best_path(costs, lengths, float(self.beta))
        return labels, path_margins(costs, lengths, float(self.beta), labels)

    def predict(self, X, lengths=None) -> np.ndarray:
        """The cheapest labels (T,) int64 of X (T, n)."""
        return self.decode(X, lengths)[0]

    def margins(self, X, lengths=None) -> np.ndarray:
        """The margins (T,) of `decode`."""
        return self.decode(X, lengths)[1]

    def score(self, X, lengths=None) -> float:
        """Mean log-likelihood, nats, of each frame's window in its cluster; higher is better."""
        X, lengths = self._check_fitted(X, lengths)
        labels, _ = best_path(self._costs(X, lengths), lengths, float(self.beta))
        costs = frame_costs(X, lengths, self.means_, self.precisions_)  # without the penalty
        return -float(costs[np.arange(len(X)), labels].mean())

    def get_params(self) -> dict:
        """The constructor's arguments by name."""
        return {
            "n_clusters": int(self.n_clusters),
            "window": int(self.window),
            "beta": float(self.beta),
            "sparsity": float(self.sparsity),
            "max_iter": int(self.max_iter),
            "seed": int(self.seed),
        }

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

    def _costs(self, X, lengths):
        return frame_costs(X, lengths, self.means_, self.precisions_, self.sparsity, self.scale_)

    def _require_fit(self):
        if not hasattr(self, "means_"):
            raise ValueError("this TICC is not fitted; call fit or load first")

    def _check_fitted(self, X, lengths):
        self._require_fit()
        X, lengths = _check(X, lengths)
        expected = self.means_.shape[1] // self.window
        if X.shape[1] != expected:
            raise ValueError(f"X: found {X.shape[1]} channels, expected {expected}")
        return X, lengths

    def _check_parameters(self):
        for name in ("n_clusters", "window", "max_iter"):
            if int(getattr(self, name)) != getattr(self, name) or getattr(self, name) < 1:
                raise ValueError(f"{name}: found {getattr(self, name)}, expected 1, 2, 3, ...")
        for name in ("beta", "sparsity"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name}: found {getattr(self, name)}, expected 0 or more")

    def _check_amount(self, X, lengths):
        """The channels' standard deviations, where X is enough to learn from."""
        scale = X.std(axis=0)
        constant = np.flatnonzero(scale <= 1e-9 * np.maximum(np.abs(X).max(axis=0), 1e-300))
        if len(constant):
            raise ValueError(
                f"X: found constant channels {constant.tolist()}, expected channels that move"
            )
        windows = int(np.maximum(lengths - self.window + 1, 0).sum())
        if windows < 2 * self.n_clusters:
            raise ValueError(
                f"X: found {windows} full windows of {self.window} frames in {len(lengths)} "
                f"sequences, expected at least {2 * self.n_clusters} for {self.n_clusters} clusters"
            )
        return scale


def _check(X, lengths) -> tuple[np.ndarray, np.ndarray]:
    """X as (T, n) float64 in C order and lengths as (S,) int64, found sound."""
    X = np.ascontiguousarray(X, dtype=np.float64)
    if X.ndim != 2 or not X.size:
        raise ValueError(f"X: found shape {X.shape}, expected (frames, channels), both above 0")
    if not np.isfinite(X).all():
        row, column = np.argwhere(~np.isfinite(X))[0]
        raise ValueError(
            f"X: found {X[row, column]} at frame {row}, channel {column}, expected finite numbers"
        )
    lengths = np.array([len(X)] if lengths is None else lengths)
    if lengths.ndim != 1 or lengths.dtype.kind not in "iu" or (lengths < 1).any():
        raise ValueError(f"lengths: found {lengths.tolist()}, expected whole numbers above 0")
    if lengths.sum() != len(X):
        raise ValueError(f"lengths: found a sum of {lengths.sum()}, expected {len(X)}, as X has")
    return X, lengths.astype(np.int64)
