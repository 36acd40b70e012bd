"""Tracking results of any format become the `motion` table; clips that the tracker lost go."""

import logging
from collections import defaultdict
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import MimelineError, NoSuchFile
from mimeline.ledger import Ledger
from mimeline.tracking import firewall, loss
from mimeline.tracking.matching import Result, Results, filmed, fitted, of_another_cut
from mimeline.tracking.origins import origins_of
from mimeline.tracking.readers import Tracker
from mimeline.tracking.take import Take

log = logging.getLogger(__name__)

FROM_MOVEMENT = frozenset(("sides_swapped", "angle_unit"))  # rules that need something to move
UNTOLD = "not applied: nothing that could tell moves enough"


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
    padded to it, with a row that says by how much, or fails where it is longer by more than two, or
    shorter though its frames are counted row by row.
    mirrored: the tracker saw mirrored pictures. bad_values: "fail" a clip with text or NaN in a
    number's place, or "mask" the frame. max_missing, max_loss, max_reprojection: see `Limits`.
    Raises MimelineError where so many clips break a convention that the configuration is at fault.
    """
    table = tables.read(tables.CLIPS, clips)
    tracker = Tracker.of(data, format, options, bad_values)
    results = Results(tracker, max_loss)
    decisions = Ledger("ingest", table["clip_id"])
    takes: dict[str, Take] = {}
    found: dict[str, list[firewall.Finding]] = defaultdict(list)  # by result: clips may share one
    able: dict[str, frozenset[str]] = defaultdict(frozenset)
    limits = Limits(max_missing, max_loss, max_reprojection)

    for clip in table.itertuples():
        try:
            result = results.of(clip)
        except MimelineError as error:
            rule = "no_tracking_result" if isinstance(error, NoSuchFile) else "unreadable"
            decisions.fail(clip.clip_id, rule, detail=str(error))
            continue
        if wrong := of_another_cut(clip, result):
            rule, facts = wrong
            decisions.fail(clip.clip_id, rule, **facts)
            continue
        take = fitted(clip, result.take)
        findings = firewall.examine(take, tracker.reader.convention.first_frame)
        found[result.path.name] += findings
        tells = firewall.tells(take)
        able[result.path.name] |= tells
        if _judge(clip, result, take, findings, limits, decisions):
            for rule in sorted(FROM_MOVEMENT - tells):
                decisions.note(clip.clip_id, rule, detail=UNTOLD)
            takes[clip.clip_id] = take
    fault = firewall.unreadable_alike(results.errors, len(results.names), tracker.folder)
    if fault := fault or firewall.systemic(found, able, tracker.folder, format):
        raise fault

    told = frozenset().union(*(take.coefficients for take in takes.values()))
    if mirrored:
        takes = {clip_id: take.mirrored() for clip_id, take in takes.items()}
    table = table[table["clip_id"].isin(list(takes))].copy()
    for column in ("fps_num", "fps_den", "n_frames"):
        table[column] = [_clock(takes[clip_id])[column] for clip_id in table["clip_id"]]
    tables.write(tables.CLIPS, table, kept)
    _write_frames(takes, told, motion, coefficients)
    tables.write(tables.ORIGINS, origins_of(takes.values()), origins)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


def _judge(
    clip,
    result: Result,
    take: Take,
    findings: Sequence[firewall.Finding],
    limits: Limits,
    decisions: Ledger,
) -> bool:
    """Decide on a clip whose result could be read; whether it is kept.

    take: what the result says, at the clip's length.
    """
    failing = next((finding for finding in findings if finding.severity == "fail"), None)
    if failing:
        decisions.fail(clip.clip_id, failing.rule, **failing.facts)
        return False
    missing = _missing(result, take, limits.missing)
    if missing["value"] > limits.missing or not len(take.motion):
        decisions.drop(clip.clip_id, "tracking_lost", **missing)
        return False
    if facts := loss.broken(take, limits.loss, limits.reprojection):
        decisions.drop(clip.clip_id, "tracking_loss", **facts)
        return False
    if why := loss.not_applied(take, limits.loss, limits.reprojection):
        decisions.note(clip.clip_id, "tracking_loss", detail=why)
    for finding in findings:
        decisions.note(clip.clip_id, finding.rule, **finding.facts)
    if missing["value"]:
        decisions.note(clip.clip_id, "masked", **missing)
    n_frames = len(result.take.motion)
    if filmed(clip) and n_frames != clip.n_frames:
        detail = f"{n_frames} frames tracked, {clip.n_frames} in the video: they begin together"
        facts = {"value": n_frames - clip.n_frames, "unit": "frames"}
        decisions.note(clip.clip_id, "frame_count", **facts, detail=detail)
    return True


def _missing(result: Result, take: Take, limit: float) -> dict:
    """Ledger facts of the frames without a face, and why they are."""
    lost = np.flatnonzero(~take.motion["valid"].to_numpy())
    n_frames, n_clip = len(result.take.motion), len(take.motion)
    why = []
    if zero := int(result.zero[:n_clip].sum()):
        why.append(f"{zero} of them since every coefficient is 0")
    if n_frames < n_clip:
        why.append(f"the result ends after {n_frames} of {n_clip} frames: the others count as lost")
    facts = {"value": len(lost) / n_clip if n_clip else 1.0, "limit": limit}
    if len(lost):
        facts |= {"first_frame": lost[0], "last_frame": lost[-1]}
    return facts | {"unit": "share of frames", "detail": "; ".join(why) or None}


def _clock(take: Take) -> dict[str, int]:
    rate = {"fps_num": take.fps.numerator, "fps_den": take.fps.denominator}
    return rate | {"n_frames": len(take.motion)}


def _write_frames(
    takes: Mapping[str, Take], told: Set[str], motion: Path, coefficients: Sequence[Path]
) -> None:
    """Write `motion` and the tables beside it, empty with a reason where there is nothing.

    told: the coefficients that the results hold, mirrored or not.
    """
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
        absent = f"the tracking results hold no {name.replace('_', ' ')}"
        absent = "left out: the pictures were mirrored" if name in told else absent
        tables.write(table, rows, path, reason="" if parts else absent)
