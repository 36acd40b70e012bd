"""Tracking results of any format become the `motion` table; clips that the tracker lost go."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import MimelineError, NoSuchFile
from mimeline.ledger import Ledger
from mimeline.tracking import firewall, loss
from mimeline.tracking.matching import TOLERANCE, filmed, fitted, of_another_cut, take_of
from mimeline.tracking.origins import origins_of
from mimeline.tracking.readers import Tracker
from mimeline.tracking.take import Take

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Limits:
    """missing: largest share of frames without a face. loss, reprojection: largest tracking loss of
    a frame, the tracker's own or its landmarks' (Höll 2024, 5.1, rule 4); None: no limit."""

    missing: float
    loss: float | None
    reprojection: float | None


def ingest(
    clips: Path,
    data: Path,
    motion: Path,
    coefficients: Sequence[Path],
    origins: Path,
    kept: Path,
    ledger: Path,
    format: str,
    options: dict,
    mirrored: bool,
    bad_values: str,
    max_missing: float,
    max_loss: float | None,
    max_reprojection: float | None,
) -> None:
    """Read each clip's tracking result into one motion table, and what else it holds beside it.

    clips, kept: `clips` tables in and out; out tells fps and n_frames. data: the user's folder.
    coefficients: a table for each of tables.COEFFICIENTS, in their order; origins: table of how
    each channel was had.
    A clip that has a video has as many frames as the video; a result of another length is cut or
    padded to it, with a row that says by how much, or fails where it is longer by more than two.
    mirrored: the tracker saw mirrored pictures. bad_values: "fail" a clip with text or NaN in a
    number's place, or "mask" the frame. max_missing, max_loss, max_reprojection: see `Limits`.
    Raises MimelineError where so many clips break a convention that the configuration is at fault.
    """
    table = tables.read(tables.CLIPS, clips)
    tracker = Tracker.of(data, format, options, bad_values)
    decisions = Ledger("ingest", table["clip_id"])
    takes: dict[str, Take] = {}
    errors: dict[str, MimelineError] = {}
    found: dict[str, list[firewall.Finding]] = {}
    able: dict[str, frozenset[str]] = {}
    limits = Limits(max_missing, max_loss, max_reprojection)

    @lru_cache(maxsize=1)
    def read(path: Path) -> Take:
        take = loss.with_loss(tracker.read(path), path, max_loss)
        take = firewall.without_lost(take)
        return take.mirrored() if mirrored else take

    for clip in table.itertuples():
        try:
            take = take_of(clip, tracker, read)
        except MimelineError as error:
            errors[clip.clip_id] = error
            rule = "no_tracking_result" if isinstance(error, NoSuchFile) else "unreadable"
            decisions.fail(clip.clip_id, rule, detail=str(error))
            continue
        if wrong := of_another_cut(clip, take):
            rule, facts = wrong
            decisions.fail(clip.clip_id, rule, **facts)
            continue
        found[clip.clip_id] = firewall.examine(take, tracker.reader.convention.first_frame)
        able[clip.clip_id] = firewall.tells(take)
        if _judge(clip, take, found[clip.clip_id], limits, decisions):
            takes[clip.clip_id] = fitted(clip, take)
    fault = firewall.unreadable_alike(errors, len(table), tracker.folder)
    if fault := fault or firewall.systemic(found, able, tracker.folder, format):
        raise fault

    table = table[table["clip_id"].isin(list(takes))].copy()
    for column in ("fps_num", "fps_den", "n_frames"):
        table[column] = [_clock(takes[clip_id])[column] for clip_id in table["clip_id"]]
    tables.write(tables.CLIPS, table, kept)
    _write_frames(takes, motion, coefficients)
    tables.write(tables.ORIGINS, origins_of(takes.values()), origins)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


def _judge(
    clip,
    take: Take,
    findings: Sequence[firewall.Finding],
    limits: Limits,
    decisions: Ledger,
) -> bool:
    """Decide on a clip whose result could be read; whether it is kept."""
    n_frames, frames = len(take.motion), fitted(clip, take).motion
    lost = np.flatnonzero(~frames["valid"].to_numpy())
    share = len(lost) / len(frames) if len(frames) else 1.0
    missing = {"value": share, "limit": limits.missing, "unit": "share of frames"}
    if len(lost):
        missing |= {"first_frame": lost[0], "last_frame": lost[-1]}
    if n_frames < len(frames):
        missing["detail"] = f"the result has {n_frames} frames: it is taken to begin with the clip"
    failing = next((finding for finding in findings if finding.severity == "fail"), None)
    if failing:
        decisions.fail(clip.clip_id, failing.rule, **failing.facts)
        return False
    if share > limits.missing or not len(frames):
        decisions.drop(clip.clip_id, "tracking_lost", **missing)
        return False
    if facts := loss.broken(take, limits.loss, limits.reprojection):
        decisions.drop(clip.clip_id, "tracking_loss", **facts)
        return False
    if why := loss.not_applied(take, limits.loss, limits.reprojection):
        decisions.note(clip.clip_id, "tracking_loss", detail=why)
    for finding in findings:
        decisions.note(clip.clip_id, finding.rule, **finding.facts)
    if len(lost):
        decisions.note(clip.clip_id, "masked", **missing)
    if filmed(clip) and n_frames != clip.n_frames:
        detail = f"{n_frames} frames tracked, {clip.n_frames} in the video: they begin together"
        facts = {"value": n_frames - clip.n_frames, "limit": TOLERANCE, "unit": "frames"}
        decisions.note(clip.clip_id, "frame_count", **facts, detail=detail)
    return True


def _clock(take: Take) -> dict[str, int]:
    rate = {"fps_num": take.fps.numerator, "fps_den": take.fps.denominator}
    return rate | {"n_frames": len(take.motion)}


def _write_frames(takes: Mapping[str, Take], motion: Path, coefficients: Sequence[Path]) -> None:
    """Write `motion` and the tables beside it, empty with a reason where there is nothing."""
    moving = [take.motion.assign(clip_id=clip_id) for clip_id, take in takes.items()]
    rows = pd.concat(moving) if moving else tables.empty(tables.MOTION)
    tables.write(tables.MOTION, rows, motion, reason="" if moving else "no clip came through")
    for (name, table), path in zip(tables.COEFFICIENTS.items(), coefficients, strict=True):
        parts = [
            take.coefficients[name].assign(clip_id=clip_id, frame=take.motion["frame"])
            for clip_id, take in takes.items()
            if name in take.coefficients
        ]
        rows = pd.concat(parts) if parts else tables.empty(table)
        reason = "" if parts else f"the tracking results hold no {name.replace('_', ' ')}"
        tables.write(table, rows, path, reason)
