"""Which frame of a lost clip shows why it was lost."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from mimeline import tables
from mimeline.reporting.album import Album, Shot
from mimeline.reporting.funnel import Loss

SIZE = 144  # pixels
MOST = 60  # lost clips of a stage that are all shown; of more, the first of each rule
MOST_STILLS = 16  # of clips that were never cut: each has to be looked up in its source


def evidence(
    losses: Sequence[Loss],
    motions: Sequence[str | Path],
    lengths: Mapping[str, int],
    album: Album,
) -> dict[str, Shot]:
    """Ask the album for a picture of each lost clip; returns clip → shot.

    motions: `motion` tables, for the frame in which a head turns farthest. lengths: clip → frames
    of its video. It is the first frame that broke the rule, or the middle of a video of which no
    frame did; of a clip that was never cut, the album's still.
    """
    wanted = _few(losses)
    farthest = _farthest({loss.clip_id for loss in wanted if loss.rule == "turned"}, motions)
    shots = {}
    for loss in wanted:
        length = lengths.get(loss.clip_id)
        if loss.span:
            frame = farthest.get(loss.clip_id, loss.span[0])
        elif length:
            frame = length // 2
        else:
            continue
        frame = min(frame, length - 1) if length else frame
        shots[loss.clip_id] = album.ask(loss.clip_id, frame, SIZE)
    stills = [loss for loss in losses if loss.clip_id in album.stills.keys() - shots.keys()]
    for loss in _varied(stills)[:MOST_STILLS]:
        shots[loss.clip_id] = album.ask(loss.clip_id, None, SIZE)
    return shots


def _few(losses: Sequence[Loss]) -> list[Loss]:
    crowd = Counter(loss.stage for loss in losses)
    seen, few = set(), []
    for loss in losses:
        key = (loss.stage, loss.rule)
        if crowd[loss.stage] <= MOST or key not in seen:
            few.append(loss)
        seen.add(key)
    return few


def _varied(losses: Sequence[Loss]) -> list[Loss]:
    """The first of each rule, then the second of each, and so on."""
    rules: Counter = Counter()
    turns = []
    for loss in losses:
        turns.append(rules[loss.stage, loss.rule])
        rules[loss.stage, loss.rule] += 1
    return [loss for _, loss in sorted(zip(turns, losses, strict=True), key=lambda pair: pair[0])]


def _farthest(clips: set[str], motions: Sequence[str | Path]) -> dict[str, int]:
    """Clip → the frame of its largest |yaw|."""
    found: dict[str, int] = {}
    if not clips:
        return found
    for path in motions:
        rows = tables.read(tables.MOTION, path, ["clip_id", "frame", "head_yaw_left"])
        rows = rows[rows["clip_id"].isin(clips)].dropna(subset=["head_yaw_left"])
        at = rows["head_yaw_left"].abs().groupby(rows["clip_id"]).idxmax()
        found |= dict(zip(at.index, rows.loc[at, "frame"].astype(int), strict=True))
    return found
