"""`mimeline generate`: motion from a timeline, or from a text, in files for other programs."""

import argparse
import os
from fractions import Fraction
from pathlib import Path

from mimeline.cli.terminal import formats_of, show_progress, tell
from mimeline.errors import BadConfig, printable

KEY = "MIMELINE_API_KEY"


def add(commands, of_a_run: argparse.ArgumentParser, that_draws: argparse.ArgumentParser) -> None:
    """Add `generate` to commands."""
    generate = commands.add_parser(
        "generate",
        parents=[of_a_run, that_draws],
        help="motion from a timeline or a sentence, by a trained model, for other programs",
        description="Ask a trained model for the motion of a timeline, or of what a text says, and "
        "write it: Live Link Face CSV (.csv), glTF (.glb), film (.mp4), numpy (.npz), Parquet "
        "(.parquet), OBJ files (.obj).",
    )
    generate.add_argument(
        "--model",
        required=True,
        metavar="NAME|PATH",
        help="a model of the run, such as timeline, or a checkpoint's folder",
    )
    asked = generate.add_mutually_exclusive_group(required=True)
    asked.add_argument(
        "--timeline",
        metavar="FILE",
        type=Path,
        action="append",
        default=[],
        help="of timelines: .json, .csv, .vtt, .eaf, .TextGrid, .txt; may be repeated",
    )
    asked.add_argument("--text", help='what the face does: "smile from 1 s to 2 s, then look left"')
    generate.add_argument(
        "-o",
        "--out",
        metavar="OUT",
        type=Path,
        nargs="+",
        action="extend",
        required=True,
        help="files to write, by their endings; or a folder, with --to",
    )
    generate.add_argument(
        "--to", metavar="FORMATS", default="", help="of the files in a folder: csv,glb"
    )
    generate.add_argument("--edit", action="store_true", help="open the timeline in $EDITOR first")
    generate.add_argument(
        "--endpoint",
        metavar="URL",
        help="an OpenAI-compatible server that turns any text into a timeline, up to /v1; without "
        f"it simple sentences are read here. A key is taken from {KEY}",
    )
    generate.add_argument("--language-model", metavar="NAME", help="the endpoint's model")
    generate.add_argument("--seconds", help="how long the clip of a text is")
    generate.add_argument("--frames", metavar="N", type=int, help="of a file that does not tell it")
    generate.add_argument("--clip", metavar="ID", help="the clip of a file of several")
    generate.add_argument(
        "--fps", help="frames per second of the motion; else the timeline's, for a text the model's"
    )
    generate.add_argument("--seed", type=int, default=0, help="another one, another motion; 0")
    generate.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a key of evaluate.timeline, such as guidance=3 or sampler_steps=50; may be repeated",
    )
    generate.add_argument(
        "--one-window",
        action="store_true",
        help="refuse timelines longer than the window that the model was trained on, which are "
        "else made in windows that overlap",
    )
    generate.set_defaults(run=_generate)


def _generate(arguments: argparse.Namespace) -> int:
    from mimeline.directions.editing import edited
    from mimeline.directions.text import in_words
    from mimeline.exchange.reading import rate_said
    from mimeline.face.load import load_driven_face
    from mimeline.generation.model_of_run import checkpoint_of, sampling_of
    from mimeline.motion import files, places
    from mimeline.motion.generated import generated, in_windows, poor, refuse_long
    from mimeline.training.checkpoint import load

    _refuse_idle(arguments)
    show_progress()
    fps, face = rate_said(arguments.fps), load_driven_face(arguments.face)
    checkpoint = checkpoint_of(arguments.model, arguments.results)
    sampling, trained = sampling_of(checkpoint, arguments.set), load(checkpoint)
    timelines = _timelines(arguments, fps, trained.fps)
    names = [timeline.clip_id for timeline in timelines]
    wanted = places.places(
        arguments.out, formats_of(arguments.to), names, arguments.timeline, arguments.overwrite
    )
    if arguments.edit:
        timelines = [edited(timeline, tell) for timeline in timelines]
    if arguments.one_window:
        refuse_long(timelines, trained)
    for timeline in timelines:
        tell(printable(f"{timeline.clip_id}, {timeline.seconds:.4g} s: {in_words(timeline)}"))
    for remark in (in_windows(timelines, trained), poor(trained)):
        if remark:
            tell(remark)
    made = {"model": str(checkpoint)} | ({"text": arguments.text} if arguments.text else {})
    motions = generated(trained, timelines, fps, sampling, arguments.seed, made)
    for name, motion in zip(names, motions, strict=True):
        for path in wanted[name]:
            tell(files.write(motion, path, face))
    return 0


def _timelines(arguments: argparse.Namespace, fps: Fraction | None, usual: Fraction) -> list:
    """What is asked for. fps: as somebody said; usual: the model's."""
    from mimeline.directions.endpoint import Endpoint
    from mimeline.directions.text import timeline_of
    from mimeline.exchange.reading import Reading, length_said, seconds_said

    if arguments.text is None:
        reading = Reading(fps, length_said(arguments.frames), arguments.clip)
        return [own for path in arguments.timeline for own in reading.untold(path)]
    endpoint = arguments.endpoint and Endpoint(
        arguments.endpoint, arguments.language_model, os.environ.get(KEY, "")
    )
    seconds = seconds_said(arguments.seconds)
    name = arguments.out[0].stem
    timeline, repairs = timeline_of(arguments.text, endpoint, fps or usual, seconds, name)
    for repair in repairs:
        tell(printable(f"mended in the answer: {repair}"))
    return [timeline]


def _refuse_idle(arguments: argparse.Namespace) -> None:
    """Raise BadConfig for what would be passed over in silence."""
    of_text = {"--endpoint": arguments.endpoint, "--seconds": arguments.seconds}
    of_files = {"--frames": arguments.frames, "--clip": arguments.clip}
    idle, with_what = (of_text, "--text") if arguments.text is None else (of_files, "--timeline")
    for option, told in idle.items():
        if told is not None:
            raise _misplaced(option, f"{with_what} with it", f"Leave {option} out.")
    if (arguments.endpoint is None) != (arguments.language_model is None):
        raise _misplaced(
            "--endpoint" if arguments.endpoint else "--language-model",
            "--endpoint and --language-model together",
            "Name the server and its model: --endpoint http://localhost:11434/v1 "
            "--language-model NAME.",
        )


def _misplaced(option: str, expected: str, remedy: str) -> BadConfig:
    return BadConfig(option, found="it alone", expected=expected, remedy=remedy)
