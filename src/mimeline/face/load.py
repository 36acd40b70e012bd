"""Any supported face model, told by what its file or folder holds."""

from pathlib import Path

from mimeline.archives import mat
from mimeline.archives.npz import read_arrays
from mimeline.archives.pickled import read_pickled
from mimeline.errors import BadFile, unreadable
from mimeline.face.embedded import embedded_face
from mimeline.face.fitting import Unfit
from mimeline.face.formats import bfm, flame, ict, obj, shapes
from mimeline.face.model import Face
from mimeline.face.motion import driver

ACCEPTED = (
    f"a folder with {ict.NEUTRAL} (ICT-FaceKit) or {obj.NEUTRAL}, an npz of named shapes, "
    "of ICT-FaceKit or of FLAME, FLAME's published pickle, or BFM_model_front.mat"
)
REMEDY = "docs/face.md has the layout of each."
ZIP, PICKLES, MATLAB = b"PK\x03\x04", (b"\x80", b"(d", b"}"), b"MATLAB "
POINTER = b"version https://git-lfs"


def load_face(path: Path | None) -> Face:
    """The face model at path; None: the embedded one.

    path: a folder of OBJ files, an npz, FLAME's pickle or BFM_model_front.mat, told apart by
    content. Metres and the subject's frame, whatever the file's were.
    Raises BadFile, with what was found, for anything else and for a model that is not whole.
    """
    if path is None:
        return embedded_face()
    path = Path(path)
    try:
        return _from_folder(path) if path.is_dir() else _from_file(path)
    except Unfit as error:
        raise BadFile(
            path,
            place=error.part,
            found=error.found,
            expected=error.expected,
            remedy=f"Export the model again. {REMEDY}",
        ) from error


def load_driven_face(path: Path | None) -> Face:
    """A face that channels move: `load_face`'s, with shapes that are named as ARKit's.

    Raises BadFile as `load_face` does, and for a model whose shapes have no such names (FLAME,
    BFM): what moves these is not in a motion.
    """
    face = load_face(path)
    if not any(driver(shape) for shape in face.shape_names):
        names = ", ".join(face.shape_names[:3])
        raise BadFile(
            path,
            found=f"a face of {len(face.shape_names)} shapes ({names}, ...), none of a channel",
            expected="shapes with ARKit's names (jawOpen, browInnerUp), as ICT-FaceKit has",
            remedy=f"Name a model that has them, or leave it out for our own. {REMEDY}",
        )
    return face


def _from_folder(folder: Path) -> Face:
    if (folder / ict.NEUTRAL).exists():
        return ict.from_folder(folder)
    if (folder / obj.NEUTRAL).exists():
        return obj.from_folder(folder)
    names = sorted(path.name for path in folder.iterdir())
    found = f"a folder of {', '.join(names[:5])}" if names else "an empty folder"
    raise BadFile(folder, found=found, expected=ACCEPTED, remedy=REMEDY)


def _from_file(path: Path) -> Face:
    try:
        with open(path, "rb") as file:
            start = file.read(64)
    except OSError as error:
        raise unreadable(path, error, expected=ACCEPTED, remedy=REMEDY) from error
    if start.startswith(ZIP):
        return _from_npz(path)
    if start.startswith(POINTER):
        remedy = "Fetch the file itself with `git lfs pull`."
        raise BadFile(path, found="a Git LFS pointer", expected=ACCEPTED, remedy=remedy)
    if start.startswith(PICKLES):
        return flame.from_arrays(path, read_pickled(path))
    if start.startswith(MATLAB):
        return bfm.from_arrays(path, mat.read_arrays(path, bfm.ARRAYS))
    found = f"a file that begins with {start[:16]!r}" if start else "an empty file"
    raise BadFile(path, found=found, expected=ACCEPTED, remedy=REMEDY)


def _from_npz(path: Path) -> Face:
    arrays = read_arrays(path, f"Write plain arrays with numpy.savez. {REMEDY}")
    if "expr_delta" in arrays:
        return ict.from_arrays(path, arrays)
    if "v_template" in arrays:
        return flame.from_arrays(path, arrays)
    return shapes.from_arrays(path, arrays)
