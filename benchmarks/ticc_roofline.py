"""How far an iteration of TICC stays from what this machine allows, and where its time goes.

python benchmarks/ticc_roofline.py [--quick]

The floor is what the machine's own rates, measured in the same run, set for the arithmetic and the
bytes of an iteration. One thread.
"""

import argparse
import math
import os
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from numba import njit
from ticc_series import K, Series, Task, make
from ticc_speed import MANY, THREADS, alone, an_iteration, ours

from mimeline.ticc.frames import ArrayFrames
from mimeline.ticc.likelihood import Costs, Gaussians
from mimeline.ticc.statistics import cluster_statistics
from mimeline.ticc.toeplitz_lasso import toeplitz_lasso
from mimeline.ticc.viterbi import Trellis
from mimeline.ticc.windows import ALIGNMENTS, Products, Windows, describe


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
        costs = Costs(Gaussians(means, lasso.precisions), windows)
        kept = {block: costs.of(*block) for block in blocks}
        viterbi = partial(Trellis, lambda *b: kept[b], blocks, windows.opens, K, task.beta)  # noqa: B023
        labels = viterbi().labels
    values = [windows.values(*block) for block in blocks]
    reading = shortest(windows.values, blocks)
    all_sums = shortest(describe, [(v, w, every) for v in values])
    statistics = shortest(cluster_statistics, [(windows, labels, K)])
    held = costs.products
    some_sums = shortest(describe, [(v, w, held) for v in values])
    likelihoods = shortest(costs.of, blocks)
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="shorter series")
    options = parser.parse_args()
    os.environ.update(dict.fromkeys(THREADS, "1"))  # the measuring processes start with these
    frames = 100_000 if options.quick else 600_000
    alone(roofline, Task("face", 3, 5, frames, 0.11, 5.0))
    alone(roofline, Task("states", 3, 5, frames, 1e-3, 5.0))
    alone(roofline, Task("states", 9, 10, frames // 6, 1e-3, 5.0))


if __name__ == "__main__":
    main()
