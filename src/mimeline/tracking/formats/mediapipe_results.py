"""FaceLandmarker results as people write them to JSON, one row per frame.

A frame is {name: score}, the list of a face's categories, the list of its faces, or a whole result
of MediaPipe's in its Python or JavaScript spelling. Untrusted: large, deep, repeated, endless.
"""

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, unreadable
from mimeline.tracking.formats.columns import EXPRESSION_RANGE
from mimeline.vocabulary import canonical

LARGEST = 2**27  # bytes of a file
# Values, lists and objects, which take far more memory than their text: 40 s of whole results with
# their landmarks, 8 min of categories.
MOST_PARTS = 4_000_000
PEEK = 2**18  # bytes that are looked at to tell a file: two results with their landmarks
FACES = ("faceBlendshapes", "face_blendshapes")
MATRICES = ("facialTransformationMatrixes", "facial_transformation_matrixes")
NAMES = ("categoryName", "category_name")
MATRIX = tuple(f"matrix_{place}" for place in range(16))
NUMBERING = ("frame", "timestamp_ms")  # what says when a frame was, the first that there is


def names_scores(path: Path) -> bool:
    """Whether a file begins like JSON of FaceLandmarker results."""
    try:
        with open(path, "rb") as file:
            start = file.read(PEEK).removeprefix(b"\xef\xbb\xbf").lstrip()
    except OSError:
        return False
    words = (*FACES, "eyeBlinkLeft", *NAMES)
    return start.startswith(b"[") and any(f'"{word}"'.encode() in start for word in words)


def rows_of(path: Path, bad_values: str) -> pd.DataFrame:
    """A row per frame: scores by name, frame and timestamp_ms where told, matrix_0 ... matrix_15.

    Empty cells are "" : a frame without a face has no score. bad_values: "fail" raises BadFile at
    the first score that is no number, "mask" leaves it as text. Raises BadFile.
    """
    frames = _loaded(path)
    if not isinstance(frames, list):
        raise _refused(path, "", found=_kind(frames), expected="a list of frames")
    try:
        rows = [_row(frame, f"frame {at}", path, bad_values) for at, frame in enumerate(frames)]
    except RecursionError as error:
        raise _refused(path, "", found="lists in lists", expected="a list of frames") from error
    table = pd.DataFrame.from_records(rows, index=pd.RangeIndex(len(rows)))
    return table.astype(object).where(table.notna(), "") if len(table.columns) else table


def _loaded(path: Path) -> Any:
    try:
        if not path.is_file() and path.exists():  # a device has no end
            raise BadFile(path, found="no plain file", expected="JSON", remedy="Name the file.")
        n_bytes = path.stat().st_size
        content = path.read_bytes() if n_bytes <= LARGEST else b""
        n_parts = sum(content.count(mark) for mark in (b",", b"[", b"{"))
        if n_bytes > LARGEST or n_parts > MOST_PARTS:
            raise BadFile(
                path,
                found=f"{n_bytes / 2**20:.0f} MiB" if n_bytes > LARGEST else f"{n_parts} parts",
                expected=f"at most {LARGEST / 2**20:.0f} MiB and {MOST_PARTS} parts",
                remedy="Leave the landmarks out, or write a CSV.",
            )
        return json.loads(
            content.decode("utf-8-sig"),
            object_pairs_hook=_each_once,
            parse_constant=_no_constant,
            parse_int=float,
        )
    except (OSError, ValueError, RecursionError) as error:
        raise unreadable(
            path,
            error,
            expected="JSON with a list of FaceLandmarker results",
            remedy="Write the results again.",
        ) from error


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for key, value in pairs:
        if key in content:
            raise ValueError(f"key {key[:40]!r} twice")
        content[key] = value
    return content


def _no_constant(word: str) -> None:
    raise ValueError(f"{word}, which is no JSON")


