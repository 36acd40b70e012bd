"""Actions with their times → an ordered list of stretches, each with all that is seen in it.

Time is split wherever the set of active actions changes (Höll 2024, 5.3). Four rules keep what is
told no finer than what is known, and lose no action:

- A start no later than its uncertainty is the clip's start; an end so close to the clip's end is
  its end.
- Changes closer together than min_s, or than their uncertainty, are one change, midway between
  them; the start and the end of one action never are.
- An end is the last second in which an action was seen (Figure 5.5): where only ends are followed
  by only starts within the uncertainty, no pause is known to lie between, and they are one change.
- An action that lasts less than min_s splits nothing: it happens in passing, in the stretch that
  holds its middle; and in each in which nothing lasts and it is seen for min_s.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import pandas as pd

SAME_S = 1e-6  # seconds: what differs by less is the same time
WHOLE_S = 0.1  # seconds that a whole clip may lack: its film has whole frames
UNSEEN_S = 0.1  # seconds: a pause of an action that nobody sees, as a threshold's flicker leaves


class Run(NamedTuple):
    """A time, in seconds of the clip, in which an action goes on without a break."""

    start_s: float
    end_s: float
    name: str
    uncertainty_s: float = 0.0

    @property
    def seconds(self) -> float:
        return self.end_s - self.start_s


class Stretch(NamedTuple):
    """A part of the clip: what is seen from its start to its end, and what happens in passing."""

    start_s: float
    end_s: float
    throughout: tuple[str, ...]  # in order of start, then as the names rank
    passing: tuple[Run, ...] = ()


def is_untimed(interval: Mapping, duration_s: float) -> bool:
    """Nobody says when: an uncertainty that is null, over the whole clip. Other nulls are exact."""
    whole = interval["start_s"] <= 0 and interval["end_s"] >= duration_s - WHOLE_S
    return whole and pd.isna(interval["uncertainty_s"])


def runs(intervals: Iterable[Mapping], duration_s: float) -> list[Run]:
    """The runs of a clip's actions, sorted; those of one action neither overlap nor touch.

    intervals: name, start_s, end_s, uncertainty_s, in any order. What lies outside the clip is cut
    off. What starts and ends at the same uncertain time lasts for its uncertainty.
    """
    found = []
    for interval in intervals:
        start, end, unsure = interval["start_s"], interval["end_s"], interval["uncertainty_s"]
        if end <= start:
            start = min(start, duration_s - unsure)
            end = start + unsure
        start, end = max(0.0, start), min(duration_s, end)
        if end - start > SAME_S:
            found.append(Run(start, end, interval["name"], unsure))
    return _united(found, SAME_S)


def without_flicker(all_runs: Iterable[Run]) -> list[Run]:
    """The runs, sorted, those of one action as one where nobody sees the pause between them."""
    return _united(all_runs, UNSEEN_S)


def _united(all_runs: Iterable[Run], pause_s: float) -> list[Run]:
    united: list[Run] = []
    for run in sorted(all_runs, key=lambda run: (run.name, run)):
        last = united[-1] if united else None
        if last and last.name == run.name and run.start_s <= last.end_s + pause_s:
            unsure = max(last.uncertainty_s, run.uncertainty_s)
            united[-1] = Run(last.start_s, max(last.end_s, run.end_s), run.name, unsure)
        else:
            united.append(run)
    return sorted(united)


def stretches(
    lasting: Sequence[Run],
    passing: Sequence[Run],
    duration_s: float,
    min_s: float,
    rank: Mapping[str, int],
) -> list[Stretch]:
    """The stretches in which anything is seen, in order; what lies between them shows nothing.

    lasting: runs that split time, none shorter than min_s. passing: runs that do not, sorted. rank:
    of actions that start together, the lower is first.
    """
    lasting = [_to_edges(run, duration_s, min_s) for run in lasting]
    times = _change_times(lasting, duration_s, min_s)
    spans = [(times[run.start_s], times[run.end_s], run.name) for run in lasting]
    spans.sort(key=lambda span: (span[0], rank.get(span[2], len(rank)), span[2]))
    parts: list[Stretch] = []
    for start, end in pairwise(sorted({*times.values()})):
        active = [name for since, until, name in spans if since <= start and until >= end]
        names = tuple(dict.fromkeys(active))
        if parts and set(parts[-1].throughout) == set(names):
            parts[-1] = parts[-1]._replace(end_s=end)
        else:
            parts.append(Stretch(start, end, names))
    if passing:
        parts = [_with_passing(part, passing, part is parts[-1], min_s) for part in parts]
    return [part for part in parts if part.throughout or part.passing]


def _to_edges(run: Run, duration_s: float, min_s: float) -> Run:
    start, end = run.start_s, run.end_s
    if _same_time(start, min_s, run.uncertainty_s):
        start = 0.0
    if _same_time(duration_s - end, min_s, run.uncertainty_s):
        end = duration_s
    return Run(start, end, run.name, run.uncertainty_s)


def _same_time(apart_s: float, min_s: float, uncertainty_s: float) -> bool:
    return apart_s < min_s - SAME_S or apart_s <= uncertainty_s + SAME_S


def _change_times(lasting: Sequence[Run], duration_s: float, min_s: float) -> dict[float, float]:
    """Where each start and each end is told to be, by its time: close ones are one change."""
    starting: dict[float, list[int]] = {}
    ending: dict[float, list[int]] = {}
    unsure: dict[float, float] = {}
    for number, run in enumerate(lasting):
        starting.setdefault(run.start_s, []).append(number)
        ending.setdefault(run.end_s, []).append(number)
        for edge in (run.start_s, run.end_s):
            unsure[edge] = max(run.uncertainty_s, unsure.get(edge, 0.0))
    told = {0.0: 0.0, duration_s: duration_s}
    together: list[float] = []
    started: set[int] = set()  # by a change of these
    ended = False
    limit = 0.0
    for time in sorted(unsure.keys() - told.keys()):
        starts, ends = starting.get(time, ()), ending.get(time, ())
        limit = max(limit, unsure[time])
        if together:
            apart = time - together[0]
            no_pause = ended and not started and not ends and apart <= limit + SAME_S
            close = apart < max(min_s, limit) - SAME_S and started.isdisjoint(ends)
            if not (close or no_pause):
                told |= dict.fromkeys(together, (together[0] + together[-1]) / 2)
                together, started, ended, limit = [], set(), False, unsure[time]
        together.append(time)
        started.update(starts)
        ended = ended or bool(ends)
    return told | dict.fromkeys(together, (together[0] + together[-1]) / 2 if together else 0.0)


def around_passing(part: Stretch, min_s: float) -> Stretch:
    """Where nothing lasts, the stretch is no longer than what passes in it, give or take min_s."""
    if part.throughout or not part.passing:
        return part
    first = min(run.start_s for run in part.passing)
    last = max(run.end_s for run in part.passing)
    return part._replace(
        start_s=first if first - part.start_s >= min_s else part.start_s,
        end_s=last if part.end_s - last >= min_s else part.end_s,
    )


def _with_passing(part: Stretch, passing: Sequence[Run], last: bool, min_s: float) -> Stretch:
    inside = []
    for run in passing:
        middle = (run.start_s + run.end_s) / 2
        seen_s = min(run.end_s, part.end_s) - max(run.start_s, part.start_s)
        if (
            part.start_s <= middle < part.end_s
            or (last and middle == part.end_s)
            or (not part.throughout and seen_s >= min_s)
        ):
            inside.append(run)
    told = tuple(run for run in inside if run.name not in part.throughout)
    return part._replace(passing=told)
