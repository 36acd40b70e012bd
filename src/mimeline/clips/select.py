"""Which clips are worth the work: rules on the catalogue alone, before any video is touched."""

import logging
from pathlib import Path

import pandas as pd

from mimeline import tables
from mimeline.errors import MissingColumn, unreadable
from mimeline.ledger import Ledger

log = logging.getLogger(__name__)

ROUNDING_S = 1e-6  # durations are differences of decimal seconds


def select(
    clips: Path,
    kept: Path,
    ledger: Path,
    min_s: float,
    max_s: float,
    min_side_px: int,
    excluded_actions: list[str],
    conditions: list[str],
    max_overlap: float | None,
    exclusions: str | None,
) -> None:
    """Keep the clips that break no rule of Höll 2024, 5.1 and 5.2.1.

    clips, kept: `clips` tables in and out. min_s, max_s: seconds. min_side_px: least width and
    height of the crop, CelebV-Text's own limit; noted where the size is not known.
    exclusions: CSV of clip_id and reason, left out by hand.
    """
    table = tables.read(tables.CLIPS, clips)
    by_hand = read_exclusions(exclusions) if exclusions else {}
    decisions = Ledger("select", table["clip_id"])
    for clip in table.itertuples():
        length = clip.end_s - clip.start_s
        unwanted = [act["name"] for act in clip.actions if act["name"] in excluded_actions]
        sizes_known = pd.notna(clip.width) and pd.notna(clip.height)
        if clip.clip_id in by_hand:
            decisions.drop(clip.clip_id, "excluded", detail=by_hand[clip.clip_id])
        elif length < min_s - ROUNDING_S:
            decisions.drop(clip.clip_id, "too_short", value=length, limit=min_s, unit="s")
        elif length > max_s + ROUNDING_S:
            decisions.drop(clip.clip_id, "too_long", value=length, limit=max_s, unit="s")
        elif unwanted:
            decisions.drop(clip.clip_id, "excluded_action", detail=", ".join(unwanted))
        elif sizes_known and (side := min(clip.width, clip.height)) < min_side_px:
            decisions.drop(clip.clip_id, "too_small", value=side, limit=min_side_px, unit="px")
        elif not sizes_known:
            detail = "not applied: the catalogue does not give the size of the crop"
            decisions.note(clip.clip_id, "too_small", limit=min_side_px, unit="px", detail=detail)
    table = table[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.CLIPS, table, kept)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


def read_exclusions(path: str) -> dict[str, str]:
    """clip_id → reason, from a CSV with these two columns."""
    try:
        rows = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, ValueError) as error:
        raise unreadable(
            path,
            error,
            expected="a CSV of clip_id and reason",
            remedy="Write it, or set select.exclusions to null.",
        ) from error
    if missing := [name for name in ("clip_id", "reason") if name not in rows]:
        raise MissingColumn(
            path,
            found=f"columns {', '.join(rows)}",
            expected=", ".join(missing),
            remedy="Head the two columns clip_id,reason.",
        )
    return dict(zip(rows["clip_id"], rows["reason"], strict=True))
