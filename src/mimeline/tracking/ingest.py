"""Tracking results of any format become the `motion` table; clips that the tracker lost go."""

import logging
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import MimelineError, NoSuchFile
from mimeline.ledger import Ledger
from mimeline.tracking.readers import read_take
from mimeline.tracking.take import Take

log = logging.getLogger(__name__)

TOLERANCE = 2.0  # frames: catalogues round seconds to 1/100, trackers skip a first or last frame


def ingest(
    clips: Path,
    data: Path,
    motion: Path,
    kept: Path,
    ledger: Path,
    format: str,
    options: dict,
    bad_values: str,
    max_missing: float,
) -> None:
    """Read each clip's tracking result into one motion table.

    clips, kept: `clips` tables in and out; out tells fps and n_frames. data: the user's folder.
    A clip that has a video has as many frames as the video; a result of another length is cut or
    padded to it, with a row that says by how much, or fails where it is longer by more than two.
    A clip's result is <folder>/<clip_id>.csv, else its part of <folder>/<source_id>.csv.
    bad_values: "fail" a clip with text or NaN in a number's place, or "mask" the frame.
    max_missing: largest share of frames without a face (Höll 2024, 5.1, rule 4, in spirit).
    """
    table = tables.read(tables.CLIPS, clips)
    folder = Path(data) / options["folder"]
    decisions = Ledger("ingest", table["clip_id"])
    motions, rates = [], {}
    for clip in table.itertuples():
        try:
            take = _take_of(clip, folder, format, options, bad_values)
        except MimelineError as error:
            rule = "no_tracking_result" if isinstance(error, NoSuchFile) else "unreadable"
            decisions.fail(clip.clip_id, rule, detail=str(error))
            continue
        if wrong := _other_cut(clip, take):
            rule, facts = wrong
            decisions.fail(clip.clip_id, rule, **facts)
            continue
        n_frames = len(take.motion)
        take = _fitted(clip, take)
        lost = np.flatnonzero(~take.motion["valid"].to_numpy())
        share = len(lost) / len(take.motion) if len(take.motion) else 1.0
        facts = {"value": share, "limit": max_missing, "unit": "share of frames"}
        if len(lost):
            facts |= {"first_frame": lost[0], "last_frame": lost[-1]}
        if n_frames < len(take.motion):
            facts["detail"] = (
                f"the result has {n_frames} frames: it is taken to begin with the clip"
            )
        if share > max_missing or not len(take.motion):
            decisions.drop(clip.clip_id, "tracking_lost", **facts)
            continue
        if _filmed(clip) and n_frames != clip.n_frames:
            detail = f"{n_frames} frames tracked, {clip.n_frames} in the video: they begin together"
            facts |= {"value": n_frames - clip.n_frames, "limit": TOLERANCE, "unit": "frames"}
            decisions.note(clip.clip_id, "frame_count", **facts | {"detail": detail})
        elif len(lost):
            decisions.note(clip.clip_id, "masked", **facts)
        motions.append(take.motion.assign(clip_id=clip.clip_id))
        rates[clip.clip_id] = (take.fps.numerator, take.fps.denominator, len(take.motion))

    table = table[table["clip_id"].isin(rates)].copy()
    for number, column in enumerate(("fps_num", "fps_den", "n_frames")):
        table[column] = [rates[clip_id][number] for clip_id in table["clip_id"]]
    tables.write(tables.CLIPS, table, kept)
    rows = pd.concat(motions) if motions else tables.empty(tables.MOTION)
    tables.write(tables.MOTION, rows, motion, reason="" if motions else "no clip came through")
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


def _filmed(clip) -> bool:
    return pd.notna(clip.media)


def _other_cut(clip, take: Take) -> tuple[str, dict] | None:
    """Rule and facts where the result cannot be that of the clip: another rate, or too long."""
    if _filmed(clip) and take.fps != (rate := Fraction(int(clip.fps_num), int(clip.fps_den))):
        detail = (
            f"the video was cut to {rate} frames a second, the tracking result has {take.fps}: "
        )
        detail += "correct fetch.fps, or the rate under ingest"
        facts = {"value": float(take.fps), "limit": float(rate), "unit": "frames per second"}
        return "frame_rate", facts | {"detail": detail}
    expected = _expected(clip, take)
    if len(take.motion) > expected + TOLERANCE:
        detail = "the tracking result is longer than its clip: it belongs to another cut"
        facts = {"value": len(take.motion), "limit": round(expected), "unit": "frames"}
        return "longer_than_clip", facts | {"detail": detail}
    return None


def _expected(clip, take: Take) -> float:
    """Frames that the clip ought to have: those of its video, else what its seconds come to."""
    return clip.n_frames if _filmed(clip) else (clip.end_s - clip.start_s) * float(take.fps)


def _fitted(clip, take: Take) -> Take:
    """The result at the clip's length: exactly where there is a video, else no shorter."""
    if _filmed(clip):
        return take.cut(0, clip.n_frames).padded(clip.n_frames)
    return take.padded(round(_expected(clip, take) - TOLERANCE / 2))


def _take_of(clip, folder: Path, format: str, options: dict, bad_values: str) -> Take:
    """The clip's own result, else its seconds of its source's result."""
    own, whole = (_result(folder, name) for name in (clip.clip_id, clip.source_id))
    if own.exists() or not whole.exists():
        return read_take(own, format, options, bad_values)
    take = read_take(whole, format, options, bad_values)
    return take.cut(round(clip.start_s * take.fps), round(clip.end_s * take.fps))


def _result(folder: Path, name: str) -> Path:
    upper = folder / f"{name}.CSV"
    return upper if upper.exists() else folder / f"{name}.csv"
