"""Pairs of clips whose pictures are alike, second by second."""

import numpy as np
import pandas as pd

from mimeline.dataset.hamming import Words
from mimeline.media.fingerprint import MIRRORED

# Bits of 64 in which two pictures may differ. By benchmarks/near_duplicates.py, copies that are
# coded anew, scaled or brightened differ in 6 at most, of those cropped by a twentieth or shifted
# by half a second three in four in 8; strangers in 11 at least.
MOST_BITS = 8


def alike_films(
    fingerprints: pd.DataFrame, rates: pd.Series, groups: pd.Series, least_share: float
) -> pd.DataFrame:
    """Pairs of clips of different groups of which one shows what the other shows, in its order.

    fingerprints: the table of that name. rates: clip_id → frames per second. groups: clip_id → a
    name; clips of one group are not compared. least_share: a pair has more than that share of the
    shorter clip's pictures alike at one offset.
    Returns clip_id, other_id, share, offset_s (other's clock less clip's, seconds), mirrored.
    """
    rows = fingerprints[fingerprints["clip_id"].isin(rates.dropna().index)]
    rows = rows.sort_values(["clip_id", "frame"], kind="stable")
    words = rows["bits"].to_numpy(np.int64)
    clip, names = pd.factorize(rows["clip_id"])
    group = pd.factorize(groups[names])[0][clip]  # (n,)
    second = rows["frame"].to_numpy() / rates[names].to_numpy(float)[clip]
    n_pictures = np.bincount(clip, minlength=len(names))
    known, found = Words(words, group), []
    for mirrored, asked in ((False, words), (True, words ^ MIRRORED)):
        i, j = known.near(asked, MOST_BITS)
        pairs = pd.DataFrame(
            {
                "a": clip[i],
                "b": clip[j],
                "offset": np.rint(second[j] - second[i]).astype(int),
                "picture": np.where(n_pictures[clip[i]] <= n_pictures[clip[j]], i, j),
            }
        )
        found.append(_at_one_offset(pairs, n_pictures).assign(mirrored=mirrored))
    pairs = pd.concat(found, ignore_index=True)
    pairs = pairs[pairs["share"] > least_share]
    pairs = pairs.sort_values(["a", "b", "share"], ascending=[True, True, False], kind="stable")
    pairs = pairs.drop_duplicates(["a", "b"])
    return pairs.assign(clip_id=names[pairs["a"]], other_id=names[pairs["b"]])[
        ["clip_id", "other_id", "share", "offset_s", "mirrored"]
    ].reset_index(drop=True)


def _at_one_offset(pairs: pd.DataFrame, n_pictures: np.ndarray) -> pd.DataFrame:
    """Clips a and b with the share of the shorter one's pictures that agree on an offset.

    pairs: a, b, offset and the shorter one's picture. Pictures are a second apart, so an offset of
    half seconds shows as either neighbour: the two count as one.
    """
    both = pd.concat([pairs, pairs.assign(offset=pairs["offset"] - 1)])
    both = both.drop_duplicates(["a", "b", "offset", "picture"])
    counts = both.groupby(["a", "b", "offset"], as_index=False).size()
    counts = counts.sort_values(["a", "b", "size"], ascending=[True, True, False], kind="stable")
    best = counts.drop_duplicates(["a", "b"])
    shorter = np.minimum(n_pictures[best["a"]], n_pictures[best["b"]])
    return best.assign(share=best["size"] / shorter, offset_s=best["offset"] + 0.5)
