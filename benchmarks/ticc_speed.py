"""How fast TICC is beside fast_ticc, how it grows, how far it stays from the machine's limits.

python benchmarks/ticc_speed.py [iterations] [fit] [growth] [roofline] [--quick] [--long]

All four tables without a name. --quick: shorter series; --long: n = 9 on 600,000 frames as well.
The peer is fast_ticc 1.1.0 (pip install fast_ticc==1.1.0), which only this file needs. One thread
each; CPU seconds count the child process that runs the peer's ADMM.

iterations: both from the same labels over the same windows, beta in nats for both. A run of many
iterations less a run of one, over the difference of their numbers: stacking, start-up and packaging
cancel. agree: share of the peer's labels that are ours after the first iteration.
fit: as a user calls it, search of a start to labels, on channels of unit variance for both.
growth: iterations of ours on longer and longer series, in memory and out of Parquet shards.
roofline: the floor that this machine's own rates set for an iteration beside what it takes.

face: channels of the toy world, raw in [0, 1]. states: segments of 50-350 frames, each of one of K
Gaussian moving averages, of unit variance about a mean. Long series draw such clips again with
fresh noise.
"""

import argparse
import contextlib
import importlib.metadata
import io
import logging
import math
import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from logging.handlers import BufferingHandler
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numba import njit
from sklearn.mixture import GaussianMixture

from mimeline.ticc import TICC
from mimeline.ticc.frames import ArrayFrames
from mimeline.ticc.likelihood import Costs, Gaussians
from mimeline.ticc.parquet import ParquetFrames
from mimeline.ticc.statistics import cluster_statistics
from mimeline.ticc.toeplitz_lasso import toeplitz_lasso
from mimeline.ticc.viterbi import Trellis
from mimeline.ticc.windows import ALIGNMENTS, Products, Windows, describe
from mimeline.toy import simulate

PEER = "1.1.0"
K, SEED = 10, 0
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
PEOPLE, CLIPS = 20, 100  # of the toy world that the face series draw from
SEGMENT = (50, 350)  # frames of a state's segments
SHARD, ROW_GROUP = 1_000_000, 65_536  # frames of a Parquet file and of a part of it
BROW = ("browDownLeft", "browInnerUp", "browOuterUpLeft")
FACE = (*BROW, "browDownRight", "browOuterUpRight")
FACE += ("mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthFrownRight")
CHANNELS = {3: BROW, 9: FACE}
NOISE = {"face": 0.01, "states": 0.1}  # deviation of what is added to a clip drawn again
REPEATS, PATIENCE_S = 7, 6.0  # most runs of one measurement; no further one after this long
SMALL = 3_000  # frames of what is run once before, to compile
MANY = {3: 6, 9: 3}  # iterations of the longer run, by channels


@dataclass(frozen=True)
class Task:
    """A series to be made, and what to ask of it."""

    data: str
    n: int
    window: int
    frames: int
    sparsity: float
    beta: float

    def __str__(self):
        return (
            f"{self.data:6} n={self.n} w={self.window:<2} K={K} T={self.frames:<8} "
            f"sparsity={self.sparsity:<5g} beta={self.beta:g}"
        )


@dataclass
class Series:
    """Clips end to end: X (T, n) or a source of it, lengths (S,), labels (T,) to start from."""

    X: np.ndarray | ParquetFrames
    lengths: np.ndarray
    labels: np.ndarray


@dataclass
class Cost:
    """CPU and wall seconds, and the iterations that they bought."""

    cpu: float
    wall: float
    iterations: int


Run = Callable[[int], tuple[int, np.ndarray]]  # most iterations -> iterations done, labels


def face_clips(n: int) -> list[np.ndarray]:
    """Clips (frames, n) of the toy world's tracked channels."""
    motion = simulate(PEOPLE, CLIPS, SEED).motion
    return [clip.to_numpy(float) for _, clip in motion.groupby("clip_id")[list(CHANNELS[n])]]


