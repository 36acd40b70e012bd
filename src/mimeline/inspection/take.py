"""A take of any format: its clock, its channels, what moves and what was lost."""

import re
from collections import defaultdict
from fractions import Fraction
from pathlib import Path

import numpy as np

from mimeline.config.trackers import OF_FACE_MODELS
from mimeline.errors import MimelineError
from mimeline.inspection.inspection import Inspection, Range
from mimeline.inspection.options import Options
from mimeline.inspection.recognise import recognised, video_of
from mimeline.media.limits import Limits
from mimeline.media.probe import probe
from mimeline.tracking import firewall, loss
from mimeline.tracking.matching import TOLERANCE, Result, of_another_film
from mimeline.tracking.origins import UNTOLD
from mimeline.tracking.readers import READERS
from mimeline.tracking.take import Take
from mimeline.vocabulary import CHANNELS, DEAD_RANGE

STRETCHES = 10  # that a take is cut into to show its course, at most
SAME_RATE = 0.01  # frames a second
NOT_CHECKED = {  # what the firewall may have no means to check, and why
    "sides": "nothing moves enough, or nothing to compare with",
    "unit of angles": "no head angles, and nothing to compare the gaze with",
}
POOR = 0.5  # quality of a mapped channel, below which it is named


def inspect_take(path: Path, format: str, options: Options) -> Inspection:
    """Read a take as a run would, and tell what is in it, or why it cannot be read."""
    tracker = options.tracker(format)
    seen = Inspection(path, tracker.reader.convention.title, numbers={"format": format})
    try:
        result = Result.read(tracker, path, options.ingest["max_loss"])
    except MimelineError as error:
        seen.error = " ".join(filter(None, (str(error), _looks_like(path, format, options))))
        return seen
    take = result.take
    findings = firewall.examine(take, tracker.reader.convention.first_frame)
    if options.ingest["mirrored"] and format in OF_FACE_MODELS:
        seen.problems.append(f"ingest.mirrored: coefficients as of {format} have no sides")
    elif options.ingest["mirrored"]:
        take = take.mirrored()
    _clock(seen, take, format, options)
    if zero := int(result.zero.sum()):
        seen.facts["without face"] += f"; {zero} of them since every coefficient is 0"
    _channels(seen, take)
    _beside(seen, take)
    _failsafe(seen, take, options)
    for finding in findings:
        where = _frames(finding.first_frame, finding.last_frame)
        listed = seen.problems if finding.severity == "fail" else seen.notes
        listed.append(f"{finding.detail} ({where})" if where else finding.detail)
    _not_checked(seen, result.take)
    if video := video_of(path, options):
        _compare(seen, take, video, options)
    if other := _looks_like(path, format, options):
        (seen.problems or seen.notes).append(other)
    return seen


def _looks_like(path: Path, format: str, options: Options) -> str:
    """The format that a take seems to have where it is read as another; else nothing."""
    found = recognised(path, options)
    if found in (None, format):
        return ""
    title = READERS[found].convention.title
    return f"It looks like another format, {title}: ingest.format: {found}"


def _not_checked(seen: Inspection, take: Take) -> None:
    """What could not be checked, which is not the same as fine."""
    told = firewall.tells(take) if take.motion["valid"].any() else frozenset()
    idle = [] if "sides_swapped" in told else ["sides"]
    angles = [name for name in seen.numbers["measured"] if CHANNELS[name].unit == "rad"]
    if angles and "angle_unit" not in told:
        idle.append("unit of angles")
    if idle:
        texts = [f"{what} ({NOT_CHECKED[what]})" for what in idle]
        seen.notes.append(f"not checked: {', '.join(texts)}")
    seen.numbers["not_checked"] = idle


