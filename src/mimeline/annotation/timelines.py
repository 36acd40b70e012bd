"""Timelines of a run's tables, tables of timelines, and the truth that scores are taken against."""

import logging
from collections.abc import Collection, Mapping
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import BadFile, NoSuchFile, printable
from mimeline.timeline import files
from mimeline.timeline.draft import Draft, nearest
from mimeline.timeline.timeline import Interval, Timeline
from mimeline.vocabulary import ACTIONS, TRACKS, track_actions

log = logging.getLogger(__name__)

PLANTED = "frames.parquet"  # in a folder of truth, it is the truth
TOLD = 6  # clips that a warning names


def timelines_of(
    intervals: pd.DataFrame, frames: pd.DataFrame, clips: pd.DataFrame
) -> dict[str, Timeline]:
    """The timeline of each clip that has frames, by clip_id.

    intervals, frames: the tables of annotate; clips: `clips`, for fps and n_frames. A track of
    which no frame is known is not measured. What a timeline cannot tell is lost: single frames that
    are not known are neutral in it.
    """
    known = {
        track: frames[list(track_actions(track))].notna().any(axis=1).groupby(frames["clip_id"])
        for track in TRACKS
    }
    measured = pd.DataFrame({track: of_clip.any() for track, of_clip in known.items()})
    own = dict(list(intervals.groupby("clip_id")))
    found = {}
    for clip in clips[clips["clip_id"].isin(measured.index)].itertuples():
        tracks = {t: [] for t in TRACKS if measured.at[clip.clip_id, t]}
        for row in own.get(clip.clip_id, intervals[:0]).itertuples():
            tracks[row.track].append(_interval(row))
        fps = Fraction(int(clip.fps_num), int(clip.fps_den))
        found[clip.clip_id] = Timeline(clip.clip_id, fps, int(clip.n_frames), tracks)
    return found


def _interval(row) -> Interval:
    return Interval(
        row.action,
        int(row.start_frame),
        int(row.end_frame),
        side=None if pd.isna(row.side) else row.side,
        source=row.source,
        cluster=None if pd.isna(row.cluster) else int(row.cluster),
        confidence=None if pd.isna(row.confidence) else float(row.confidence),
    )


def frames_of(timelines: Mapping[str, Timeline]) -> pd.DataFrame:
    """The `frames` table of timelines: a row for each frame of each, pd.NA for a track without key.

    An action of one side of the face counts as shown. Where the sides show different actions of a
    track, the frame has no class on it: pd.NA.
    """
    parts = [_frames(timeline) for _, timeline in sorted(timelines.items())]
    return pd.concat(parts, ignore_index=True) if parts else tables.empty(tables.FRAMES)


def _frames(timeline: Timeline) -> pd.DataFrame:
    shown = {action: np.zeros(timeline.n_frames, dtype=bool) for action in ACTIONS}
    for interval in timeline:
        shown[interval.action][interval.start : interval.end] = True
    columns = {"clip_id": timeline.clip_id, "frame": np.arange(timeline.n_frames)}
    for track in TRACKS:
        actions = track_actions(track)
        several = np.sum([shown[action] for action in actions], axis=0) > 1  # (n_frames,)
        untold = several | (track not in timeline.tracks)
        columns |= {a: pd.array(shown[a], dtype="boolean") for a in actions}
        for action in actions:
            columns[action][untold] = pd.NA
    return pd.DataFrame(columns)[tables.FRAMES.schema.names]


