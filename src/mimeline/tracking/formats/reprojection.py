"""How far a tracker's landmarks lie from where FLAME, posed and seen as it says, has them.

The landmarks were found in the picture, and the head was fitted to them and to more: where it was
lost, they part. On the user's FLAME they are found through the embedded face, which names them.
Nose, corners of the eyes and mouth are compared. Left out are the jaw line, whose landmarks move
with the view; the brows, which are hair that FLAME does not have; and the eyelids, which the
tracker moves by shapes of its own.

Where another face (ICT-FaceKit) names its landmarks, too, these come 0.03 eye distances from its
own; with the brows it would be 0.05.
"""

from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from mimeline.errors import BadFile
from mimeline.face.correspondence import correspondence
from mimeline.face.load import load_face
from mimeline.face.model import Face
from mimeline.face.raster import vertex_normals

RIGHT_EYE, LEFT_EYE = 36, 45  # outer corners, iBUG
COMPARED = [*range(27, 36), 36, 39, 42, 45, *range(48, 68)]
FACING = 0.01  # metres; as far apart are places whose unit normals differ by 1


def reprojection_error(
    face: Path,
    identity: np.ndarray,
    expression: np.ndarray,
    jaw: np.ndarray,
    R: np.ndarray,
    t: np.ndarray,
    K: np.ndarray,
    landmarks: np.ndarray,
) -> np.ndarray:
    """RMS distance (n,) of the COMPARED landmarks from those of the head.

    face: the user's FLAME file. identity (n, 300), expression (n, E): its coefficients · jaw
    (n, 3, 3): its turn · R (n, 3, 3), t (n, 3) metres, K (n, 3, 3): OpenCV's camera, in which x is
    seen at K (R x + t) · landmarks (n, 68, 2): iBUG, pixels, x right, y down.
    In distances between the outer corners of the eyes, as large as they would be seen from the
    front; NaN where anything is missing, infinite where the head is behind the camera or the
    numbers come to nothing.
    Raises BadFile where the face is no FLAME.
    """
    n = len(landmarks)
    told = (identity, expression, jaw, R, t, K, landmarks[:, COMPARED])
    known = np.isfinite(np.concatenate([part.reshape(n, -1) for part in told], axis=1)).all(1)
    errors = np.full(n, np.nan)
    if not known.any():
        return errors
    identity, expression, jaw, R, t, K, shown = (part[known] for part in told)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        points = _points(face, identity, expression, jaw) @ R.transpose(0, 2, 1) + t[:, None]
        seen = points @ K.transpose(0, 2, 1)  # (n known, m, 3)
        off = np.linalg.norm(seen[..., :2] / seen[..., 2:] - shown, axis=2)  # (n known, m)
        eyes = points[:, [COMPARED.index(RIGHT_EYE), COMPARED.index(LEFT_EYE)]]  # (n known, 2, 3)
        apart = np.linalg.norm(eyes[:, 0] - eyes[:, 1], axis=1) * K[:, 0, 0] / eyes[..., 2].mean(1)
        relative = np.sqrt((off**2).mean(1)) / apart
    errors[known] = np.where(relative >= 0, relative, np.inf)  # below 0 behind the camera
    return errors


def compared_on(face: Face) -> tuple[np.ndarray, np.ndarray]:
    """Where the COMPARED landmarks lie on a face: vertices (m, 3), and their shares (m, 3).

    Raises ValueError as `correspondence` does.
    """
    ours = load_face(None)
    partners = correspondence(face, ours)
    # A landmark without a partner, as in between the lips, is the nearest that faces its way.
    normals = vertex_normals(np.float32(ours.neutral), ours.triangles)
    places = np.hstack([ours.neutral, FACING * normals])  # (V, 6)
    _, rows = cKDTree(places[partners.vertices]).query(places[ours.landmarks[COMPARED]])
    return partners.corners[rows], partners.shares[rows]


def _points(
    face: Path, identity: np.ndarray, expression: np.ndarray, jaw: np.ndarray
) -> np.ndarray:
    """The COMPARED landmarks (n, m, 3) of heads in FLAME's own frame, metres."""
    model, corners, shares = _marked(face)
    coefficients = np.zeros((len(identity), len(model.shape_names)))
    width = identity.shape[1]
    given = min(expression.shape[1], coefficients.shape[1] - width)  # a smaller file has no others
    coefficients[:, :width] = identity
    coefficients[:, width : width + given] = expression[:, :given]
    vertices = model.vertices(coefficients, {"jaw": jaw})
    return np.einsum("nmcx,mc->nmx", vertices[:, corners], shares)


@cache
def _marked(face: Path) -> tuple[Face, np.ndarray, np.ndarray]:
    """FLAME at its landmarks only: identities, then expressions are its shapes; and the landmarks'
    corners (m, 3) and shares (m, 3) in it.

    It ends in a vertex for each joint, at its centre: so the centres follow the shapes.
    Raises BadFile where the file is no FLAME.
    """
    model = load_face(face)
    if model.regressor is None or "jaw" not in model.joint_names:
        raise BadFile(
            face,
            found=f"a face with joints {', '.join(model.joint_names) or 'of no name'}",
            expected="FLAME, which the tracker's coefficients are of",
            remedy="Give FLAME's generic_model.pkl.",
        )
    corners, shares = compared_on(model)
    vertices, corners = np.unique(corners, return_inverse=True)

    def reduced(points: np.ndarray) -> np.ndarray:
        return np.concatenate([points[..., vertices, :], model.regressor @ points], axis=-2)

    J = len(model.joints)
    return (
        Face(
            neutral=reduced(model.neutral),
            triangles=np.zeros((0, 3), np.int32),
            shapes=reduced(np.concatenate([model.identities, model.shapes])),
            shape_names=(*model.identity_names, *model.shape_names),
            joints=model.joints,
            skin=np.concatenate([model.skin[vertices], np.eye(J, dtype=np.float32)]),
            pose_shapes=None if model.pose_shapes is None else reduced(model.pose_shapes),
            regressor=np.hstack([np.zeros((J, len(vertices))), np.eye(J)]),
        ),
        corners.reshape(-1, 3),
        shares,
    )
