"""What names a person gives in a few minutes are worth, on worlds with known truth.

python benchmarks/labelling.py [--toy-seeds 7 11 12] [--people 40] [--clips 120] [--looks 5]

Macro-F1 per region on the toy world, everything at the default configuration:

person       names each cluster after at most `looks` of its intervals, answering from truth.
             Or until two answers agree, or with nothing proposed before.
person, 5 %  the same person, wrong in so many of their answers: mean of several, and the worst. And
             where they look on, at the further exemplars, until one name leads by three.
proposals    nobody looked.
oracle       every cluster by all its frames.
thresholds   each frame alone by the rules of the proposals, intervals shorter than annotate's
             min_frames left out; "median" smooths the channels over nine frames of the clip first,
             "tuned" sets each action's limit so that macro-F1 on this very truth is highest. Both
             together are more than anybody without a truth could do.
unseen       the clips of every fifth source: fitted, looked at and tuned without them.

Frames whose cluster has no name count as without an action. Then the looks that are spent, over all
three regions, until their mean macro-F1 is within .01 of what all looks come to, and stays there:
where the next look is worth most (active), at each cluster in turn, and at random (mean, range);
from the proposals, from those for a face that moves half as far (worse), and from none.
"""

import argparse
import time
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from scipy.ndimage import median_filter

from mimeline.annotation.annotate import annotate_frames
from mimeline.annotation.choice import choose
from mimeline.annotation.proposals import propose, read_rules
from mimeline.annotation.queries import classes
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.runs import run_starts
from mimeline.annotation.scores import macro_f1, region_scores, true_codes
from mimeline.annotation.series import dead_channels
from mimeline.annotation.thresholds import Limits
from mimeline.config.sections import Annotate, Label, Segment
from mimeline.evaluation.annotation import by_thresholds, oracle
from mimeline.evaluation.labelling import Naming, answers, curves, orders
from mimeline.ticc import TICC
from mimeline.toy import World, simulate
from mimeline.vocabulary import (
    ACTIONS,
    NEUTRAL,
    SERIES_REGIONS,
    SERIES_TRACK,
    resource,
    series_actions,
    series_channels,
)

REGIONS = ("brow", "eye", "mouth", "closure", "head", "gaze")
BARS = {
    "person": {"brow": 0.90, "eye": 0.91, "mouth": 0.87, "closure": 0.95, "head": 0.87,
               "gaze": 0.89},
    "unseen": {"brow": 0.89, "eye": 0.88, "mouth": 0.85},
}  # fmt: skip
ABOVE_THRESHOLDS, BELOW_PERSON, NEAR = 0.02, 0.03, 0.01
MEDIAN_FRAMES = 9
HELD_OUT = 5  # every fifth source is unseen
MISTAKES, PERSONS = (0.05, 0.10), 10
LEAD = 3  # intervals: four of five called alike
RANDOM_ORDERS = 200
SIDE = "left"
LIMITS = Limits(**Annotate().model_dump())
RULES = read_rules(resource("proposals.csv"))


@dataclass(frozen=True)
class Fitted:
    """A region of some clips. values (n_frames, d) of the model's channels · clusters, exemplars,
    proposed: tables."""

    model: RegionModel
    values: np.ndarray
    clusters: pd.DataFrame
    exemplars: pd.DataFrame
    proposed: pd.DataFrame


def fit(motion: pd.DataFrame, region: str) -> Fitted:
    measured = list(series_channels(region, SIDE))
    dead = dead_channels(motion[measured])
    channels = tuple(name for name in measured if name not in dead)
    X = motion[list(channels)].to_numpy("float64")
    _, lengths = np.unique(motion["clip_id"].to_numpy(str), return_counts=True)
    ticc = TICC(**getattr(Segment(), region).model_dump()).fit(X, lengths)
    model = RegionModel(ticc, channels)
    clusters = model.decode(motion)
    options = Label()
    rng = np.random.default_rng([options.seed, SERIES_REGIONS.index(region)])
    shown = choose(clusters, X, options.n_random, options.n_further, rng).assign(region=region)
    return Fitted(model, X, clusters, shown, propose(region, clusters, X, channels, RULES))


def named(
    fitted: Fitted, truth: pd.DataFrame, region: str, looks: int, enough=None, **person
) -> Naming:
    """What a person makes of a region's clusters.

    enough: keeps of the answers those that they take the time for. person: of `answers`.
    """
    shown = fitted.exemplars[fitted.exemplars["rank"] < looks]
    answered = answers(shown, truth, region, **person)
    answered = enough(answered) if enough else answered
    return Naming.of(fitted.clusters, fitted.proposed, answered, truth, region)