def read_truth(truth: str | Path, clips: pd.DataFrame, decisions: pd.DataFrame) -> pd.DataFrame:
    """The `frames` table that scores are taken against.

    truth: a folder with frames.parquet, as the toy world's; a folder with files of timelines, of
    any format; or one such file. clips: the run's `clips`, for fps and n_frames. decisions: the
    `ledger` of the stages before, which tells of the clips that the run did not keep. A file is of
    the clip that it names, else of the one that bears its name. A track that it does not have is
    not judged; clips without a file are not in the table, nor are those that the run did not keep:
    they are warned of.

    Raises BadFile for a file that cannot be read, is of a clip that nobody knows or of one that
    another file is of, or has another frame rate or length than its clip; NoSuchFile where nothing
    is.
    """
    truth = Path(truth)
    if (truth / PLANTED).is_file():
        return _planted(truth / PLANTED, clips)
    kept = clips.dropna(subset=["fps_num", "fps_den", "n_frames"])
    run = {c.clip_id: Fraction(int(c.fps_num), int(c.fps_den)) for c in kept.itertuples()}
    lengths = dict(zip(kept["clip_id"], kept["n_frames"].astype(int), strict=True))
    lost = _lost(decisions)
    found, read_from, left_out = {}, {}, {}
    for path in _files(truth):
        for clip_id, draft in files.drafts(path):
            if clip_id in run:
                _require_as_in_the_run(path, clip_id, draft, run[clip_id], lengths[clip_id])
            elif clip_id in lost:
                left_out[clip_id] = lost[clip_id]
            else:
                raise _nobody(path, clip_id, run, lost)
        for timeline in files.read_all(path, run, lengths, clips=run.keys()):
            clip_id = timeline.clip_id
            if clip_id in found:
                raise BadFile(
                    path,
                    place=f"clip {clip_id}",
                    found=f"the clip that {read_from[clip_id].name} is of",
                    expected="one timeline of a clip",
                    remedy="Move one of the two out, or make one of them: mimeline timeline merge.",
                )
            found[clip_id], read_from[clip_id] = timeline, path
    if left_out:
        log.warning("%s", _not_kept(truth, left_out))
    log.info("truth: timelines of %d of %d clips, from %s", len(found), len(clips), truth)
    return frames_of(found)


def _planted(path: Path, clips: pd.DataFrame) -> pd.DataFrame:
    """The table, after a warning where it has frames that its clips have not."""
    true = tables.read(tables.FRAMES, path)
    kept = clips.dropna(subset=["n_frames"])
    lengths = dict(zip(kept["clip_id"], kept["n_frames"].astype(int), strict=True))
    told = true.groupby("clip_id")["frame"].max() + 1
    longer = [clip_id for clip_id, n in told.items() if n > lengths.get(clip_id, n)]
    if longer:
        clip_id, more = longer[0], f" and {len(longer) - 1} more" if longer[1:] else ""
        log.warning(
            "%s: frames beyond the end of clip %s (%d frames, not %d)%s; with another frame rate "
            "than the run's it is no truth of it",
            path,
            printable(clip_id),
            lengths[clip_id],
            told[clip_id],
            more,
        )
    return true


def _lost(decisions: pd.DataFrame) -> dict[str, str]:
    """Clip → what became of it, of those that the run did not keep."""
    rows = decisions[decisions["status"] != "kept"]
    return {row.clip_id: f"{row.status} at {row.stage}: {row.rule}" for row in rows.itertuples()}


def _not_kept(truth: Path, left_out: Mapping[str, str]) -> str:
    told = [f"{clip_id} ({why})" for clip_id, why in sorted(left_out.items())]
    more = f" and {len(told) - TOLD} more" if len(told) > TOLD else ""
    return printable(
        f"truth: clips in {truth} that the run did not keep are not scored: "
        f"{', '.join(told[:TOLD])}{more}. mimeline why tells more of a clip."
    )


def _files(truth: Path) -> list[Path]:
    """The files of timelines at a path: itself, or what lies in the folder."""
    if truth.is_file():
        return [truth]
    found = files.files_in(truth) if truth.is_dir() else []
    if not found:
        raise NoSuchFile(
            truth,
            found="no file of a timeline" if truth.is_dir() else "no such folder",
            expected=f"{PLANTED}, or files that end in {', '.join(files.SUFFIXES)}",
            remedy="Export the run's timelines, correct them, and name their folder: "
            "mimeline timeline export --to eaf -o FOLDER.",
        )
    return found


def _nobody(path: Path, clip_id: str, run: Collection[str], lost: Collection[str]) -> BadFile:
    close = nearest(clip_id, [*run, *lost])
    near = "" if close is None else f"Near it: {close}. "
    return BadFile(
        path,
        place=f"clip {clip_id}",
        found="no clip of that name in the run",
        expected=f"one of the {len(run)} that it kept",
        remedy=f"{near}Name the file after its clip, or move it out of evaluate.truth.",
    )


def _require_as_in_the_run(
    path: Path, clip_id: str, draft: Draft, fps: Fraction, n_frames: int
) -> None:
    """Raises BadFile where a file tells another frame rate or length of a clip than the run has."""
    for what, told, own in (
        ("frames per second", draft.fps, fps),
        ("frames", draft.n_frames, n_frames),
    ):
        if told not in (None, own):
            raise BadFile(
                path,
                place=f"clip {clip_id}",
                found=f"{told} {what}",
                expected=f"{own}, as the run has them",
                remedy="Make it from an export of this run: mimeline timeline export.",
            )
