"""A take of FLAME's coefficients, whatever file they come from.

FLAME's axes are the subject's own: +x to the subject's left, +y up, +z out of the face. Rotations
are axis times angle in radians; the head turns with the root, then with the neck. Where the
camera's axes are those of pictures (y down, z away), a face that looks at it is turned about x by
pi: such a take is upside down and faces away all along, as no other is, and is turned back.
Source: Li et al. 2017, "Learning a model of facial shape and expression from 4D scans".
"""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.face.rotations import angles_of
from mimeline.tables import AXES, COEFFICIENTS
from mimeline.tracking.formats import arkit
from mimeline.tracking.formats.columns import EXPRESSION_RANGE
from mimeline.tracking.formats.model_coefficients import refuse_beyond, rotations_of
from mimeline.tracking.take import Origin, Take, assemble
from mimeline.vocabulary import HEAD

COLUMNS = COEFFICIENTS["flame"].value_names
EXPRESSION = [name for name in COLUMNS if name.startswith("exp")]
EYELIDS = ["eyelid_left", "eyelid_right"]
FARTHEST = {"head": 3.3, "neck": 1.7, "jaw": 1.7, "left_eye": 1.7, "right_eye": 1.7}
# radians that half of a take's frames may be beyond; degrees are, but for a face at rest


def joint(name: str) -> list[str]:
    """The columns of a joint's rotation."""
    return [f"{name}_{axis}" for axis in AXES]


def take_of(
    told: pd.DataFrame,
    frame: np.ndarray,
    valid: np.ndarray,
    fps: Fraction,
    face: Path | None,
    bad_values: str,
    path: Path,
    first_frame: int | None = None,
    numbered: bool = False,
) -> Take:
    """A take of those of FLAME's coefficients that are told.

    told (n, any of COLUMNS): what is missing is not known. frame (n,): rising numbers from 0 on.
    valid (n,) bool. face: the user's FLAME file, or None. bad_values: "fail" or "mask", of what is
    no number. first_frame, numbered: as in Take.
    Raises BadFile where a valid frame holds what is no coefficient, or a head faces away.
    """
    with np.errstate(over="ignore"):
        told = told.astype("float32").reset_index(drop=True)
    spoilt = ~np.isfinite(told.to_numpy()).all(axis=1) & valid
    if spoilt.any() and bad_values == "fail":
        raise BadFile(
            path,
            place=f"frame {frame[spoilt.argmax()]} (from 0)",
            found="a NaN or infinity",
            expected="numbers",
            remedy="Track the clip again, or set ingest.bad_values: mask to treat it as a gap.",
        )
    valid = valid & ~spoilt
    told[~valid] = np.nan
    _refuse_out_of_range(told, path)
    rows = told.reindex(columns=COLUMNS)
    channels, origins = arkit.from_flame(rows, face)
    head, origin = _head(rows, path)
    origins = origins | dict.fromkeys(HEAD, origin)
    motion = assemble(frame, valid, channels.join(head), np.nan, path)
    table = rows.set_index(frame).reindex(pd.RangeIndex(len(motion)))
    return Take(motion, fps, {"flame": table}, origins, first_frame=first_frame, numbered=numbered)


def _refuse_out_of_range(told: pd.DataFrame, path: Path) -> None:
    """Raises where a rotation must be in degrees, or a number can be no coefficient."""
    for name, farthest in FARTHEST.items():
        if not set(joint(name)) <= set(told):
            continue
        angle = np.linalg.norm(told[joint(name)].to_numpy(np.float64), axis=1)
        angle = angle[np.isfinite(angle)]
        if len(angle) and (angle.max() > 2 * np.pi or np.median(angle) > farthest):
            raise BadFile(
                path,
                place=f"rotation of {name}",
                found=f"angles up to {angle.max():.3g}, half of them above {np.median(angle):.3g}",
                expected="axis times angle in radians",
                remedy="Turn degrees into radians.",
            )
    refuse_beyond(told, "", "Give FLAME's coefficients as its layer takes them.", path)
    low, high = EXPRESSION_RANGE
    lids = told[[name for name in EYELIDS if name in told]]
    beyond = ((lids < low) | (lids > high)).to_numpy()
    if beyond.any():
        row, column = np.argwhere(beyond)[0]
        raise BadFile(
            path,
            place=f"{lids.columns[column]}, row {row} (from 0)",
            found=f"{lids.iat[row, column]:.3g}",
            expected="0 for an open eye, 1 for a closed one",
            remedy="Give the eyelids as metrical-tracker has them, or leave them out.",
        )


def _head(rows: pd.DataFrame, path: Path) -> tuple[pd.DataFrame, Origin]:
    """The head's angles by channel, and how they were had."""
    told = {name: rows[joint(name)].notna().to_numpy().any() for name in ("head", "neck")}
    if not any(told.values()):
        return pd.DataFrame(index=rows.index), Origin("no rotation of the head", measured=False)
    turns = rotations_of(rows[joint("head")]) if told["head"] else np.eye(3)
    if told["neck"]:
        turns = turns @ rotations_of(rows[joint("neck")])
    text = " and ".join({"head": "root", "neck": "neck"}[n] for n in told if told[n]) + " rotation"
    up, forward = np.nanmedian(turns[:, 1, 1]), np.nanmedian(turns[:, 2, 2])
    if up < 0 and forward < 0:
        turns = np.diag([1.0, -1.0, -1.0]) @ turns
        text += ", turned by pi about x: the camera's axes are a picture's"
    elif up < 0 or forward < 0:
        raise BadFile(
            path,
            place="rotation of head",
            found="a head upside down" if up < 0 else "a face that looks away from the camera",
            expected="+x to the subject's left, +y up, +z towards the camera",
            remedy="Bring the rotations into these axes, or leave them out.",
        )
    head = pd.DataFrame(dict(zip(HEAD, angles_of(turns), strict=True)), index=rows.index)
    return head, Origin(text)
