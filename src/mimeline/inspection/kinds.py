"""Which kind of thing a path is: told by what is in it, or by the format that somebody names."""

from pathlib import Path

from mimeline.errors import BadFile, NoSuchFile, unreadable
from mimeline.inspection import files
from mimeline.inspection.catalogues import catalogue, table_of_clips
from mimeline.inspection.folder import inspect_folder
from mimeline.inspection.inspection import Inspection
from mimeline.inspection.options import Options
from mimeline.inspection.recognise import format_of, is_video, may_be
from mimeline.inspection.take import inspect_take
from mimeline.tracking.formats.columns import header_of, read_columns
from mimeline.tracking.readers import READERS

EXPECTED = "a file or a folder that can be read"
OTHERS = {  # ending → what looks into such a file
    ".parquet": files.table,
    ".json": catalogue,
    ".csv": files.head_poses,
    **dict.fromkeys(files.FACES, files.face),
    ".pkl": lambda path: catalogue(path) or files.face(path),
}


def inspect(path: Path, options: Options) -> Inspection:
    """What is at path. Raises NoSuchFile where nothing is, BadFile where nobody knows it.

    A file that is known and cannot be read is no exception here: its inspection says why.
    """
    path = Path(path)
    try:
        return _inspect(path, options)
    except OSError as error:
        raise unreadable(path, error, expected=EXPECTED, remedy="Check the path.") from error


def _inspect(path: Path, options: Options) -> Inspection:
    if not (path.is_file() or path.is_dir()):
        found = "neither a file nor a folder" if path.exists() else "no such file or folder"
        kind = BadFile if path.exists() else NoSuchFile
        raise kind(path, found=found, expected=EXPECTED, remedy="Check the path.")
    if format := options.format if options.named and path.is_file() else format_of(path, options):
        options.refuse_idle({format})
        return inspect_take(path, format, options)
    if path.is_dir():
        return inspect_folder(path, options)
    if is_video(path):
        return files.video(path)
    if files.is_losses(path):
        return files.losses(path)
    if seen := table_of_clips(path, options):
        return seen
    if (look := OTHERS.get(path.suffix.lower())) and (seen := look(path)):
        return seen
    if options.format and may_be(path, options.format):  # the configuration knows better
        options.refuse_idle({options.format})
        return inspect_take(path, options.format, options)
    if path.suffix.lower() == ".csv" and len(header_of(path)) == 1:
        read_columns(path)  # says what separates them where it is no comma
    raise BadFile(
        path,
        found=_beginning(path),
        expected=f"a tracking result ({', '.join(READERS)}), a video, a table of a run, "
        "a catalogue (CelebV-Text, CelebV-HQ, a table of clips), a list of exclusions, "
        "6DRepNet angles or a face model",
        remedy="--format NAME reads it as that format and says what is missing.",
    )


def _beginning(path: Path) -> str:
    """How a file begins, for people."""
    with path.open("rb") as file:
        head = file.read(60)
    if not head:
        return "an empty file"
    text = head.decode("utf-8", errors="replace").splitlines()[0]
    return f"a file that begins with {text!r}"
