"""How fast TICC is beside fast_ticc, and how it grows.

python benchmarks/ticc_speed.py [iterations] [fit] [growth] [--quick] [--long]

All three tables without a name. --quick: shorter series; --long: n = 9 on 600,000 frames as well.
The peer is fast_ticc 1.1.0 (pip install fast_ticc==1.1.0), which only this file needs. One thread
each; CPU seconds count the child process that runs the peer's ADMM.

iterations: both from the same labels over the same windows, beta in nats for both. A run of many
iterations less a run of one, over the difference of their numbers: stacking, start-up and packaging
cancel. agree: share of the peer's labels that are ours after the first iteration.
fit: as a user calls it, search of a start to labels, on channels of unit variance for both.
growth: iterations of ours on longer and longer series, in memory and out of Parquet shards.

face: channels of the toy world, raw in [0, 1]. states: segments of 50-350 frames, each of one of K
Gaussian moving averages, of unit variance about a mean. Long series draw such clips again with
fresh noise.
"""

import argparse
import contextlib
import importlib.metadata
import io
import logging
import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
from logging.handlers import BufferingHandler
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from ticc_series import BROW, CHANNELS, SEED, K, Series, Task, make

from mimeline.ticc import TICC
from mimeline.ticc.parquet import ParquetFrames

PEER = "1.1.0"
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
SHARD, ROW_GROUP = 1_000_000, 65_536  # frames of a Parquet file and of a part of it
REPEATS, PATIENCE_S = 7, 6.0  # most runs of one measurement; no further one after this long
SMALL = 3_000  # frames of what is run once before, to compile
MANY = {3: 6, 9: 3}  # iterations of the longer run, by channels


@dataclass
class Cost:
    """CPU and wall seconds, and the iterations that they bought."""

    cpu: float
    wall: float
    iterations: int


Run = Callable[[int], tuple[int, np.ndarray]]  # most iterations -> iterations done, labels


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


TABLES = {
    "iterations": iterations_table,
    "fit": fit_table,
    "growth": growth_table,
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
