"""metrical-tracker's rotations: six numbers each, and the camera twice.

Six numbers are the first two rows of a matrix. The camera goes round a head at rest: opencv.R is
for points as columns in OpenCV's axes, camera.R the same for points as rows in PyTorch3D's.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mimeline.errors import BadFile
from mimeline.tracking.formats.metrical_frame import REMEDY

OPENCV_FROM_FLAME = np.diag([1.0, -1.0, -1.0])  # for a face that looks into the camera
OPENCV_FROM_PYTORCH3D = np.diag([-1.0, -1.0, 1.0])
TOLERANCE = 1e-2  # of a rotation's entries, between the two cameras and from being a rotation


def matrices_of(six: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) of rotations (n, 6); NaN where the six numbers tell none.

    The rows are made orthonormal one after the other (Zhou et al. 2019, section B).
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        first = six[:, :3] / np.linalg.norm(six[:, :3], axis=1, keepdims=True)
        second = six[:, 3:] - (first * six[:, 3:]).sum(axis=1, keepdims=True) * first
        second /= np.linalg.norm(second, axis=1, keepdims=True)
        return np.stack([first, second, np.cross(first, second)], axis=1)


def six_of(matrices: np.ndarray) -> np.ndarray:
    """The six numbers (n, 6) of rotations (n, 3, 3)."""
    return matrices[:, :2].reshape(-1, 6)


def vectors_of(matrices: np.ndarray) -> np.ndarray:
    """Axis times angle (n, 3), radians, of rotations (n, 3, 3); NaN where they are."""
    known = np.isfinite(matrices).all(axis=(1, 2))
    vectors = np.full((len(matrices), 3), np.nan)
    if known.any():
        vectors[known] = Rotation.from_matrix(matrices[known]).as_rotvec()
    return vectors


def cameras_of(head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """camera.R (n, 6) and opencv.R (n, 3, 3) of a head's rotations (n, 3, 3) against the camera.

    head: in the subject's frame, +x to the subject's left, +y up, +z out of the face.
    """
    opencv = OPENCV_FROM_FLAME @ np.asarray(head, np.float64)
    return six_of((OPENCV_FROM_PYTORCH3D @ opencv).transpose(0, 2, 1)), opencv


def head_of(
    camera: np.ndarray,
    opencv: np.ndarray,
    readable: np.ndarray,
    files: list[Path],
    bad_values: str,
) -> tuple[np.ndarray, str]:
    """Undoes `cameras_of`: the head's rotations (n, 3, 3), NaN where unknown; and their source.

    camera (n, 6) and opencv (n, 3, 3): NaN in a frame that lacks one. readable (n,) bool; files: a
    frame each. bad_values: "fail", or "mask" to leave out a frame that tells no rotation, or two.
    Raises BadFile for such a frame; with "mask" where none tells one, or more than half tell two:
    then they are not damaged but of another make.
    """
    other = OPENCV_FROM_PYTORCH3D @ matrices_of(camera).transpose(0, 2, 1)  # (n, 3, 3)
    apart = readable & (np.abs(opencv - other).max(axis=(1, 2)) > TOLERANCE)  # not where one lacks
    if apart.any() and (bad_values == "fail" or apart.sum() > readable.sum() / 2):
        raise BadFile(
            files[apart.argmax()],
            place="camera.R",
            found="another rotation than in opencv.R",
            expected="the same camera: the first two rows of PyTorch3D's matrix, +x left, +y up, "
            "+z in",
            remedy="Write camera.R as PyTorch3D's matrix_to_rotation_6d does, or leave one away.",
        )
    source = "camera.R" if np.isnan(opencv[readable]).all() else "opencv.R"
    told = other if source == "camera.R" else opencv
    none = readable & ~apart & ~_are_rotations(told)
    known = readable & ~apart & ~none
    if none.any() and (bad_values == "fail" or not known.any()):
        raise BadFile(
            files[none.argmax()],
            place=source,
            found="no rotation",
            expected="opencv.R of shape (1, 3, 3) or camera.R of shape (1, 6), a rotation",
            remedy=REMEDY,
        )
    return OPENCV_FROM_FLAME @ np.where(known[:, None, None], told, np.nan), source


def _are_rotations(matrices: np.ndarray) -> np.ndarray:
    """Which (n,) of matrices (n, 3, 3) turn and do nothing else; NaN does not."""
    with np.errstate(invalid="ignore", over="ignore"):
        off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        return (off < TOLERANCE) & (np.linalg.det(matrices) > 0)
