"""What makes TICC's labels right: each choice against the default, on worlds with known truth.

python benchmarks/ticc_quality.py TABLE ... [--mocap FOLDER] [--toy-seeds 7 1 2] [--fit-seeds 0 1 2]

Tables: see TABLES, or --help. Every row is the default with one thing changed. The columns:

toy, waves: macro-F1 over Neutral and the actions, clusters named by the majority of their frames
(an oracle), mean over brow, eye and mouth and over the seeds. toy is the toy world; waves is a
second world of another kind of motion and noise, made here, so that no choice is judged on one
world alone. mocap: adjusted Rand index, mean over five CMU MoCap takes (subject 86, 4 channels) and
over seeds of the fit; with --mocap alone, the folder with amc_86_*.4d and labels.json of
github.com/Lab-ANT/Time2State. Behind ± is the standard deviation over seeds. error, lag: mean
absolute and mean signed distance of found switches from planted ones in frames, over both worlds.
"""

import argparse
import json
import time
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import adjusted_rand_score, f1_score
from sklearn.mixture import GaussianMixture

from mimeline.ticc import TICC, start
from mimeline.toy import simulate
from mimeline.vocabulary import SERIES_REGIONS, series_actions, series_channels

PEOPLE, CLIPS = 40, 60
CLUSTERS = {"brow": 9, "eye": 8, "mouth": 9}
MOCAP_BETA = 1100.0
WAVES = {"clips": 60, "frames": 240}
NEAR = 15  # frames within which a found switch belongs to a planted one
HELD_OUT = 5  # every fifth source is kept out of the fit


@dataclass(frozen=True)
class Region:
    """X (T, n), truth (T,) with 0 for Neutral, counted (T,) bool, lengths (S,), source (S,)."""

    name: str
    X: np.ndarray
    truth: np.ndarray
    counted: np.ndarray
    lengths: np.ndarray
    source: np.ndarray

    def of(self, sources: np.ndarray) -> "Region":
        """The sequences of some sources."""
        kept = np.isin(self.source, sources)  # (S,)
        frames = np.repeat(kept, self.lengths)  # (T,)
        parts = self.X[frames], self.truth[frames], self.counted[frames]
        return Region(self.name, *parts, self.lengths[kept], self.source[kept])


@cache
def toy(seed: int, clips: int = CLIPS, noise: float = 1.0) -> list[Region]:
    """The regions of the toy world, its tracker noise times `noise`."""
    world = simulate(PEOPLE, clips, seed)
    ids = world.motion["clip_id"].to_numpy(str)
    names, begins = np.unique(ids, return_index=True)
    lengths = np.diff(np.append(begins, len(ids)))
    sources = {clip.clip_id: clip.source for clip in world.clips}
    source = np.array([sources[name] for name in names])
    regions = []
    for region in SERIES_REGIONS:
        channels, actions = list(series_channels(region, "left")), series_actions(region)
        clean = world.clean[channels].to_numpy(float)
        X = np.clip(clean + noise * (world.motion[channels].to_numpy(float) - clean), 0, None)
        truth = world.frames[list(actions)].to_numpy() @ np.arange(1, len(actions) + 1)
        counted = np.ones(len(X), dtype=bool)
        if region == "eye":
            counted = ~world.frames["EyeClose"].to_numpy(bool)
        regions.append(Region(region, X, truth, counted, lengths, source))
    return regions


# Levels of the three channels in each state, and how far and how often (Hz) they swing there.
STATES = {
    "brow": (
        ((0.02, 0.05, 0.04), 0.0, 1),
        ((0.0, 0.5, 0.6), 0.03, 2),
        ((0.55, 0.08, 0.0), 0.05, 4),
    ),
    "eye": (
        ((0.08, 0.05, 0.02), 0.0, 1),
        ((0.2, 0.55, 0.0), 0.05, 3),
        ((0.0, 0.0, 0.5), 0.03, 2),
    ),
    "mouth": (
        ((0.03, 0.08, 0.03), 0.06, 4),
        ((0.3, 0.1, 0.0), 0.06, 4),
        ((0.75, 0.2, 0.0), 0.05, 2),
        ((0.0, 0.25, 0.5), 0.04, 3),
    ),
}


