"""The commands of `mimeline timeline`: files of timelines converted, compared, joined, checked."""

import argparse
from pathlib import Path

from mimeline.cli.terminal import colour, say, tell
from mimeline.errors import MimelineError, printable

FORMATS = "json, csv, vtt, eaf, TextGrid, txt"


def add(commands, of_a_run: argparse.ArgumentParser, for_programs: argparse.ArgumentParser) -> None:
    """Add `timeline` and its own commands to commands."""
    timeline = commands.add_parser(
        "timeline",
        help="convert, compare, join and check files of timelines; take them out of a run",
        description="Files of timelines: JSON, CSV, WebVTT (.vtt), ELAN (.eaf), Praat (.TextGrid), "
        "STMC (.txt). The ending of its name tells a file's format.",
    )
    own = timeline.add_subparsers(dest="action", required=True)
    as_read = _as_read()

    convert = own.add_parser(
        "convert",
        parents=[as_read],
        help="write a timeline in another format",
        description="Read a file of timelines, or all in a folder, and write it in another format.",
    )
    convert.add_argument("source", metavar="IN", type=Path, help="a file, or a folder of files")
    convert.add_argument(
        "target",
        metavar="OUT",
        type=Path,
        help="a file; a folder, or a name without an ending: there each clip has a file of its own",
    )
    convert.add_argument("--to", metavar="FORMAT", help=f"of OUT: {FORMATS}; else by its ending")
    convert.add_argument("--media", metavar="FILE", type=Path, help="the clip's video, for ELAN")
    convert.add_argument("--overwrite", action="store_true", help="replace what is there")
    convert.set_defaults(run=_convert)

    diff = own.add_parser(
        "diff",
        parents=[as_read, for_programs],
        help="where two timelines of a clip differ, and how far they agree",
        description="The actions that only one of two timelines has, that are moved, that are "
        "others; how many frames agree. The exit code is 1 where they differ, 2 for a file that "
        "cannot be read.",
    )
    diff.add_argument("first", metavar="A", type=Path)
    diff.add_argument("second", metavar="B", type=Path)
    diff.set_defaults(run=_diff)

    merge = own.add_parser(
        "merge",
        parents=[as_read],
        help="make one timeline of two",
        description="The tracks and actions of both; what goes on in the other one is joined. Not "
        "for a correction and its original: what was deleted would come back. The "
        "exit code is 1 where they show different actions at a time, and nobody is preferred.",
    )
    merge.add_argument("first", metavar="A", type=Path)
    merge.add_argument("second", metavar="B", type=Path)
    merge.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="file to write")
    merge.add_argument("--to", metavar="FORMAT", help=f"of OUT: {FORMATS}; else by its ending")
    merge.add_argument("--media", metavar="FILE", type=Path, help="the clip's video, for ELAN")
    merge.add_argument(
        "--prefer",
        choices=["first", "second"],
        help="who is right where they show different actions; without it that is an error",
    )
    merge.add_argument("--overwrite", action="store_true", help="replace what is there")
    merge.set_defaults(run=_merge)

    lint = own.add_parser(
        "lint",
        parents=[as_read, for_programs],
        help="what is wrong with files of timelines",
        description="Every problem of the files, a line each. The exit code is 1 on an error, "
        "0 where there are only warnings.",
    )
    lint.add_argument("files", metavar="FILE", nargs="+", type=Path)
    lint.add_argument(
        "--min-frames", metavar="N", type=int, default=2, help="warn of what is shorter; 2"
    )
    lint.set_defaults(run=_lint)

    export = own.add_parser(
        "export",
        parents=[of_a_run],
        help="a run's timelines as files, one per clip",
        description="Write the timelines of a run into a folder, a file for each clip, linked with "
        "its video where it has one; to be corrected, and to score the run by: evaluate.truth.",
    )
    export.add_argument(
        "clips",
        nargs="*",
        metavar="CLIP",
        help="a clip's id, how it begins and a star ('zBy*'), a source; without any: all clips",
    )
    export.add_argument("--to", metavar="FORMAT", required=True, help=FORMATS)
    export.add_argument("-o", "--out", metavar="FOLDER", type=Path, required=True)
    export.add_argument("--overwrite", action="store_true", help="replace what is there")
    export.set_defaults(run=_export)


def _as_read() -> argparse.ArgumentParser:
    """What files are read by that do not tell it themselves."""
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("--fps", help="frames per second: 25, 29.97, 30000/1001")
    options.add_argument("--frames", metavar="N", type=int, help="how many frames the clip has")
    options.add_argument(
        "--clip", metavar="ID", help="the clip: of several the one, of none its name"
    )
    options.add_argument(
        "--from", dest="format", metavar="FORMAT", help=f"how files are read: {FORMATS}"
    )
    return options


def _convert(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.conversion import convert

    written = convert(
        arguments.source,
        arguments.target,
        _reading(arguments),
        _format(arguments.to),
        arguments.media,
        arguments.overwrite,
    )
    tell(written)
    return 0


def _diff(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.differences import as_json, as_text
    from mimeline.timeline.comparison import diff

    files = arguments.first, arguments.second
    try:
        found = diff(*_reading(arguments).both(*files))
    except MimelineError as error:
        tell(f"mimeline: {error}")
        return 2
    say(as_json(found, *files) if arguments.json else as_text(found, *files, colour()))
    return 1 if found else 0


def _merge(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.conversion import write
    from mimeline.timeline.joining import cost, merge

    files = arguments.first, arguments.second
    first, second = _reading(arguments).both(*files)
    merged = merge(first, second, arguments.prefer)
    written = write(
        merged,
        arguments.out,
        _format(arguments.to),
        arguments.media,
        files,
        arguments.overwrite,
    )
    tell(written)
    paid = cost(first, second, merged)
    told = f"overlapping intervals: {paid.joined} joined, as long as both together"
    if arguments.prefer:
        loser = arguments.second if arguments.prefer == "first" else arguments.first
        told += f"; {paid.cut} cut and {paid.left_out} left out of {loser}"
    tell(printable(told))
    return 0


def _lint(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.problems import as_json, as_text, errors, lint

    found = lint(arguments.files, _reading(arguments), arguments.min_frames)
    say(as_json(found) if arguments.json else as_text(found, colour()))
    return 1 if errors(found) else 0


def _export(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.export import export

    found = export(
        arguments.results,
        arguments.clips,
        arguments.out,
        _format(arguments.to),
        arguments.overwrite,
    )
    tell(found)
    for problem in found.missed:
        tell(f"mimeline: {problem}")
    return 1 if found.missed else 0


def _reading(arguments: argparse.Namespace):
    from mimeline.exchange.reading import Reading, length_said, rate_said

    fps = rate_said(arguments.fps)
    if fps is not None and "." in arguments.fps:
        tell(f"{arguments.fps} frames per second are {fps}")
    format = _format(arguments.format, "--from")
    return Reading(fps, length_said(arguments.frames), arguments.clip, format)


def _format(text: str | None, option: str = "--to") -> str | None:
    from mimeline.exchange.reading import format_said

    return format_said(text, option)