def until_two_agree(answered: pd.DataFrame) -> pd.DataFrame:
    """The answers of a person who goes on once two intervals of a cluster were called alike."""
    again = answered.groupby(["cluster", "answer"]).cumcount() == 1
    again &= answered["answer"] >= 0
    return answered[again.groupby(answered["cluster"]).cumsum() - again == 0]


def until_one_leads(answered: pd.DataFrame, looks: int) -> pd.DataFrame:
    """The answers of a person who looks on where, after so many, no name leads by LEAD."""
    kept = []
    for _, own in answered.groupby("cluster"):
        called = own["answer"].to_numpy()[:, None] == np.arange(len(ACTIONS))  # (n, names)
        counts = np.sort(called.cumsum(axis=0), axis=1)
        leads = counts[:, -1] - counts[:, -2] >= LEAD
        leads[: looks - 1] = False
        kept.append(own.iloc[: leads.argmax() + 1] if leads.any() else own)
    return pd.concat(kept)


def labels_of(fitted: Fitted, naming: Naming) -> pd.DataFrame:
    """The `labels` after all looks."""
    names = np.array([*classes(naming.region), None], dtype=object)  # the last: UNSURE
    return fitted.proposed.sort_values("cluster").assign(action=names[naming.names[:, -1]])


def score(motion, truth, clusters: dict[str, pd.DataFrame], labels) -> dict[str, float]:
    """Macro-F1 by region as annotated; a frame that has no name has no action."""
    found = annotate_frames(motion, clusters, pd.concat(labels), LIMITS)
    return region_scores(truth, found.fillna(False))


def smoothed(motion: pd.DataFrame) -> pd.DataFrame:
    """The regions' channels under a median over frames of a clip."""
    channels = [name for region in SERIES_REGIONS for name in series_channels(region, SIDE)]
    parts = [
        median_filter(clip.to_numpy(), size=(MEDIAN_FRAMES, 1), mode="nearest")
        for _, clip in motion.groupby("clip_id", sort=True)[channels]
    ]
    return motion.assign(**dict(zip(channels, np.concatenate(parts).T, strict=True)))


