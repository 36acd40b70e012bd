"""The commands of `mimeline motion`: files of motion converted."""

import argparse
from pathlib import Path

from mimeline.cli.terminal import show_progress, tell


def add(commands, as_taken: argparse.ArgumentParser, that_draws: argparse.ArgumentParser) -> None:
    """Add `motion` and its own commands to commands."""
    motion = commands.add_parser(
        "motion",
        help="convert files of facial motion",
        description="Files of motion: Live Link Face CSV (.csv), glTF (.glb), numpy (.npz), "
        "Parquet (.parquet), any tracking result; and, to write, film (.mp4) and OBJ files (.obj).",
    )
    own = motion.add_subparsers(dest="action", required=True)
    convert = own.add_parser(
        "convert",
        parents=[as_taken, that_draws],
        help="write a motion, or a tracking result, in other formats",
        description="Read a motion, or any tracking result, and write it in another format.",
    )
    convert.add_argument("source", metavar="IN", type=Path, nargs="+", help="what to read")
    convert.add_argument(
        "target",
        metavar="OUT",
        type=Path,
        help="a file; or a folder, or a name without an ending: there each has files of its own",
    )
    convert.add_argument(
        "--to", metavar="FORMAT", nargs="+", default=[], help="of the files in a folder"
    )
    convert.add_argument("--fps", help="frames per second to bring it to")
    convert.add_argument(
        "--timeline", metavar="FILE", type=Path, help="what it does; a film shows it under the face"
    )
    convert.set_defaults(run=_convert)


def _convert(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.reading import rate_said
    from mimeline.face.load import load_driven_face
    from mimeline.inspection.options import options
    from mimeline.motion.conversion import convert

    show_progress()
    written = convert(
        arguments.source,
        arguments.target,
        arguments.to,
        options(arguments.config, arguments.set, arguments.format),
        rate_said(arguments.fps),
        arguments.timeline,
        load_driven_face(arguments.face),
        arguments.overwrite,
    )
    for one in written:
        tell(one)
    return 0
