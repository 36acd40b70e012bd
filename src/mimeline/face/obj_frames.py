"""A face that moves, as a folder of Wavefront OBJ files: one for each frame."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from mimeline.face.model import Face


def write(folder: Path, name: str, face: Face, frames: Iterable[tuple[int, np.ndarray]]) -> int:
    """Write <name>_<frame>.obj for each frame's vertices (V, 3); metres, colours after positions.

    Every file has the same vertices and triangles in the same order. Returns how many were
    written.
    """
    colours = face.colours / 255
    triangles = "".join(f"f {a} {b} {c}\n" for a, b, c in (face.triangles + 1).tolist())
    looks = [f" {red:.4f} {green:.4f} {blue:.4f}" for red, green, blue in colours.tolist()]
    count = 0
    for frame, vertices in frames:
        lines = (
            f"v {x:.7f} {y:.7f} {z:.7f}{look}\n"
            for (x, y, z), look in zip(vertices.tolist(), looks, strict=True)
        )
        text = f"o {name}\n{''.join(lines)}{triangles}"
        (folder / f"{name}_{frame:05d}.obj").write_text(text, encoding="utf-8")
        count += 1
    return count
