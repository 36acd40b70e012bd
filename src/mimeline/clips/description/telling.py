"""How much of a busy clip is told: no more stretches and words than a reader, or CLIP, takes in."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Container, Mapping, Sequence

from mimeline.clips.description.stretches import (
    SAME_S,
    Run,
    Stretch,
    around_passing,
    stretches,
    without_flicker,
)

FRAME_WORDS = 7  # of a stretch beside its actions: "then she ... for a short time"


def told(
    all_runs: list[Run],
    duration_s: float,
    min_s: float,
    max_stretches: int,
    max_words: int,
    rank: Mapping[str, int],
    n_words: Callable[[str], int],
) -> list[Stretch]:
    """The stretches of a clip, at most max_stretches, told in about max_words at most.

    Where there would be more, the shortest runs no longer split time and are told in passing, in
    the stretch that holds their middle: as few of them as leave room to tell something of every
    stretch. Then as much in passing is told as there are words for: what the text does not have yet
    first, then the longest.

    all_runs: as `stretches.runs` gives them. n_words: of what is said of an action.
    """
    all_runs = without_flicker(all_runs)
    by_length = sorted(all_runs, key=lambda run: (run.seconds, run))
    n_short = sum(run.seconds < min_s - SAME_S for run in by_length)

    def cut(n_passing: int) -> list[Stretch]:
        passing, lasting = sorted(by_length[:n_passing]), by_length[n_passing:]
        return stretches(lasting, passing, duration_s, min_s, rank)

    def fits(n_passing: int) -> bool:
        parts = [_barest(part) for part in cut(n_passing)]
        return len(parts) <= max_stretches and _length(parts, n_words) <= max_words

    fewest = n_short
    if not fits(n_short):
        fewest = bisect_left(range(len(all_runs)), True, lo=n_short + 1, key=fits)
    return [around_passing(part, min_s) for part in _filled(cut(fewest), max_words, n_words)]


def _barest(part: Stretch) -> Stretch:
    """What lasts alone; where nothing does, what passes for longest."""
    seconds = {} if part.throughout else _seconds_in_passing(part)
    return _with_passing(part, {max(seconds, key=seconds.__getitem__)} if seconds else ())


def _filled(parts: list[Stretch], max_words: int, n_words: Callable[[str], int]) -> list[Stretch]:
    barest = [_barest(part) for part in parts]
    told = [set(_names(part)) for part in barest]
    anywhere = set().union(*told)
    room = max_words - _length(barest, n_words)
    longest_first = sorted(
        (-seconds, number, name)
        for number, part in enumerate(parts)
        for name, seconds in _seconds_in_passing(part).items()
    )
    for again in (False, True):
        for _, number, name in longest_first:
            due = name not in told[number] and (name in anywhere) == again
            if due and n_words(name) < room:
                told[number].add(name)
                anywhere.add(name)
                room -= n_words(name) + 1
    return [_with_passing(part, names) for part, names in zip(parts, told, strict=True)]


def _seconds_in_passing(part: Stretch) -> Counter[str]:
    seconds: Counter[str] = Counter()
    for run in part.passing:
        seconds[run.name] += run.seconds
    return seconds


def _with_passing(part: Stretch, names: Container[str]) -> Stretch:
    return part._replace(passing=tuple(run for run in part.passing if run.name in names))


def _length(parts: Sequence[Stretch], n_words: Callable[[str], int]) -> int:
    said = sum(n_words(name) + 1 for part in parts for name in _names(part))
    return said + FRAME_WORDS * len(parts)


def _names(part: Stretch) -> list[str]:
    return [*part.throughout, *dict.fromkeys(run.name for run in part.passing)]
