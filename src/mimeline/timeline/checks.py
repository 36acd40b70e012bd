"""Whether what a file says is a timeline: every problem of it, and the Timeline it makes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from mimeline.timeline.clock import MOST_FRAMES, nearest_frame
from mimeline.timeline.draft import Draft, DraftInterval, Problem, nearest, shown, tier_name
from mimeline.timeline.timeline import SIDES, Interval, Timeline, overlaps
from mimeline.vocabulary import ACTIONS, NEUTRAL, TRACKS, track_actions

SHORTEST = 2  # frames: an interval of fewer is rather a slip than an action
ON_GRID_S = Fraction(1, 1000)  # as far from a frame's start as a time in milliseconds may lie
SLACK_S = Fraction(1, 10)  # what sound may last longer than its picture


@dataclass(frozen=True)
class Judgement:
    """timeline: None where there is an error. problems: errors first, each in the file's order."""

    timeline: Timeline | None
    problems: tuple[Problem, ...]


def judge(
    draft: Draft,
    name: str,
    fps: Fraction | None = None,
    n_frames: int | None = None,
    shortest: int | None = None,
) -> Judgement:
    """What is wrong with a draft, and the Timeline that it makes where nothing is.

    name: what the clip is called where the file does not tell. fps, n_frames: what the user says of
    it. shortest: frames; an interval of fewer is warned of, as are other likely slips; None: slips
    are not looked for.
    """
    rate = draft.fps or fps
    length, length_problems = _length(draft, rate, n_frames)
    entries, name_problems = _well_named(draft)
    problems = [
        *draft.problems,
        *_rate_problems(draft, fps),
        *length_problems,
        *_size_problems(length),
        *name_problems,
    ]
    by_track: dict[str, list[_Placed]] = {track: [] for track in TRACKS}
    if rate is not None or not draft.in_seconds:
        for entry in entries:
            placed = _Placed(entry, rate if draft.in_seconds else None)
            if entry.end == draft.seconds and length is not None:
                placed.end = length  # what lasts to the end of the sound lasts to that of the clip
            by_track[placed.track].append(placed)
        problems += _overlap_problems(by_track)
        by_track = {t: [p for p in by_track[t] if p.entry.action != NEUTRAL] for t in TRACKS}
        problems += _frame_problems(by_track, length)
        problems += [] if shortest is None else _slips(by_track, shortest)
    problems.sort(key=lambda problem: problem.severity != "error")
    if problems and problems[0].severity == "error":
        return Judgement(None, tuple(problems))
    measured = {*draft.tracks, *map(_track, entries)}
    tracks = {t: [placed.interval() for placed in by_track[t]] for t in TRACKS if t in measured}
    return Judgement(Timeline(draft.clip_id or name, rate, length, tracks), tuple(problems))


class _Placed:
    """A draft's interval on the frame grid. fps: None where its times are frames already."""

    def __init__(self, entry: DraftInterval, fps: Fraction | None):
        self.entry, self.fps = entry, fps
        self.track, self.side = _track(entry), entry.side
        self.start, self.end = entry.start, entry.end
        if fps is not None:
            self.start, self.end = (nearest_frame(t, fps) for t in (entry.start, entry.end))

    @property
    def tier(self) -> str:
        return tier_name(self.track, self.side)

    @property
    def off_grid(self) -> tuple[Fraction, Fraction]:
        """Seconds from each edge to the start of a frame; 0 where its times are frames."""
        if self.fps is None:
            return Fraction(0), Fraction(0)
        start, end = self.start / self.fps, self.end / self.fps
        return abs(self.entry.start - start), abs(self.entry.end - end)

    def interval(self) -> Interval:
        entry = self.entry
        return Interval(
            entry.action,
            self.start,
            self.end,
            entry.side,
            entry.source,
            entry.cluster,
            entry.confidence,
        )

    def __str__(self) -> str:
        return f"{self.entry.action} on {self.tier} over frames {self.start} to {self.end}"


def _unknown_track(place: str, track: str) -> Problem:
    """The problem of a name that is no track's."""
    close = nearest(track, TRACKS)
    return Problem(
        place,
        found=f"track {shown(track)}",
        expected=f"one of {', '.join(TRACKS)}",
        remedy=f"Did you mean {close}?" if close else "Name one of these tracks.",
    )


