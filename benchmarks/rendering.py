"""How fast faces are drawn on one core: frames per second against 30 (real time).

python benchmarks/rendering.py [--faces MODEL ...] [--repeats 20]

Without faces: heads of two shells (a skin and a cavity behind it) with 2,000 and 27,000 vertices.
The fastest of several repeats of `draw` at rest, and of `perform` over ten seconds.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.face.load import load_face
from mimeline.face.model import Face, Joint
from mimeline.face.motion import perform
from mimeline.face.render import Camera, draw
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

REAL_TIME, FRAMES, SIZES, COUNTS = 30, 300, (256, 512), (2_000, 27_000)


def shell(n_rings: int, n_around: int, radius: float, first: int):
    """Vertices of an ellipsoid and its triangles, numbered from first."""
    down = np.linspace(0, np.pi, n_rings)[:, None]
    around = np.linspace(0, 2 * np.pi, n_around, endpoint=False)
    x, y = np.sin(down) * np.sin(around), np.cos(down) + 0 * around
    points = radius * np.stack([0.8 * x, 1.2 * y, np.sin(down) * np.cos(around)], -1)
    number = first + np.arange(n_rings * n_around).reshape(n_rings, n_around)
    a, b = number[:-1], np.roll(number, -1, axis=1)[:-1]
    c, d = number[1:], np.roll(number, -1, axis=1)[1:]
    quads = np.stack([a, c, d, b], -1).reshape(-1, 4)
    return points.reshape(-1, 3), np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def head(n_vertices: int) -> Face:
    """Two shells, one in the other, with a shape for every channel."""
    n_rings = int(np.sqrt(n_vertices / 4))
    outer, outer_triangles = shell(n_rings, 2 * n_rings, 0.1, 0)
    inner, inner_triangles = shell(n_rings, 2 * n_rings, 0.08, len(outer))
    neutral = np.concatenate([outer, inner])
    names = [name for name in CHANNELS if name in EXPRESSIONS]
    shapes = np.random.default_rng(0).normal(0, 1e-3, (len(names), *neutral.shape))
    return Face(
        neutral=neutral,
        triangles=np.concatenate([outer_triangles, inner_triangles]),
        shapes=shapes,
        shape_names=names,
        joints=[Joint("head", None, np.zeros(3))],
        skin=np.ones((len(neutral), 1)),
    )


def seconds(work, repeats: int) -> float:
    """The shortest of several runs; the first, which compiles, is not counted."""
    work()
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", nargs="*", type=Path, default=[])
    parser.add_argument("--repeats", type=int, default=20)
    arguments = parser.parse_args()
    faces = [load_face(path) for path in arguments.faces] or [head(count) for count in COUNTS]
    motion = pd.DataFrame(np.full((FRAMES, len(CHANNELS)), 0.1), columns=list(CHANNELS))
    for face in faces:
        told = f"{len(face.neutral):6d} vertices, {len(face.triangles):6d} triangles"
        for size in SIZES:
            camera = Camera.framing(face, size)
            per_s = 1 / seconds(lambda f=face, c=camera: draw(f, f.neutral, c), arguments.repeats)
            print(f"{told}  draw {size} px: {per_s:6.0f} /s, {per_s / REAL_TIME:5.1f} x real time")
        per_s = FRAMES / seconds(lambda f=face: perform(f, motion), 3)
        print(f"{told}  perform:     {per_s:6.0f} /s, {per_s / REAL_TIME:5.1f} x real time")


if __name__ == "__main__":
    main()