class Tuned:
    """Thresholds on a region's actions, each set where truth says that it is best."""

    GRID = np.linspace(0.02, 0.7, 69)  # of a mean excess of an action's descriptors over its rest
    SWEEPS = 4

    def __init__(self, motion: pd.DataFrame, truth: pd.DataFrame, region: str):
        self.region = region
        self.rest = RULES.rest(motion[list(series_channels(region, SIDE))].to_numpy("float64"))
        codes = true_codes(truth, SERIES_TRACK[region])
        strength, begins = self._strength(motion), run_starts(motion)
        self.limits = np.array([rule.least for rule in self._rules()])
        for _ in range(self.SWEEPS):
            for action in range(len(self.limits)):
                tried = np.repeat(self.limits[None], len(self.GRID), axis=0)
                tried[:, action] = self.GRID
                scores = [
                    self._f1(without_short(self._codes(strength, limits), begins), codes)
                    for limits in tried
                ]
                self.limits = tried[int(np.argmax(scores))]

    def frames(self, motion: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
        names = (NEUTRAL, *series_actions(self.region))
        codes = self._codes(self._strength(motion), self.limits)
        labels = pd.DataFrame(
            {"region": self.region, "cluster": range(len(names)), "action": names}
        )
        return motion[["clip_id", "frame"]].assign(cluster=codes, margin=0.0), labels

    def _rules(self):
        by_action = {rule.action: rule for rule in RULES.actions}
        return [by_action[action] for action in series_actions(self.region)]

    def _strength(self, motion) -> np.ndarray:
        """(n_frames, actions): mean excess of each action's descriptors."""
        channels = list(series_channels(self.region, SIDE))
        excess = motion[channels].to_numpy("float64") - self.rest
        descriptors = [name.removesuffix(SIDE.capitalize()) for name in channels]
        own = [[descriptors.index(d) for d in rule.descriptors] for rule in self._rules()]
        return np.column_stack([excess[:, columns].mean(axis=1) for columns in own])

    @staticmethod
    def _codes(strength, limits) -> np.ndarray:
        """(n_frames,) 0 for Neutral, else the strongest action past its limit, and of two as strong
        the one of the higher limit."""
        passed = strength >= limits
        order = strength + 1e-6 * limits
        best = np.where(passed, order, -np.inf).argmax(axis=1)
        return np.where(passed.any(axis=1), best + 1, 0)

    def _f1(self, codes, truth) -> float:
        size = len(self.limits) + 1
        counted = truth >= 0
        flat = np.bincount(truth[counted] * size + codes[counted], minlength=size * size)
        return float(macro_f1(flat.reshape(size, size)))


def without_short(codes: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """codes (n_frames,) with runs that annotate would leave out as Neutral; begins: of clips."""
    starts = np.union1d(np.flatnonzero(np.diff(codes)) + 1, begins)
    lengths = np.diff([*starts, len(codes)])
    return np.where(np.repeat(lengths >= LIMITS.min_frames, lengths), codes, 0)


def by_tuned(motion: pd.DataFrame, seen: pd.DataFrame, seen_truth: pd.DataFrame):
    """(clusters by region, labels) of motion, by thresholds tuned on what was seen."""
    each = {region: Tuned(seen, seen_truth, region).frames(motion) for region in SERIES_REGIONS}
    return {r: c for r, (c, _) in each.items()}, [labels for _, labels in each.values()]


def by_rules(motion: pd.DataFrame):
    """(clusters by region, labels) of motion, by the rules of the proposals."""
    each = {region: by_thresholds(motion, RULES, region, SIDE) for region in SERIES_REGIONS}
    return {r: c for r, (c, _) in each.items()}, [labels for _, labels in each.values()]


def print_row(name: str, scores: dict[str, float]) -> None:
    cells = "".join(f"{scores.get(region, np.nan):9.3f}" for region in REGIONS)
    print(f"  {name:42}{cells}", flush=True)


def measure(world: World, looks: int, seed: int) -> dict[str, dict[str, float]]:
    """Scores by variant; a line for each as it is known."""
    found = {}

    def tell(name, scores):
        found[name] = scores
        print_row(name, scores)

    motion, truth = world.motion, world.frames
    fits = {region: fit(motion, region) for region in SERIES_REGIONS}
    clusters = {region: one.clusters for region, one in fits.items()}
    person = {region: named(one, truth, region, looks) for region, one in fits.items()}
    labels = [labels_of(one, person[region]) for region, one in fits.items()]
    tell("person", score(motion, truth, clusters, labels))
    brisk = {r: named(one, truth, r, looks, until_two_agree) for r, one in fits.items()}
    short = [labels_of(one, brisk[region]) for region, one in fits.items()]
    spent = sum(int(naming.looks.sum()) for naming in brisk.values())
    tell(f"person, until two agree: {spent} looks", score(motion, truth, clusters, short))
    bare = {r: replace(one, proposed=unproposed(one)) for r, one in fits.items()}
    blind = [labels_of(one, named(one, truth, r, looks)) for r, one in bare.items()]
    tell("person, nothing proposed", score(motion, truth, clusters, blind))
    every = max(int(one.exemplars["rank"].max()) for one in fits.values()) + 1
    further = every, partial(until_one_leads, looks=looks)
    for chance, (most, enough) in product(MISTAKES, ((looks, None), further)):
        runs, spent = [], 0
        for number in range(PERSONS):
            rng = np.random.default_rng([seed, number])
            erring = {
                region: named(one, truth, region, most, enough, mistakes=chance, rng=rng)
                for region, one in fits.items()
            }
            spent += sum(int(naming.looks.sum()) for naming in erring.values())
            named_so = [labels_of(one, erring[region]) for region, one in fits.items()]
            runs.append(score(motion, truth, clusters, named_so))
        runs = pd.DataFrame(runs)
        who = f"person, {chance:.0%} wrong, {spent / PERSONS:.0f} looks"
        tell(who, runs.mean().to_dict())
        tell(f"{who}, worst of {PERSONS}", runs.min().to_dict())
    proposed = [one.proposed for one in fits.values()]
    tell("proposals", score(motion, truth, clusters, proposed))
    best = [oracle(truth, rows, region) for region, rows in clusters.items()]
    tell("oracle", score(motion, truth, clusters, best))
    smooth = smoothed(motion)
    tell("thresholds", score(motion, truth, *by_rules(motion)))
    tell("thresholds, median", score(motion, truth, *by_rules(smooth)))
    tell("thresholds, tuned", score(motion, truth, *by_tuned(motion, motion, truth)))
    tell("thresholds, median, tuned", score(motion, truth, *by_tuned(smooth, smooth, truth)))
    for name, scores in unseen(world, looks).items():
        tell(name, scores)
    unnamed = sum(float(p.loc[p["action"].isna(), "share"].sum()) for p in proposed)
    print(f"  share of frames without a proposal, mean of regions: {unnamed / len(proposed):.3f}")
    print_spent(fits, truth, looks, seed)
    return found


def unseen(world: World, looks: int) -> dict[str, dict[str, float]]:
    source = {clip.clip_id: clip.source for clip in world.clips}
    of_frame = world.motion["clip_id"].map(source)
    out = of_frame.isin(sorted(set(source.values()))[::HELD_OUT]).to_numpy()
    parts = [table[rows].reset_index(drop=True) for rows in (~out, out)
             for table in (world.motion, world.frames)]  # fmt: skip
    seen, seen_truth, motion, truth = parts
    fits = {region: fit(seen, region) for region in SERIES_REGIONS}
    labels = [labels_of(one, named(one, seen_truth, region, looks)) for region, one in fits.items()]
    clusters = {region: one.model.decode(motion) for region, one in fits.items()}
    smooth, smooth_seen = smoothed(motion), smoothed(seen)
    proposed = [one.proposed for one in fits.values()]
    return {
        "unseen person": score(motion, truth, clusters, labels),
        "unseen proposals": score(motion, truth, clusters, proposed),
        "unseen thresholds": score(motion, truth, *by_rules(motion)),
        "unseen thresholds, median, tuned": score(
            motion, truth, *by_tuned(smooth, smooth_seen, seen_truth)
        ),
    }


def less_moving(region: str, one: Fitted) -> pd.DataFrame:
    """What is proposed for the same clusters of a face or a tracker that goes half as far."""
    values = 0.5 * one.values
    return propose(region, one.clusters, values, one.model.channels, RULES)


def unproposed(one: Fitted) -> pd.DataFrame:
    return one.proposed.assign(action=None, confidence=np.nan)


STARTS = {
    "proposals": lambda region, one: one.proposed,
    "worse proposals": less_moving,
    "no proposals": lambda region, one: unproposed(one),
}


def needed(curve: np.ndarray) -> np.ndarray:
    """(...) looks after which macro-F1 (..., n + 1) stays within NEAR of its end."""
    short = curve < curve[..., -1:] - NEAR
    from_end = short[..., ::-1].argmax(axis=-1)  # of the last point that is short
    return np.where(short.any(axis=-1), curve.shape[-1] - from_end, 0)


def print_spent(fits: dict[str, Fitted], truth: pd.DataFrame, looks: int, seed: int) -> None:
    for start, propose_again in STARTS.items():
        found = {}
        for region, one in fits.items():
            again = replace(one, proposed=propose_again(region, one))
            found[region] = named(again, truth, region, looks)
        total = sum(int(naming.looks.sum()) for naming in found.values())
        cells = []
        for way, order in orders(found, RANDOM_ORDERS, np.random.default_rng(seed)).items():
            looked = needed(curves(found, order, np.arange(total + 1))["f1"])
            spread = f" ({looked.min()}-{looked.max()})" if len(looked) > 1 else ""
            cells.append(f"{way} {looked.mean():.1f}{spread}")
        print(f"  looks of {total}, {start:18}: " + ", ".join(cells), flush=True)


def checks(found: dict[str, dict[str, float]]) -> list[tuple[str, str, float, float]]:
    """(what, region, value, least)."""
    person, without = found["person"], found["thresholds"]
    rows = [("person", r, person[r], bar) for r, bar in BARS["person"].items()]
    rows += [("unseen", r, found["unseen person"][r], b) for r, b in BARS["unseen"].items()]
    rows += [("above thresholds", r, person[r] - without[r], ABOVE_THRESHOLDS)
             for r in SERIES_REGIONS]  # fmt: skip
    rows += [("proposals to person", r, found["proposals"][r] - person[r], -BELOW_PERSON)
             for r in SERIES_REGIONS]  # fmt: skip
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--toy-seeds", type=int, nargs="+", default=[7, 11, 12])
    parser.add_argument("--people", type=int, default=40)
    parser.add_argument("--clips", type=int, default=120)
    parser.add_argument("--looks", type=int, default=5)
    options = parser.parse_args()
    outcomes = {}
    for seed in options.toy_seeds:
        began = time.monotonic()
        print(f"\nseed {seed:<39}" + "".join(f"{region:>9}" for region in REGIONS), flush=True)
        world = simulate(options.people, options.clips, seed)
        outcomes[seed] = checks(measure(world, options.looks, seed))
        print(f"  {time.monotonic() - began:.0f} s", flush=True)
    print(f"\n{'':32}{'least':>8}" + "".join(f"{f'seed {seed}':>11}" for seed in outcomes))
    for rows in zip(*outcomes.values(), strict=True):
        what, region, _, bar = rows[0]
        cells = "".join(f"{value:9.3f}{' ' if value >= bar else '!':2}" for *_, value, _ in rows)
        print(f"{what:24}{region:8}{bar:8.2f}{cells}")
    missed = sum(value < bar for rows in outcomes.values() for *_, value, bar in rows)
    print(f"{missed} short of the bar (!)")


if __name__ == "__main__":
    main()