def _track(entry: DraftInterval) -> str:
    return ACTIONS[entry.action].track if entry.track is None else entry.track


def _well_named(draft: Draft) -> tuple[list[DraftInterval], list[Problem]]:
    """The intervals whose names are known, and the problems of the others' names."""
    places = dict.fromkeys(draft.tracks, "")
    places |= {entry.track: entry.place for entry in reversed(draft.intervals)}
    unknown = {t: place for t, place in places.items() if t is not None and t not in TRACKS}
    problems = [_unknown_track(place, track) for track, place in unknown.items()]
    good, judged = [], {}  # names are few, and those that are wrong cost time
    for entry in draft.intervals:
        if entry.track in unknown:
            continue
        name = entry.track, entry.side, entry.action
        if name not in judged:
            judged[name] = _name_problem(entry)
        if judged[name] is None:
            good.append(entry)
        else:
            problems.append(replace(judged[name], place=entry.place))
    return good, problems


def _name_problem(entry: DraftInterval) -> Problem | None:
    if entry.action == NEUTRAL and entry.track is not None:
        return None
    if entry.action not in ACTIONS:
        known = ACTIONS if entry.track is None else track_actions(entry.track)
        close = nearest(entry.action, known) or nearest(entry.action, ACTIONS)
        return Problem(
            entry.place,
            found=f"action {shown(entry.action)}" if entry.action.strip() else "no action",
            expected=f"one of {', '.join(known)}",
            remedy=f"Did you mean {close}?" if close else "Name one of these actions.",
        )
    home = ACTIONS[entry.action].track
    if entry.track in (None, home):
        return None
    return Problem(
        entry.place,
        found=f"{entry.action} on {tier_name(entry.track, entry.side)}",
        expected=f"one of {', '.join(track_actions(entry.track))}",
        remedy=f"Move it to {tier_name(home, entry.side)}.",
    )


def _rate_problems(draft: Draft, fps: Fraction | None) -> Iterator[Problem]:
    if draft.fps is None and fps is None:
        yield Problem(
            "",
            found="no frame rate",
            expected="frames per second: this file does not tell them",
            remedy="Say the clip's own: --fps RATE, such as 25 or 30000/1001.",
        )
    if draft.fps is not None and fps is not None and draft.fps != fps:
        yield Problem(
            "",
            found=f"{draft.fps} frames per second",
            expected=f"{fps}, as you said",
            remedy="Leave --fps out, or mend the file.",
        )


def _length(
    draft: Draft, fps: Fraction | None, said: int | None
) -> tuple[int | None, list[Problem]]:
    """How many frames the clip has: as the file tells, else as said, else by its seconds."""
    told, seconds = draft.n_frames, draft.seconds
    if told is None and said is None and seconds is None:
        problem = Problem(
            "",
            found="no length",
            expected="how many frames the clip has: this file does not tell",
            remedy="Say it: --frames N.",
        )
        return None, [problem]
    if told is not None:
        return told, [] if said in (None, told) else [_other_length(f"{told} frames", said)]
    if fps is None or seconds is None:
        return said, []
    length = nearest_frame(seconds, fps) if said is None else said
    off, lasts = abs(seconds - length / fps), f"a length of {float(seconds):.3f} s"
    if said is not None:
        return length, [_other_length(lasts, said)] if off > SLACK_S else []
    if off <= ON_GRID_S:
        return length, []
    problem = Problem(
        "",
        found=lasts,
        expected=f"whole frames at {fps} per second",
        remedy=f"It is taken for {length} frames: say --frames if that is wrong.",
        severity="warning",
    )
    return length, [problem]


def _size_problems(n_frames: int | None) -> Iterator[Problem]:
    if n_frames is not None and not 0 <= n_frames <= MOST_FRAMES:
        yield Problem(
            "",
            found=f"a length of {shown(str(n_frames))} frames",
            expected="as many as the clip has, 0 or more",
            remedy="Say it: --frames N, or mend the file.",
        )


def _other_length(found: str, said: int) -> Problem:
    return Problem(
        "",
        found=found,
        expected=f"{said} frames, as you said",
        remedy="See that it is the file of this clip and that the frame rate is right.",
    )


