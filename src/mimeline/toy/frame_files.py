"""The toy world as metrical-tracker leaves it: .frame folders, and a face model to read them by.

The model is the embedded face in FLAME's published layout; nothing of FLAME is in it. Its 100
expressions are fixed mixtures of the embedded face's own shapes, all but those that the jaw, the
eyelids and the eyes tell, so that no coefficient is a channel by itself.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from mimeline.atomic import whole
from mimeline.face.embedded import anatomy, embedded_face
from mimeline.face.embedded.mesh import build
from mimeline.face.formats.flame import JOINT_NAMES, N_IDENTITIES
from mimeline.face.rotations import turned
from mimeline.tables import AXES
from mimeline.toy.livelink import VERGENCE
from mimeline.tracking.formats import metrical_tracker
from mimeline.tracking.formats.arkit import JAW_OPEN, JAW_SIDEWAYS
from mimeline.vocabulary import EXPRESSIONS, HEAD

FACE, FOLDER = "face_model.npz", "metrical_tracker"
N_EXPRESSIONS, SEED = 100, 11
CARRIED = ("eyeBlink", "eyeLook", "jawOpen", "jawLeft", "jawRight")  # by lids, eyes and jaw
MIXED = tuple(name for name in EXPRESSIONS if not name.startswith(CARRIED))
METRES = 0.01  # in a centimetre of the embedded face's anatomy


def write_takes(folder: Path, motion: pd.DataFrame, tracked: np.ndarray) -> None:
    """`checkpoint/<frame>.frame` in folder for the rows of a clip that were tracked.

    motion: the clip's rows of table `motion`, (n, ...). tracked (n,) bool.
    """
    (folder / metrical_tracker.CHECKPOINT).mkdir(parents=True)
    head = turned(*(motion[name].to_numpy(float) for name in HEAD))
    metrical_tracker.write(folder, coefficients(motion), head, tracked)


def coefficients(motion: pd.DataFrame) -> pd.DataFrame:
    """FLAME's coefficients (n, ...), named as in the flame table, of rows of table `motion`."""
    expression = motion[list(MIXED)].to_numpy(float) @ _mixture().T  # (n, 100)
    rows = dict(
        zip((f"exp{number:03d}" for number in range(N_EXPRESSIONS)), expression.T, strict=True)
    )
    told = {name: motion[name].to_numpy(float) for name in ("gaze_left", "gaze_up", *EXPRESSIONS)}
    sideways = JAW_SIDEWAYS * (told["jawLeft"] - told["jawRight"])
    turns = {
        "jaw": (sideways, -JAW_OPEN * told["jawOpen"]),
        "left_eye": (told["gaze_left"] - VERGENCE, told["gaze_up"]),
        "right_eye": (told["gaze_left"] + VERGENCE, told["gaze_up"]),
    }
    for joint, (left, up) in turns.items():
        vectors = Rotation.from_matrix(turned(left, up, np.zeros(len(motion)))).as_rotvec()
        rows |= {f"{joint}_{axis}": vectors[:, number] for number, axis in enumerate(AXES)}
    rows |= {f"eyelid_{side.lower()}": told[f"eyeBlink{side}"] for side in ("Left", "Right")}
    return pd.DataFrame(rows)


def write_face(path: Path) -> None:
    """Write the world's face model, an npz file of FLAME's arrays."""
    face, mesh = embedded_face(), build()
    V = len(face.neutral)
    shapes = face.shapes[[face.shape_names.index(name) for name in MIXED]]
    directions = np.zeros((V, 3, N_IDENTITIES + N_EXPRESSIONS), np.float32)
    directions[..., N_IDENTITIES:] = np.einsum("ei,ivx->vxe", _mixture(), shapes)
    held = dict(zip(face.joint_names, face.skin.T, strict=True))
    weights = {
        "head": held["neck"],
        "neck": held["head"] * (1 - mesh.jaw),
        "jaw": held["head"] * mesh.jaw,
        "left_eye": held["left_eye"],
        "right_eye": held["right_eye"],
    }
    centres = {joint.name: joint.centre for joint in face.joints}
    centres = {
        "head": centres["neck"],
        "neck": centres["head"],
        "jaw": np.multiply(anatomy.HINGE_AT, METRES),
        "left_eye": centres["left_eye"],
        "right_eye": centres["right_eye"],
    }
    with whole(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(
            file,
            v_template=face.neutral,
            shapedirs=directions,
            posedirs=np.zeros((V, 3, 9 * (len(JOINT_NAMES) - 1)), np.float32),
            J_regressor=_regressor(face.neutral, [centres[name] for name in JOINT_NAMES]),
            weights=np.stack([weights[name] for name in JOINT_NAMES], axis=1).astype(np.float32),
            kintree_table=np.array([[2**32 - 1, 0, 1, 1, 1], range(5)], np.uint32),
            f=face.triangles.astype(np.uint32),
        )


def _mixture() -> np.ndarray:
    """What each shape adds to each expression, (100, shapes): columns at right angles, length 1."""
    rng = np.random.default_rng(SEED)
    return np.linalg.qr(rng.normal(size=(N_EXPRESSIONS, len(MIXED))))[0]


def _regressor(points: np.ndarray, centres: list[np.ndarray]) -> np.ndarray:
    """The smallest weights (5, V) of sum 1 by which points (V, 3) have centres (5, 3) as means."""
    wanted = np.column_stack([np.float64(centres), np.ones(len(centres))])  # (5, 4)
    known = np.column_stack([np.float64(points), np.ones(len(points))])  # (V, 4)
    return (wanted @ np.linalg.pinv(known)).astype(np.float32)