def state_clips(n: int, window: int) -> list[np.ndarray]:
    """Clips (frames, n) of one state each: moving averages of white noise over a window."""
    rng = np.random.default_rng(SEED)
    filters = rng.normal(size=(K, window, n, n))
    filters /= np.sqrt((filters**2).sum(axis=(1, 2), keepdims=True))  # unit variance
    means = 0.5 * rng.normal(size=(K, n))
    clips = []
    for state in rng.permutation(np.arange(CLIPS) % K):
        noise = rng.normal(size=(rng.integers(*SEGMENT) + window - 1, n))
        parts = [noise[lag : len(noise) - window + 1 + lag] for lag in range(window)]
        moving = sum(part @ filters[state, lag] for lag, part in enumerate(parts))
        clips.append(means[state] + moving)
    return clips


def make(task: Task) -> Series:
    """The task's series, at least as long as asked; labels of a mixture of single frames."""
    rng = np.random.default_rng(SEED)
    clips = face_clips(task.n) if task.data == "face" else state_clips(task.n, task.window)
    frames = np.concatenate(clips)
    mixture = GaussianMixture(K, reg_covar=1e-3, max_iter=50, random_state=SEED)
    labels = mixture.fit_predict(frames / frames.std(axis=0))
    ends = np.cumsum([len(clip) for clip in clips])
    pieces = [slice(end - len(clip), end) for end, clip in zip(ends, clips, strict=True)]
    drawn, total = [], 0
    while total < task.frames:
        drawn.append(pieces[rng.integers(len(pieces))])
        total += drawn[-1].stop - drawn[-1].start
    X, start = np.empty((total, task.n)), np.empty(total, np.int64)
    at = 0
    for piece in drawn:  # clip by clip, so that the making needs no more memory than the series
        end = at + piece.stop - piece.start
        X[at:end] = frames[piece]
        X[at:end] += NOISE[task.data] * rng.standard_normal((end - at, task.n))
        start[at:end] = labels[piece]
        at = end
    return Series(X, np.array([piece.stop - piece.start for piece in drawn]), start)


def seconds() -> tuple[float, float]:
    """CPU seconds of this process and of its children that have ended, and the clock."""
    usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in usage), time.perf_counter()


def peak_mb() -> float:
    """The most memory that this process, or a child of it that has ended, ever held."""
    whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    unit = 1 if sys.platform == "darwin" else 1024
    return max(resource.getrusage(who).ru_maxrss for who in whose) * unit / 1e6


def least(run: Run, max_iter: int) -> Cost:
    """The least of several runs; of one where that takes long."""
    costs, begun = [], time.perf_counter()
    while len(costs) < REPEATS and (not costs or time.perf_counter() - begun < PATIENCE_S):
        before = seconds()
        iterations, _ = run(max_iter)
        costs.append(np.subtract(seconds(), before))
    return Cost(*np.min(costs, axis=0), iterations)


def an_iteration(run: Run, many: int) -> Cost:
    """Of an iteration after the first; iterations is the last one's number."""
    one, more = least(run, 1), least(run, many)
    further = more.iterations - one.iterations
    if further < 1:
        raise RuntimeError("converged in the first iteration: nothing to measure")
    return Cost((more.cpu - one.cpu) / further, (more.wall - one.wall) / further, more.iterations)


def full_windows(lengths: np.ndarray, window: int) -> np.ndarray:
    """(T,) bool: the frames that end a whole window of their clip."""
    ends = np.repeat(np.cumsum(lengths), lengths)
    return np.arange(len(ends)) - (ends - np.repeat(lengths, lengths)) >= window - 1


