"""Motion in files: what each kind is called, who opens it, what it does not keep."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Literal

from mimeline.errors import BadFile, NoSuchFile, printable, unreadable
from mimeline.face.model import Face
from mimeline.inspection.options import Options
from mimeline.inspection.recognise import format_of as format_of_take
from mimeline.motion import about
from mimeline.motion.formats import arrays, film, livelink, mesh_frames, scene, table
from mimeline.motion.motion import Motion
from mimeline.reporting import words
from mimeline.tracking.matching import Result
from mimeline.tracking.readers import READERS
from mimeline.vocabulary import CHANNELS


@dataclass(frozen=True)
class Format:
    """A kind of file that motion is written to. program: what opens it.

    write: motion, path, and a face where it draws → what of the face it cannot say. faceless: what
    becomes of frames in which no face was seen. draws: whether it shows a face, and then holds what
    that does rather than the numbers. gaps: whether it says that a channel is not known; otherwise
    0 stands there.
    """

    name: str
    ending: str
    program: str
    write: Callable[..., tuple[str, ...] | None]
    faceless: Literal["left out", "pale", "kept"]
    draws: bool = False
    gaps: bool = False


LIVE_LINK, STILLS = "Unreal, Live Link Face tools", "programs without animation"
FORMATS: dict[str, Format] = {
    form.name: form
    for form in (
        Format("livelink", ".csv", LIVE_LINK, livelink.write, "left out"),
        Format("gltf", ".glb", "Blender, three.js, engines", scene.write, "left out", draws=True),
        Format("mp4", ".mp4", "any player", film.write, "pale", draws=True),
        Format("npz", ".npz", "numpy", arrays.write, "kept", gaps=True),
        Format("parquet", ".parquet", "pandas, pyarrow, duckdb", table.write, "kept", gaps=True),
        Format("obj", ".obj", STILLS, mesh_frames.write, "left out", draws=True),
    )
}
ENDINGS = tuple(form.ending for form in FORMATS.values())
REMEDY = f"Name the file by what it is to be: {', '.join(ENDINGS)}."


@dataclass(frozen=True)
class Written:
    """A file, or a folder of files, of a motion. lost: what of the face it does not keep."""

    path: Path
    format: Format
    motion: Motion
    lost: tuple[str, ...]

    def __str__(self) -> str:
        """One line."""
        frames = len(self.motion)
        faceless = frames - int(self.motion.frames["valid"].sum())
        left_out = faceless if self.format.faceless == "left out" else 0
        kept = words.plural(frames - left_out, "frame")
        text = f"wrote {self.path} (for {self.format.program}): {kept}"
        text += f" at {float(self.motion.fps):g} per second"
        if left_out:
            text += f", without the {words.count(left_out)} that show no face"
        elif faceless and self.format.faceless == "pale":
            text += f", pale in the {words.count(faceless)} that show no face"
        moved = self.motion.moved
        rest = [name for name in CHANNELS if name not in moved]
        if rest and not self.format.gaps:
            some = words.listing(rest) if len(rest) < 6 else f"{len(rest)} channels"
            text += f"; at 0, as nothing is known of {'it' if len(rest) == 1 else 'them'}: {some}"
        if self.lost:
            text += f"; not kept: {', '.join(self.lost)}"
        return printable(text)


def format_of(path: Path) -> Format:
    """The format that a file's ending means. Raises BadFile for none."""
    ending = path.suffix.casefold()
    for form in FORMATS.values():
        if form.ending == ending:
            return form
    found = f"a name that ends in {ending}" if ending else "a name without an ending"
    raise BadFile(path, found=found, expected=f"one of {', '.join(ENDINGS)}", remedy=REMEDY)


def write(motion: Motion, path: Path, face: Face) -> Written:
    """Write a motion; the file is whole or not there. face: for the formats that show one.

    Raises BadFile for an ending that is no format's, a motion without a frame to write, and a place
    that cannot be written to.
    """
    form = format_of(path)
    try:
        lost = form.write(motion, path, face) if form.draws else form.write(motion, path)
    except OSError as error:
        raise unreadable(
            path, error, expected="a place to write to", remedy="Choose another one."
        ) from error
    target = path.with_suffix("") if form.name == "obj" else path
    return Written(target, form, motion, tuple(lost or ()))


def read(path: Path, options: Options) -> Motion:
    """The motion of a file: one of ours, glTF with named morph targets, or any tracking result.

    options: how a tracking result is read. What lies beside a file of ours is taken into account.
    Raises NoSuchFile where there is none, BadFile for a file that holds no motion.
    """
    path = Path(path)
    if not path.exists():
        raise NoSuchFile(
            path,
            found="no such file",
            expected="a motion, or a tracking result",
            remedy="See that the path is right.",
        )
    ending = path.suffix.casefold()
    if not options.named and ending == ".glb":
        return scene.read(path, _said_rate(options))
    if not options.named and ending == ".npz" and arrays.holds(path):
        return arrays.read(path)
    if not options.named and ending == ".parquet" and table.holds(path):
        return table.read(path)
    return _take(path, options)


def _take(path: Path, options: Options) -> Motion:
    """A tracking result, with what lies beside it where it is one of ours."""
    format = options.format if options.named else format_of_take(path, options)
    if format is None:
        raise BadFile(
            path,
            found="nothing that moves a face",
            expected=f"a motion of ours (.glb, .npz, .parquet), glTF with morph targets, or a "
            f"tracking result ({', '.join(READERS)})",
            remedy="--format NAME reads it as that format; `mimeline inspect` says what it is.",
        )
    options.refuse_idle({format})
    tracker, told = options.tracker(format), about.read_beside(path)
    rate = about.rate(told)
    if rate and "fps" in tracker.reading and not options.knows_fps(format):
        tracker = replace(tracker, reading={**tracker.reading, "fps": str(rate)})
    result = Result.read(tracker, path, options.ingest["max_loss"])
    return about.informed(Motion.of_take(result.take), told)


def _said_rate(options: Options) -> Fraction | None:
    """The rate that somebody said of takes of any format."""
    rates = {own["fps"] for own in options.ingest.values() if type(own) is dict and "fps" in own}
    said = any(key.rpartition(".")[2] == "fps" for key in options.told)
    return Fraction(rates.pop()) if said and len(rates) == 1 else None
