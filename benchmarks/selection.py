"""How long the selection of a large catalogue takes, and what is asked of its results after.

python benchmarks/selection.py [--clips 70000] [--texts 0] [--seed 0]

The records are made up, with the proportions of CelebV-Text: some five clips of a source, lengths
around ten seconds, boxes in shares of the picture, half of them with a size in pixels, one to five
actions with whole-second times, an emotion, eight attributes, and clips that occur twice. Each step
runs in a process of its own: seconds are those of the whole call without the imports, the
processor's and (by the clock); the peak is the process's largest resident memory, imports included.
`select` is the whole stage: it reads the table, decides, writes the table and the ledger, with a
list of exclusions and two conditions.
"""

import argparse
import multiprocessing
import resource
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.clips.exclusions import write_exclusions
from mimeline.clips.select import select
from mimeline.inspection import funnel, why
from mimeline.ledger import Ledger

LIMIT_S, LIMIT_MB = 5.0, 1024.0  # of select
ACTIONS = ["talk", "smile", "blink", "gaze", "nod", "frown", "laugh", "turn", "shake_head"]
EMOTIONS = ["neutral", "happy", "sad", "angry", "surprise"]
OPTIONS = {
    "min_s": 5.0,
    "max_s": 10.0,
    "min_side_px": 512,
    "excluded_actions": ["turn", "shake_head", "head_wagging"],
    "conditions": ["emotion != 'angry'", "duration_s < 9.5 or 'smile' in actions"],
    "max_overlap": 0.5,
}


def generated(n: int, texts: int, rng: np.random.Generator) -> pd.DataFrame:
    """A `clips` table of n records; one of twenty is its neighbour once more."""
    number = np.sort(rng.integers(0, max(n // 5, 1), n))
    start = np.round(rng.uniform(0, 1800, n), 2)
    again = np.flatnonzero((rng.random(n) < 0.05) & (number == np.roll(number, 1)))
    start[again] = start[again - 1]
    length = np.round(2 + rng.gamma(4, 2.0, n), 2)
    edges = {"bbox_top": rng.uniform(0, 0.3, n), "bbox_left": rng.uniform(0, 0.5, n)}
    wide, high = rng.uniform(0.2, 0.5, n), rng.uniform(0.3, 0.7, n)
    told = rng.random(n) < 0.5
    table = pd.DataFrame(
        {
            "clip_id": [f"v{v:06d}_{k}_0" for k, v in enumerate(number)],
            "source_id": [f"v{v:06d}" for v in number],
            "start_s": start,
            "end_s": start + length,
            **edges,
            "bbox_bottom": edges["bbox_top"] + high,
            "bbox_right": edges["bbox_left"] + wide,
            "width": pd.array((wide * 1920).astype(int), "Int64"),
            "height": pd.array((high * 1600).astype(int), "Int64"),
            "actions": [_timed(ACTIONS, rng.integers(1, 6), s, rng) for s in length],
            "emotions": [_timed(EMOTIONS, 1, s, rng) for s in length],
            "attributes": [[f"attribute {a}" for a in rng.integers(0, 40, 8)] for _ in range(n)],
            "texts": [
                ["She talks, and then she smiles for a long time."] * texts for _ in range(n)
            ],
            "shard": 0,
        }
    ).reindex(columns=tables.CLIPS.schema.names)
    table["emotion"] = [items[0]["name"] for items in table["emotions"]]
    table.loc[~told, ["width", "height"]] = pd.NA
    return table


def _timed(names: list[str], count: int, length: float, rng: np.random.Generator) -> list[dict]:
    edges = np.sort(rng.integers(0, int(length) + 1, (count, 2)).astype(float), axis=1)
    chosen = rng.choice(names, count)
    return [
        {"name": str(name), "start_s": a, "end_s": b, "uncertainty_s": 1.0}
        for name, (a, b) in zip(chosen, edges, strict=True)
    ]


def prepare(results: Path, n: int, texts: int, seed: int) -> None:
    """The catalogue's table and ledger, and a list of exclusions of one clip in fifty."""
    table = generated(n, texts, np.random.default_rng(seed))
    tables.write(tables.CLIPS, table, results / "catalogue" / "00" / "clips.parquet")
    ledger = Ledger("catalogue", table["clip_id"])
    ledger.close(results / "catalogue" / "ledger.parquet", table["clip_id"])
    write_exclusions(results / "exclusions.csv", dict.fromkeys(table["clip_id"][::50], "occlusion"))


def run_select(results: Path) -> None:
    select(
        results / "catalogue" / "00" / "clips.parquet",
        results / "select" / "00" / "clips.parquet",
        results / "select" / "00" / "ledger.parquet",
        **OPTIONS,
        exclusions=str(results / "exclusions.csv"),
        catalogue=results / "catalogue" / "ledger.parquet",
    )


def ask(results: Path, sets: tuple[str, ...] = ()) -> None:
    """`mimeline funnel` with these values, by the run's own configuration."""
    own = results / "own.yaml"
    own.write_text(str({"select": OPTIONS | {"exclusions": str(results / "exclusions.csv")}}))
    funnel.as_text(funnel.funnel(results, [own], sets))


def ask_why(results: Path) -> None:
    ids = tables.read(tables.CLIPS, results / "catalogue" / "00" / "clips.parquet", ["clip_id"])
    why.as_text(why.why(results, [ids["clip_id"].iloc[-1]]))


STEPS = {
    "select": run_select,
    "funnel": ask,
    "funnel --set select.max_s=12": partial(ask, sets=("select.max_s=12",)),
    "funnel --set select.max_s=6,8,12,14": partial(ask, sets=("select.max_s=6,8,12,14",)),
    "why CLIP": ask_why,
}


def _measured(work, sent) -> None:
    clock, processor = time.perf_counter(), time.process_time()
    work()
    seconds = time.process_time() - processor, time.perf_counter() - clock
    sent.send((*seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def alone(work) -> tuple[float, float, float]:
    """Seconds of the processor and by the clock, and peak megabytes of the work, all alone."""
    apart = multiprocessing.get_context("spawn")
    received, sent = apart.Pipe(duplex=False)
    process = apart.Process(target=_measured, args=(work, sent))
    process.start()
    measured = received.recv()
    process.join()
    return measured


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clips", type=int, default=70_000)
    parser.add_argument("--texts", type=int, default=0, help="texts per clip")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        results = Path(folder)
        alone(partial(prepare, results, given.clips, given.texts, given.seed))
        print(f"{given.clips} clips, {given.texts} texts each")
        for name, step in STEPS.items():
            seconds, clock, peak_mb = alone(partial(step, results))
            limits = f"  (limits {LIMIT_S:g} s, {LIMIT_MB:g} MB)" if name == "select" else ""
            print(
                f"{name:<36} {seconds:6.2f} s ({clock:.2f}) {peak_mb:5.0f} MB{limits}", flush=True
            )


if __name__ == "__main__":
    main()