def _span_problems(entry: _Placed, n_frames: int | None) -> Iterator[Problem]:
    drawn = entry.entry
    if drawn.start >= drawn.end:
        how = "empty" if drawn.start == drawn.end else "reversed"
        yield Problem(
            drawn.place,
            found=f"{entry}, which is {how}",
            expected="an end after the start",
            remedy="Move an edge, or take the interval out.",
        )
    elif entry.start == entry.end:
        yield Problem(
            drawn.place,
            found=f"{drawn.action} on {entry.tier} that lasts {_ms(drawn.end - drawn.start)}",
            expected=f"at least a frame: {_ms(1 / entry.fps)}",
            remedy="Draw it longer, or take it out.",
        )
    elif entry.start < 0 or (n_frames is not None and entry.end > n_frames):
        clip = "a clip that starts at 0" if n_frames is None else f"frames 0 to {n_frames}"
        yield Problem(
            drawn.place,
            found=str(entry),
            expected=f"an interval within the clip, {clip}",
            remedy="Cut it, or see that frame rate and length are the clip's.",
        )


def _frame_problems(
    by_track: Mapping[str, list[_Placed]], n_frames: int | None
) -> Iterator[Problem]:
    """What is wrong with where the actions lie."""
    entries = [entry for placed in by_track.values() for entry in placed]
    for entry in entries:
        yield from _span_problems(entry, n_frames)
    yield from _grid_problems(entries)


def _overlap_problems(by_track: Mapping[str, list[_Placed]]) -> Iterator[Problem]:
    """What shares frames on a track, neutral as well; puts each track's in the order of time."""
    for placed in by_track.values():
        placed.sort(key=lambda entry: (entry.start, entry.end))
        for earlier, entry in overlaps([e for e in placed if e.start < e.end]):
            after = f"{earlier} ({earlier.entry.place})"
            yield Problem(
                entry.entry.place,
                found=str(entry),
                expected=f"a start at {earlier.end} or later, after {after}",
                remedy="Intervals of a track exclude each other: move an edge, or take one out.",
            )


def _grid_problems(placed: Sequence[_Placed]) -> Iterator[Problem]:
    off = [entry for entry in placed if max(entry.off_grid) > ON_GRID_S]
    if off:
        farthest = max(off, key=lambda entry: max(entry.off_grid))
        n_edges = sum(edge > ON_GRID_S for entry in off for edge in entry.off_grid)
        advice = "see that the frame rate is the clip's."
        if n_edges > len(placed) > 1:
            advice = "more than half of all edges are off, so it probably has another rate."
        more = f", and {len(off) - 1} more intervals off the frames" if len(off) > 1 else ""
        yield Problem(
            farthest.entry.place,
            found=f"an edge {_ms(max(farthest.off_grid))} from a frame's start{more}",
            expected=f"edges on the starts of frames at {farthest.fps} per second",
            remedy=f"Each is taken for the nearest frame: {advice}",
            severity="warning",
        )


def _slips(by_track: Mapping[str, Sequence[_Placed]], shortest: int) -> Iterator[Problem]:
    for placed in by_track.values():
        for entry in placed:
            if 0 < entry.end - entry.start < shortest:
                yield Problem(
                    entry.entry.place,
                    found=str(entry),
                    expected=f"an interval of {shortest} frames or more",
                    remedy="See whether it is a slip.",
                    severity="warning",
                )
        halves = ([e for e in placed if e.side in (None, half)] for half in SIDES)
        pairs = dict.fromkeys(pair for half in halves for pair in pairwise(half))
        yield from filter(None, (_neighbours(*pair) for pair in pairs))


def _neighbours(before: _Placed, after: _Placed) -> Problem | None:
    gap = after.start - before.end
    if gap == 1:
        found, expected = f"a gap of one frame after {before}", "none, or a longer one"
    elif gap == 0 and (before.entry.action, before.side) == (after.entry.action, after.side):
        found, expected = (
            f"{after}, which touches one of the same action",
            "one interval of the two",
        )
    else:
        return None
    remedy = "See whether it is a slip."
    return Problem(after.entry.place, found, expected, remedy, severity="warning")


def _ms(seconds: Fraction) -> str:
    return f"{float(1000 * seconds):.1f} ms"
