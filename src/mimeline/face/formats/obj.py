"""Face models as a folder of Wavefront OBJ files: neutral.obj and one file per shape."""

import io
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, unreadable
from mimeline.face.formats.shapes import head_only, metres_per_unit, named
from mimeline.face.model import Face

NEUTRAL = "neutral.obj"
IDENTITY = "identity"
MAX_FILES, MAX_BYTES = 1000, 100_000_000  # of a folder; of a file
REMEDY = "Export the mesh as OBJ again, with every vertex in the same order in all files."


def from_folder(folder: Path) -> Face:
    """The face of a folder: neutral.obj, <channel>.obj at 1, identity<...>.obj at 1.

    Vertices may carry colours (x y z red green blue, 0-1). Raises BadFile as `named` does, and
    where a file is no OBJ or has another number of vertices.
    """
    neutral, colours = read_vertices(folder / NEUTRAL)
    triangles = read_triangles(folder / NEUTRAL, len(neutral))
    offsets = read_offsets(folder, NEUTRAL, neutral)
    unit = metres_per_unit(folder / NEUTRAL, neutral)
    identities = [name for name in offsets if name.startswith(IDENTITY)]
    shapes = [name for name in offsets if not name.startswith(IDENTITY)]
    joints, skin = head_only(neutral * unit)
    return named(
        folder,
        neutral=neutral * unit,
        triangles=triangles,
        shapes=stacked(offsets, shapes, neutral) * unit,
        shape_names=shapes,
        joints=joints,
        skin=skin,
        colours=colours,
        identities=stacked(offsets, identities, neutral) * unit,
        identity_names=identities,
    )


def read_offsets(folder: Path, neutral_name: str, neutral: np.ndarray) -> dict[str, np.ndarray]:
    """File stem → offsets (V, 3) from neutral (V, 3), of every other OBJ file of the folder.

    Raises BadFile where a file has another number of vertices.
    """
    paths = sorted(path for path in folder.glob("*.obj") if path.name != neutral_name)
    if len(paths) > MAX_FILES:
        raise BadFile(
            folder,
            found=f"{len(paths)} OBJ files",
            expected=f"at most {MAX_FILES}",
            remedy="Keep one neutral face and one file per shape in the folder.",
        )
    offsets = {}
    for path in paths:
        vertices, _ = read_vertices(path)
        if vertices.shape != neutral.shape:
            raise BadFile(
                path,
                found=f"{len(vertices)} vertices",
                expected=f"{len(neutral)}, as in {neutral_name}",
                remedy=REMEDY,
            )
        offsets[path.stem] = vertices - neutral
    return offsets


def stacked(offsets: dict[str, np.ndarray], names: list[str], neutral: np.ndarray) -> np.ndarray:
    """Offsets (n, V, 3) of the names, also where there are none."""
    return np.stack([offsets[n] for n in names]) if names else np.zeros((0, *neutral.shape))


def read_vertices(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Vertices (V, 3) float64 of an OBJ file, and their colours (V, 3) uint8 or None.

    Raises BadFile where the file is no OBJ, or its lines disagree.
    """
    rows = b"\n".join(line[2:] for line in _lines(path) if line.startswith(b"v "))
    expected = "v x y z, or v x y z r g b, in numbers"
    try:
        table = pd.read_csv(io.BytesIO(rows), sep=r"\s+", header=None, dtype=np.float64)
    except ValueError as error:  # pandas' own errors are ValueErrors
        found = str(error) if rows else "no v lines"
        raise BadFile(path, found=found, expected=expected, remedy=REMEDY) from error
    values = table.to_numpy()  # (V, 3-7)
    if values.shape[1] not in (3, 4, 6, 7) or not np.isfinite(values).all():
        found = f"v lines of {values.shape[1]} numbers, or not all finite"
        raise BadFile(path, found=found, expected=expected, remedy=REMEDY)
    colours = None
    if values.shape[1] >= 6:
        colours = np.rint(255 * np.clip(values[:, -3:], 0, 1)).astype(np.uint8)  # (V, 3)
    return values[:, :3], colours


def read_triangles(path: Path, n_vertices: int) -> np.ndarray:
    """Triangles (F, 3) of an OBJ file's polygons, counted from 0.

    Raises BadFile where a polygon is not one of known vertices.
    """
    triangles = []
    for number, line in enumerate(_lines(path), start=1):
        if not line.startswith(b"f "):
            continue
        try:
            corners = [int(corner.split(b"/")[0]) for corner in line[2:].split()]
        except ValueError:
            corners = []
        corners = [c - 1 if c > 0 else n_vertices + c for c in corners]  # negative: from the end
        if len(corners) < 3 or not all(0 <= c < n_vertices for c in corners):
            raise BadFile(
                path,
                place=f"line {number}",
                found=line[:60].decode(errors="replace"),
                expected=f"f with three or more of {n_vertices} vertices",
                remedy=REMEDY,
            )
        triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    if not triangles:
        raise BadFile(path, found="no f lines", expected="polygons", remedy=REMEDY)
    return np.array(triangles)


def _lines(path: Path) -> list[bytes]:
    expected, remedy = f"a Wavefront OBJ file of at most {MAX_BYTES // 10**6} MB", REMEDY
    try:
        if path.stat().st_size > MAX_BYTES:
            found = f"{path.stat().st_size // 10**6} MB"
            raise BadFile(path, found=found, expected=expected, remedy=remedy)
        return path.read_bytes().splitlines()
    except OSError as error:
        raise unreadable(path, error, expected=expected, remedy=remedy) from error
