"""Before a training: is there enough, of what, and what is odd."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import pandas as pd

from mimeline.dataset.action_counts import LEAST_RUNS, action_counts, habits
from mimeline.dataset.channel_quality import channel_quality
from mimeline.dataset.part_sizes import frame_rates, part_sizes, times_seen
from mimeline.dataset.split import PARTS
from mimeline.dataset.windows import Clip, Normaliser
from mimeline.dataset.windows import clips as as_clips
from mimeline.vocabulary import ACTIONS, SERIES_TRACK

MOSTLY_INVALID = 0.5  # share of a clip's frames, from which it is told
NAMED = 4  # things named in a finding
LABELLED = set(SERIES_TRACK.values())  # tracks whose actions come from clusters, not from limits


@dataclass(frozen=True)
class Finding:
    """what: is odd; where: clips, channels or actions; remedy: a key or a command.

    problem: training would fail or be meaningless; else it is a remark.
    """

    problem: bool
    what: str
    where: str
    remedy: str


@dataclass(frozen=True)
class Check:
    """What a training would find.

    parts, channels, actions, habits: as `part_sizes`, `channel_quality`, `action_counts` and
    `habits` make them. rates: training clips by frame rate. seen: times that each training frame is
    seen, on average. findings: problems first.
    """

    parts: pd.DataFrame
    channels: pd.DataFrame
    actions: pd.DataFrame
    habits: pd.DataFrame
    rates: Counter[Fraction]
    seen: float
    findings: tuple[Finding, ...]

    @property
    def sound(self) -> bool:
        """Whether there is no problem."""
        return not any(finding.problem for finding in self.findings)


def check(
    clips: pd.DataFrame,
    motion: pd.DataFrame,
    frames: pd.DataFrame,
    split: pd.DataFrame,
    statistics: pd.DataFrame,
    *,
    window: int,
    batch: int,
    steps: int,
    least_frames: int,
) -> Check:
    """Measure what a training would read, and tell what is odd about it.

    clips, motion, frames, split, statistics: the tables of these names. window: frames; batch:
    windows per step; steps: of the training. least_frames: valid training frames, below which
    nothing is trained.
    """
    motion = motion[motion["clip_id"].isin(split["clip_id"])]
    normaliser = Normaliser.from_statistics(statistics)
    ids = {part: set(split.loc[split["part"] == part, "clip_id"]) for part in PARTS}
    usable = {part: as_clips(motion, frames, normaliser, ids[part]) for part in PARTS}
    parts = part_sizes(clips, split, usable, window)
    channels = channel_quality(motion, statistics, ids["train"])
    actions = action_counts(frames, split)
    rates = frame_rates(clips, usable["train"])
    seen = times_seen(usable["train"], window, batch, steps)
    findings = [
        *_of_parts(parts, usable, window, least_frames, seen),
        *_of_rates(rates, parts),
        *_of_leaks(clips, split),
        *_of_channels(channels),
        *_of_actions(actions),
    ]
    return Check(
        parts,
        channels,
        actions,
        habits(frames[frames["clip_id"].isin(ids["train"])], actions),
        rates,
        seen,
        tuple(sorted(findings, key=lambda finding: not finding.problem)),
    )


def _of_parts(
    parts: pd.DataFrame,
    usable: dict[str, list[Clip]],
    window: int,
    least_frames: int,
    seen: float,
) -> Iterator[Finding]:
    train = parts.loc["train"]
    valid = sum(int(clip.valid.sum()) for clip in usable["train"])
    if not train["clips"]:
        yield _problem("no clip to train on", "train", "mimeline funnel tells where clips are lost")
    elif valid < least_frames:
        yield _problem(
            f"{valid} valid frames to train on, fewer than {least_frames}: nothing is trained",
            "train",
            "mimeline funnel tells where clips are lost",
        )
    for part, lost in (("val", "no validation loss"), ("test", "nothing to score the model on")):
        if not parts.loc[part, "clips"]:
            yield _remark(f"no clip in a part, so {lost}", part, f"split.{part}, or more sources")
    for part in PARTS:
        if number := parts.loc[part, "unusable"]:
            what = f"clips left out, without a valid frame of a learnt channel ({number})"
            yield _remark(what, part, "mimeline why CLIP tells what its tracking is worth")
    short = [clip.clip_id for clip in usable["train"] if len(clip.valid) < window]
    if short:
        what = f"{len(short)} of {len(usable['train'])} clips shorter than a window of {window} "
        what += "frames: they are padded, and the padding does not count in the loss"
        yield _remark(what, _named(short), "train.timeline.window, or select.min_s")
    everyone = [clip for part in PARTS for clip in usable[part]]
    poor = [c.clip_id for c in everyone if 1 - c.valid.mean() > MOSTLY_INVALID]
    if poor:
        what = f"more than {MOSTLY_INVALID:.0%} of the frames are invalid"
        yield _remark(what, _named(poor), "ingest.max_missing drops such clips")
    if 0 < seen < 1:
        what = f"a training frame is seen {seen:.2g} times on average"
        yield _remark(what, "train", "train.timeline.steps or train.timeline.batch")


def _of_rates(rates: Counter[Fraction], parts: pd.DataFrame) -> Iterator[Finding]:
    usable = parts.loc["train", "clips"] - parts.loc["train", "unusable"]
    if usable and not rates:
        yield _problem("no frame rate is known", "train", "run the stages from ingest on again")
    if len(rates) > 1:
        where = ", ".join(f"{rate} fps ({n})" for rate, n in sorted(rates.items()))
        what = "clips differ in frame rate; a window is a number of frames, not of seconds"
        yield _remark(what, where, "fetch.fps makes them alike")


def _of_leaks(clips: pd.DataFrame, split: pd.DataFrame) -> Iterator[Finding]:
    """A source, a person or a group of the split in two parts."""
    known = split.merge(clips[["clip_id", "source_id", "subject_id"]], on="clip_id", how="left")
    by_time = known["group"].nunique() < len(PARTS)
    for column, word in (("source_id", "source"), ("subject_id", "person"), ("group", "group")):
        several = known.dropna(subset=[column]).groupby(column)["part"].nunique()
        shared = list(several.index[several > 1])
        if not shared:
            continue
        what = f"the same {word} in several parts"
        if by_time:
            what += ", blocks of time since there are fewer than three groups"
            yield _remark(what, _named(shared), "add sources of other people")
        else:
            what += ", which are to share nothing"
            remedy = "snakemake --cores 2 --forcerun split"
            yield _problem(what, _named(shared), remedy)
        return  # those that follow say it again


def _of_channels(channels: pd.DataFrame) -> Iterator[Finding]:
    learnt = channels[channels["learnt"]]
    if learnt.empty:
        what = "no channel is measured in half of the valid training frames"
        yield _problem(what, "train", "mimeline inspect FILE tells what the tracking result holds")
    elif learnt["constant"].all():
        what = "all channels are constant: there is no motion to learn"
        yield _problem(what, "train", "mimeline inspect FILE tells what the tracking result holds")
    else:
        constant = list(learnt.index[learnt["constant"]])
        if constant:
            what = "channels that do not move in training, which the model learns to hold"
            yield _remark(what, _named(constant), "another tracker, if they are wanted")
    seldom = channels[~channels["learnt"] & (channels["measured"] > 0)]
    if len(seldom):
        what = "channels measured in too few frames, and not learnt"
        yield _remark(what, _named(list(seldom.index)), "more clips of the tracker that has them")
    some = learnt[learnt["without"] > 0]
    if len(some):
        what = "channels measured in some training clips only"
        where = _named(list(some.index), lambda name: f"{name} (not in {some['without'][name]})")
        yield _remark(what, where, "nothing, where takes differ: it does not count in their loss")
    beyond = channels[channels["outside"] > 0].sort_values("outside", ascending=False)
    if len(beyond):
        names = list(beyond.index)
        where = _named(names, lambda name: f"{name} (frames: {beyond['outside'][name]})")
        what = "channels that leave what a face can do"
        yield _remark(
            what,
            where,
            "mimeline inspect TAKE shows its ranges; select.exclusions leaves clips out",
        )


def _of_actions(actions: pd.DataFrame) -> Iterator[Finding]:
    of = {part: own.set_index("action") for part, own in actions.groupby("part")}
    train = of["train"]
    if not train["frames"].any():
        what = "no action in any frame: the timelines tell the model nothing"
        yield _problem(what, "train", "mimeline label, and the limits of annotate")
        return
    unmeasured = [action for action in ACTIONS if not train["measured"][action]]
    if unmeasured:
        what = "actions not measured in training, which the model cannot be told"
        yield _remark(what, _named(unmeasured), "a tracker that has their channels")
    for words, wanted in (
        ("no training clip shows", train["runs"] == 0),
        (
            f"seen fewer than {LEAST_RUNS} times in training",
            train["runs"].between(1, LEAST_RUNS - 1),
        ),
    ):
        by_hand = {True: "mimeline label names clusters", False: "annotate has their limits"}
        for labelled, remedy in by_hand.items():
            names = [
                name
                for name in ACTIONS
                if wanted[name]
                and train["measured"][name]
                and (ACTIONS[name].track in LABELLED) == labelled
            ]
            if names:
                yield _remark(words, _named(names), f"more clips; {remedy}")
    for part in ("val", "test"):
        unseen = [a for a in ACTIONS if of[part]["runs"][a] and not train["runs"][a]]
        if unseen:
            what = f"actions of {part} that training never sees"
            yield _remark(what, _named(unseen), "split.seed, or more clips")


def _problem(what: str, where: str, remedy: str) -> Finding:
    return Finding(True, what, where, remedy)


def _remark(what: str, where: str, remedy: str) -> Finding:
    return Finding(False, what, where, remedy)


def _named(names: list[str], shown: Callable[[str], str] = str) -> str:
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(map(shown, names[:NAMED])) + more
