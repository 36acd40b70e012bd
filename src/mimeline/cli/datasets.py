"""The command `mimeline dataset`: a run's clips as data sets for other trainers."""

import argparse
from pathlib import Path

from mimeline.cli.terminal import tell

LAYOUTS = ("huggingface", "humanml3d")


def add(commands, of_a_run: argparse.ArgumentParser) -> None:
    """Add `dataset` and its own command to commands."""
    dataset = commands.add_parser(
        "dataset",
        help="a run's clips as a data set for other trainers",
        description="A run's motion, timelines and texts in the layouts that other trainers read.",
    )
    own = dataset.add_subparsers(dest="action", required=True)
    export = own.add_parser(
        "export",
        parents=[of_a_run],
        help="sharded Parquet with a card, or HumanML3D's folder",
        description="Write the clips of a run's training, validation and test part into a folder, "
        "with a card. Videos are not copied. Where the licence of the recordings forbids to pass "
        "on what is made of them, or is not told, nothing is written unless that is said.",
    )
    export.add_argument(
        "--to",
        choices=LAYOUTS,
        required=True,
        help="huggingface: Parquet, a row per clip, for `datasets`, pandas, pyarrow; humanml3d: "
        "arrays and texts, for text-to-motion trainers",
    )
    export.add_argument("-o", "--out", metavar="FOLDER", type=Path, required=True)
    export.add_argument(
        "--data-set",
        metavar="NAME[=PATTERN]",
        action="append",
        default=[],
        help="whose recordings the clips are, or those whose id or source fits the pattern; "
        "without it what the catalogue's format tells; may be repeated",
    )
    for option, what in (
        ("--licence", "the licence of a data set, such as cc-by-4.0"),
        ("--consent", "what the people in a data set agreed to, for the card"),
    ):
        export.add_argument(
            option,
            metavar="[NAME=]TEXT",
            action="append",
            default=[],
            help=f"{what}; with its name where there are several; may be repeated",
        )
    export.add_argument(
        "--redistribute",
        metavar="NAME",
        action="append",
        default=[],
        help="write what is made of this data set although its licence forbids passing it on, or "
        "is not known to permit it; the card says so; may be repeated",
    )
    export.add_argument(
        "--contact", metavar="TEXT", default="", help="whom people may ask that are in it"
    )
    export.add_argument(
        "--shard-mb",
        metavar="MB",
        type=int,
        default=256,
        help="huggingface: a Parquet file's size in memory, after which the next begins; 256",
    )
    export.add_argument(
        "--fps", metavar="N", help="humanml3d: the motion's frame rate; 20, as its loaders expect"
    )
    export.add_argument("--overwrite", action="store_true", help="replace an earlier export")
    export.set_defaults(run=_export)


def _export(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.datasets import export
    from mimeline.exchange.licences import Told
    from mimeline.exchange.reading import rate_said

    told = Told(
        arguments.data_set,
        arguments.licence,
        arguments.consent,
        arguments.redistribute,
        arguments.contact,
    )
    found = export(
        arguments.results,
        arguments.to,
        arguments.out,
        told,
        arguments.overwrite,
        max(arguments.shard_mb, 1),
        rate_said(arguments.fps),
    )
    tell(found)
    return 0
