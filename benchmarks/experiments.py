"""The paper's experiments on worlds with known truth: what each setting gains or loses.

python benchmarks/experiments.py [--toy-seeds 7 11 12] [--people 40] [--clips 120] [--seeds 1]
                                 [--claspy PYTHON] [--only EXPERIMENT ...] [--set KEY=NUMBER ...]

What `snakemake experiments` does on recordings (docs/experiments.md), on toy worlds, everything at
the default configuration, each cluster named by truth. Per setting and region: macro-F1, and in
brackets the least and the greatest of the worlds; behind it, of the same worlds, what it differs by
from the configured setting. A star: in every world it differs to the same side, by more than the
95 % interval over that world's clips. Last, what the paper reports (its own recordings, 4.1).

Options: more starts of each fit; a Python with claspy; some experiments only; keys of segment that
are set otherwise for all regions (--set window=3 beta=5). `--noise FACTOR` scales the tracker's
noise, `--lingering` makes it one that lingers, of the same size.
"""

import argparse
import time
from collections.abc import Mapping

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.annotation.proposals import read_rules
from mimeline.config.sections import Experiments, Segment, Series, Sweep
from mimeline.evaluation.attempts import REFERENCE, Plan
from mimeline.evaluation.experiments import recorded, tried
from mimeline.reporting.paired import Compared, Key
from mimeline.toy import World, simulate
from mimeline.vocabulary import EXPRESSIONS, SERIES_REGIONS, resource

RULES = read_rules(resource("proposals.csv"))
RESAMPLES = 500
LINGERS = 0.9  # correlation of the lingering noise from one frame to the next


def noisy(world: World, factor: float, lingering: bool, seed: int) -> pd.DataFrame:
    """The world's motion, what the tracker adds to it scaled or given a memory."""
    motion, channels = world.motion.copy(), list(EXPRESSIONS)
    clean = world.clean[channels].to_numpy("float64")
    added = motion[channels].to_numpy("float64") - clean
    if lingering:
        fresh = np.random.default_rng(seed).permutation(added, axis=0)
        for at in range(1, len(fresh)):
            fresh[at] = LINGERS * fresh[at - 1] + np.sqrt(1 - LINGERS**2) * fresh[at]
        added = fresh
    motion[channels] = (clean + factor * added).clip(0, 1).astype("float32")
    return motion


def plan(region: str, options: argparse.Namespace) -> Plan:
    series, sweep = Series(), Sweep()
    separators = {"null_length": series.null_length, "null_value": series.null_value}
    configured = getattr(Segment(), region).model_dump() | separators | options.set
    return Plan(
        region,
        series.side,
        configured,
        sweep.n_clusters,
        sweep.beta,
        Experiments().unseen,
        RULES,
        options.claspy,
    )


def measure(seed: int, options: argparse.Namespace) -> dict[str, Compared]:
    """A world's settings by region; what was left out is printed."""
    world = simulate(options.people, options.clips, seed)
    motion = world.motion
    if options.noise != 1 or options.lingering:
        motion = noisy(world, options.noise, options.lingering, seed)
    sources = {clip.clip_id: clip.source for clip in world.clips}
    clips = pd.DataFrame({"clip_id": list(sources), "source_id": list(sources.values())})
    units = tables.empty(tables.COEFFICIENTS["action_units"])
    found = {}
    for region in SERIES_REGIONS:
        recordings = recorded(clips, motion, units, world.frames, region)
        rows, left_out = tried(recordings, plan(region, options), options.seeds, options.only)
        for row in left_out.itertuples():
            print(f"  {row.region}, {row.experiment}, {row.setting}: {row.reason}", flush=True)
        found[region] = Compared(rows, region, RESAMPLES, seed)
    return found


def cell(worlds: list[Compared], key: Key) -> str:
    scores = np.array([own.score(key).value for own in worlds])
    text = f"{scores.mean():.3f} ({scores.min():.3f}-{scores.max():.3f})"
    if key == REFERENCE:
        return f"{text:46}"
    gains = [own.difference(key, REFERENCE) for own in worlds]
    values = np.array([gain.value for gain in gains])
    sure = len({np.sign(value) for value in values}) == 1 and not any(g.tie for g in gains)
    said = f"{values.mean():+.3f} ({values.min():+.3f} {values.max():+.3f}){'*' if sure else ''}"
    return f"{text} {said:25}"


def published(key: Key) -> str:
    rows = pd.read_csv(resource("paper_scores.csv"))
    asked = ("reference", "optimum") if key == REFERENCE else key
    own = rows[(rows["experiment"] == asked[0]) & (rows["setting"] == asked[1])]
    by_region: Mapping[str, float] = own.set_index("region")["value"]
    return " ".join(f"{by_region[r]:.2f}" if r in by_region else "-" for r in SERIES_REGIONS)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--toy-seeds", type=int, nargs="+", default=[7, 11, 12])
    parser.add_argument("--people", type=int, default=40)
    parser.add_argument("--clips", type=int, default=120)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--claspy")
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--set", nargs="+", default=[])
    parser.add_argument("--noise", type=float, default=1.0)
    parser.add_argument("--lingering", action="store_true")
    options = parser.parse_args()
    pairs = (each.split("=") for each in options.set)
    options.set = {key: float(v) if "." in v else int(v) for key, v in pairs}
    began, worlds = time.monotonic(), []
    for seed in options.toy_seeds:
        worlds.append(measure(seed, options))
        print(f"  world {seed}: {time.monotonic() - began:.0f} s so far", flush=True)
    keys = dict.fromkeys(k for world in worlds for own in world.values() for k in own.counts)
    order = list(dict.fromkeys(key[0] for key in keys))
    print(f"\n{'':34}" + "".join(f"{region:46}" for region in SERIES_REGIONS) + "paper")
    for key in sorted(keys, key=lambda key: order.index(key[0])):
        cells = ""
        for region in SERIES_REGIONS:
            there = [world[region] for world in worlds if key in world[region].counts]
            cells += cell(there, key) if there else f"{'-':46}"
        print(f"{' '.join(key):34}{cells}{published(key)}")


if __name__ == "__main__":
    main()
