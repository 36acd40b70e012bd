"""EMOCA's and DECA's codes: a folder per clip, in it a folder per frame and face.

EMOCA numbers the frames of a video from 1 and the faces of a frame from 0 (000001_000), and saves
exp.npy and pose.npy in each; DECA counts from 0 (<name>_frame0000), or from 1 where the pictures
that it was given do, and its codes are in <frame>.mat. A frame without a face has no folder.
FLAME's vertices go to the picture by a scaling and a shift, then y and z change sign: so the camera
looks along FLAME's -z with y up, and the root rotation is the head's against the camera as it
stands; nothing is turned about.
Source: Feng et al. 2021 (DECA), Danecek et al. 2022 (EMOCA), and the authors' code.
"""

import io
import logging
import os
import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.archives import mat
from mimeline.errors import BadFile, MimelineError, unreadable
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.flame_take import EXPRESSION, joint, take_of
from mimeline.tracking.take import MOST_FRAMES, Take

log = logging.getLogger(__name__)

FRAME = re.compile(r"(?P<counted>.*frame)?(?P<frame>[0-9]{1,9})(_(?P<face>[0-9]{3}))?")
N_EXPRESSIONS, N_POSE = 50, 6
COLUMNS = [*EXPRESSION[:N_EXPRESSIONS], *joint("head"), *joint("jaw")]
MOST_BYTES = 4096  # of an .npy file: a code has 50 numbers
MOST_MAT_BYTES = 100_000
MOST_FOLDERS = 64  # that are looked into for codes

Frames = dict[int, dict[int, str]]  # number → face → name of its folder

ENDINGS: tuple[str, ...] = ()
CONVENTION = Convention(
    title="EMOCA and DECA codes",
    files="a folder, in it (or in results/<model>) 000001_000/exp.npy and pose.npy per frame and "
    "face, counted from 1; or DECA's <name>_frame0000/<name>_frame0000.mat, counted from 0",
    coefficients="FLAME: 50 expressions, root and jaw; shape, texture, light and detail are left "
    "alone",
    axes="FLAME's, the subject's: +x to the subject's left, +y up, +z out of the face",
    rotation="pose: root, then jaw, each axis times angle; root is the head against the camera",
    angle_unit="radians",
    sides="the subject's",
    first_frame=1,
    gap="no folder",
    never="gaze and eyelids; ARKit channels but the jaw's where the user's FLAME file is not given",
    evidence="derived from the projection in the authors' public code; no recording",
    meanings={
        "head_yaw_left": "+y of the root, where the other two are 0",
        "head_pitch_up": "-x of the root, where the other two are 0",
        "head_tilt_left": "-z of the root, where the other two are 0",
    },
)


def holds(path: Path) -> bool:
    """Whether a folder holds folders of frames with codes."""
    try:
        return len(_homes(path)) == 1
    except (OSError, MimelineError):
        return False


def read(path: Path, fps: str, face: Path | None, bad_values: str) -> Take:
    """Read the codes of a clip; of several faces in a frame, the first that was found.

    fps: of the video. face: the user's FLAME file, or None. bad_values: "fail" or "mask", of
    numbers that are none and of folders whose codes are missing or cannot be read; where none of
    them can be, the take cannot.
    Raises BadFile, with the frame, for what are no such codes.
    """
    folder, frames, kind = _home(path)
    shared = sum(len(faces) > 1 for faces in frames.values())
    if shared:
        log.warning("%s: several faces in %d frames, the first of each is taken", path, shared)
    read_code = READ[kind]()
    numbers = sorted(frames)
    rows = np.full((len(numbers), len(COLUMNS)), np.nan)
    failure = None
    for row, number in enumerate(numbers):
        name = frames[number][min(frames[number])]
        try:
            code = _code(read_code, folder / name)
        except BadFile as error:
            if bad_values == "fail":
                raise
            failure = failure or error
            continue
        if code is not None:
            rows[row] = code
        elif bad_values == "fail":
            raise BadFile(
                path,
                place=name,
                found="no codes",
                expected="those of every frame that has a folder",
                remedy="Run it again, or set ingest.bad_values: mask to treat it as a gap.",
            )
    if failure and np.isnan(rows).all():
        raise failure
    counted = any(FRAME.fullmatch(next(iter(f.values())))["counted"] for f in frames.values())
    return take_of(
        pd.DataFrame(rows, columns=COLUMNS),
        np.array(numbers) - min(numbers[0], 1),
        np.ones(len(numbers), bool),
        Fraction(fps),
        face,
        bad_values,
        path,
        first_frame=None if counted and numbers[0] == 0 else numbers[0],
        numbered=True,
    )


def _code(read_code: Callable, folder: Path) -> np.ndarray | None:
    """A frame's code, None where its folder has none. Raises BadFile where it cannot be read."""
    try:
        return read_code(folder)
    except OSError as error:
        raise _no_code(folder, str(error)) from error


