"""A folder: the takes in it, or its videos, or what lies in its folders."""

from collections import Counter, defaultdict
from itertools import islice
from pathlib import Path

from mimeline.errors import BadFile
from mimeline.inspection import files
from mimeline.inspection.inspection import Inspection
from mimeline.inspection.options import Options
from mimeline.inspection.recognise import format_of, is_video, kind_of, may_be
from mimeline.inspection.take import NOT_CHECKED, inspect_take
from mimeline.tracking.readers import READERS

SHOWN = 20  # lines of a list, before the rest is counted
NAMED = 6  # names in a sentence
PEEKED = 200  # files of an inner folder that are looked at


def inspect_folder(path: Path, options: Options) -> Inspection:
    """Every take of a folder is read; of what else lies there it is said what it is.

    Raises BadFile where nothing in it is known.
    """
    children = sorted(
        child
        for child in path.iterdir()
        if not child.name.startswith(".") and child.name not in options.exclude
    )
    takes = _takes(children, options)
    options.refuse_idle(set(takes.values()))
    sidecars = [child for child in children if takes and files.is_losses(child)]
    rest = [child for child in children if child not in takes and child not in sidecars]
    videos = [child for child in rest if is_video(child)]
    seen = Inspection(path, "folder")
    if takes:
        _of_takes(seen, [inspect_take(child, takes[child], options) for child in sorted(takes)])
        if videos:
            seen.facts["videos"] = str(len(videos))
        if sidecars:
            seen.facts["loss sidecars"] = str(len(sidecars))
    elif videos:
        _of_videos(seen, [files.video(child) for child in videos])
    known = [(_name(c), _what(c, options)) for c in rest if c not in videos]
    if takes or videos:
        seen.notes += [f"also here: {name} ({what})" for name, what in known[:SHOWN] if what]
        if unknown := [name for name, what in known if not what]:
            seen.notes.append(f"not known: {_list(unknown)}")
    else:
        known = known if any(what for _, what in known) else [(_name(c), _face(c)) for c in rest]
        if not any(what for _, what in known):
            return _nothing_known(path, rest)
        seen.rows = [("name", "what"), *((name, what or "–") for name, what in known)]
    return seen


def _takes(children: list[Path], options: Options) -> dict[Path, str]:
    """The takes among a folder's children, each with the format that it is read as."""
    takes = {child: format for child in children if (format := format_of(child, options))}
    formats = set(takes.values())
    asked = options.format
    if any(may_be(take, asked) for take in takes if asked):
        formats = {asked}  # a run takes no others
    elif asked and not takes and not any(_what(child, options) for child in children):
        formats = {asked}  # whose columns may bear the user's own names
    if len(formats) != 1:
        return takes
    (format,) = formats
    fitting = {c: format for c in children if may_be(c, format) and not kind_of(c, options)}
    return {c: f for c, f in takes.items() if f == format} | fitting


def _of_takes(seen: Inspection, takes: list[Inspection]) -> None:
    """What a folder's takes come to, and a line for each."""
    kinds = Counter(take.kind for take in takes)
    whole = [take.numbers for take in takes if not take.error]
    seen.facts["takes"] = ", ".join(f"{n} × {kind}" for kind, n in kinds.items())
    seen.facts["without fault"] = f"{sum(take.sound for take in takes)} of {len(takes)}"
    if whole:
        frames, lost = (sum(n[key] for n in whole) for key in ("frames", "without_face"))
        seen.facts["length"] = f"{_length(sum(n['seconds'] for n in whole))}, {frames} frames"
        seen.facts["without face"] = f"{lost} frames" if lost else "none"
        every = set.intersection(*(set(n["measured"]) for n in whole))
        some = set.union(*(set(n["measured"]) for n in whole)) - every
        seen.facts["channels"] = f"{len(every)} in every take"
        if some:
            seen.facts["channels"] += f"; {_list(sorted(some))} in some"
    seen.rows = [("take", "frames", "seconds", "fps", "no face", "channels", "problems")]
    seen.rows += [_line(take) for take in takes[:SHOWN]]
    if len(takes) > SHOWN:
        seen.notes.append(f"{len(takes) - SHOWN} more takes are counted and not listed")
    for what in NOT_CHECKED:
        if n := sum(what in numbers["not_checked"] for numbers in whole):
            seen.notes.append(f"{what} not checked in {n} {'take' if n == 1 else 'takes'}")
    wrong: dict[str, list[str]] = defaultdict(list)
    for take in takes:
        for text in filter(None, (take.error, *take.problems)):
            wrong[text.removeprefix(str(take.path)).lstrip(",: ")].append(take.path.name)
    _tell(seen, wrong)
    seen.numbers = {
        "takes": {
            take.path.name: take.numbers
            | {"problems": [text for text in (take.error, *take.problems) if text]}
            for take in takes
        }
    }


