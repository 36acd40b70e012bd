"""CLaP on one series: a program of its own, for an environment that has claspy.

It needs numpy and claspy and nothing of this package. python clap_apart.py ASKED FOUND, both .npz:
asked holds values (T, d), lengths (S,) and seed, found the labels (T,).
"""

import sys

import numpy as np

# Half the window that CLaP works on: what changes is a level, which few frames tell.
CHANGE_WINDOW, STATE_WINDOW = 5, 10
# Segments of at least so many windows: the least that three neighbours allow, 20 frames.
LEAST_WINDOWS, NEIGHBOURS = 4, 3
# The default classifier, ROCKET, takes the level out of each window, and so does ClaSP's distance.
CLASSIFIER, DISTANCE = "rdst", "euclidean_distance"
# ClaSP's test for significance (p < 1e-30) asks for more frames than a clip has.
VALIDATION, LEAST_SCORE = "score_threshold", 0.75


def states(values: np.ndarray, lengths: np.ndarray, seed: int) -> np.ndarray:
    """The labels (T,) of CLaP's states (Ermshaus et al. 2025), from 0.

    values (T, d): sequences end to end, every channel of unit variance · lengths (S,).
    """
    from claspy.state_detection import AgglomerativeCLaPDetection

    changes = change_points(values, lengths, seed)
    if not len(changes):
        return np.zeros(len(values), dtype="int64")
    clap = AgglomerativeCLaPDetection(
        window_size=STATE_WINDOW, classifier=CLASSIFIER, n_jobs=1, random_state=seed
    )
    _, labels = np.unique(clap.fit_predict(values, changes), return_inverse=True)
    return labels


def change_points(values: np.ndarray, lengths: np.ndarray, seed: int) -> np.ndarray:
    """Rows at which a segment begins: those of ClaSP in each sequence, and the sequences' own.

    values, lengths: as for `states`.
    """
    from claspy.segmentation import BinaryClaSPSegmentation

    found, begin = [], 0
    for length in lengths:
        if begin:
            found.append(begin)
        if length >= 2 * LEAST_WINDOWS * CHANGE_WINDOW:
            clasp = BinaryClaSPSegmentation(
                window_size=CHANGE_WINDOW,
                k_neighbours=NEIGHBOURS,
                excl_radius=LEAST_WINDOWS,
                distance=DISTANCE,
                validation=VALIDATION,
                threshold=LEAST_SCORE,
                n_jobs=1,
                random_state=seed,
            )
            inside = clasp.fit_predict(values[begin : begin + length])
            found.extend(begin + int(change) for change in inside)
        begin += int(length)
    return np.array(found, dtype="int64")


def main(asked: str, found: str) -> None:
    with np.load(asked) as given:
        labels = states(given["values"], given["lengths"], int(given["seed"]))
    np.savez(found, labels=labels)


if __name__ == "__main__":
    main(*sys.argv[1:])
