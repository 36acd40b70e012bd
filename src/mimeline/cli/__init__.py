"""The command line of mimeline: what people do beside running the workflow."""

import argparse
import os
import sys
from pathlib import Path

from mimeline import __version__
from mimeline.cli import datasets, generate, motion, timelines
from mimeline.cli.terminal import colour, say
from mimeline.errors import MimelineError


def main() -> None:
    """Entry point of the `mimeline` command."""
    arguments = _parsed(sys.argv[1:])
    try:
        sys.exit(arguments.run(arguments))
    except MimelineError as error:
        sys.exit(f"mimeline: {error}")
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:  # `| head` has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parsed(words: list[str]) -> argparse.Namespace:
    """The arguments. Ids of clips may begin with -, which argparse takes for an option."""
    parser, ids = _parser(), []
    if (
        words[:1] == ["why"] or words[:2] in (["timeline", "export"], ["motion", "export"])
    ) and "--" not in words:
        ids = [word for word in words if len(word) > 2 and word[0] == "-" != word[1]]
    arguments = parser.parse_args([word for word in words if word not in ids])
    if ids:
        arguments.clips += ids
    if arguments.command == "why" and not arguments.clips:
        parser.error("why needs a clip's id, a pattern or a source")
    return arguments


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="mimeline", description="Facial-action timelines from face-tracking results."
    )
    parser.add_argument("--version", action="version", version=f"mimeline {__version__}")
    commands = parser.add_subparsers(dest="command", required=True)
    of_a_run = argparse.ArgumentParser(add_help=False)
    of_a_run.add_argument("--results", type=Path, default=Path("results"), help="a run's results")
    for_programs = argparse.ArgumentParser(add_help=False)
    for_programs.add_argument("--json", action="store_true", help="for programs")

    with_a_page = argparse.ArgumentParser(add_help=False)
    with_a_page.add_argument("--port", type=int, default=0, help="0: any that is free")
    with_a_page.add_argument("--no-browser", action="store_true", help="only say the address")

    as_taken = argparse.ArgumentParser(add_help=False)
    as_taken.add_argument("--format", help="read it as this format of ingest.format, and no other")
    as_taken.add_argument(
        "--config", type=Path, help="a run's configuration: takes are read as it would"
    )
    as_taken.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a key of section ingest, such as fps=25, angle_unit=degrees or bad_values=mask; "
        "may be repeated",
    )
    on_a_face = argparse.ArgumentParser(add_help=False)
    on_a_face.add_argument(
        "--face",
        metavar="PATH",
        type=Path,
        help="a face model with ARKit's shapes, such as ICT-FaceKit's; without it our own",
    )
    that_draws = argparse.ArgumentParser(add_help=False, parents=[on_a_face])
    that_draws.add_argument("--overwrite", action="store_true", help="replace what is there")

    config = commands.add_parser(
        "config", help="write config.yaml and config.schema.json from the models"
    )
    config.add_argument("folder", nargs="?", type=Path, default=Path("config"))
    config.set_defaults(run=_config)

    inspect = commands.add_parser(
        "inspect",
        parents=[as_taken, for_programs],
        help="what a file or folder is, and what is wrong with it",
        description="Say what a tracking result, video, table, catalogue, face model or folder is: "
        "its format, channels, frames, ranges and problems. The exit code is 1 on a problem.",
    )
    inspect.add_argument("path", type=Path, help="a file, or a folder")
    inspect.set_defaults(run=_inspect)

    why = commands.add_parser(
        "why",
        parents=[of_a_run, for_programs],
        help="what became of a clip, stage by stage",
        description="What each stage decided on a clip, by which rule, value and limit, and what "
        "to do about it. Several clips have a line each.",
    )
    why.add_argument(
        "clips", nargs="*", metavar="CLIP", help="a clip's id, a pattern such as 'oC9r*', a source"
    )
    why.set_defaults(run=_why)

    funnel = commands.add_parser(
        "funnel",
        parents=[of_a_run, for_programs],
        help="how many clips came through each stage, and how many would with other limits",
        description="The clips of a run, stage by stage, with the reasons of every loss. With "
        "--set, what would change; nothing is run and nothing is written.",
    )
    funnel.add_argument(
        "--config",
        type=Path,
        action="append",
        default=[],
        help="a configuration to go by; without it that of the run",
    )
    funnel.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="another limit, such as select.max_s=12, several, as select.max_s=8,12,15, or "
        "pose.max_yaw_deg=40; may be repeated",
    )
    funnel.set_defaults(run=_funnel)

    check_data = commands.add_parser(
        "check-data",
        parents=[of_a_run, for_programs],
        help="before a long training: is there enough data, of what, and what is odd",
        description="What a training would find in a run's annotated and divided clips: parts, "
        "windows, channels, actions. The exit code is 1 on a problem, 0 where there are only "
        "remarks.",
    )
    check_data.add_argument(
        "--config",
        type=Path,
        action="append",
        default=[],
        help="a configuration to go by; without it that of the run",
    )
    check_data.set_defaults(run=_check_data)

    preview = commands.add_parser(
        "preview",
        parents=[as_taken, on_a_face, with_a_page],
        help="see a motion or a timeline in a browser, on a face that can be turned",
        description="Serve a page on this machine alone that shows a motion (.csv, .glb, .npz, "
        ".parquet, any tracking result), or what a timeline says (.json, .csv, .vtt, .eaf, "
        ".TextGrid, .txt), on a face that can be turned, frame by frame; two files stand side by "
        "side.",
    )
    preview.add_argument("file", metavar="FILE", type=Path, help="a motion, or timelines")
    preview.add_argument("other", metavar="OTHER", type=Path, nargs="?", help="to compare it with")
    preview.add_argument("--clip", metavar="ID", help="of a file of timelines, the one shown first")
    preview.add_argument("--fps", help="of timelines that do not tell it: 25, 29.97, 30000/1001")
    preview.add_argument(
        "--frames", metavar="N", type=int, help="of timelines that do not tell how long they are"
    )
    preview.set_defaults(run=_preview)

    label = commands.add_parser(
        "label",
        parents=[of_a_run, with_a_page],
        help="name the clusters in a browser, from a few of their intervals each",
        description="Serve a page on this machine alone that shows intervals of each cluster; a "
        "keystroke names it. The names go to a YAML file for label.file.",
    )
    label.add_argument(
        "--file",
        type=Path,
        help="the label file to write, and to go on with where it is there; without it label.file "
        "of the run, or config/labels/<name of the results>.yaml",
    )
    label.add_argument(
        "--person",
        default="",
        help="who labels: another person's answers go to a file of their own, blind to the first's",
    )
    label.set_defaults(run=_label)

    review = commands.add_parser(
        "review",
        parents=[of_a_run, with_a_page],
        help="look at the clips in a browser and write the list of those to leave out",
        description="Serve a page on this machine alone that plays the clips; what is left out "
        "there, and why, goes to a CSV for select.exclusions.",
    )
    review.add_argument(
        "--exclusions",
        type=Path,
        default=Path("config/exclusions.csv"),
        help="the list to write, and to go on with where it is there",
    )
    review.set_defaults(run=_review)

    rate = commands.add_parser(
        "rate",
        parents=[of_a_run, with_a_page],
        help="judge in a browser, blind, whether timelines fit what is seen",
        description="Serve a page on this machine alone that shows clips with timelines, in random "
        "order and without saying who made them; a person answers on five points.",
    )
    rate.add_argument("--person", required=True, help="who rates")
    rate.add_argument("--pairs", type=int, default=15, help="pairs of each kind")
    rate.add_argument(
        "--kinds",
        nargs="+",
        default=[],
        metavar="KIND",
        help="some of truth, annotation, generation and mismatched, rather than all that the run "
        "has; without generation, films are shown where there are",
    )
    rate.add_argument("--seed", type=int, default=0, help="seed of the pairs that are drawn")
    rate.add_argument(
        "--file",
        type=Path,
        help="the CSV of answers to write, and to go on with where it is there; without it "
        "config/ratings/<name of the results>.csv",
    )
    rate.set_defaults(run=_rate)

    ratings = commands.add_parser(
        "ratings",
        parents=[for_programs],
        help="what people answered on the pages of `rate`, with intervals",
    )
    ratings.add_argument("files", nargs="+", type=Path, metavar="FILE", help="a CSV of answers")
    ratings.set_defaults(run=_ratings)

    timelines.add(commands, of_a_run, for_programs)
    motion.add(commands, of_a_run, as_taken, that_draws)
    generate.add(commands, of_a_run, that_draws)
    datasets.add(commands, of_a_run)
    return parser