def ours(task: Task, series: Series) -> Run:
    """A run of the paper's cost on the paper's windows, which are the peer's as well."""
    full = full_windows(series.lengths, task.window)
    lengths = series.lengths if isinstance(series.X, np.ndarray) else None  # a source knows its own

    def run(max_iter):
        model = TICC(
            n_clusters=K,
            window=task.window,
            beta=task.beta,
            sparsity=task.sparsity,
            boundary="mask",
            alignment="trailing",
            standardise=False,
            cost="likelihood",
            max_iter=max_iter,
        )
        model.fit(series.X, lengths, start=series.labels)
        return model.n_iter_, model.labels_[full]

    return run


@contextlib.contextmanager
def watched():
    """Counts the peer's iterations by what it logs, and drops what it prints."""
    log, kept = logging.getLogger("fast_ticc.main_loop"), BufferingHandler(sys.maxsize)
    log.setLevel(logging.INFO)
    log.propagate = False
    log.addHandler(kept)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield lambda: sum("Beginning iteration" in record.msg for record in kept.buffer)
    finally:
        log.removeHandler(kept)


def theirs(task: Task, series: Series) -> Run:
    """A run of fast_ticc on windows stacked before.

    Its front end takes no labels, so this fills its ModelState and calls main_loop._optimize_model,
    as fit_stacked_data does after its own start.
    """
    from fast_ticc import data_preparation, main_loop
    from fast_ticc.containers import arguments, model_state

    ends = np.cumsum(series.lengths)
    stacked = data_preparation.stack_training_data_multiple_series(
        np.split(series.X, ends[:-1]), task.window
    )  # (T - S (w - 1), wn)
    switch = np.full(len(stacked), task.beta)
    switch[np.cumsum(series.lengths - task.window + 1) - 1] = 0  # free from a clip to the next
    labels = series.labels[full_windows(series.lengths, task.window)].tolist()

    def run(max_iter):
        given = arguments.UserArguments(
            sparsity_weight=float(task.sparsity),
            iteration_limit=max_iter,
            label_switching_cost=switch,
            min_cluster_size=20,
            min_meaningful_covariance=0,
            num_clusters=K,
            num_processors=1,
            window_size=task.window,
            biased_covariance=False,
        )
        model = model_state.ModelState.empty_model(given, stacked)
        model.point_labels = labels
        with watched() as iterations:
            model = main_loop._optimize_model(model, stacked)
        return iterations(), np.array(model.point_labels)

    return run


def compare(task: Task) -> str:
    """A row of the iterations table."""
    small, series = make(replace(task, frames=SMALL)), make(task)
    for side in (ours, theirs):
        side(task, small)(1)  # compiles
    mine, peer = ours(task, series), theirs(task, series)
    agree = (mine(1)[1] == peer(1)[1]).mean()
    mine, peer = an_iteration(mine, MANY[task.n]), an_iteration(peer, MANY[task.n])
    return (
        f"{task} iterations 2-{mine.iterations}, 2-{peer.iterations}  "
        f"CPU s {mine.cpu:8.4f} {peer.cpu:8.3f} {peer.cpu / mine.cpu:6.1f} x  "
        f"wall s {mine.wall:8.4f} {peer.wall:8.3f} {peer.wall / mine.wall:6.1f} x  "
        f"agree {agree:6.2%}"
    )


def iterations_table(options) -> None:
    print("\niterations: seconds per iteration of ours, of fast_ticc, and how many times faster")
    sizes = {3: [10_000, 100_000, 600_000], 9: [10_000, 100_000]}
    if options.quick:
        sizes = {3: [10_000, 100_000], 9: []}
    if options.long:
        sizes[9].append(600_000)
    for n, window in ((3, 5), (9, 10)):
        for data, sparsity in (("states", 1e-3), ("face", 0.11)):
            for frames in sizes[n]:
                print(alone(compare, Task(data, n, window, frames, sparsity, 5.0)), flush=True)


