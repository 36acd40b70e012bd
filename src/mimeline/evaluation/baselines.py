"""Other ways to cluster the frames of a region than TICC.

X (T, d): the sequences end to end · lengths (S,): frames of each · seed: of the random starts. A
labelling is (T,) int64 from 0; not every label need occur.
"""

import logging
import os
import subprocess
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from hmmlearn.hmm import GaussianHMM
from sklearn.exceptions import ConvergenceWarning
from sklearn.mixture import GaussianMixture

from mimeline.errors import BadConfig
from mimeline.evaluation import clap_apart

log = logging.getLogger(__name__)

MIXTURE_STARTS = 3
CHAIN_STARTS, CHAIN_STEPS = 3, 100
RIDGE = 1e-3  # frames' worth of prior: what a state has that lost all its frames
# Added to variances, of channels of variance 1: the likeliest state is else one of the frames in
# which a channel is exactly 0.
FLOOR = 0.02
CHAIN_GAIN = 1.0  # nats of all frames: a step that gains less is the last
# 7,000 frames take CLaP 40 s and 0.8 GB of memory, 13,400 take 1.5 GB: a long corpus has no end.
CLAP_FRAMES, CLAP_SECONDS = 7000, 3600
UNTRIED = -1
CLASPY = "python -m venv claspy && claspy/bin/pip install claspy"


def by_mixture(X: np.ndarray, n: int, seed: int) -> np.ndarray:
    """Labels of n full-covariance Gaussians: every frame alone."""
    mixture = GaussianMixture(n, n_init=MIXTURE_STARTS, random_state=seed)
    return mixture.fit(X).predict(X).astype("int64")


def by_hidden_markov(X: np.ndarray, lengths: np.ndarray, n: int, seed: int) -> np.ndarray:
    """Labels of the most likely path of a hidden Markov model of n full-covariance Gaussians.

    Every sequence begins anew. A start has the Gaussians of a mixture on single frames: from
    Gaussians all alike, the library's own start, states melt into one. The likeliest model is
    taken; one past fitting does not count. Raises ValueError where all are.
    """
    values = _unit_variance(X)
    best, most = None, -np.inf
    rng = np.random.default_rng(seed)
    with _into_our_log("hmmlearn"), warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", ConvergenceWarning)  # fewer different frames than states
        for start in rng.integers(2**31, size=CHAIN_STARTS):
            chain = GaussianHMM(
                n,
                "full",
                n_iter=CHAIN_STEPS,
                tol=CHAIN_GAIN,
                init_params="st",
                random_state=int(start),
                transmat_prior=1 + RIDGE,
                means_weight=RIDGE,
                covars_prior=FLOOR * len(X) / n * np.eye(X.shape[1]),
                covars_weight=X.shape[1] + 1,
            )
            try:
                mixture = GaussianMixture(n, reg_covar=FLOOR, random_state=int(start)).fit(values)
                chain.means_, chain.covars_ = mixture.means_, mixture.covariances_
                chain.fit(values, lengths)
                likelihood = chain.score(values, lengths)
            except (ValueError, np.linalg.LinAlgError) as error:
                log.info("a start with %d states degenerates: %s", n, error)
                continue
            log.info("log likelihood %.0f after %d steps", likelihood, chain.monitor_.iter)
            if likelihood > most:
                best, most = chain, likelihood
        if best is None:
            raise ValueError(f"every start of a hidden Markov model of {n} states degenerates")
        return best.predict(values, lengths).astype("int64")


def by_clap(X: np.ndarray, lengths: np.ndarray, python: str, seed: int) -> np.ndarray:
    """Labels of CLaP (Ermshaus et al. 2025), which finds how many states there are.

    It is given CLAP_FRAMES at most: whole sequences, drawn at random. The frames of the others are
    UNTRIED. python: interpreter of an environment that has claspy; it cannot be ours, since claspy
    needs older versions of numpy and pandas.
    Raises BadConfig where python gives no labels, ValueError where every sequence is too long.
    """
    lengths = np.asarray(lengths)
    tried = drawn(lengths, CLAP_FRAMES, np.random.default_rng(seed))  # (S,)
    inside = np.repeat(tried, lengths)  # (T,)
    if not tried.any():
        raise ValueError(f"no sequence is of {CLAP_FRAMES} frames or fewer")
    labels = np.full(len(X), UNTRIED, dtype="int64")
    log.info("CLaP is given %d of %d sequences", tried.sum(), len(lengths))
    labels[inside] = _clap(_unit_variance(X[inside]), lengths[tried], python, seed)
    return labels


def drawn(lengths: np.ndarray, most: int, rng: np.random.Generator) -> np.ndarray:
    """(S,) bool: sequences drawn at random, of no more than so many frames together."""
    order = rng.permutation(np.flatnonzero(lengths <= most))
    chosen = np.zeros(len(lengths), dtype=bool)
    chosen[order[np.cumsum(lengths[order]) <= most]] = True
    return chosen


def _clap(values: np.ndarray, lengths: np.ndarray, python: str, seed: int) -> np.ndarray:
    with tempfile.TemporaryDirectory() as folder:
        asked, found = Path(folder, "asked.npz"), Path(folder, "found.npz")
        np.savez(asked, values=values, lengths=lengths, seed=seed)
        # -I: its own libraries only, none of this folder's or of PYTHONPATH
        _run([python, "-I", clap_apart.__file__, str(asked), str(found)], python)
        try:
            with np.load(found) as given:
                labels = given["labels"]
        except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
            raise _unfit(python, f"no labels ({error})") from error
    if labels.shape != (len(values),) or labels.dtype.kind not in "iu":
        raise _unfit(python, f"labels of shape {labels.shape} and kind {labels.dtype}")
    return labels


def _run(command: list[str], python: str) -> None:
    own = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            env=own,
            timeout=CLAP_SECONDS,
        )
    except OSError as error:
        raise _unfit(python, error.strerror or str(error)) from error
    except subprocess.TimeoutExpired as error:
        raise _unfit(python, f"no end after {CLAP_SECONDS} s") from error
    told = done.stderr.decode("utf-8", "replace").strip().splitlines()
    if done.returncode:
        raise _unfit(python, told[-1] if told else f"exit status {done.returncode}")


def _unfit(python: str, found: str) -> BadConfig:
    return BadConfig(
        python,
        place="key experiments.claspy",
        found=found,
        expected="a Python interpreter that runs CLaP",
        remedy=f"Install claspy in an environment of its own ({CLASPY}) and name its bin/python; "
        "null leaves CLaP out.",
    )


def _unit_variance(X: np.ndarray) -> np.ndarray:
    """(T, d) X with mean 0 and variance 1; a channel that never moves is 0."""
    deviation = X.std(axis=0)
    return (X - X.mean(axis=0)) / np.where(deviation > 0, deviation, 1)


class _Retold(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        log.info("%s: %s", record.name, record.getMessage())


@contextmanager
def _into_our_log(library: str) -> Iterator[None]:
    """What a library warns of is told as information, by us: its starts may well disagree."""
    theirs, retold = logging.getLogger(library), _Retold()
    propagates, theirs.propagate = theirs.propagate, False
    theirs.addHandler(retold)
    try:
        yield
    finally:
        theirs.removeHandler(retold)
        theirs.propagate = propagates
