"""Words of 64 bits that differ in few of them, without comparing all with all.

Words that differ in at most d bits differ in at most d // 3 of one of three bands (pigeonhole).
Each band has a table of words by its value, in which all values that near are looked up.
"""

from itertools import combinations

import numba
import numpy as np

BANDS = 3
WIDTH = 22  # bits of the widest band: 64 / 3, rounded up
MOST_PARTNERS = 50  # of a word; a thousand that are all alike are tied in a chain


class Words:
    """Words that others are looked for among.

    words: (n,) int64. groups: (n,) int64; words of one group are no pair.
    """

    def __init__(self, words: np.ndarray, groups: np.ndarray):
        self.words = np.ascontiguousarray(words).view(np.uint64)
        self.groups = groups
        self._tables = [_table(self.words, band) for band in range(BANDS)] if len(words) else []

    def near(self, asked: np.ndarray, limit: int) -> tuple[np.ndarray, np.ndarray]:
        """Pairs i < j of two groups, (m,), (m,) int64: asked[i] differs from word j in at most
        limit bits.

        asked: (n,) int64, the words themselves or, for copies that are changed in a known way, the
        words so changed. A word has at most MOST_PARTNERS partners.
        """
        asked = np.ascontiguousarray(asked).view(np.uint64)
        found, flips = np.zeros(len(asked), np.int64), _flips(limit // BANDS)
        pairs = [np.empty((0, 2), np.int64)]
        for band, table in enumerate(self._tables):
            wanted = _asked(asked, band)
            pairs.append(
                _pairs_of_band(
                    self.words, asked, self.groups, found, *table, *wanted, flips, band, limit
                )
            )
        i, j = np.concatenate(pairs).T
        return i, j


def _table(words: np.ndarray, band: int) -> tuple[np.ndarray, np.ndarray]:
    """Where words with each value of a band start, (2^22 + 1,), and the words by it, (n,)."""
    key = _band(words, band)
    starts = np.zeros(2**WIDTH + 1, np.int32)
    np.cumsum(np.bincount(key, minlength=2**WIDTH), out=starts[1:])
    return starts, np.argsort(key, kind="stable")


def _asked(asked: np.ndarray, band: int) -> tuple[np.ndarray, np.ndarray]:
    """Values of a band, rising, and whose they are: so memory is read in order."""
    key = _band(asked, band)
    order = np.argsort(key, kind="stable")
    return key[order], order


def _mask(band: int) -> int:
    return sum(1 << bit for bit in range(band, 64, BANDS))


# Every third bit is of one band, so that all bands have bits that tell much and bits that do not.
MASKS = np.array([_mask(band) for band in range(BANDS)], np.uint64)


def _band(words: np.ndarray, band: int) -> np.ndarray:
    """The bits of a band, pushed together, (n,) int64."""
    key = np.zeros(len(words), np.int64)
    for place, bit in enumerate(range(band, 64, BANDS)):
        key |= ((words >> np.uint64(bit)) & np.uint64(1)).astype(np.int64) << place
    return key


def _flips(radius: int) -> np.ndarray:
    """Every change of a band in at most radius bits, the smallest first."""
    changes = [bits for r in range(radius + 1) for bits in combinations(range(WIDTH), r)]
    return np.array([sum(1 << bit for bit in bits) for bits in changes], np.int64)


@numba.njit(cache=True)
def _ones(word):
    word -= (word >> np.uint64(1)) & np.uint64(0x5555555555555555)
    pairs = np.uint64(0x3333333333333333)
    word = (word & pairs) + ((word >> np.uint64(2)) & pairs)
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (word * np.uint64(0x0101010101010101)) >> np.uint64(56)


@numba.njit(cache=True)
def _pairs_of_band(
    words, asked, groups, found, starts, by_key, wanted, by_wanted, flips, band, limit
):
    radius = limit // BANDS
    pairs, count = np.empty((1024, 2), np.int64), 0
    for flip in flips:
        for at_wanted in range(len(wanted)):
            key, i = wanted[at_wanted] ^ flip, by_wanted[at_wanted]
            for at in range(starts[key], starts[key + 1]):
                j = by_key[at]
                if j <= i or groups[j] == groups[i] or found[i] == MOST_PARTNERS:
                    continue
                differing = asked[i] ^ words[j]
                if _ones(differing) > limit:
                    continue
                known = False  # from an earlier band
                for earlier in range(band):
                    known |= _ones(differing & MASKS[earlier]) <= radius
                if known:
                    continue
                if count == len(pairs):
                    longer = np.empty((2 * count, 2), np.int64)
                    longer[:count] = pairs
                    pairs = longer
                pairs[count] = i, j
                count += 1
                found[i] += 1
    return pairs[:count].copy()
