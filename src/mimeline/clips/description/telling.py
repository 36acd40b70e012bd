"""How much of a busy clip is told: no more stretches and words than a reader, or CLIP, takes in."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from mimeline.clips.description.stretches import SAME_S, Run, Stretch, stretches

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
    the stretch that holds their middle: as few of them as will do. What is then too long to tell in
    passing is left out, what is told elsewhere in the clip first, then the shortest.

    all_runs: as `stretches.runs` gives them. n_words: of what is said of an action.
    """

    by_length = sorted(all_runs, key=lambda run: (run.seconds, run))
    n_short = sum(run.seconds < min_s - SAME_S for run in by_length)

    def cut(n_passing: int) -> list[Stretch]:
        passing, lasting = sorted(by_length[:n_passing]), by_length[n_passing:]
        return stretches(lasting, passing, duration_s, min_s, rank)

    def fits(n_passing: int) -> bool:
        parts = cut(n_passing)
        lasting = [part._replace(passing=()) for part in parts]
        return len(parts) <= max_stretches and _length(lasting, n_words) <= max_words

    fewest = n_short
    if not fits(n_short):
        fewest = bisect_left(range(len(all_runs)), True, lo=n_short + 1, key=fits)
    return [_around_passing(part, min_s) for part in _shortened(cut(fewest), max_words, n_words)]


def _length(parts: Sequence[Stretch], n_words: Callable[[str], int]) -> int:
    said = sum(n_words(name) + 1 for part in parts for name in _names(part))
    return said + FRAME_WORDS * len(parts)


def _names(part: Stretch) -> list[str]:
    return [*part.throughout, *dict.fromkeys(run.name for run in part.passing)]


def _shortened(
    parts: list[Stretch], max_words: int, n_words: Callable[[str], int]
) -> list[Stretch]:
    too_long = _length(parts, n_words) - max_words
    if too_long <= 0:
        return parts
    times_told = Counter(name for part in parts for name in _names(part))
    seconds: dict[tuple[int, str], float] = {}
    for number, part in enumerate(parts):
        for run in part.passing:
            seconds[number, run.name] = seconds.get((number, run.name), 0.0) + run.seconds
    left_out: set[tuple[int, str]] = set()
    most_left_out = min(len(seconds), times_told.total() - 1)  # something is told
    while too_long > 0 and len(left_out) < most_left_out:
        _, _, number, name = min(
            (times_told[name] == 1, seconds[number, name], number, name)
            for number, name in seconds.keys() - left_out
        )
        left_out.add((number, name))
        times_told[name] -= 1
        too_long -= n_words(name) + 1
    kept = [
        part._replace(
            passing=tuple(run for run in part.passing if (number, run.name) not in left_out)
        )
        for number, part in enumerate(parts)
    ]
    return [part for part in kept if part.throughout or part.passing]


def _around_passing(part: Stretch, min_s: float) -> Stretch:
    """Where nothing lasts, the stretch is no longer than what passes in it, give or take min_s."""
    if part.throughout:
        return part
    first = min(run.start_s for run in part.passing)
    last = max(run.end_s for run in part.passing)
    return part._replace(
        start_s=first if first - part.start_s >= min_s else part.start_s,
        end_s=last if part.end_s - last >= min_s else part.end_s,
    )