@cache
def waves(seed: int) -> list[Region]:
    """A second world: states that swing, noise that lingers, spikes, and channels stuck at zero."""
    return [_waves(name, np.random.default_rng([seed, i])) for i, name in enumerate(STATES)]


def _waves(name: str, rng: np.random.Generator) -> Region:
    clips, n_frames, states = WAVES["clips"], WAVES["frames"], STATES[name]
    X, truth = np.empty((clips, n_frames, 3)), np.empty((clips, n_frames), dtype=int)
    time_s = np.arange(n_frames) / 30
    for clip in range(clips):
        level, swing = np.empty((n_frames, 3)), np.empty((n_frames, 3))
        gain, at, state = rng.uniform(0.75, 1.25, 3), 0, 0
        while at < n_frames:
            end = at + 8 + int(rng.gamma(2.0, 15.0))
            levels, amplitude, hertz = states[state]
            level[at:end] = np.array(levels) * gain * rng.uniform(0.7, 1.1)
            phase = 2 * np.pi * (hertz * time_s[at:end, None] + rng.random(3))
            swing[at:end] = amplitude * np.sin(phase)
            truth[clip, at:end] = state
            state = 0 if state and rng.random() < 0.6 else rng.choice(_others(state, len(states)))
            at = end
        noise = np.empty((n_frames, 3))
        lingering = rng.normal(size=3)
        for t in range(n_frames):  # first order, half of it from the frame before
            lingering = 0.5 * lingering + np.sqrt(0.75) * rng.normal(size=3)
            noise[t] = lingering
        noise += 3 * (rng.random((n_frames, 3)) < 0.02) * rng.standard_t(3, (n_frames, 3))
        moved = gaussian_filter1d(level, 3.0, axis=0) + gaussian_filter1d(swing, 1.0, axis=0)
        X[clip] = np.clip(moved + (0.08 + 0.12 * level) * noise, 0, 1)
    flat = X.reshape(-1, 3)
    counted = np.ones(len(flat), dtype=bool)
    return Region(
        name, flat, truth.ravel(), counted, np.full(clips, n_frames), np.arange(clips) // 2
    )


def _others(state: int, count: int) -> list[int]:
    return [other for other in range(count) if other != state]


@cache
def mocap(folder: Path) -> list[Region]:
    """Takes of one sequence each; truth counts from 0."""
    takes = []
    for name, ends in json.loads((folder / "labels.json").read_text())["labels"].items():
        X = np.loadtxt(folder / f"{name}.4d")
        truth, begin = np.zeros(len(X), dtype=int), 0
        for end, state in ends.items():
            truth[begin : int(end)] = state
            begin = int(end)
        counted = np.ones(len(X), dtype=bool)
        takes.append(Region(name, X, truth, counted, np.array([len(X)]), np.zeros(1, dtype=int)))
    return takes


