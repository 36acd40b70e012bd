"""How much each part of the data holds, of how many sources and people."""

from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction

import pandas as pd

from mimeline.dataset.split import PARTS
from mimeline.dataset.windows import Clip


def part_sizes(
    clips: pd.DataFrame, split: pd.DataFrame, usable: Mapping[str, Sequence[Clip]], window: int
) -> pd.DataFrame:
    """A row per part, indexed by it: train, val, test.

    clips, split: the tables of these names. usable: of each part, what training makes of it.
    window: frames.

    Returns clips (in the split) and unusable (of them: without a valid frame); frames, invalid
    (share of them) and hours of the usable ones; sources, persons (those that are known);
    windows: places where a window can begin; short: usable clips shorter than a window.
    """
    known = split.merge(clips, on="clip_id", how="left").set_index("clip_id")
    rows = {}
    for part in PARTS:
        own, used = known[known["part"] == part], usable[part]
        frames = sum(len(clip.valid) for clip in used)
        valid = sum(int(clip.valid.sum()) for clip in used)
        seconds = pd.Series({clip.clip_id: len(clip.valid) for clip in used}, dtype="float64")
        seconds *= (own["fps_den"] / own["fps_num"]).reindex(seconds.index).astype("float64")
        rows[part] = {
            "clips": len(own),
            "unusable": len(own) - len(used),
            "frames": frames,
            "invalid": 1 - valid / frames if frames else 0.0,
            "hours": seconds.sum() / 3600,
            "sources": own["source_id"].nunique(),
            "persons": own["subject_id"].nunique(),
            "windows": sum(max(len(clip.valid) - window, 0) + 1 for clip in used),
            "short": sum(len(clip.valid) < window for clip in used),
        }
    return pd.DataFrame.from_dict(rows, orient="index")


def times_seen(train: Sequence[Clip], window: int, batch: int, steps: int) -> float:
    """How often a training sees each frame, on average; 0 without frames.

    A clip is drawn by its valid frames, and of a clip shorter than the window all is seen.
    """
    frames = sum(len(clip.valid) for clip in train)
    weights = [int(clip.valid.sum()) for clip in train]
    if not frames:
        return 0.0
    seen = [
        weight * min(len(clip.valid), window) for weight, clip in zip(weights, train, strict=True)
    ]
    return steps * batch * sum(seen) / sum(weights) / frames


def frame_rates(clips: pd.DataFrame, train: Sequence[Clip]) -> Counter[Fraction]:
    """How many training clips have each frame rate, of those where it is known."""
    own = clips[clips["clip_id"].isin([clip.clip_id for clip in train])]
    known = own.dropna(subset=["fps_num", "fps_den"])
    return Counter(Fraction(int(c.fps_num), int(c.fps_den)) for c in known.itertuples())