def whole_fit(side: str, task: Task) -> tuple[Cost, float, float]:
    """What a fit costs, and the process's peak MB with the data made and at the end."""
    fit = fit_ours if side == "ours" else fit_theirs
    fit(task, make(replace(task, frames=SMALL)), 1)  # compiles
    series = make(task)
    series.X /= series.X.std(axis=0)
    loaded, before = peak_mb(), seconds()
    iterations = fit(task, series, 30)
    cpu, wall = np.subtract(seconds(), before)
    return Cost(cpu, wall, iterations), loaded, peak_mb()


def fit_ours(task: Task, series: Series, max_iter: int) -> int:
    model = TICC(
        n_clusters=K,
        window=task.window,
        beta=task.beta,
        sparsity=task.sparsity,
        max_iter=max_iter,
    )
    return model.fit(series.X, series.lengths).n_iter_


def fit_theirs(task: Task, series: Series, max_iter: int) -> int:
    import fast_ticc

    np.random.seed(SEED)  # noqa: NPY002 - its mixture draws from numpy's global state
    with watched() as iterations:
        fast_ticc.ticc_joint_labels(
            np.split(series.X, np.cumsum(series.lengths)[:-1]),
            window_size=task.window,
            num_clusters=K,
            sparsity_weight=float(task.sparsity),
            label_switching_cost=task.beta,
            iteration_limit=max_iter,
        )
    return iterations()


def fit_table(options) -> None:
    print("\nfit: start search to labels, at most 30 iterations; peak memory of the process")
    for frames in [20_000] if options.quick else [100_000, 600_000]:
        task = Task("face", 3, 5, frames, 0.11, 20.0)
        costs = {}
        for side in ("ours", "fast_ticc"):
            costs[side], loaded, peak = alone(whole_fit, side, task)
            cost = costs[side]
            print(
                f"{task} {side:9} iterations {cost.iterations:2}  CPU s {cost.cpu:8.2f}  "
                f"wall s {cost.wall:8.2f}  peak MB {peak:6.0f}, before the fit {loaded:6.0f}",
                flush=True,
            )
        mine, peer = costs.values()
        print(f"{task} ratio: CPU {peer.cpu / mine.cpu:.1f} x, wall {peer.wall / mine.wall:.1f} x")


def write_shards(task: Task, folder: Path) -> None:
    """The task's series as Parquet files of whole clips, and start.npy, its labels."""
    series = make(task)
    np.save(folder / "start.npy", series.labels)
    ends = np.cumsum(series.lengths)
    columns = dict(zip(CHANNELS[task.n], series.X.T.astype(np.float32), strict=True))
    columns["clip_id"] = np.repeat(np.arange(len(ends)), series.lengths)
    columns["frame"] = np.arange(ends[-1]) - np.repeat(ends - series.lengths, series.lengths)
    table = pa.table(columns)
    cuts = np.unique(ends[np.searchsorted(ends, np.arange(SHARD, ends[-1] + SHARD, SHARD)) - 1])
    for index, (begin, end) in enumerate(pairwise([0, *cuts])):
        path = folder / f"{index:03}.parquet"
        pq.write_table(table.slice(begin, end - begin), path, row_group_size=ROW_GROUP)


def read_shards(folder: Path) -> Series:
    source = ParquetFrames(sorted(folder.glob("*.parquet")), BROW, "clip_id", "frame")
    return Series(source, source.lengths, np.load(folder / "start.npy"))


def grown(task: Task, source: Callable[..., Series], small, whole) -> tuple[Cost, float, float]:
    """An iteration of ours, and the process's peak MB before the data and at the end."""
    ours(task, source(small))(2)  # compiles
    before = peak_mb()
    return an_iteration(ours(task, source(whole)), MANY[task.n]), before, peak_mb()


def growth_in_memory(task: Task):
    return alone(grown, task, make, replace(task, frames=SMALL), task)


