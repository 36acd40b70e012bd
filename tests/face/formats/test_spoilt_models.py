"""Every array of every model, spoilt in many ways, refuses the file."""

import numpy as np
import pytest

from mimeline.errors import BadFile
from mimeline.face.formats import flame, ict, shapes
from mimeline.face.load import load_face
from mimeline.face.model import Joint

from ..conftest import chained_face
from .conftest import published

NUMBERS = {
    "text": lambda a: a.astype("U8"),
    "bytes": lambda a: a.astype("S8"),
    "complex": lambda a: a + 1j,
    "one number": lambda a: np.float32(1),
    "deeper": lambda a: a[None],
    "one short": lambda a: np.delete(a, -1, axis=min(1, a.ndim - 1)),
    "nan": lambda a: np.full(a.shape, np.nan),
    "inf": lambda a: np.full(a.shape, np.inf),
    "huge": lambda a: np.full(a.shape, 1e300),
}
WHOLE = {
    "fractions": lambda a: a + 0.5,
    "negative": lambda a: -2 - a.astype(np.int64),
    "past 32 bits": lambda a: np.full(a.shape, 2**62),
}
NAMES = {
    "bytes": lambda a: a.astype("S20"),
    "numbers": lambda a: np.arange(len(a)),
    "two-dimensional": lambda a: a[None],
    "one text": lambda a: a[0],
    "one short": lambda a: a[:-1],
}
WHOLE_NUMBERS = ("triangles", "landmarks", "joint_parents", "f", "kintree_table", "quads")
UNREAD = "J"  # of FLAME's arrays


@pytest.fixture(scope="session")
def layouts(like_ict, tmp_path_factory):
    """model → its arrays and those that it must have."""
    path = tmp_path_factory.mktemp("full") / "face.npz"
    rng = np.random.default_rng(0)
    face = chained_face(
        neutral=rng.random((12, 3)) * 0.3,
        joints=[Joint(n, p, rng.random(3)) for n, p in (("neck", None), ("head", 0), ("eye", 1))],
        landmarks=np.arange(68) % 12,
        pose_shapes=rng.random((18, 12, 3)),
        regressor=rng.dirichlet(np.ones(12), 3),
    )
    shapes.to_npz(face, path)
    with np.load(path) as file:
        full = {name: file[name] for name in file.files}
    return {
        "shapes": (full, (*shapes.REQUIRED, *shapes.JOINTS)),
        "flame": (published(), flame.REQUIRED),
        "ict": (like_ict, ict.PACKED),
    }


def refusal(path, arrays) -> str:
    """Why the arrays are refused; empty where they are not."""
    np.savez(path, **arrays)
    try:
        load_face(path)
    except BadFile as error:
        return str(error)
    return ""


@pytest.mark.parametrize("model", ["shapes", "flame", "ict"])
def test_a_spoilt_array_refuses_the_file_and_is_named(tmp_path, layouts, model):
    arrays, required = layouts[model]
    path, reasons = tmp_path / "face.npz", {}
    assert refusal(path, arrays) == ""
    for name in sorted(set(arrays) - {UNREAD}):
        ways = NAMES if name.endswith("_names") else NUMBERS
        ways = ways | WHOLE if name in WHOLE_NUMBERS else ways
        for way, spoil in ways.items():
            reasons[name, way] = refusal(path, arrays | {name: spoil(arrays[name])})
    for name in required:
        rest = {other: array for other, array in arrays.items() if other != name}
        reasons[name, "missing"] = refusal(path, rest)
    assert [case for case, reason in reasons.items() if "array" not in reason] == []
