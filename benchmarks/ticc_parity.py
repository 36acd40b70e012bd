"""How near the estimator comes to the original TICC code, from one start in as many iterations.

python benchmarks/ticc_parity.py [--iterations 5] [--seeds 7]

The estimator runs with the paper's windows and costs on raw channels, with half the code's beta.
Of synthetic motions and of the toy world's regions as one literal series, with null sequences of
100 frames of -1 between clips. Label i of the original is that of the window from frame i on, so
of our frame i + w - 1; frames before the first full window are left out. refilled counts the
clusters that ran empty and that the original gave frames at random: from there on the two differ.
mended is the index against the original without its zeros at the end, its |P_i| - 1 and its early
stop of ADMM, which move labels where clusters outnumber the motions and overlap.
"""

import argparse
from collections.abc import Iterator

import numpy as np
from sklearn.metrics import adjusted_rand_score

from mimeline.ticc import TICC
from mimeline.ticc.reference import forward_windows, mixture_start, reference_iterations
from mimeline.toy import World, simulate
from mimeline.vocabulary import SERIES_REGIONS, series_channels

WINDOW, SPARSITY = 5, 0.11
NULL_LENGTH, NULL_VALUE = 100, -1.0
PEOPLE, CLIPS = 40, 60


def motions(n_frames: int, n_motions: int, seed: int) -> np.ndarray:
    """Correlated noise (n_frames, 3) around a level, both of a motion that lasts 20-60 frames."""
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(n_motions, 3, 3))
    levels = rng.normal(size=(n_motions, 3))
    X, state, motion = np.empty((n_frames, 3)), np.zeros(3), 0
    left = 0
    for t in range(n_frames):
        if left == 0:
            motion = (motion + rng.integers(1, n_motions)) % n_motions
            left = rng.integers(20, 60)
        state = 0.6 * state + mixing[motion] @ rng.normal(size=3)
        X[t] = levels[motion] + state
        left -= 1
    return X


def literal_series(world: World, region: str) -> np.ndarray:
    """A region's channels (T, n) of all clips, a null sequence between each two."""
    channels = list(series_channels(region, "left"))
    null = np.full((NULL_LENGTH, len(channels)), NULL_VALUE)
    parts = []
    for _, clip in world.motion.groupby("clip_id", sort=True)[channels]:
        parts += [null, clip.to_numpy(np.float64)]
    return np.concatenate(parts[1:])


def estimator_labels(X, n_clusters, beta, start, iterations) -> np.ndarray:
    """The estimator's labels (T - w + 1,) of the frames whose window is full."""
    model = TICC(
        n_clusters=n_clusters,
        window=WINDOW,
        beta=beta / 2,
        sparsity=SPARSITY,
        alignment="trailing",
        standardise=False,
        cost="likelihood",
        boundary="mask",
        max_iter=iterations,
    )
    model.fit(X, start=np.pad(start, (WINDOW - 1, 0), mode="edge"))
    return model.labels_[WINDOW - 1 :]


def compare(X, n_clusters: int, beta: float, iterations: int) -> tuple[int, int, list[float]]:
    """Iterations, refills; adjusted Rand index, share of equal labels, index of the mended."""
    start = mixture_start(forward_windows(X, WINDOW), n_clusters, 0)  # (T - w + 1,)
    given = (X, n_clusters, WINDOW, beta, SPARSITY, iterations, start)
    rounds = list(reference_iterations(*given))
    original, mended = rounds[-1].labels, list(reference_iterations(*given, mended=True))
    ours = estimator_labels(X, n_clusters, beta, start, len(rounds))
    agreement = [adjusted_rand_score(original, ours), float((original == ours).mean())]
    ours = estimator_labels(X, n_clusters, beta, start, len(mended))
    agreement.append(adjusted_rand_score(mended[-1].labels, ours))
    return len(rounds), sum(len(each.refilled) for each in rounds), agreement


def cases(seed: int) -> Iterator[tuple[str, np.ndarray, int, float]]:
    """Name, series (T, n), number of clusters and the code's beta."""
    for beta in (5, 50, 400):
        yield "9 motions", motions(10_000, 9, seed), 9, beta
    yield "6 motions", motions(10_000, 6, seed), 9, 5
    world = simulate(PEOPLE, CLIPS, seed)
    for region in SERIES_REGIONS:
        for n_clusters, beta in ((5, 5), (9, 5), (9, 50)):
            yield f"toy {region}", literal_series(world, region), n_clusters, beta


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=5)
    parser.add_argument("--seeds", type=int, nargs="+", default=[7])
    options = parser.parse_args()
    print("data        seed      T  K  beta  iterations  refilled  ADJUSTED RAND   equal  mended")
    for seed in options.seeds:
        for name, X, n_clusters, beta in cases(seed):
            rounds, refills, agreement = compare(X, n_clusters, beta, options.iterations)
            row = f"{name:<11} {seed:>4} {len(X):>6} {n_clusters:>2} {beta:>5} {rounds:>11}"
            rand, equal, mended = agreement
            print(f"{row} {refills:>9} {rand:>14.4f} {equal:>7.4f} {mended:>7.4f}", flush=True)


if __name__ == "__main__":
    main()