def growth_out_of_core(task: Task):
    with TemporaryDirectory() as folder:
        small, whole = Path(folder, "small"), Path(folder, "whole")
        for part, frames in ((small, SMALL), (whole, task.frames)):
            part.mkdir()
            alone(write_shards, replace(task, frames=frames), part)
        return alone(grown, task, read_shards, small, whole)


def growth_table(options) -> None:
    print("\ngrowth: seconds per iteration of ours; linear: beside the first row's time per frame")
    sizes = [100_000, 1_000_000, 5_000_000, 20_000_000]
    sizes = [100_000, 300_000, 1_000_000] if options.quick else sizes
    for place, measured in (("memory", growth_in_memory), ("Parquet", growth_out_of_core)):
        first = None
        for frames in sizes:
            task = Task("face", 3, 5, frames, 0.11, 5.0)
            cost, before, peak = measured(task)
            per_frame = cost.cpu / frames * 1e9
            first = first or per_frame
            print(
                f"{task} {place:7} iterations 2-{cost.iterations}  CPU s {cost.cpu:8.4f}  "
                f"ns a frame {per_frame:6.1f}, linear {per_frame / first - 1:+6.1%}  "
                f"peak MB {peak:5.0f}, {peak - before:5.0f} above the process without data "
                f"(in memory it is {8e-6 * task.n * frames:.0f})",
                flush=True,
            )


def gemm_gflops(dtype, size: int = 2048) -> float:
    A = np.ones((size, size), dtype)
    return 2 * size**3 / shortest(np.matmul, [(A, A)]) / 1e9


def copy_gb_s(size: int = 2**28) -> float:
    """Bytes read and written per second."""
    A, B = np.ones(size, np.uint8), np.ones(size, np.uint8)
    return 2 * size / shortest(np.copyto, [(B, A)]) / 1e9


def add_ns(count: int = 10_000_000) -> float:
    """How long an addition waits for the one before it."""
    return shortest(_chain, [(count,)]) / count * 1e9


@njit
def _chain(count):
    total = 0.0
    for _ in range(count):
        total += 1e-3
    return total


def shortest(work: Callable, parts=((),)) -> float:
    """CPU seconds of work on all parts, the least of several runs; results are let go."""
    taken = []
    for _ in range(4):  # the first compiles
        begun = time.process_time()
        for part in parts:
            work(*part)
        taken.append(time.process_time() - begun)
    return min(taken)


def roofline(task: Task) -> None:
    """Prints the machine's rates, the floor they set for an iteration, and an iteration."""
    single, double = gemm_gflops(np.float32), gemm_gflops(np.float64)
    copy, add = copy_gb_s(), add_ns()
    print(
        f"one thread: sgemm {single:.0f} GFLOP/s, dgemm {double:.0f} GFLOP/s, "
        f"copy {copy:.1f} GB/s, dependent addition {add:.2f} ns"
    )
    series = make(task)
    T, n, w = len(series.X), task.n, task.window
    lag_sums = n * (n + 1) // 2 + (w - 1) * n * n  # that a window holds, and a cluster weighs
    chain = 3 + math.ceil(math.log2(K))  # operations that wait on each other
    floors = {
        f"weighing {1 + w * n + lag_sums} numbers a frame and cluster at the sgemm rate": (
            2 * (1 + w * n + lag_sums) * K / single
        ),
        "lag sums, multiplied and added up once, at the sgemm rate": 2 * lag_sums / single,
        "frames and costs through memory once, float32": 4 * (n + 2 * K) / copy,
        f"Viterbi, {chain} dependent additions a frame": chain * add,
    }
    for name, ns in floors.items():
        print(f"{task}  {T * ns / 1e6:9.2f} ms  {name}")
    floor = T * sum(floors.values()) / 1e9
    print(f"{task}  {floor * 1e3:9.2f} ms  floor of an iteration: the sum of these")
    run = ours(task, series)
    run(2)  # compiles
    cost = an_iteration(run, MANY[n])
    print(
        f"{task}  {cost.cpu * 1e3:9.2f} ms  an iteration (2-{cost.iterations}), "
        f"{cost.cpu / floor:.1f} x the floor"
    )
    for name, taken in steps(task, series).items():
        print(f"{task}  {taken * 1e3:9.2f} ms    of which {name}", flush=True)


