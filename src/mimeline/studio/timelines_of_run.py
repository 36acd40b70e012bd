"""The timelines of a run that people may judge: the truth's, its own, and those that motion was
generated for."""

import hashlib
from collections.abc import Collection
from fractions import Fraction
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.annotation.timelines import read_truth
from mimeline.clips.media_of_run import files_of
from mimeline.errors import BadFile, NoSuchFile
from mimeline.run import recall
from mimeline.studio.watched import stamp
from mimeline.vocabulary import CHANNELS

TRUTH, ANNOTATION, GENERATION, MISMATCHED = "truth", "annotation", "generation", "mismatched"
KINDS = (TRUTH, ANNOTATION, GENERATION, MISMATCHED)


class TimelinesOfRun:
    """Read once, when the page is started; the long tables only for the clips that are asked for.

    results: a run's results, up to `annotate` at least. of_kind: kind → the clips of which there
    may be a pair; absent: kind → why there is none. parts: clip → test, val or train; empty where
    nothing is split. films: clip → its film. face: as report.face. Raises NoSuchFile where there is
    no run, or no timeline; BadFile for a table that cannot be read.
    """

    def __init__(self, results: str | Path):
        self.results = Path(results)
        self.run = recall(self.results)
        self._frames = sorted(self.results.glob("annotate/*/frames.parquet"))
        self._motions = sorted(self.results.glob("ingest/*/motion.parquet"))
        self._generated = self.results / "evaluate" / "timeline" / "generated.parquet"
        self._split = self.results / "split" / "split.parquet"
        self._truth = self._place_of_truth()
        self._kept = self._kept_clips()
        self._clips = self._annotated()
        self.films = files_of(self.results, "film")
        self.face: str | None = (self.run.config.get("report") or {}).get("face")
        self.parts = self._parts()
        self.absent: dict[str, str] = {}
        found = {
            TRUTH: self._with_truth(),
            ANNOTATION: set(self._clips.index),
            GENERATION: self._with_generated(),
            MISMATCHED: self._with_another(),
        }
        self.of_kind = {kind: clips for kind, clips in found.items() if clips}
        self._read = self._state()

    def fingerprint(self) -> str:
        """Another text whenever what is shown may be: timelines, truth, split, motion, what was
        generated, the face that is drawn, and the films; of these their sizes, as they are large.

        A copy of the results elsewhere has the same.
        """
        read = [*self._frames, *self._motions, self._split, self._generated]
        read += [*self._files_of_truth(), *([Path(self.face)] if self.face else [])]
        digest = hashlib.sha256()
        for path in read:
            if path.is_file():
                digest.update(f"{path.parent.name}/{path.name}".encode())
                with open(path, "rb") as file:
                    digest.update(hashlib.file_digest(file, "sha256").digest())
        for clip_id, film in sorted(self.films.items()):
            digest.update(f"{clip_id}/{film.stat().st_size}".encode())
        return digest.hexdigest()[:16]

    @property
    def is_behind(self) -> bool:
        """Whether the generated motion is older than the timelines that it was asked for."""
        if GENERATION not in self.of_kind:
            return False
        made = self._generated.stat().st_mtime
        return any(path.stat().st_mtime > made for path in self._frames)

    def refuse_changed(self) -> None:
        """Raise BadFile where the results are no longer those that were read."""
        if self._state() != self._read:
            raise BadFile(
                self.results,
                found="other results: the run went on meanwhile",
                expected="the timelines that this page was started with",
                remedy="Start mimeline rate again, with another --file; what was answered is "
                "written.",
            )

    def fps(self, clip_id: str) -> Fraction:
        clip = self._clips.loc[clip_id]
        return Fraction(int(clip["fps_num"]), int(clip["fps_den"]))

    def n_frames(self, clip_id: str) -> int:
        return int(self._clips.at[clip_id, "n_frames"])

    def frames(self, clips: Collection[str]) -> pd.DataFrame:
        """The `frames` table of annotate, of these clips."""
        return _of(tables.FRAMES, self._frames, clips)

    def truth(self, clips: Collection[str]) -> pd.DataFrame:
        """The truth's `frames` table, of these clips; empty where there is none."""
        return self._true[self._true["clip_id"].isin(clips)].reset_index(drop=True)

    def motion(self, clips: Collection[str]) -> pd.DataFrame:
        """The real `motion`, of these clips."""
        return _of(tables.MOTION, self._motions, clips, ["clip_id", "frame", "valid", *CHANNELS])

    def generated(self, clips: Collection[str]) -> pd.DataFrame:
        """The generated `motion`; clip_id is the clip whose own timeline was asked for."""
        columns = ["clip_id", "frame", "valid", *CHANNELS]
        return _of(tables.MOTION, [self._generated], clips, columns)

    def _state(self) -> list:
        return [stamp(path) for path in (*self._frames, *self._motions, self._generated)]

    def _kept_clips(self) -> pd.DataFrame:
        """clip_id, fps_num, fps_den and n_frames of the clips that came to be annotated."""
        if not self._frames:
            begun = any(self.results.glob("catalogue/*/clips.parquet"))
            raise NoSuchFile(
                self.results / "annotate" if begun else self.results,
                found="no timelines" if begun else "no results of a run",
                expected="a run's results up to its timelines, annotate/*/frames.parquet",
                remedy=f"Run `{self.run.command('--until', 'annotate')}`, or name the folder of "
                "another run with --results.",
            )
        paths = sorted(self.results.glob("pose/*/clips.parquet"))
        return tables.read_all(tables.CLIPS, paths, ["clip_id", "fps_num", "fps_den", "n_frames"])

    def _annotated(self) -> pd.DataFrame:
        """Of these, those with timelines, by clip_id."""
        annotated: set[str] = set()
        for path in self._frames:  # one at a time: there is a row per frame
            annotated.update(tables.read(tables.FRAMES, path, ["clip_id"])["clip_id"].unique())
        clips = self._kept[self._kept["clip_id"].isin(annotated)]
        if clips.empty:
            raise NoSuchFile(
                self.results / "annotate",
                found="no clip with a timeline",
                expected="timelines to judge",
                remedy="`mimeline funnel` and `mimeline why` tell what became of the clips.",
            )
        return clips.set_index("clip_id").sort_index()

    def _parts(self) -> dict[str, str]:
        if not self._split.is_file():
            return {}
        rows = tables.read(tables.SPLIT, self._split, ["clip_id", "part"])
        return dict(zip(rows["clip_id"], rows["part"], strict=True))

    def _place_of_truth(self) -> Path | None:
        if told := (self.run.config.get("evaluate") or {}).get("truth"):
            return Path(told)
        toy = self.results / "toy" / "truth"  # where the workflow puts it
        return toy if toy.is_dir() else None

    def _files_of_truth(self) -> list[Path]:
        if self._truth is None:
            return []
        if not self._truth.is_dir():
            return [self._truth]
        return sorted(p for p in self._truth.iterdir() if not p.name.startswith("."))

    def _with_truth(self) -> set[str]:
        self._true = tables.empty(tables.FRAMES)
        if self._truth is None:
            self.absent[TRUTH] = "evaluate.truth names none"
            return set()
        if not self._truth.exists():
            self.absent[TRUTH] = f"{self._truth} is not there"
            return set()
        ledgers = sorted(self.results.glob("*/*/ledger.parquet"))
        ledgers += self.results.glob("*/ledger.parquet")
        decisions = tables.read_all(tables.LEDGER, ledgers)
        self._true = read_truth(self._truth, self._kept, decisions)
        if not (found := set(self._true["clip_id"]) & set(self._clips.index)):
            self.absent[TRUTH] = f"{self._truth} knows none of the clips"
        return found

    def _with_generated(self) -> set[str]:
        if not self._generated.is_file():
            command = self.run.command("--until", "evaluate_timeline")
            self.absent[GENERATION] = f"no motion was generated: `{command}` does"
            return set()
        made = tables.read(tables.MOTION, self._generated, ["clip_id"])["clip_id"]
        if not (found := set(made) & set(self._clips.index)):
            self.absent[GENERATION] = tables.reason(self._generated) or "no motion was generated"
        return found

    def _with_another(self) -> set[str]:
        if len(self._clips) < 2:
            self.absent[MISMATCHED] = "there is one clip alone"
            return set()
        return set(self._clips.index)


def _of(table, paths, clips: Collection[str], columns=None) -> pd.DataFrame:
    """The rows of these clips out of several files of one table."""
    names = list(columns or table.schema.names)
    parts = [tables.read(table, path, names, sorted(clips)) for path in paths]
    rows = pd.concat([part for part in parts if len(part)] or [tables.empty(table)[names]])
    return rows.sort_values(["clip_id", "frame"], ignore_index=True)
