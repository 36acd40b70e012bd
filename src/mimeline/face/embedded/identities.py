"""What makes persons differ: smooth warps of the embedded face, each named for what it enlarges.

Centimetres, frame of anatomy.
"""

import numpy as np

from mimeline.face.embedded.mesh import Mesh
from mimeline.face.embedded.parts import BROW_ROWS
from mimeline.face.embedded.skin import MEET
from mimeline.face.falloff import bell, folded, smoothstep


def offsets(mesh: Mesh) -> np.ndarray:
    """Offsets (I, V, 3) of NAMES at 1.

    An eye with its lids moves as a rigid thing or is scaled as one, so lids fit their ball.
    """
    points = folded(mesh.points)
    ball = mesh.points[mesh.left("eye")]
    eye = (ball.min(0) + ball.max(0)) / 2
    socket = _socket(mesh, points, eye)[:, None]  # (V, 1)
    brow = mesh.left("brow").reshape(BROW_ROWS, -1)
    out = []
    for warp in WARPS.values():
        field = warp(mesh, points)
        carried = warp(mesh, np.broadcast_to(eye, points.shape))
        out.append(field + socket * (carried - field))
    out.append(_brow_height(points))
    out.append(socket * (points - eye) * 0.13)
    out.append(socket * [0.38, 0, 0])
    for field in out:
        field[brow, :2] = field[brow, :2].mean(0)  # a brow keeps its breadth and lies on the skin
    return np.array([mesh.symmetric(field) for field in out])


def _socket(mesh: Mesh, points: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """1 (V,) on eyeball and lids, falling to 0 around them and on the midline."""
    away = np.linalg.norm((points - eye) * [1, 1.1, 0.5], axis=1)
    socket = 1 - smoothstep(away, 2.3, 3.8)
    socket *= smoothstep(points[:, 0], 0, 1.3) * smoothstep(points[:, 2], 1.5, 3.5)
    socket[np.isin(mesh.part, ["upper_teeth", "lower_teeth", "tongue"])] = 0
    for rigid in (mesh.left("eye"), mesh.left("lash"), mesh.skin.lids):
        socket[rigid] = 1
    return socket


def _scaled(points: np.ndarray, axis: int, amount) -> np.ndarray:
    """Offsets (V, 3) along an axis by an amount, a number or (V,), of the coordinate."""
    return (amount * points[:, axis])[:, None] * np.eye(3)[axis]


def _face_width(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return _scaled(p, 0, 0.07)


def _face_length(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return -0.09 * np.clip(-p[:, 1], 0, 11.5)[:, None] * [0, 1, 0]


def _forehead_height(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return 0.10 * np.clip(p[:, 1] - 2, 0, None)[:, None] * [0, 1, 0]


def _jaw_width(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    below_cheeks, above_neck = smoothstep(-p[:, 1], 3.5, 8.5), smoothstep(p[:, 1], -14.5, -11)
    return _scaled(p, 0, 0.15 * below_cheeks * above_neck)


def _chin_size(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    chin = bell(p, (0, -10.4, 8.6), (2.7, 1.8, 3.5))
    return _scaled(p, 0, 0.15 * chin) + chin[:, None] * [0, -0.55, 0.65]


def _cheek_fullness(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return bell(p, (4.6, -4.6, 6.6), (1.9, 2.5, 3.5))[:, None] * [0.55, 0, 0.4]


def _nose_size(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return 0.20 * bell(p, (0, -3, 10), (1.8, 2.3, 3))[:, None] * (p - [0, -1.5, 8.2])


def _nose_width(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return _scaled(p, 0, 0.24 * bell(p, (0.5, -3.9, 9.8), (1.6, 1.6, 2)))


def _brow_height(p: np.ndarray) -> np.ndarray:
    brow = bell(p, (3.2, 2.3, 8.2), (3, 1.8, 4)) * smoothstep(p[:, 1], 1.25, 1.9)
    return 0.42 * brow[:, None] * [0, 1, 0]


def _mouth_width(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    return _scaled(p, 0, 0.15 * bell(p, (0, -7, 9), (3.6, 2, 2.5)))


def _lip_fullness(mesh: Mesh, p: np.ndarray) -> np.ndarray:
    lips = mesh.soft * np.exp(-((mesh.lip_distance / 0.5) ** 2))
    meet = mesh.points[mesh.skin.lips[MEET]]
    upper = meet[: len(meet) // 2 + 1]
    height = p[:, 1] - np.interp(p[:, 0], upper[:, 0], upper[:, 1])
    return lips[:, None] * np.stack([0 * lips, 0.32 * height, 0 * lips + 0.12], axis=-1)


WARPS = {
    "faceWidth": _face_width,
    "faceLength": _face_length,
    "foreheadHeight": _forehead_height,
    "jawWidth": _jaw_width,
    "chinSize": _chin_size,
    "cheekFullness": _cheek_fullness,
    "noseSize": _nose_size,
    "noseWidth": _nose_width,
    "mouthWidth": _mouth_width,
    "lipFullness": _lip_fullness,
}
NAMES = (*WARPS, "browHeight", "eyeSize", "eyeSpacing")
