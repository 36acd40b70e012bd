"""ARKit channels from the coefficients of face models, which are no ARKit channels.

The jaw, the eyelids and the eyes tell theirs by themselves. Expressions are carried over through
what they do to the user's own face model and what ARKit's shapes do to the embedded one.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.face.load import load_face
from mimeline.face.motion import LOOK_DOWN, LOOK_SIDEWAYS, LOOK_UP
from mimeline.face.rotations import angles_of
from mimeline.tables import AXES
from mimeline.tracking.formats.columns import EXPRESSION_RANGE
from mimeline.tracking.formats.model_coefficients import rotations_of
from mimeline.tracking.take import Origin
from mimeline.vocabulary import EXPRESSIONS, GAZE

if TYPE_CHECKING:
    from mimeline.face.retarget import Retargeting

# The jaw's turn at a coefficient of 1, radians: what fits these shapes of the embedded face best.
JAW_OPEN, JAW_SIDEWAYS = 0.29, 0.14
MOST = 1.05  # of a coefficient that is solved or an eye's: real takes pass 1 a little
EYES = {"Left": "left_eye", "Right": "right_eye"}
LOOKS = tuple(name for name in EXPRESSIONS if name.startswith("eyeLook"))
JAW, LIDS = ("jawOpen", "jawLeft", "jawRight"), ("eyeBlinkLeft", "eyeBlinkRight")
NO_FACE, NO_EXPRESSION = "no face model was given", "expressions are not given"

Channels = tuple[pd.DataFrame, dict[str, Origin]]


def from_flame(rows: pd.DataFrame, face: Path | None) -> Channels:
    """Channels that FLAME's coefficients tell, and how each was had; the head is not among them.

    rows: columns of tables.COEFFICIENTS["flame"], a row per frame, NaN where a frame has none; a
    column without a number is one that the tracker does not give. face: the user's file of FLAME,
    or None. Left and right eye, jaw and expression are told against the head; the expression's
    movement is that without the jaw's.
    Returns columns of vocabulary.CHANNELS, row by row beside rows, in [0, MOST] or radians; the
    eyelids' and the jaw's as they are told, the jaw's within EXPRESSION_RANGE.
    Raises BadFile where the face is no FLAME.
    """
    channels: dict[str, np.ndarray] = {}
    origins: dict[str, Origin] = {}
    for side in ("Left", "Right"):
        column = f"eyelid_{side.lower()}"
        if _told(rows, [column]):
            channels[f"eyeBlink{side}"] = rows[column].to_numpy(float)
            origins[f"eyeBlink{side}"] = Origin(column)
    if _told(rows, _axes("jaw")):
        left, up, _ = angles_of(rotations_of(rows[_axes("jaw")]))
        low, high = EXPRESSION_RANGE
        channels["jawOpen"] = np.clip(-up / JAW_OPEN, low, high)
        channels["jawLeft"] = np.clip(left / JAW_SIDEWAYS, 0, high)
        channels["jawRight"] = np.clip(-left / JAW_SIDEWAYS, 0, high)
        origins["jawOpen"] = Origin(f"jaw rotation, 1 at {JAW_OPEN} rad")
        origins["jawLeft"] = origins["jawRight"] = Origin(f"jaw rotation, 1 at {JAW_SIDEWAYS} rad")
    if all(_told(rows, _axes(eye)) for eye in EYES.values()):
        angles = {side: angles_of(rotations_of(rows[_axes(eye)])) for side, eye in EYES.items()}
        channels |= _looks(angles)
        channels["gaze_left"] = (angles["Left"][0] + angles["Right"][0]) / 2
        channels["gaze_up"] = (angles["Left"][1] + angles["Right"][1]) / 2
        origins |= dict.fromkeys(LOOKS, Origin("rotation of the eye"))
        origins |= dict.fromkeys(GAZE, Origin("rotations of the eyes, their mean"))
    else:
        no_eyes = Origin("the eyes' rotations are not given", measured=False)
        origins |= dict.fromkeys((*LOOKS, *GAZE), no_eyes)
    lacking = dict.fromkeys(JAW, "no jaw rotation is given")
    lacking |= dict.fromkeys(LIDS, "no eyelids are given")
    return _with_expression(rows, face, channels, origins, lacking)


def from_bfm(rows: pd.DataFrame, face: Path | None) -> Channels:
    """As `from_flame`, of the Basel Face Model's coefficients: the expression alone tells channels.

    rows: columns of tables.COEFFICIENTS["bfm"]. face: the user's BFM_model_front.mat, or None.
    """
    no_eyes = Origin("the Basel Face Model has no eyes that turn", measured=False)
    return _with_expression(rows, face, {}, dict.fromkeys((*LOOKS, *GAZE), no_eyes), {})


def _with_expression(
    rows: pd.DataFrame,
    face: Path | None,
    channels: dict[str, np.ndarray],
    origins: dict[str, Origin],
    lacking: Mapping[str, str],
) -> Channels:
    """Channels and origins with those that the expression tells, where nothing else does.

    lacking: channel → what else would have told it.
    """
    rest = tuple(name for name in EXPRESSIONS if name not in origins)
    told = rows.notna().any()
    columns = [name for name in rows.columns[told] if name.startswith("exp")]
    if not columns or face is None:
        why = NO_FACE if columns else NO_EXPRESSION
        for name in rest:
            text = (
                f"{lacking[name]}, and {why}" if name in lacking else f"not measured, since {why}"
            )
            origins[name] = Origin(text, measured=False)
    else:
        way, n_shapes = _way(face, rest)
        solved = way.coefficients(_expressions(rows[columns], n_shapes, face), MOST)  # (n, S)
        for number, name in enumerate(rest):
            quality = float(way.quality[number])
            if way.possible[number]:
                channels[name] = solved[:, number]
                origins[name] = Origin(f"expression through {face.name}", quality=quality)
            else:
                text = f"not possible: {face.name} cannot show it apart from other movements"
                origins[name] = Origin(text, measured=False, quality=quality)
    return pd.DataFrame(channels, index=rows.index, dtype=float), origins


@cache
def _way(face: Path, names: tuple[str, ...]) -> tuple["Retargeting", int]:
    """The way from a file's expressions to ARKit shapes, and how many expressions it has.

    Raises BadFile where the file holds no face with expressions exp000 and on.
    """
    from mimeline.face.retarget import retargeting  # compiled code, slow to import

    expected = "the face model that the coefficients are of"
    remedy = (
        "Correct the format's key face (as ingest.flame.face): FLAME's generic_model.pkl, for the "
        "Basel Face Model BFM_model_front.mat."
    )
    try:
        source = load_face(face)
    except BadFile as error:
        raise BadFile(
            face, place=error.place, found=error.found, expected=error.expected, remedy=remedy
        ) from error
    numbered = tuple(f"exp{number:03d}" for number in range(len(source.shape_names)))
    if not numbered or source.shape_names != numbered:
        found = f"shapes {', '.join(source.shape_names[:3]) or 'none'} ..."
        raise BadFile(face, found=found, expected=expected, remedy=remedy)
    try:
        return retargeting(source, load_face(None), names), len(numbered)
    except ValueError as error:
        raise BadFile(face, found=str(error), expected=expected, remedy=remedy) from error


def _expressions(rows: pd.DataFrame, n_shapes: int, face: Path) -> np.ndarray:
    """Coefficients (n, E) of the face's expressions; those that the tracker does not give rest."""
    known = [f"exp{number:03d}" for number in range(n_shapes)]
    beyond = rows.drop(columns=known, errors="ignore")
    if (beyond.fillna(0) != 0).any(axis=None):
        raise BadFile(
            face,
            found=f"{n_shapes} expressions",
            expected=f"the model of {beyond.columns[-1]} too, which the tracking results have",
            remedy="Give the face model that the tracker used.",
        )
    told = rows.reindex(columns=known).to_numpy(float, copy=True)  # (n, E)
    told[:, np.isnan(told).all(axis=0)] = 0
    return told


def _told(rows: pd.DataFrame, columns: Sequence[str]) -> bool:
    """Whether the columns are there, each with a number."""
    return set(columns) <= set(rows) and bool(rows[list(columns)].notna().any().all())


def _axes(joint: str) -> list[str]:
    return [f"{joint}_{axis}" for axis in AXES]


def _looks(angles: dict[str, tuple[np.ndarray, ...]]) -> dict[str, np.ndarray]:
    """The eyeLook channels, in [0, MOST], of each side's eye, turned left and up by radians."""
    looks = {}
    for side, outwards in (("Left", 1), ("Right", -1)):
        left, up, _ = angles[side]
        looks[f"eyeLookOut{side}"] = outwards * left / LOOK_SIDEWAYS
        looks[f"eyeLookIn{side}"] = -outwards * left / LOOK_SIDEWAYS
        looks[f"eyeLookUp{side}"], looks[f"eyeLookDown{side}"] = up / LOOK_UP, -up / LOOK_DOWN
    return {name: np.clip(values, 0, MOST) for name, values in looks.items()}