def steps(task: Task, series: Series) -> dict[str, float]:
    """CPU seconds of the parts of the fourth iteration, each alone."""
    n, w = task.n, task.window
    frames = ArrayFrames(series.X, series.lengths)
    windows = Windows(frames, ALIGNMENTS["trailing"](w), np.zeros(n), np.ones(n))
    blocks, every = list(windows.blocks()), Products.every(w, n)
    labels, lasso = series.labels, None
    for _ in range(4):
        before = lasso
        _, means, covariances = cluster_statistics(windows, labels, K)
        covariances += 1e-6 * np.eye(n * w)
        lasso = toeplitz_lasso(covariances, w, task.sparsity, before)
        costs = Costs(Gaussians(means, lasso.precisions), windows.reach)
        kept = {block: costs.of(windows, *block) for block in blocks}
        viterbi = partial(Trellis, lambda *b: kept[b], blocks, windows.opens, K, task.beta)  # noqa: B023
        labels = viterbi().labels
    values = [windows.values(*block) for block in blocks]
    reading = shortest(windows.values, blocks)
    all_sums = shortest(describe, [(v, w, every) for v in values])
    statistics = shortest(cluster_statistics, [(windows, labels, K)])
    held = costs.products
    some_sums = shortest(describe, [(v, w, held) for v in values])
    likelihoods = shortest(costs.of, [(windows, *block) for block in blocks])
    admm = f"ADMM, warm ({lasso.iterations.sum()} steps over {K} clusters)"
    return {
        "reading frames, twice": 2 * reading,
        f"lag sums for the statistics ({len(every.lag)})": all_sums,
        "adding them up per cluster": statistics - reading - all_sums,
        admm: shortest(toeplitz_lasso, [(covariances, w, task.sparsity, before)]),
        f"lag sums for the likelihoods ({len(held.lag)} not zero)": some_sums,
        "weighing them, and windows that a border cuts": likelihoods - reading - some_sums,
        "Viterbi": shortest(viterbi),
    }


def roofline_table(options) -> None:
    print("\nroofline: milliseconds per iteration, floor and measured")
    frames = 100_000 if options.quick else 600_000
    alone(roofline, Task("face", 3, 5, frames, 0.11, 5.0))
    alone(roofline, Task("states", 3, 5, frames, 1e-3, 5.0))
    alone(roofline, Task("states", 9, 10, frames // 6, 1e-3, 5.0))


TABLES = {
    "iterations": iterations_table,
    "fit": fit_table,
    "growth": growth_table,
    "roofline": roofline_table,
}


def alone(work, *given):
    """The result of work in a fresh process of its own, so that memory and threads are its own."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(work, *given).result()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="*", metavar="table", help=f"of {', '.join(TABLES)}")
    parser.add_argument("--quick", action="store_true", help="shorter series")
    parser.add_argument("--long", action="store_true", help="also n=9 on 600,000 frames")
    options = parser.parse_args()
    unknown = set(options.tables) - set(TABLES)
    if unknown:
        parser.error(f"no table {', '.join(sorted(unknown))}; there are {', '.join(TABLES)}")
    tables = options.tables or list(TABLES)
    if {"iterations", "fit"} & set(tables):
        try:
            found = importlib.metadata.version("fast_ticc")
        except importlib.metadata.PackageNotFoundError:
            found = "nothing"
        if found != PEER:
            parser.error(f"fast_ticc {PEER}: found {found}; pip install fast_ticc=={PEER}")
    os.environ.update(dict.fromkeys(THREADS, "1"))  # the measuring processes start with these
    for name in tables:
        TABLES[name](options)


if __name__ == "__main__":
    main()
