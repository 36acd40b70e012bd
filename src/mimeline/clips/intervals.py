"""What is told of stretches of a clip: name, start_s and end_s within it, uncertainty_s."""

import math
from collections import defaultdict
from collections.abc import Iterable

Interval = dict[str, str | float | None]  # as the table `clips` has them in actions and emotions


def over(name: str, length: float) -> Interval:
    """What holds for a whole clip of so many seconds, where nobody says when."""
    return {"name": name, "start_s": 0.0, "end_s": length, "uncertainty_s": None}


def placed(
    told: Iterable[tuple[str, float, float]], length: float, uncertainty_s: float
) -> tuple[list[Interval], list[str]]:
    """Intervals of a clip, clamped to it, and in words those that lie outside of it.

    told: name, begin and end in seconds from the clip's start. length: the clip's seconds.
    uncertainty_s: how far an edge may lie elsewhere; what is outside by no more is its edge.
    Raises ValueError where an end is before its begin, or either is no number.
    """
    inside: list[Interval] = []
    outside = []
    for name, since, until in told:
        if not since <= until:
            raise ValueError(f"{name} from {since:g} to {until:g} s")
        if since > length + uncertainty_s or until < -uncertainty_s:
            outside.append(f"{name} {since:.5g} to {until:.5g} s")
            continue
        since, until = (min(max(edge, 0.0), length) for edge in (since, until))
        edges = {"start_s": since, "end_s": until, "uncertainty_s": uncertainty_s}
        inside.append({"name": name, **edges})
    return inside, outside


def between(
    intervals: Iterable[Interval], since: float, until: float, last: bool
) -> list[Interval]:
    """What of the intervals may lie from since to until seconds, as seconds from since.

    One that is outside by less than it is uncertain is an edge, as in `placed`. One whose times are
    certain and that has no length belongs to the stretch that it begins; at the very end to the
    last one.
    """
    length, found = until - since, []
    for interval in intervals:
        start, end = interval["start_s"] - since, interval["end_s"] - since
        give = interval["uncertainty_s"] or 0.0
        if start == end and not give:
            inside = 0 <= start < length or (last and start == length)
        else:
            inside = end + give > 0 and start - give < length
        if inside:
            start, end = (min(max(edge, 0.0), length) for edge in (start, end))
            found.append(interval | {"start_s": start, "end_s": end})
    return found


def longest(intervals: Iterable[Interval]) -> str | None:
    """The name that is shown for the most seconds in all; None where there is none."""
    seconds: dict[str, float] = defaultdict(float)
    for interval in intervals:
        seconds[interval["name"]] += interval["end_s"] - interval["start_s"]
    return max(seconds, key=seconds.__getitem__, default=None)


def timed(interval: Interval) -> str:
    """The name with its seconds, where they are known: `turn 2–3 s ± 1`."""
    since, until, give = (interval.get(key) for key in ("start_s", "end_s", "uncertainty_s"))
    if any(second is None or math.isnan(second) for second in (since, until)):
        return interval["name"]
    about = f" ± {give:g}" if give and not math.isnan(give) else ""
    return f"{interval['name']} {since:.3g}–{until:.3g} s{about}"


def outside_clip(told: list[str]) -> list[tuple[str, dict]]:
    """The ledger's note on intervals that were left out of a clip; none where there are none."""
    facts = {"value": len(told), "unit": "intervals", "detail": "; ".join(told)}
    return [("outside_clip", facts)] if told else []