def names_of(labels: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """The class that most frames of each cluster have, (K,)."""
    votes = np.zeros((labels.max() + 1, truth.max() + 1))
    np.add.at(votes, (labels, truth), 1)
    return votes.argmax(axis=1)


def macro_f1(region: Region, found: np.ndarray) -> float:
    counted = region.counted
    return float(f1_score(region.truth[counted], found[counted], average="macro", zero_division=0))


def switch_distances(region: Region, found: np.ndarray) -> np.ndarray:
    """Signed frames from planted switches to the nearest found one into the same class."""
    inside = np.ones(len(found), dtype=bool)
    inside[np.cumsum(region.lengths)[:-1]] = False
    planted = np.flatnonzero((np.diff(region.truth, prepend=region.truth[0]) != 0) & inside)
    switched = np.flatnonzero((np.diff(found, prepend=found[0]) != 0) & inside)
    distances = []
    for at in planted:
        same = switched[found[switched] == region.truth[at]] - at
        same = same[np.abs(same) <= NEAR]
        if len(same):
            distances.append(same[np.argmin(np.abs(same))])
    return np.array(distances)


def astride(model: TICC, region: Region) -> int:
    """Clusters most of whose frames lie where a window reaches over a border, or that have none."""
    age = np.concatenate([np.arange(n) for n in region.lengths])
    left = np.repeat(region.lengths, region.lengths) - 1 - age
    reach = (model.window - 1) // 2 if model.alignment == "centred" else 0
    near = (age < model.window - 1 - reach) | (left < reach)
    size = np.bincount(model.labels_, minlength=model.n_clusters)
    return int((2 * np.bincount(model.labels_[near], minlength=len(size)) >= size).sum())


def measure(world: str, seed: int, folder: Path | None = None, **changes) -> list[dict]:
    """Fits of the regions of a world with the default changed; a dictionary of figures each.

    changes: TICC's arguments, and more: more_clusters than the default, beta_times the default,
    noise of the toy world.
    """
    noise = changes.pop("noise", 1.0)
    if world == "mocap":
        return [_fit(take, MOCAP_BETA, len(np.unique(take.truth)), changes | {"seed": seed})
                for take in mocap(folder)]  # fmt: skip
    regions = waves(seed) if world == "waves" else toy(seed, noise=noise)
    return [_fit(region, TICC().beta, CLUSTERS[region.name], changes) for region in regions]


def _fit(region: Region, beta: float, n_clusters: int, changes: dict) -> dict:
    changes = dict(changes)
    n_clusters += changes.pop("more_clusters", 0)
    beta *= changes.pop("beta_times", 1.0)
    begin = time.process_time()
    model = TICC(**{"n_clusters": n_clusters, "beta": beta} | changes)
    model.fit(region.X, region.lengths)
    figures = {"name": region.name, "seconds": time.process_time() - begin}
    if len(region.lengths) == 1:
        score = adjusted_rand_score(region.truth, model.labels_)
        return figures | {"score": float(score)}
    found = names_of(model.labels_, region.truth)[model.labels_]
    distances = switch_distances(region, found)
    return figures | {
        "score": macro_f1(region, found),
        "error": float(np.abs(distances).mean()),
        "lag": float(distances.mean()),
        "astride": astride(model, region),
    }


def differing(name: str, values) -> dict[str, dict]:
    return {f"{name} {value}": {name: value} for value in values}


TABLES = {
    "default": {"default": {}},
    "scale": {
        "standardise True": {},
        "raw": {"standardise": False},
    },
    "sparsity": differing("sparsity", (0.003, 0.01, 0.03, 0.11, 0.3, 1.0)),
    "cost": differing("cost", ("penalised", "likelihood"))
    | {"likelihood, sparsity .3": {"cost": "likelihood", "sparsity": 0.3}},
    "alignment": differing("alignment", ("centred", "trailing")),
    "boundary": differing("boundary", ("mask", "paper"))
    | {
        "paper, raw": {"boundary": "paper", "standardise": False},
        "paper, 4 clusters more": {"boundary": "paper", "more_clusters": 4},
    },
    "window": {
        f"window {window}, beta x {window / 5:g}": {"window": window, "beta_times": window / 5}
        for window in (1, 3, 5, 7, 10)
    },
    "beta": differing("beta_times", (0.1, 0.25, 0.5, 1, 1.5, 3, 6)),
    "clusters": differing("more_clusters", (-2, 0, 2, 4, 8)),
    "noise": differing("noise", (0.5, 1.0, 1.5, 2.0)),
    "paper": {
        "the paper's choices": {
            "boundary": "paper",
            "alignment": "trailing",
            "standardise": False,
            "cost": "likelihood",
        }
    },
}


def print_rows(rows: dict[str, dict], toy_seeds, fit_seeds, folder: Path | None) -> None:
    print(
        f"{'':28}{'toy':>14}{'waves':>14}{'mocap':>14}{'error':>7}{'lag':>7}{'astride':>9}{'s':>6}"
    )
    for name, changes in rows.items():
        cells, found, seconds = [], [], 0.0
        seeds = {"toy": toy_seeds, "waves": range(len(toy_seeds)), "mocap": fit_seeds}
        for world in seeds:
            if (world == "mocap" and not folder) or ("noise" in changes and world != "toy"):
                cells.append("-")
                continue
            runs = [measure(world, seed, folder, **changes) for seed in seeds[world]]
            means = [np.mean([figures["score"] for figures in run]) for run in runs]
            cells.append(f"{np.mean(means):.3f} ± {np.std(means):.3f}")
            seconds += np.mean([np.mean([f["seconds"] for f in run]) for run in runs])
            found += [f for run in runs for f in run if "error" in f]
        error, lag, on = (np.mean([f[key] for f in found]) for key in ("error", "lag", "astride"))
        columns = "".join(f"{cell:>14}" for cell in cells)
        print(f"{name:28}{columns}{error:7.2f}{lag:7.2f}{on:9.1f}{seconds:6.1f}", flush=True)


def print_toy(seeds) -> None:
    """Per region on 120 clips: of a mixture on frames, of TICC, and of TICC on unseen sources."""
    print(f"{'seed':6}{'region':8}{'gmm':>8}{'ticc':>8}{'seen':>8}{'unseen':>8}")
    for seed in seeds:
        for region in toy(seed, clips=120):
            mixture = GaussianMixture(8, random_state=0).fit_predict(region.X[region.counted])
            truth = region.truth[region.counted]
            named = names_of(mixture, truth)[mixture]
            gmm = f1_score(truth, named, average="macro", zero_division=0)
            ticc = _fit(region, TICC().beta, CLUSTERS[region.name], {})["score"]
            seen, unseen = held_out(region)
            print(
                f"{seed:<6}{region.name:8}{gmm:8.3f}{ticc:8.3f}{seen:8.3f}{unseen:8.3f}", flush=True
            )


def held_out(region: Region) -> tuple[float, float]:
    """Macro-F1 on the sources of the fit and on every fifth source, which was not in it."""
    sources = np.unique(region.source)
    unseen = region.of(sources[::HELD_OUT])
    seen = region.of(np.setdiff1d(sources, sources[::HELD_OUT]))
    model = TICC(n_clusters=CLUSTERS[region.name]).fit(seen.X, seen.lengths)
    names = names_of(model.labels_, seen.truth)
    found = names[model.predict(unseen.X, unseen.lengths)]
    return macro_f1(seen, names[model.labels_]), macro_f1(unseen, found)


def print_mocap(seeds, folder: Path | None) -> None:
    """Adjusted Rand index of each take."""
    if not folder:
        raise SystemExit("the table of takes needs --mocap FOLDER")
    for seed in seeds:
        run = measure("mocap", seed, folder)
        cells = "  ".join(f"{figures['name']} {figures['score']:.3f}" for figures in run)
        mean = np.mean([figures["score"] for figures in run])
        print(f"seed {seed}  {cells}  mean {mean:.3f}", flush=True)


def thin_out(every: int) -> None:
    """Fit the start's mixtures on every nth frame: a search takes half the time."""

    def mixture(features, n_clusters, rng):
        fitted = GaussianMixture(
            n_clusters,
            init_params="k-means++",
            reg_covar=start.RIDGE,
            max_iter=start.EM_STEPS,
            random_state=int(rng.integers(2**31)),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            return fitted.fit(features[::every]).predict(features)

    start._mixture = mixture


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="+", choices=[*TABLES, "regions", "takes"])
    parser.add_argument("--mocap", type=Path, help="folder of the MoCap takes")
    parser.add_argument("--toy-seeds", type=int, nargs="+", default=[7, 1])
    parser.add_argument("--fit-seeds", type=int, nargs="+", default=[0, 1])
    parser.add_argument("--every", type=int, help="fit the start's mixtures on every nth frame")
    options = parser.parse_args()
    if options.every:
        thin_out(options.every)
    for name in options.tables:
        print(f"\n{name}")
        if name == "regions":
            print_toy(options.toy_seeds)
        elif name == "takes":
            print_mocap(options.fit_seeds, options.mocap)
        else:
            print_rows(TABLES[name], options.toy_seeds, options.fit_seeds, options.mocap)


if __name__ == "__main__":
    main()
