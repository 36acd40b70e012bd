"""The commands of `mimeline timeline`: files of timelines converted, compared, joined, checked."""

import argparse
from pathlib import Path


def add(commands, of_a_run: argparse.ArgumentParser, for_programs: argparse.ArgumentParser) -> None:
    """Add `timeline` and its own commands to commands."""
    timeline = commands.add_parser(
        "timeline",
        help="convert, compare, join and check files of timelines",
        description="Files of timelines: JSON, CSV, WebVTT, ELAN, Praat, STMC.",
    )
    own = timeline.add_subparsers(dest="action", required=True)
    convert = own.add_parser("convert", help="write a timeline in another format")
    convert.add_argument("source", metavar="IN", type=Path)
    convert.add_argument("target", metavar="OUT", type=Path)
    convert.set_defaults(run=_convert)


def _convert(arguments: argparse.Namespace) -> int:
    raise NotImplementedError
