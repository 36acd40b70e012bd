"""A run that has come to split, as one takes it elsewhere: its clips, shard by shard."""

import hashlib
import json
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import BadFile, NoSuchFile
from mimeline.inspection.left_behind import ledgers, rows_of, shards
from mimeline.reporting.funnel import Stage, funnel
from mimeline.run import Run, recall
from mimeline.vocabulary import CHANNELS

UNTIL = ("--until", "describe", "split")  # annotate comes before describe
_OF_A_FRAME = ["clip_id", "frame"]


@dataclass(frozen=True)
class Shard:
    """Clips of a run, as their tables have them.

    clips: `clips` with part and group, sorted by clip_id. motion, frames: a row for each frame of
    each clip, in the same order. intervals: in that order, too.
    """

    clips: pd.DataFrame
    motion: pd.DataFrame
    frames: pd.DataFrame
    intervals: pd.DataFrame

    def of(self, ids: Collection[str]) -> "Shard":
        """The same of some of its clips."""
        tables_ = (self.clips, self.motion, self.frames, self.intervals)
        own = (t[t["clip_id"].isin(list(ids))].reset_index(drop=True) for t in tables_)
        return Shard(*own)


@dataclass(frozen=True)
class Finished:
    """clips: the `clips` table of those that are in a part of the split, with part and group.

    stages: what became of all clips of the catalogue; in = kept + dropped + failed.
    """

    results: Path
    run: Run
    clips: pd.DataFrame
    stages: list[Stage]

    @cached_property
    def channels(self) -> pd.DataFrame:
        """A row per channel, by its name: measured, origin, quality; share, mean, std, low, high.

        measured: whether some of the tracking results give it. Of several origins the least
        reliable. The rest is of the training part: share of its frames that have the channel, and
        what `statistics` has besides.
        """
        had = rows_of(self.results, "ingest", tables.ORIGINS)
        had = had.sort_values(["measured", "quality"], ascending=[False, True], kind="stable")
        had = had.drop_duplicates("channel").set_index("channel").reindex(list(CHANNELS))
        seen = rows_of(self.results, "split", tables.STATISTICS).set_index("channel")
        had["measured"] = had["measured"].astype("boolean").fillna(False).astype(bool)
        return had.join(seen.rename(columns={"measured": "share"}))

    @property
    def measured(self) -> list[str]:
        """The channels that some of the tracking results give, in the vocabulary's order."""
        return list(self.channels.index[self.channels["measured"]])

    @cached_property
    def by_time(self) -> bool:
        """Whether the parts are blocks of time, so that they share recordings and people."""
        return rows_of(self.results, "split", tables.LEDGER)["rule"].eq("split_by_time").any()

    @cached_property
    def named_by(self) -> dict[str, int]:
        """Who named the clusters that the timelines are made of: human, moved, proposed → many."""
        named = rows_of(self.results, "label", tables.LABELS)
        return {str(who): int(n) for who, n in named["source"].value_counts().sort_index().items()}

    @cached_property
    def descriptions(self) -> dict[str, list[str]]:
        """Clip → the sentences that `describe` made, each once."""
        told = rows_of(self.results, "describe", tables.DESCRIPTIONS)
        return {c: list(dict.fromkeys(rows["text"])) for c, rows in told.groupby("clip_id")}

    @property
    def config_digest(self) -> str:
        """Sixteen digits that tell the run's configuration from any other; empty: not known."""
        if not self.run.config:
            return ""
        text = json.dumps(self.run.config, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def shards(self) -> Iterator[Shard]:
        """The clips, as many at a time as the run kept together.

        Raises BadFile where a clip's tables are not of the same frames, or a clip has none.
        """
        left = set(self.clips["clip_id"])
        for folder in shards(self.results, "ingest"):
            shard = self._shard(folder.name)
            left -= set(shard.clips["clip_id"])
            if len(shard.clips):
                yield shard
        if left:
            raise self._stale("ingest", f"no motion of clip {min(left)!r}")

    def _shard(self, name: str) -> Shard:
        own = tables.read(tables.CLIPS, self.results / "ingest" / name / "clips.parquet")
        clips = self.clips[self.clips["clip_id"].isin(own["clip_id"])].reset_index(drop=True)
        ids = clips["clip_id"].tolist()
        motion = tables.read(
            tables.MOTION, self.results / "ingest" / name / "motion.parquet", clips=ids
        )
        folder = self.results / "annotate" / name
        frames = tables.read(tables.FRAMES, folder / "frames.parquet", clips=ids)
        intervals = tables.read(tables.INTERVALS, folder / "intervals.parquet", clips=ids)
        if not motion[_OF_A_FRAME].equals(frames[_OF_A_FRAME]):
            raise self._stale("annotate", "other frames than those of the motion")
        n_frames = motion.groupby("clip_id").size().reindex(ids, fill_value=0)
        for clip_id, n, expected in zip(ids, n_frames, clips["n_frames"], strict=True):
            if n != expected or n == 0:
                raise self._stale("ingest", f"{n} frames of clip {clip_id!r}, not {expected}")
        if not (motion["clip_id"].to_numpy() == np.repeat(ids, n_frames)).all():
            raise self._stale("ingest", "clips in another order")
        return Shard(clips, motion, frames, intervals)

    def _stale(self, stage: str, found: str) -> BadFile:
        return BadFile(
            self.results / stage,
            found=found,
            expected="the frames of the clips that the run kept",
            remedy=f"The tables are of different runs: {self.run.command(*UNTIL)}.",
        )


def finished(results: Path) -> Finished:
    """The run that left the results.

    Raises NoSuchFile where no run has been, or none that came to split; BadFile where it left no
    clip, or tables of different runs.
    """
    ledgers(results)
    run = recall(results)
    annotated = any((Path(results) / "annotate").glob("*/frames.parquet"))
    split = rows_of(results, "split", tables.SPLIT)
    if not annotated or not (Path(results) / "split" / "split.parquet").is_file():
        raise NoSuchFile(
            results,
            found="no timelines" if not annotated else "no split",
            expected="a run that has come to split, which makes train, validation and test",
            remedy=f"{run.command(*UNTIL)} makes them.",
        )
    if split.empty:
        raise BadFile(
            results,
            found="no clip",
            expected="clips that came through every stage",
            remedy="mimeline funnel tells what became of them.",
        )
    clips = rows_of(results, "pose", tables.CLIPS)
    told = clips.merge(split, on="clip_id", validate="one_to_one")
    if len(told) != len(split):
        raise BadFile(
            Path(results) / "split",
            found=f"{len(split)} clips, of which pose kept {len(told)}",
            expected="clips that pose kept",
            remedy=f"The tables are of different runs: {run.command(*UNTIL)}.",
        )
    stages = funnel(ledgers(results), through=told["clip_id"].tolist()).stages
    return Finished(Path(results), run, told.sort_values("clip_id", ignore_index=True), stages)