def _clock(seen: Inspection, take: Take, format: str, options: Options) -> None:
    """Frames, their rate, where they begin and what is missing of them."""
    n_frames, seconds = len(take.motion), float(len(take.motion) / take.fps)
    said = Fraction(options.ingest[format]["fps"]) / options.ingest[format].get("stride", 1)
    whence = "as told" if options.knows_fps(format) else "assumed; else --set fps=…"
    whence = whence if take.fps == said else "as the file says"
    first = f", counted from {take.first_frame}" if take.first_frame is not None else ""
    seen.facts["frames"] = f"{n_frames}{first}"
    seen.facts["length"] = f"{seconds:.1f} s at {_rate(take.fps)} fps ({whence})"
    valid = take.motion["valid"].to_numpy(bool)
    gone = _runs(~valid)
    lost = sum(end - start for start, end in gone)
    seen.facts["without face"] = "none"
    if gone:
        step = np.gcd.reduce(np.flatnonzero(valid))
        start, end = max(gone, key=lambda gap: gap[1] - gap[0])
        share = f"{_count(lost, 'frame')}, {100 * lost / n_frames:.1f} %"
        seen.facts["without face"] = (
            f"{share}, in {_count(len(gone), 'gap')}, the longest: {_frames(start, end - 1)}"
        )
        limit = options.ingest["max_missing"]
        if step > 1 and "stride" in options.ingest[format]:
            seen.problems.append(
                f"only 1 frame in {step} has a face: --set stride={step} where the tracker "
                "passed over the frames between"
            )
        elif lost > limit * n_frames:
            seen.problems.append(
                f"{100 * lost / n_frames:.0f} % of the frames have no face, more than the "
                f"{100 * limit:g} % of ingest.max_missing: the clip would be dropped"
            )
    seen.numbers |= {
        "frames": n_frames,
        "fps": str(take.fps),
        "seconds": seconds,
        "first_frame": take.first_frame,
        "without_face": lost,
        "gaps": [[int(start), int(end)] for start, end in gone],
    }


def _channels(seen: Inspection, take: Take) -> None:
    """Which channels there are, how they were had, and what they do."""
    measured = [name for name in CHANNELS if take.motion[name].notna().any()]
    origins = {name: take.origins.get(name, UNTOLD) for name in CHANNELS}
    regions: dict[str, list[bool]] = defaultdict(list)
    for name in CHANNELS:
        regions[_region(name)].append(name in measured)
    parts = [f"{region} {sum(has)}/{len(has)}" for region, has in regions.items()]
    seen.facts["channels"] = f"{len(measured)} of {len(CHANNELS)} · {' · '.join(parts)}"
    quality = {n: q for n in measured if (q := origins[n].quality) is not None}
    if quality:
        low, high = min(quality.values()), max(quality.values())
        seen.facts["mapped"] = f"{_count(len(quality), 'channel')}, quality {low:.2f} to {high:.2f}"
        if poor := [name for name, value in quality.items() if value < POOR]:
            seen.notes.append(f"mapped with a quality below {POOR}: {', '.join(poor)}")
    for name in measured:
        seen.ranges.append(_range(name, take.motion[name].to_numpy(np.float64)))
    if dead := [r.channel for r in seen.ranges if r.dead]:
        seen.notes.append(
            f"{_count(len(dead), 'channel')} hardly moving, by less than {DEAD_RANGE}: dotted above"
        )
    why: dict[str, list[str]] = defaultdict(list)
    for name in CHANNELS:
        if name not in measured:
            told = origins[name]
            why["no number in any frame" if told.measured else told.text].append(name)
    for reason, names in why.items():
        reason = reason.removeprefix("not measured, ")
        seen.notes.append(f"not measured, {reason}: {_named(names)}")
    seen.numbers |= {"measured": measured, "quality": quality, "dead": dead, "absent": dict(why)}


def _beside(seen: Inspection, take: Take) -> None:
    """What else the take holds: other representations, the tracker's own confidence and loss."""
    held = {
        name: rows
        for name, rows in take.coefficients.items()
        if len(rows) and rows.notna().to_numpy().any()
    }
    if held:
        parts = [f"{name} ({int(rows.notna().any().sum())} columns)" for name, rows in held.items()]
        seen.facts["also holds"] = ", ".join(parts)
    told = take.motion["confidence"].dropna()
    if len(told):
        seen.facts["confidence"] = f"{told.mean():.2f} on average, {told.min():.2f} at least"
    values = take.motion["tracker_loss"].dropna()
    if len(values):
        what = f" ({take.loss})" if take.loss else ""
        seen.facts["tracking loss"] = (
            f"{values.mean():.3g} on average, {values.max():.3g} at most{what}"
        )
    else:
        seen.facts["tracking loss"] = "not told"
    seen.numbers["also_holds"] = list(held)


