"""Tracking results of any format become the `motion` table; clips that the tracker lost go."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.errors import MimelineError
from mimeline.ledger import Ledger
from mimeline.tracking.readers import read_take
from mimeline.tracking.take import Take

log = logging.getLogger(__name__)


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
            rule = "no_tracking_result" if error.found == "no such file" else "unreadable"
            decisions.fail(clip.clip_id, rule, detail=str(error))
            continue
        lost = np.flatnonzero(~take.motion["valid"].to_numpy())
        share = len(lost) / len(take.motion)
        facts = {"value": share, "limit": max_missing, "unit": "share of frames"}
        if len(lost):
            facts |= {"first_frame": lost[0], "last_frame": lost[-1]}
        if share > max_missing:
            decisions.drop(clip.clip_id, "tracking_lost", **facts)
            continue
        if len(lost):
            decisions.note(clip.clip_id, "masked", detail=f"{len(lost)} frames masked", **facts)
        motions.append(take.motion.assign(clip_id=clip.clip_id))
        rates[clip.clip_id] = (take.fps.numerator, take.fps.denominator, len(take.motion))

    table = table[table["clip_id"].isin(rates)].copy()
    for number, column in enumerate(("fps_num", "fps_den", "n_frames")):
        table[column] = [rates[clip_id][number] for clip_id in table["clip_id"]]
    tables.write(tables.CLIPS, table, kept)
    rows = pd.concat(motions) if motions else tables.empty(tables.MOTION)
    tables.write(tables.MOTION, rows, motion, reason="" if motions else "no clip came through")
    decisions.close(ledger, table["clip_id"])
    log.info("%s", decisions)


def _take_of(clip, folder: Path, format: str, options: dict, bad_values: str) -> Take:
    """The clip's own result, or its seconds of its source's result, as long as the clip is."""
    own = folder / f"{clip.clip_id}.csv"
    whole = folder / f"{clip.source_id}.csv"
    cut_from_source = not own.exists() and whole.exists()
    take = read_take(whole if cut_from_source else own, format, options, bad_values)
    if cut_from_source:
        take = take.cut(round(clip.start_s * take.fps), round(clip.end_s * take.fps))
    return take.padded(_whole_frames((clip.end_s - clip.start_s) * take.fps))


def _whole_frames(count: float) -> int:
    """Catalogues round seconds to 1/100: a clip of 164.9 frames may have 164."""
    return int(np.floor(round(float(count), 3) - 0.5))
