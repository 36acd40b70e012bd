"""The commands of `mimeline motion`: files of motion converted, a run's motion in files."""

import argparse
from pathlib import Path

from mimeline.cli.terminal import formats_of, show_progress, tell


def add(
    commands,
    of_a_run: argparse.ArgumentParser,
    as_taken: argparse.ArgumentParser,
    that_draws: argparse.ArgumentParser,
) -> None:
    """Add `motion` and its own commands to commands."""
    motion = commands.add_parser(
        "motion",
        help="convert files of facial motion, take it out of a run",
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
        "--to", metavar="FORMATS", default="", help="of the files in a folder: csv,glb"
    )
    convert.add_argument("--fps", help="frames per second to bring it to")
    convert.add_argument(
        "--timeline", metavar="FILE", type=Path, help="what it does; a film shows it under the face"
    )
    convert.set_defaults(run=_convert)

    export = own.add_parser(
        "export",
        parents=[of_a_run, that_draws],
        help="a run's motion as files",
        description="Write the motion of a run's clips, with the timelines that it found.",
    )
    export.add_argument(
        "clips",
        nargs="*",
        metavar="CLIP",
        help="a clip's id, how it begins and a star ('zBy*'), a source; without any: all clips",
    )
    export.add_argument(
        "-o",
        "--out",
        metavar="OUT",
        type=Path,
        action="append",
        required=True,
        help="a folder; or a file of one clip, by its ending; may be repeated",
    )
    export.add_argument(
        "--to", metavar="FORMATS", default="", help="of the files in a folder: csv,glb"
    )
    export.set_defaults(run=_export)


def _convert(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.reading import rate_said
    from mimeline.face.load import load_driven_face
    from mimeline.inspection.options import options
    from mimeline.motion.conversion import convert

    show_progress()
    written = convert(
        arguments.source,
        arguments.target,
        formats_of(arguments.to),
        options(arguments.config, arguments.set, arguments.format),
        rate_said(arguments.fps),
        arguments.timeline,
        load_driven_face(arguments.face),
        arguments.overwrite,
    )
    for one in written:
        tell(one)
    return 0


def _export(arguments: argparse.Namespace) -> int:
    from mimeline.face.load import load_driven_face
    from mimeline.motion import files
    from mimeline.motion.of_run import named, of_run
    from mimeline.motion.places import places

    show_progress()
    face = load_driven_face(arguments.face)
    names, missed = named(arguments.results, arguments.clips)
    wanted = places(arguments.out, formats_of(arguments.to), names, overwrite=arguments.overwrite)
    for name, motion in of_run(arguments.results, names):
        for path in wanted[name]:
            tell(files.write(motion, path, face))
    for problem in missed:
        tell(f"mimeline: {problem}")
    return 1 if missed else 0
