"""Which clips are worth the work: rules on the catalogue alone, before any video is touched."""

import logging
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline import tables
from mimeline.clips.conditions import Condition, condition, facts
from mimeline.clips.exclusions import FILM, read_exclusions
from mimeline.clips.findings import FACTS, Findings
from mimeline.clips.intervals import Interval, timed
from mimeline.clips.overlap import duplicates
from mimeline.ledger import Ledger

log = logging.getLogger(__name__)

ROUNDING_S = 1e-6  # durations are differences of decimal seconds
UNKNOWN_SIZE = "not applied: the catalogue does not give the size of the crop"
BESIDES = "also a duplicate of"  # what the detail of another rule says
NAMED = 5  # ids that the log names


def select(
    clips: Path,
    kept: Path,
    ledger: Path,
    min_s: float,
    max_s: float,
    min_side_px: int,
    excluded_actions: Sequence[str],
    conditions: Sequence[str],
    max_overlap: float | None,
    exclusions: str | None,
    catalogue: Path | None = None,
) -> None:
    """Keep the clips that break no rule of Höll 2024, 5.1 and 5.2.1, nor of the user's own.

    clips, kept: `clips` tables in and out. exclusions: CSV of clip_id and reason, left out by
    hand. catalogue: the ledger of the clips of all shards; where it is given, the log names what
    the list excludes and nobody has. The rules: `decide`.
    Raises BadConfig for a condition, BadFile or MissingColumn for a list that is none.
    """
    asked = [condition(text) for text in conditions]
    by_hand = read_exclusions(exclusions) if exclusions else {}
    if catalogue and (idle := unknown(by_hand, catalogue)):
        named = ", ".join(idle[:NAMED]) + (", …" if len(idle) > NAMED else "")
        log.warning("%s: ids that no clip has: %d (%s)", exclusions, len(idle), named)
    table = tables.read(tables.CLIPS, clips)
    found = decide(
        table,
        min_s=min_s,
        max_s=max_s,
        min_side_px=min_side_px,
        excluded_actions=excluded_actions,
        conditions=asked,
        max_overlap=max_overlap,
        exclusions=by_hand,
    )
    decisions = Ledger("select", table["clip_id"])
    for clip_id, status, *facts_of_clip in found.itertuples(index=False, name=None):
        say = decisions.drop if status == "dropped" else decisions.note
        say(clip_id, **dict(zip(FACTS, facts_of_clip, strict=True)))
    table = table[table["clip_id"].isin(decisions.kept)]
    tables.write(tables.CLIPS, table, kept)
    decisions.close(ledger, table["clip_id"])
    decisions.tell(log)


def decide(
    clips: pd.DataFrame,
    *,
    min_s: float,
    max_s: float,
    min_side_px: int,
    excluded_actions: Sequence[str],
    conditions: Sequence[Condition],
    max_overlap: float | None,
    exclusions: Mapping[str, str],
) -> pd.DataFrame:
    """What the ledger says of the clips: the first rule that each breaks, in this order.

    excluded: left out by hand, whatever else holds; exclusions may write an id with .mp4 at its
    end. too_short, too_long: min_s and max_s seconds, both allowed. excluded_action: the catalogue
    lists such an action, be it ever so short or uncertain; blanks and underscores are one.
    too_small: the lesser of width and height, pixels. condition: one of the user's. duplicate: it
    overlaps a clip of its source that breaks no rule, by more than max_overlap; where a clip breaks
    another rule and is a duplicate besides, the detail tells.

    clips: rows of the `clips` table. Returns clip_id, status, rule, value, limit, unit, detail: a
    row for each dropped clip, and for each rule that could not be applied to a kept one.
    """
    columns = {"duration_s", "side_px"}.union(*(asked.columns for asked in conditions))
    known = facts(clips, sorted(columns))
    found = Findings(clips["clip_id"])
    ids, listed_by_hand = clips["clip_id"], dict(exclusions)
    reasons = ids.map(listed_by_hand).fillna((ids + FILM).map(listed_by_hand))
    found.drop("excluded", reasons.notna(), details=lambda rows: reasons.iloc[rows])
    length = known["duration_s"].to_numpy(float)  # (n,)
    found.drop("too_short", length < min_s - ROUNDING_S, length, min_s, "s")
    found.drop("too_long", length > max_s + ROUNDING_S, length, max_s, "s")
    acts = _unwanted(clips["actions"], excluded_actions)
    listed = [bool(of_clip) for of_clip in acts]
    found.drop(
        "excluded_action",
        listed,
        details=lambda rows: [", ".join(map(timed, acts[row])) for row in rows],
    )
    side = known["side_px"].to_numpy(float, na_value=np.nan)  # (n,)
    found.drop("too_small", side < min_side_px, side, min_side_px, "px")
    found.note("too_small", np.isnan(side), lambda rows: UNKNOWN_SIZE, min_side_px, "px")
    for asked in conditions:
        holds = asked.holds(known)
        found.drop("condition", ~holds.fillna(True), details=partial(asked.values, known))
        found.note("condition", holds.isna(), partial(asked.gaps, known))
    if max_overlap is not None:
        _drop_duplicates(found, clips, max_overlap)
    return found.table()


def _unwanted(actions: pd.Series, names: Sequence[str]) -> list[list[Interval]]:
    """Per clip, those of its actions that bear one of the names."""
    spelt = set(map(_spelt, names))
    return [[act for act in of_clip if _spelt(act["name"]) in spelt] for of_clip in actions]


def _spelt(name: str) -> str:
    return name.strip().replace(" ", "_")


def _drop_duplicates(found: Findings, clips: pd.DataFrame, max_overlap: float) -> None:
    """Duplicates among the clips that are left; the others are told that they are some, too."""
    gone = ~found.free
    again = duplicates(clips[~gone], max_overlap).set_index("clip_id").reindex(clips["clip_id"])
    share, stays = again["share"].to_numpy(), again["stays"].to_numpy(object)
    found.drop(
        "duplicate",
        again["share"].notna(),
        share,
        max_overlap,
        "of time and box",
        lambda rows: [f"{clip_id} stays" for clip_id in stays[rows]],
    )
    besides = duplicates(clips, max_overlap).set_index("clip_id")["stays"]
    besides = besides.reindex(clips["clip_id"]).to_numpy(object)
    rows = np.flatnonzero(gone & pd.notna(besides))
    found.add(rows, [f"{BESIDES} {clip_id}" for clip_id in besides[rows]])


def unknown(by_hand: Mapping[str, str], catalogue: Path) -> list[str]:
    """Ids of the list that no clip of the catalogue's ledger has."""
    known = set(tables.read(tables.LEDGER, catalogue, ["clip_id"])["clip_id"])
    return sorted(name for name in by_hand if not {name, name.removesuffix(FILM)} & known)