def _config(arguments: argparse.Namespace) -> int:
    from mimeline.config import default_yaml, json_schema

    arguments.folder.mkdir(parents=True, exist_ok=True)
    (arguments.folder / "config.yaml").write_text(default_yaml(), encoding="utf-8")
    (arguments.folder / "config.schema.json").write_text(json_schema(), encoding="utf-8")
    return 0


def _inspect(arguments: argparse.Namespace) -> int:
    from mimeline.inspection import as_json, as_text, inspect, options

    chosen = options(arguments.config, arguments.set, arguments.format)
    seen = inspect(arguments.path, chosen)
    say(as_json(seen) if arguments.json else as_text(seen, colour()))
    if seen.error:
        print(f"mimeline: {seen.error}", file=sys.stderr)
    return 0 if seen.sound else 1


def _why(arguments: argparse.Namespace) -> int:
    from mimeline.inspection import why

    found = why.why(arguments.results, arguments.clips)
    say(why.as_json(found) if arguments.json else why.as_text(found, colour()))
    for problem in found.missed:
        print(f"mimeline: {problem}", file=sys.stderr)
    return 1 if found.missed else 0


def _funnel(arguments: argparse.Namespace) -> int:
    from mimeline.inspection import funnel

    found = funnel.funnel(arguments.results, arguments.config, arguments.set)
    say(funnel.as_json(found) if arguments.json else funnel.as_text(found, colour()))
    return 0 if found.sound else 1


