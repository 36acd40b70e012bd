"""Whether proposals are sure as often as they are right, over toy worlds, their settings damaged.

python benchmarks/proposals.py [--seeds 1 2 3 7] [--clips 60] [--fits FOLDER]

Each region is fitted with the default and with too few clusters, on the default and on doubled and
trebled tracker noise. A name is right where truth gives it to most of the cluster's frames. Since a
fit does not depend on a channel's scale, each is also proposed names for as if the tracker's
coefficients came to more or less than they should, by exp of a normal deviate of REACH_SD, and as
if people rested REST_SD farther apart. The first table tells of proposals by their confidence how
many were right; the second, per seed and region at the default settings, macro-F1 of the proposed
names and of those that truth gives. --fits keeps the fits, to begin with them another time.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from ticc_quality import CLUSTERS, Region, macro_f1, names_of, toy

from mimeline.annotation.proposals import propose, read_rules
from mimeline.ticc import TICC
from mimeline.vocabulary import NEUTRAL, resource, series_actions, series_channels

NOISES, FEWER = (1.0, 2.0, 3.0), (0, 3, 5, 6)
REACH_SD, REST_SD = 0.3, 0.06
EDGES = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
RULES = read_rules(resource("proposals.csv"))


def clusters_of(region: Region, seed: int, noise: float, fewer: int, fits: Path | None):
    """(T,) cluster of each frame."""
    kept = fits and fits / f"{seed}-{len(region.lengths)}-{noise}-{fewer}-{region.name}.npy"
    if kept and kept.exists():
        return np.load(kept)
    ticc = TICC(max(2, CLUSTERS[region.name] - fewer), max_iter=15).fit(region.X, region.lengths)
    if kept:
        np.save(kept, ticc.labels_)
    return ticc.labels_


def proposals(region: Region, ids: np.ndarray, values: np.ndarray) -> pd.DataFrame:
    """The `labels` rows for ids (T,), values (T, n) in the place of the region's."""
    clips = np.repeat([f"clip{i:03d}" for i in range(len(region.lengths))], region.lengths)
    frame = np.concatenate([np.arange(n) for n in region.lengths])
    clusters = {"clip_id": clips, "frame": frame, "cluster": ids, "margin": 1.0}
    channels = series_channels(region.name, "left")
    return propose(region.name, pd.DataFrame(clusters), values, channels, RULES)


def judged(region: Region, ids: np.ndarray, values: np.ndarray) -> pd.DataFrame:
    """The proposals with `right`."""
    found = proposals(region, ids, values)
    true = names_of(ids[region.counted], region.truth[region.counted])[found["cluster"]]
    names = np.array([NEUTRAL, *series_actions(region.name)], dtype=object)
    return found.assign(right=found["action"] == names[true])


def damaged(region: Region, rng: np.random.Generator) -> np.ndarray:
    """(T, n) values of a tracker of another reach and of people who rest farther apart."""
    people, person = np.unique(np.repeat(region.source, region.lengths), return_inverse=True)
    rest = rng.normal(0, REST_SD, (len(people), region.X.shape[1]))
    return region.X * np.exp(rng.normal(0, REACH_SD)) + rest[person]


def print_reliability(found: pd.DataFrame) -> None:
    named = found[found["action"].notna()]
    print(f"{'confidence':14}{'names':>7}{'mean':>7}{'right':>7}")
    for bounds, rows in named.groupby(pd.cut(named["confidence"], EDGES), observed=True):
        mean, right = rows["confidence"].mean(), rows["right"].mean()
        print(f"{bounds!s:14}{len(rows):7}{mean:7.2f}{right:7.2f}")
    mean, right = named["confidence"].mean(), named["right"].mean()
    print(f"{'all':14}{len(named):7}{mean:7.2f}{right:7.2f}")
    print(f"{'no name':14}{len(found) - len(named):7}")


def f1_of(region: Region, ids: np.ndarray) -> tuple[float, float]:
    """Macro-F1 of the proposed names, none as Neutral, and of the names that truth gives."""
    found = proposals(region, ids, region.X)
    codes = {a: i for i, a in enumerate([NEUTRAL, *series_actions(region.name)])}
    names = np.zeros(ids.max() + 1, dtype=int)
    names[found["cluster"]] = found["action"].map(codes).fillna(0)
    true = names_of(ids[region.counted], region.truth[region.counted])
    return macro_f1(region, names[ids]), macro_f1(region, true[ids])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 7])
    parser.add_argument("--clips", type=int, default=60)
    parser.add_argument("--fits", type=Path, help="folder to keep fits in")
    options = parser.parse_args()
    if options.fits:
        options.fits.mkdir(parents=True, exist_ok=True)
    as_is, other, scores = [], [], []
    rng = np.random.default_rng(0)
    for seed in options.seeds:
        for noise in NOISES:
            for region in toy(seed, options.clips, noise):
                for fewer in FEWER:
                    ids = clusters_of(region, seed, noise, fewer, options.fits)
                    as_is.append(judged(region, ids, region.X))
                    other.append(judged(region, ids, damaged(region, rng)))
                    if noise == 1 and not fewer:
                        scores.append((seed, region.name, *f1_of(region, ids)))
    for title, found in (("trackers as they are", as_is), ("of another reach and rest", other)):
        print(title)
        print_reliability(pd.concat(found))
        print()
    print(f"{'seed':6}{'region':8}{'proposed':>9}{'truth':>7}")
    for seed, region, own, truth in scores:
        print(f"{seed:<6}{region:8}{own:9.3f}{truth:7.3f}")


if __name__ == "__main__":
    main()
