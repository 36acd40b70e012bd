"""What a .frame of metrical-tracker tells: a row of numbers, and which of them is what."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mimeline.archives.torch_saved import read_saved
from mimeline.errors import BadFile
from mimeline.tracking.formats.flame_take import EXPRESSION

# Field → its shape, but for the leading 1; and those that only landmarks are held to.
FIELDS: dict[str, tuple[int, ...]] = {
    "flame.exp": (len(EXPRESSION),),
    "flame.jaw": (6,),
    "flame.eyes": (12,),
    "flame.eyelids": (2,),
    "camera.R": (6,),
    "opencv.R": (3, 3),
}
SEEN = {"flame.shape": (300,), "opencv.t": (3,), "opencv.K": (3, 3)}
FEWER = ("flame.exp", "flame.shape")  # a tracker may have less of them: the others rest
SHAPES = FIELDS | SEEN
ENDS = np.cumsum([math.prod(shape) for shape in SHAPES.values()])
PLACES = {
    name: slice(end - math.prod(shape), end)
    for (name, shape), end in zip(SHAPES.items(), ENDS, strict=True)
}
WIDTH = int(ENDS[-1])  # of a row
REMEDY = (
    "Let the tracker make the frame anew (delete it and those after it, and start it again), or "
    "set ingest.bad_values: mask to treat it as a gap."
)


def field_of(rows: np.ndarray, name: str) -> np.ndarray:
    """A field (n, *its shape) of the rows (n, WIDTH) of frames; NaN where a frame lacks it."""
    return rows[:, PLACES[name]].reshape(len(rows), *SHAPES[name])


def read_frame(file: Path, number: int, fields: Mapping[str, tuple[int, ...]]) -> np.ndarray:
    """A row (WIDTH,) with the fields of a frame; NaN where it lacks one, or it was not asked for.

    number: as in the file's name. fields: of SHAPES.
    Raises BadFile for a frame of another number, or a field that is not of its shape.
    """
    row = np.full(WIDTH, np.nan)
    content = read_saved(file, REMEDY)
    frame_id = content.get("frame_id", number)
    if str(frame_id)[:20].lstrip("0") != str(number).lstrip("0"):
        raise BadFile(
            file,
            place="frame_id",
            found=repr(str(frame_id)[:20]),
            expected=f"{number:05d}, as the file's name says",
            remedy="Give the file its own name back. Frames count from 0; the pictures beside "
            "them from 1, and from begin_frames on where the tracker skipped some.",
        )
    for name, shape in fields.items():
        group, _, field = name.partition(".")
        values = content[group].get(field) if isinstance(content.get(group), dict) else None
        if values is None and name != "flame.exp":
            continue
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu":
            _refuse(file, name, "nothing" if values is None else "no numbers", shape)
        found = values.shape[1:] if values.ndim > len(shape) else values.shape
        fewer = name in FEWER and len(found) == 1 and 0 < found[0] < shape[0]
        if values.size != math.prod(found) or (found != shape and not fewer):
            _refuse(file, name, str(values.shape), shape)
        if not np.isfinite(values).all():
            _refuse(file, name, "a NaN or infinity", shape)
        row[PLACES[name]] = 0
        row[PLACES[name]][: values.size] = values.ravel()
    return row


def _refuse(file: Path, name: str, found: str, shape: tuple[int, ...]) -> None:
    expected = f"numbers of shape {(1, *shape)}"
    raise BadFile(file, place=name, found=found, expected=expected, remedy=REMEDY)