def _check_data(arguments: argparse.Namespace) -> int:
    from mimeline.inspection.check_data import as_json, as_text, check_data

    found, plan = check_data(arguments.results, arguments.config)
    if arguments.json:
        say(as_json(found, plan))
    else:
        say(as_text(found, plan, arguments.results, colour()))
    return 0 if found.sound else 1


def _preview(arguments: argparse.Namespace) -> int:
    from mimeline.exchange.reading import Reading, length_said, rate_said
    from mimeline.inspection import options
    from mimeline.studio.preview import serve

    serve(
        [path for path in (arguments.file, arguments.other) if path],
        arguments.face,
        options(arguments.config, arguments.set, arguments.format),
        Reading(rate_said(arguments.fps), length_said(arguments.frames), arguments.clip),
        arguments.port,
        not arguments.no_browser,
    )
    return 0


def _label(arguments: argparse.Namespace) -> int:
    from mimeline.studio.label import serve

    serve(
        arguments.results,
        arguments.file,
        arguments.person,
        arguments.port,
        not arguments.no_browser,
    )
    return 0


def _review(arguments: argparse.Namespace) -> int:
    from mimeline.studio.review import serve

    serve(arguments.results, arguments.exclusions, arguments.port, not arguments.no_browser)
    return 0


def _rate(arguments: argparse.Namespace) -> int:
    from mimeline.studio.rate import serve

    serve(
        arguments.results,
        arguments.file,
        arguments.person,
        arguments.pairs,
        arguments.seed,
        arguments.kinds,
        arguments.port,
        not arguments.no_browser,
    )
    return 0


def _ratings(arguments: argparse.Namespace) -> int:
    from mimeline.studio import ratings

    found = ratings.ratings(arguments.files)
    say(ratings.as_json(found) if arguments.json else ratings.as_text(found))
    return 0