def _home(path: Path) -> tuple[Path, Frames, str]:
    """The folder that holds the frames' folders, these, and what their codes are saved as."""
    expected = "a folder per frame with exp.npy and pose.npy, or with DECA's .mat"
    remedy = "Run EMOCA with --save_codes True; add exp and pose to what DECA saves as .mat."
    try:
        homes = _homes(path)
    except OSError as error:
        raise unreadable(path, error, expected=expected, remedy=remedy) from error
    if not homes:
        raise BadFile(path, found="no codes", expected=expected, remedy=remedy)
    if len(homes) > 1:
        raise BadFile(
            path,
            found=f"codes in {homes[0][0].name} and in {homes[1][0].name}",
            expected="those of one model",
            remedy="Leave one of them there.",
        )
    return homes[0]


def _homes(path: Path) -> list[tuple[Path, Frames, str]]:
    """Every folder of a clip's that holds codes: itself, one below, or one below its results."""
    frames, below = _listed(path)
    if kind := _kind(path, frames):
        return [(path, frames, kind)]
    if (path / "results").is_dir():
        below += _listed(path / "results")[1]
    homes = []
    for folder in sorted(below)[:MOST_FOLDERS]:
        frames, _ = _listed(folder)
        if kind := _kind(folder, frames):
            homes.append((folder, frames, kind))
    return homes


def _listed(folder: Path) -> tuple[Frames, list[Path]]:
    """The folders in a folder: those that are named as frames are, and the others."""
    frames: Frames = {}
    others = []
    with os.scandir(folder) as entries:
        for entry in entries:
            if not entry.is_dir():
                continue
            if not (named := FRAME.fullmatch(entry.name)):
                others.append(Path(entry.path))
                continue
            faces = frames.setdefault(int(named["frame"]), {})
            if other := faces.get(face := int(named["face"] or 0)):
                raise BadFile(
                    folder,
                    found=f"{other} and {entry.name}",
                    expected="a folder for each face of a frame",
                    remedy="Keep the results of one video in a folder.",
                )
            faces[face] = entry.name
            if len(frames) > MOST_FRAMES:
                raise BadFile(
                    folder,
                    found=f"more than {MOST_FRAMES} frames",
                    expected="fewer in a take",
                    remedy="Split the take.",
                )
    return frames, others


def _kind(folder: Path, frames: Frames) -> str:
    """What the codes of the first frames are saved as, "" where there are none."""
    for number in sorted(frames)[:MOST_FOLDERS]:
        name = frames[number][min(frames[number])]
        for kind, file in (("npy", "exp.npy"), ("mat", f"{name}.mat")):
            if (folder / name / file).is_file():
                return kind
    return ""


def _npy_reader() -> Callable[[Path], np.ndarray | None]:
    """What reads a frame's exp.npy and pose.npy; their headers are all alike, and parsed once."""
    types: dict[bytes, tuple[tuple[int, ...], np.dtype]] = {}

    def vector(path: Path, length: int) -> np.ndarray:
        with open(path, "rb", buffering=0) as file:
            data = file.read(MOST_BYTES)
        start = 10 + int.from_bytes(data[8:10], "little")
        header = data[:start]
        if header not in types:
            types[header] = _type_of(header, path)
        shape, kind = types[header]
        if shape not in ((length,), (1, length)):
            raise _no_code(path, f"shape {shape}", length)
        if len(data) - start != length * kind.itemsize:
            raise _no_code(path, f"{len(data) - start} bytes", length)
        return np.frombuffer(data, kind, length, start)

    def code(folder: Path) -> np.ndarray | None:
        expression, pose = folder / "exp.npy", folder / "pose.npy"
        if not (expression.is_file() and pose.is_file()):
            return None
        return np.concatenate([vector(expression, N_EXPRESSIONS), vector(pose, N_POSE)])

    return code


def _type_of(header: bytes, path: Path) -> tuple[tuple[int, ...], np.dtype]:
    """Shape and type of the numbers of an .npy file with this header."""
    file = io.BytesIO(header)
    try:
        if np.lib.format.read_magic(file) != (1, 0):
            raise ValueError("a later version of the format")
        shape, _, kind = np.lib.format.read_array_header_1_0(file)
    except Exception as error:  # the header is a literal that may be anything
        raise _no_code(path, "a spoilt header") from error
    if kind.kind not in "fiu" or len(shape) > 2:
        raise _no_code(path, f"{kind} of {len(shape)} axes"[:100])
    return shape, kind


def _no_code(path: Path, found: str, length: int | str = "a code's") -> BadFile:
    return BadFile(
        path,
        found=found,
        expected=f"an .npy file of {length} numbers",
        remedy="Run EMOCA with --save_codes True again.",
    )


def _mat_reader() -> Callable[[Path], np.ndarray | None]:
    """What reads exp and pose of a frame's .mat file."""

    def code(folder: Path) -> np.ndarray | None:
        path = folder / f"{folder.name}.mat"
        if not path.is_file():
            return None
        found = mat.read_arrays(path, ("exp", "pose"), MOST_MAT_BYTES)
        parts = []
        for key, length in (("exp", N_EXPRESSIONS), ("pose", N_POSE)):
            if key not in found or found[key].size != length:
                raise BadFile(
                    path,
                    place=f"variable {key}",
                    found=f"shape {found[key].shape}" if key in found else "no such variable",
                    expected=f"{length} numbers",
                    remedy="DECA's --saveMat saves what it decoded: add exp and pose of its codes.",
                )
            parts.append(found[key].ravel())
        return np.concatenate(parts)

    return code


READ = {"npy": _npy_reader, "mat": _mat_reader}