def _line(take: Inspection) -> tuple[str, ...]:
    if take.error:
        return (take.path.name, *5 * "–", "cannot be read")
    n = take.numbers
    fps = f"{n['frames'] / n['seconds']:.5g}" if n["seconds"] else "–"
    texts = (n["frames"], f"{n['seconds']:.1f}", fps, n["without_face"], len(n["measured"]))
    return (take.path.name, *map(str, texts), str(len(take.problems) or "none"))


def _of_videos(seen: Inspection, videos: list[Inspection]) -> None:
    """What a folder's videos come to, and a line for each."""
    seconds = sum(video.numbers["seconds"] for video in videos if not video.error)
    seen.facts["videos"] = f"{len(videos)}, {_length(seconds)}"
    names = ("size", "fps", "frames", "length", "codec", "sound")
    seen.rows = [("video", *names)]
    for video in videos[:SHOWN]:
        cells = [video.facts.get(name, "–") for name in names]
        seen.rows.append((video.path.name, *cells))
    if len(videos) > SHOWN:
        seen.notes.append(f"{len(videos) - SHOWN} more videos are counted and not listed")
    wrong = {v.error.removeprefix(f"{v.path}: "): [v.path.name] for v in videos if v.error}
    _tell(seen, wrong)
    seen.numbers = {"videos": {v.path.name: v.numbers | {"error": v.error} for v in videos}}


def _tell(seen: Inspection, wrong: dict[str, list[str]]) -> None:
    """What is wrong, each with the names that it holds for."""
    seen.problems += [f"{_list(names)}: {text}" for text, names in list(wrong.items())[:SHOWN]]
    if len(wrong) > SHOWN:
        seen.problems.append(f"and {len(wrong) - SHOWN} more")


def _nothing_known(path: Path, rest: list[Path]) -> Inspection:
    """A face model's folder, at best."""
    seen = files.face(path)
    if not seen.error:
        return seen
    raise BadFile(
        path,
        found=f"nothing known among {_list(list(map(_name, rest)))}" if rest else "an empty folder",
        expected=f"takes of {', '.join(READERS)}, videos, tables of a run or a face model",
        remedy="Name the folder or file that holds the takes.",
    )


def _what(path: Path, options: Options) -> str:
    """What a file is, or what an inner folder holds; empty where nothing is known."""
    if (kind := kind_of(path, options)) or not path.is_dir():
        return kind or ""
    try:
        inner = list(islice((p for p in path.iterdir() if not p.name.startswith(".")), PEEKED))
    except OSError:
        return ""
    kinds = Counter(filter(None, (kind_of(p, options) for p in sorted(inner))))
    more = f" in its first {PEEKED} files" if kinds and len(inner) == PEEKED else ""
    return ", ".join(f"{n} × {kind}" for kind, n in kinds.items()) + more


def _face(path: Path) -> str:
    """ "face model" where a file is one; nobody can tell before it is loaded."""
    named = path.suffix.lower() in files.FACES and path.is_file()
    return "face model" if named and not files.face(path).error else ""


def _name(path: Path) -> str:
    return f"{path.name}/" if path.is_dir() else path.name


def _list(names: list[str]) -> str:
    """The first few names, and how many more."""
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + more


def _length(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 120 else f"{seconds / 60:.1f} min"