def _failsafe(seen: Inspection, take: Take, options: Options) -> None:
    """Whether a frame's tracking loss would drop the clip, or why nobody can say."""
    limits = options.ingest["max_loss"], options.ingest["max_reprojection"]
    if facts := loss.broken(take, *limits):
        seen.problems.append(
            f"tracking loss of {facts['value']:.3g} in frame {facts['first_frame']}, more than "
            f"{facts['limit']:g} {facts['unit'] or ''}: the clip would be dropped"
        )
    elif take.loss and (why := loss.not_applied(take, *limits)):
        seen.notes.append(f"the limit of the tracking loss is {why}")


def _compare(seen: Inspection, take: Take, video: Path, options: Options) -> None:
    """Hold a take against the video that bears its name: does a run find them of one length?"""
    try:
        found = probe(video, Limits())
    except MimelineError as error:
        seen.notes.append(f"the video of that name cannot be read: {error}")
        return
    seen.facts["video"] = f"{video.name}: {found.n_frames} frames at {_rate(found.rate)} fps"
    frames, film_fps = len(take.motion), options.film_fps or take.fps
    same_rate = abs(found.rate - film_fps) < SAME_RATE
    n_film = found.n_frames if same_rate else round(found.duration_s * film_fps)
    hint = ""
    if abs(found.rate - take.fps) > SAME_RATE:
        seen.notes.append(
            f"the video of that name has {_rate(found.rate)} frames a second, the take "
            f"{_rate(take.fps)}"
        )
        if abs(frames - found.n_frames) <= TOLERANCE:
            hint = f"; as many frames as the video has at its own rate: --set fps={found.rate}?"
    if wrong := of_another_film(take, film_fps, n_film):
        _, facts = wrong
        seen.problems.append(
            f"{facts['detail']} ({_count(frames, 'frame')}, {video.name} comes to {n_film}{hint})"
        )
    elif frames != n_film:
        more = "more" if frames > n_film else "fewer"
        seen.notes.append(
            f"{_count(abs(frames - n_film), 'frame')} {more} than the video of that name{hint}"
        )


def _range(name: str, values: np.ndarray) -> Range:
    """values: (n,), NaN where not measured."""
    known = values[~np.isnan(values)]
    low, mean, high = (float(f(known)) for f in (np.min, np.mean, np.max))
    angle = CHANNELS[name].unit == "rad"
    rest = mean if angle else 0.0
    course = [
        float(there[np.argmax(np.abs(there - rest))]) if len(there) else None
        for part in np.array_split(values, min(STRETCHES, len(values)))
        for there in [part[~np.isnan(part)]]
    ]
    return Range(name, low, mean, high, angle, high - low < DEAD_RANGE, course)


def _frames(first: int | None, last: int | None) -> str:
    """A stretch of frames, both included; nothing where it is not told."""
    if first is None or last is None:
        return ""
    return f"frame {first}" if first == last else f"frames {first}–{last}"


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """Half-open stretches in which flags (n,) bool are set."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _named(channels: list[str]) -> str:
    """Channels; a region of several by its name alone where it is there as a whole."""
    regions: dict[str, list[str]] = defaultdict(list)
    for name in CHANNELS:
        regions[_region(name)].append(name)
    whole = [r for r, names in regions.items() if len(names) > 1 and set(names) <= set(channels)]
    parts = [f"all of {', '.join(whole)}"] if whole else []
    parts += [", ".join(rest)] if (rest := [n for n in channels if _region(n) not in whole]) else []
    return "; ".join(parts)


def _region(channel: str) -> str:
    """brow, eye, cheek, nose, jaw, mouth, tongue, gaze or head."""
    return re.match("[a-z]+", channel)[0]


def _rate(fps: Fraction) -> str:
    return f"{float(fps):.5g}"


def _count(n: int, word: str) -> str:
    return f"{n} {word}" if n == 1 else f"{n} {word}s"
