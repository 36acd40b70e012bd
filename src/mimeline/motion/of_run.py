"""The motion of a run's clips, with the timelines that it found."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

from mimeline import tables
from mimeline.annotation.timelines import timelines_of
from mimeline.errors import NoSuchFile
from mimeline.inspection.asked import meant
from mimeline.inspection.left_behind import decisions, rows_of, shards
from mimeline.motion.motion import Motion
from mimeline.run import recall
from mimeline.tracking.origins import told

STAGE = "ingest"


def named(results: Path, asked: Sequence[str]) -> tuple[list[str], list[str]]:
    """The clips of a run that have motion, and a problem for each name that nobody has.

    asked: ids, patterns of ids or sources, as for `why`; empty: all clips. Raises NoSuchFile where
    no run has been, or none of the clips has motion; BadFile where nobody has any of the names.
    """
    known = decisions(results)["clip_id"].unique()
    clips = rows_of(results, STAGE, tables.CLIPS)["clip_id"]
    ids, missed = sorted(clips), []
    if asked:
        catalogue = rows_of(results, "catalogue", tables.CLIPS).set_index("clip_id", drop=False)
        ids, _, missed = meant(asked, known, catalogue, results)
    there = set(clips)
    without = [clip_id for clip_id in ids if clip_id not in there]
    missed += [
        f"{clip_id} has no motion: mimeline why says what became of it" for clip_id in without
    ]
    if len(without) == len(ids):
        raise NoSuchFile(
            results,
            found="no motion" + (" of a clip that you name" if asked else ""),
            expected="that of clips that came through ingest",
            remedy=f"{recall(results).command('--until', STAGE)} makes it.",
        )
    return [clip_id for clip_id in ids if clip_id in there], missed


def of_run(results: Path, clips: Sequence[str]) -> Iterator[tuple[str, Motion]]:
    """Each clip's motion, in the order of shards, with its timeline where the run has one."""
    about = rows_of(results, STAGE, tables.CLIPS).set_index("clip_id", drop=False)
    about = about.loc[list(clips)]
    timelines = timelines_of(
        rows_of(results, "annotate", tables.INTERVALS),
        rows_of(results, "annotate", tables.FRAMES),
        about,
    )
    for folder in shards(results, STAGE):
        origins = told(tables.read(tables.ORIGINS, folder / "origins.parquet"))
        rows = tables.read(tables.MOTION, folder / "motion.parquet", clips=sorted(about.index))
        for clip_id, frames in rows.groupby("clip_id"):
            clip = about.loc[clip_id]
            fps = Fraction(int(clip["fps_num"]), int(clip["fps_den"]))
            frames = frames.drop(columns="clip_id").reset_index(drop=True)
            yield str(clip_id), Motion(frames, fps, origins, timelines.get(clip_id))