def _row(frame: Any, place: str, path: Path, bad_values: str) -> dict[str, float | str]:
    row: dict[str, float | str] = {}
    faces, matrices = frame, None
    if isinstance(frame, dict):
        told = [name for name in NUMBERING if name in frame]
        row |= {name: _number(frame[name], name, place, path, bad_values) for name in told}
        _check_matrix_named(frame, place, path)
        matrices = next((frame[key] for key in MATRICES if key in frame), None)
        faces = next((frame[key] for key in FACES if key in frame), frame)
    categories = _categories(faces, place, path)
    for name, score in categories:
        channel = _channel(name)
        if channel is None:
            continue  # _neutral, and whatever stands beside the scores
        if channel in row:
            raise _refused(path, place, found=f"{channel} twice", expected="each name once")
        row[channel] = _number(score, channel, place, path, bad_values)
        if isinstance(score, float) and not EXPRESSION_RANGE[0] <= score <= EXPRESSION_RANGE[1]:
            found = f"{channel} {score:g}"
            raise _refused(path, place, found=found, expected="a score between 0 and 1")
    if categories and not set(row) - set(NUMBERING):
        raise _refused(
            path, place, found="no ARKit name", expected="scores by their categories' names"
        )
    if matrices and categories:
        row |= zip(MATRIX, _matrix(matrices, place, path), strict=True)
    return row


@lru_cache(maxsize=1024)
def _channel(name: str) -> str | None:
    return canonical(name)


def _check_matrix_named(frame: dict[str, Any], place: str, path: Path) -> None:
    """Raises BadFile where a matrix stands under a name of which nothing is known."""
    for key in frame:
        if "matri" in key.casefold() and key not in MATRICES:
            raise _refused(
                path,
                place,
                found=key[:40],
                expected=" or ".join(MATRICES),
                remedy="Rename it, or leave it out: the head is then not measured.",
            )


def _categories(faces: Any, place: str, path: Path) -> list[tuple[str, Any]]:
    """Names and scores of the only face; none where there is no face."""
    if faces is None or faces == []:
        return []
    if isinstance(faces, dict):
        if "categories" in faces:
            return _categories(faces["categories"], place, path)
        beside = {*NUMBERING, *MATRICES}
        return [(name, score) for name, score in faces.items() if name not in beside]
    if not isinstance(faces, list) or not all(isinstance(part, dict | list) for part in faces):
        found = f"{len(faces)} numbers" if isinstance(faces, list) else _kind(faces)
        raise _refused(path, place, found=found, expected="scores by their categories' names")
    if all(isinstance(part, dict) and any(key in part for key in NAMES) for part in faces):
        return [
            (str(next(part[key] for key in NAMES if key in part)), part.get("score"))
            for part in faces
        ]
    if len(faces) > 1:
        raise _refused(
            path,
            place,
            found=f"{len(faces)} faces",
            expected="one: they are not told apart from frame to frame",
            remedy="Track with num_faces: 1.",
        )
    return _categories(faces[0], place, path)


def _matrix(matrices: Any, place: str, path: Path) -> list[float]:
    """Sixteen numbers of the only face's matrix, in the order in which they stand."""
    first = matrices[0] if isinstance(matrices, list) else matrices
    data = first.get("data") if isinstance(first, dict) else first
    if isinstance(data, float):
        data = matrices  # the sixteen numbers alone
    if isinstance(data, list) and data and all(isinstance(part, list) for part in data):
        data = [cell for part in data for cell in part]
    if not isinstance(data, list) or len(data) != 16 or not all(_finite(cell) for cell in data):
        raise _refused(
            path, place, found="another matrix", expected="sixteen numbers of a 4 x 4 matrix"
        )
    return data


def _number(value: Any, name: str, place: str, path: Path, bad_values: str) -> float | str:
    """The value, or text in its place that `numbers` masks."""
    if _finite(value):
        return value
    if bad_values == "fail":
        found = f"{name} {str(value)[:40]!r}"
        raise _refused(path, place, found=found, expected="a number")
    return "no number"


def _finite(cell: Any) -> bool:
    return isinstance(cell, float) and abs(cell) < np.inf


def _kind(value: Any) -> str:
    kinds = {dict: "an object", list: "a list", str: "text", float: "a number"}
    return kinds.get(type(value), str(value))


def _refused(
    path: Path, place: str, found: str, expected: str, remedy: str = "Write the results again."
) -> BadFile:
    return BadFile(path, place=place, found=found, expected=expected, remedy=remedy)
