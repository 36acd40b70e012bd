"""Timelines in files: read, checked and written in the formats of the field."""

import logging
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from mimeline.atomic import whole
from mimeline.errors import BadFile, NoSuchFile, unreadable
from mimeline.timeline.checks import SHORTEST, Judgement, judge
from mimeline.timeline.draft import Draft, Problem, nearest, shown
from mimeline.timeline.format import (
    CLIP,
    CLUSTER,
    CONFIDENCE,
    EMPTY,
    FORMATS,
    FPS,
    MEDIA,
    N_FRAMES,
    NEUTRAL_TRACKS,
    SOURCE,
    SUFFIXES,
    Format,
    format_of,
)
from mimeline.timeline.timeline import Timeline

__all__ = [
    "FORMATS",
    "FPS",
    "MEDIA",
    "N_FRAMES",
    "SUFFIXES",
    "draft_of",
    "drafts",
    "files_in",
    "format_of",
    "lint",
    "read",
    "read_all",
    "write",
    "write_all",
]

log = logging.getLogger(__name__)


def read(
    path: str | Path,
    fps: Fraction | None = None,
    n_frames: int | None = None,
    clip_id: str | None = None,
    format: str | None = None,
) -> Timeline:
    """The timeline of one clip.

    fps, n_frames: frames per second and frames, where the file does not tell them. clip_id: which
    clip, where the file names its clips; else what the clip is called (the file's name otherwise).
    Raises BadFile with the first of its errors, and how many there are.
    """
    draft = draft_of(path, clip_id, format)
    return _timeline(path, judge(draft, clip_id or Path(path).stem, fps, n_frames))


def read_all(
    path: str | Path,
    fps: Fraction | Mapping[str, Fraction] | None = None,
    n_frames: int | Mapping[str, int] | None = None,
    format: str | None = None,
    clips: Collection[str] | None = None,
) -> list[Timeline]:
    """The timelines of all clips of a file, in its order.

    fps, n_frames: as for read; of every clip, or by clip. clips: those that are wanted; None: all.
    Raises BadFile as read does.
    """
    there = [d for d in drafts(path, format) if clips is None or d[0] in clips]
    return [_timeline(path, judged) for judged in _judged(there, fps, n_frames)]


def draft_of(path: str | Path, clip_id: str | None = None, format: str | None = None) -> Draft:
    """What a file says of one clip, before anybody judged it. clip_id: as for read.

    Raises BadFile where the file cannot be read, does not have the clip, or has several.
    """
    there = drafts(path, format)
    names = [name for name, _ in there]
    if clip_id is not None and [draft.clip_id for _, draft in there] not in ([None], []):
        there = [(name, draft) for name, draft in there if name == clip_id]
        if not there:
            raise _no_clip(path, clip_id, names)
    if len(there) > 1:
        raise BadFile(
            path,
            found=f"{len(there)} clips, {shown(', '.join(names))}",
            expected="one",
            remedy=f"Say which one: --clip {names[0]}.",
        )
    return there[0][1] if there else Draft(None, (), in_seconds=False)


def drafts(path: str | Path, format: str | None = None) -> list[tuple[str, Draft]]:
    """What a file says of each of its clips, before anybody judged it, after the clip's name.

    A clip that the file does not name is called as the file, and by its place among several.
    Raises BadFile for a file that cannot be read.
    """
    found, stem = format_of(path, format).read(Path(path)), Path(path).stem
    places = [stem] if len(found) == 1 else [f"{stem}_{n}" for n in range(1, len(found) + 1)]
    return [(draft.clip_id or place, draft) for draft, place in zip(found, places, strict=True)]


def files_in(folder: Path) -> list[Path]:
    """The files of timelines in a folder, by their endings, sorted; hidden ones are passed over."""
    endings = {suffix.casefold() for suffix in SUFFIXES}
    there = [path for path in sorted(folder.iterdir()) if path.suffix.casefold() in endings]
    return [path for path in there if path.is_file() and not path.name.startswith(".")]


def lint(
    path: str | Path,
    fps: Fraction | Mapping[str, Fraction] | None = None,
    n_frames: int | Mapping[str, int] | None = None,
    format: str | None = None,
    shortest: int = SHORTEST,
) -> list[Problem]:
    """All that is wrong with a file, errors first; empty where nothing is.

    fps, n_frames: as for read_all. shortest: frames; an interval of fewer is warned of. A file that
    cannot be read at all has one problem. Raises NoSuchFile where there is none.
    """
    try:
        judged = _judged(drafts(path, format), fps, n_frames, shortest)
    except NoSuchFile:
        raise
    except BadFile as error:
        return [Problem(error.place, error.found, error.expected, error.remedy)]
    problems = dict.fromkeys(problem for judgement in judged for problem in judgement.problems)
    return sorted(problems, key=lambda problem: problem.severity != "error")


def write(
    timeline: Timeline,
    path: str | Path,
    format: str | None = None,
    media: str | Path | None = None,
) -> tuple[str, ...]:
    """Write the timeline; the file is whole or not there.

    media: the clip's film, which ELAN opens beside it. Returns what the timeline has and the file
    does not keep: of source, cluster, confidence, clip, clips without intervals, fps, n_frames,
    neutral tracks, media.
    Raises BadFile for a format or a place that cannot be written.
    """
    return _write([timeline], Path(path), format_of(path, format), media)


