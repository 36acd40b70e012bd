"""Coefficients of the Basel Face Model: 257 a frame, as Deep3DFaceReconstruction gives them.

A vertex v of the face stands at R v + t, with R = Rz(angle_z) Ry(angle_y) Rx(angle_x), before a
camera at z = 10 that looks along -z: x is to the right of the picture, y up, z towards the camera.
Those are the subject's own axes, so R is the head's rotation as it stands.
Source: Deng et al. 2019, "Accurate 3D Face Reconstruction with Weakly-Supervised Learning", and
the authors' code.
"""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from mimeline.archives import mat
from mimeline.errors import BadFile, MimelineError
from mimeline.face.rotations import angles_of
from mimeline.tables import AXES, COEFFICIENTS
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats import arkit
from mimeline.tracking.formats.model_coefficients import refuse_beyond
from mimeline.tracking.take import MOST_FRAMES, Origin, Take, assemble
from mimeline.vocabulary import HEAD

WIDTH = 257
KEPT = np.r_[80:144, 224:227, 254:257]  # expression, angles, translation
COLUMNS = COEFFICIENTS["bfm"].value_names
ANGLES = [f"angle_{axis}" for axis in AXES]
MOST_BYTES = 300_000_000  # as doubles: an hour and a half at 25 frames a second

ENDINGS = (".mat",)
CONVENTION = Convention(
    title="Basel Face Model (Deep3DFaceReconstruction, DreamTalk)",
    files="<name>.mat of MATLAB's version 5 to 7, with coeff (frames, 257)",
    coefficients="80 identity, 64 expression, 80 texture, 3 angles, 27 light, 3 translation; "
    "expression, angles and translation are kept as exp000-exp063, angle_x.., translation_x..",
    axes="x to the right of the picture, y up, z towards the camera; the face looks along +z",
    rotation="angles about x, y, z: R = Rz Ry Rx, turning columns",
    angle_unit="radians",
    sides="the face model's; expressions have none of their own",
    first_frame=None,
    gap="a row of zeros",
    never="gaze; ARKit channels where the user's BFM_model_front.mat is not given",
    evidence="the flow inside the face in 16 videos of DreamTalk, over 271 pairs of frames six "
    "apart, fitted by a shift, a plane and a bulge: the bulge goes to the right of the picture "
    "with angle_y (r = .72, 91 % as far as geometry asks for) and down with angle_x (r = .58, "
    "83 %), the plane turns counter-clockwise with angle_z (r = .87, 89 %)",
    meanings={
        "head_yaw_left": "+angle_y, where the other two are 0",
        "head_pitch_up": "-angle_x, where the other two are 0",
        "head_tilt_left": "-angle_z, where the other two are 0",
    },
)


def holds(path: Path) -> bool:
    """Whether a .mat file holds 257 coefficients a frame."""
    try:
        if path.suffix.lower() not in ENDINGS:
            return False
        return mat.shapes(path, ["coeff"]).get("coeff", ())[1:] == (WIDTH,)
    except MimelineError:
        return False


def read(path: Path, fps: str, face: Path | None, bad_values: str) -> Take:
    """Read a sequence of coefficients, a row per frame.

    fps: frames per second. face: the user's BFM_model_front.mat, or None. bad_values: "fail" or
    "mask", of numbers that are none.
    Raises BadFile, with the row, for what is no such sequence.
    """
    coefficients = _coefficients(path)
    if coefficients.shape[1] != WIDTH or not 0 < len(coefficients) <= MOST_FRAMES:
        raise BadFile(
            path,
            place="variable coeff",
            found=f"shape {coefficients.shape}",
            expected=f"(frames, {WIDTH}), up to {MOST_FRAMES} frames",
            remedy="Give the coefficients as Deep3DFaceReconstruction's network tells them.",
        )
    bad = ~np.isfinite(coefficients).all(axis=1)
    if bad.any() and bad_values == "fail":
        raise BadFile(
            path,
            place=f"variable coeff, row {int(bad.argmax())} (from 0)",
            found="a NaN or infinity",
            expected="numbers",
            remedy="Track the clip again, or set ingest.bad_values: mask to treat it as a gap.",
        )
    valid = ~bad & coefficients.any(axis=1)
    rows = np.where(valid[:, None], coefficients[:, KEPT], np.nan)  # (n, 257) → (n, 70)
    rows = pd.DataFrame(rows, columns=COLUMNS)
    _refuse_out_of_range(rows, path)
    channels, origins = arkit.from_bfm(rows, face)
    turns = Rotation.from_euler("xyz", rows[ANGLES]).as_matrix()  # (n, 3, 3), Rz Ry Rx
    head = pd.DataFrame(dict(zip(HEAD, angles_of(turns), strict=True)))
    origins = origins | dict.fromkeys(HEAD, Origin("angle_x, angle_y, angle_z, as a rotation"))
    motion = assemble(np.arange(len(rows)), valid, channels.join(head), np.nan, path)
    return Take(motion, Fraction(fps), {"bfm": rows.astype("float32")}, origins)


def _coefficients(path: Path) -> np.ndarray:
    """Variable `coeff` as (n, k) floats."""
    found = mat.read_arrays(path, ["coeff"], MOST_BYTES)
    if "coeff" not in found or found["coeff"].ndim != 2:
        raise BadFile(
            path,
            found="no variable coeff of two axes",
            expected=f"coeff (frames, {WIDTH})",
            remedy="Save the coefficients of all frames as one array of that name.",
        )
    return found["coeff"].astype(float)


def _refuse_out_of_range(rows: pd.DataFrame, path: Path) -> None:
    largest = rows[ANGLES].abs().max().max()
    if largest > np.pi:
        raise BadFile(
            path,
            place="variable coeff, columns 224 to 226",
            found=f"an angle of {largest:.3g}",
            expected="radians within half a turn",
            remedy="Give the angles in radians, in the order of Deep3DFaceReconstruction.",
        )
    remedy = "Give the coefficients as Deep3DFaceReconstruction's network tells them."
    refuse_beyond(rows, "variable coeff, ", remedy, path)