def write_all(
    timelines: Iterable[Timeline], path: str | Path, format: str | None = None
) -> tuple[str, ...]:
    """Write the timelines of several clips into one file; returns and raises as write does."""
    form, timelines = format_of(path, format), list(timelines)
    if len(timelines) != 1 and not form.several:
        able = [suffix for f in FORMATS.values() if f.several for suffix in f.suffixes]
        raise BadFile(
            path,
            found=f"{len(timelines)} clips",
            expected=f"one: a file of format {form.name} holds no more",
            remedy=f"Write a file per clip, or one that ends in {', '.join(able)}.",
        )
    counts = Counter(timeline.clip_id for timeline in timelines)
    twice = next((name for name, count in counts.items() if count > 1), None)
    if twice is not None and CLIP not in form.loses:
        raise BadFile(
            path,
            found=f"clip {shown(twice)} twice",
            expected="each clip once",
            remedy="Write the second into a file of its own.",
        )
    return _write(timelines, Path(path), form, None)


def _write(
    timelines: Sequence[Timeline], path: Path, form: Format, media: str | Path | None
) -> tuple[str, ...]:
    try:
        if media is None or MEDIA in form.loses:
            content = form.write(timelines).encode()
        else:
            content = form.write(timelines, Path(media), path.parent).encode()
        with whole(path) as temporary:
            temporary.write_bytes(content)
    except UnicodeEncodeError as error:
        raise _unfit(
            path, form, "a clip's name with half a character, which no text can hold"
        ) from error
    except ValueError as error:
        raise _unfit(path, form, str(error)) from error
    except OSError as error:
        raise unreadable(
            path, error, expected="a place to write to", remedy="Choose another one."
        ) from error
    lost = {name for timeline in timelines for name in _held(timeline, path)}
    lost |= {MEDIA} if media is not None else set()
    return tuple(name for name in _TOLD if name in lost & form.loses)


_TOLD = (SOURCE, CLUSTER, CONFIDENCE, CLIP, EMPTY, FPS, N_FRAMES, NEUTRAL_TRACKS, MEDIA)


def _held(timeline: Timeline, path: Path) -> Iterator[str]:
    """What the timeline has that some format does not keep."""
    yield from (FPS, N_FRAMES)
    if timeline.clip_id != path.stem:
        yield CLIP
    if not any(timeline.tracks.values()):
        yield EMPTY
    if not all(timeline.tracks.values()):
        yield NEUTRAL_TRACKS
    for interval in timeline:
        if interval.source != "human":
            yield SOURCE
        if interval.cluster is not None:
            yield CLUSTER
        if interval.confidence is not None:
            yield CONFIDENCE


def _unfit(path: Path, form: Format, found: str) -> BadFile:
    return BadFile(
        path,
        found=found,
        expected=f"a timeline that {form.name} can hold",
        remedy="Write JSON (.json), which holds every timeline.",
    )


def _judged(
    drafts: Iterable[tuple[str, Draft]],
    fps: Fraction | Mapping[str, Fraction] | None,
    n_frames: int | Mapping[str, int] | None,
    shortest: int | None = None,
) -> list[Judgement]:
    judged, seen = [], set()
    for clip, draft in drafts:
        judgement = judge(draft, clip, _of(fps, clip), _of(n_frames, clip), shortest)
        if clip in seen:
            judgement = Judgement(None, (_twice(clip), *judgement.problems))
        seen.add(clip)
        if isinstance(fps, Mapping) or isinstance(n_frames, Mapping):
            judgement = replace(judgement, problems=_placed(judgement.problems, clip))
        judged.append(judgement)
    return judged


def _twice(clip_id: str) -> Problem:
    return Problem(
        f"clip {clip_id}",
        found="the same clip a second time",
        expected="each clip once",
        remedy="Take one out, or call it otherwise.",
    )


def _placed(problems: Iterable[Problem], clip_id: str) -> tuple[Problem, ...]:
    """The problems, those of the whole clip with its name."""
    return tuple(p if p.place else replace(p, place=f"clip {clip_id}") for p in problems)


def _of(said, clip_id: str):
    return said.get(clip_id) if isinstance(said, Mapping) else said


def _timeline(path: str | Path, judged: Judgement) -> Timeline:
    errors = [problem for problem in judged.problems if problem.severity == "error"]
    if judged.timeline is None:
        first, more = errors[0], len(errors) - 1
        command = f" {more} more: mimeline timeline lint tells them all." if more else ""
        raise BadFile(
            path,
            place=first.place,
            found=first.found,
            expected=first.expected,
            remedy=first.remedy + command,
        )
    for problem in judged.problems:
        log.warning("%s: warning: %s", path, problem)
    return judged.timeline


def _no_clip(path: str | Path, clip_id: str, names: Sequence[str]) -> BadFile:
    close = nearest(clip_id, names)
    return BadFile(
        path,
        found=f"{len(names)} clip{'s' if len(names) != 1 else ''}, {shown(', '.join(names))}",
        expected=f"clip {shown(clip_id)}",
        remedy=f"Did you mean --clip {close}?" if close else "Say one that is in the file.",
    )
