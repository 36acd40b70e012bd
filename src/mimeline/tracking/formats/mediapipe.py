"""MediaPipe FaceLandmarker: scores of 51 ARKit coefficients and `_neutral`, and the head's matrix.

The facial transformation matrix takes MediaPipe's canonical face into a right-handed space whose
camera looks along -Z. In the canonical face the outer corner of the subject's left eye (point 263)
lies at +X, the brows at +Y and the tip of the nose (point 1) at +Z. Those are the subject's axes:
the rotation needs no change of basis. Its last row is 0, 0, 0, 1, which tells rows from columns
where sixteen numbers stand in a line. The result tells no gaze: it is worked out from the eyeLook
coefficients, by the slopes of a real Live Link take.
"""

import re
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile
from mimeline.face.motion import LOOK_DOWN, LOOK_SIDEWAYS, LOOK_UP
from mimeline.face.rotations import angles_of
from mimeline.tracking.convention import Convention
from mimeline.tracking.formats.columns import expressions, header_of, numbers, read_columns
from mimeline.tracking.formats.mediapipe_results import NUMBERING, names_scores, rows_of
from mimeline.tracking.take import MOST_FRAMES, Origin, Take, assemble
from mimeline.vocabulary import EXPRESSIONS, GAZE, HEAD, canonical

NEVER = "tongueOut"
DEAD = ("cheekPuff", "noseSneerLeft", "noseSneerRight", "eyeWideLeft", "eyeWideRight")
OTHERS = frozenset(("Timecode", "FaceScore"))  # columns of formats that bear the same names
LONGEST = 80  # letters of a column's name that is looked at
FEWEST_CELLS = 9  # columns m11, m12 ... that are taken for a matrix
LATEST = 60_000  # milliseconds at which a take may begin: before, nobody had a face
STRETCH = 1.01  # of the longest axis against the shortest, in a matrix of rotation and scale

ENDINGS = (".csv", ".json")
CONVENTION = Convention(
    title="MediaPipe FaceLandmarker",
    files="<name>.csv, a row per frame, or <name>.json, a list of frames",
    coefficients="51 of ARKit's 52 in [0, 1] and _neutral, by name",
    axes="the subject's: +X the subject's left, +Y up, +Z out of the face",
    rotation="4 x 4 facial transformation matrix, by rows or by columns (its 0, 0, 0, 1 tells)",
    angle_unit="none: the head is a matrix, the gaze is worked out from coefficients",
    sides="the subject's, where the picture was not flipped",
    first_frame=0,
    gap="an empty list, an empty row, or a frame that is left out",
    never="tongueOut; hardly ever moving: cheekPuff, noseSneer, eyeWide",
    evidence="derived: published coordinates of the canonical face (points 1, 33, 263) and the "
    "statement that metric space is right-handed with the camera looking along -Z",
    meanings={
        "head_yaw_left": "the matrix's +Z leans to +X",
        "head_pitch_up": "the matrix's +Z leans to +Y",
        "head_tilt_left": "the matrix's +Y leans to +X",
        "gaze_left": "eyeLookOutLeft - eyeLookInLeft and eyeLookInRight - eyeLookOutRight, "
        f"{LOOK_SIDEWAYS} rad at 1, mean of both eyes",
        "gaze_up": f"eyeLookUp, {LOOK_UP} rad at 1, less eyeLookDown, {LOOK_DOWN} rad at 1, "
        "mean of both eyes",
    },
)


def holds(path: Path) -> bool:
    """Whether the file's header is one of this format's, or its JSON names scores."""
    if path.suffix.lower() == ".json":
        return names_scores(path)
    names = header_of(path)
    return "_neutral" in names and not names & OTHERS


def read(path: Path, bad_values: str, fps: str) -> Take:
    """Read a table or a list of results.

    bad_values: "fail" or "mask". fps: rate of the video that was analysed. Rows are frames; where
    a column `frame` numbers them, from 0, or `timestamp_ms` times them, those left out are gaps.
    The matrix's sixteen numbers are columns matrix_0 ... matrix_15, or m00 ... m33; columns that
    look like it and are numbered otherwise are refused.
    Raises BadFile.
    """
    in_json = path.suffix.lower() == ".json"
    table = rows_of(path, bad_values) if in_json else read_columns(path)
    columns = [name for name in table if canonical(name) in EXPRESSIONS]
    columns = [name for name in columns if canonical(name) != NEVER]
    if not columns or table.empty:
        raise BadFile(
            path,
            found="no score",
            expected="at least a frame with a face, scores by their categories' names",
            remedy="Turn on output_face_blendshapes, and write names beside the scores.",
        )
    table, frame, first_frame = _clock(table, Fraction(fps), path, bad_values)
    cells = _matrix_columns(table, path)
    values, bad = numbers(table, [*columns, *cells], path, bad_values, blank_ok=True)
    channels = expressions(values[columns], path)
    found = channels.notna().any(axis=1).to_numpy() & ~bad
    origins = {name: _origin(name, name in channels) for name in EXPRESSIONS}

    if cells:
        turns = _rotations(values[cells].to_numpy().reshape(-1, 4, 4), path)
        channels = channels.assign(**dict(zip(HEAD, angles_of(turns), strict=True)))
        origins |= dict.fromkeys(HEAD, Origin("facial transformation matrix"))
    else:
        absent = Origin("without the facial transformation matrix", measured=False)
        origins |= dict.fromkeys(HEAD, absent)
    gaze, origin = _gaze(channels)
    channels = channels.assign(**gaze)
    origins |= dict.fromkeys(GAZE, origin)
    motion = assemble(frame, found, channels, np.nan, path)
    return Take(
        motion,
        Fraction(fps),
        origins=origins,
        first_frame=first_frame,
        numbered=any(name in table for name in NUMBERING),
    )


def _clock(
    table: pd.DataFrame, fps: Fraction, path: Path, bad_values: str
) -> tuple[pd.DataFrame, np.ndarray, int | None]:
    """The rows in the order of frames, their frames from 0, and the first one's number."""
    column = next((name for name in NUMBERING if name in table), None)
    if column is None:
        return table, np.arange(len(table)), None
    told, bad = numbers(table, [column], path, bad_values)
    told = told.loc[~bad, column]
    number = told if column == "frame" else (told * float(fps) / 1000).round()
    wrong = (number < 0) | (number % 1 != 0) | number.duplicated()
    if wrong.any() or number.empty:
        row = int(wrong.to_numpy().argmax()) if wrong.any() else 0
        raise BadFile(
            path,
            place=f"column {column}",
            found=f"{told.iloc[row]:.10g} in row {row + 1}" if len(told) else "no number",
            expected="whole numbers from 0 on, each once"
            if column == "frame"
            else f"milliseconds from 0 on, {1000 / float(fps):.4g} from frame to frame",
            remedy="Set ingest.mediapipe.fps to the video's rate, or number the frames."
            if column == "frame"
            else "Set ingest.mediapipe.fps to the video's rate; write milliseconds, or frames.",
        )
    number = number.sort_values()
    if column == "timestamp_ms":
        _check_milliseconds(told[number.index], number, fps, path)
    number = np.minimum(number, MOST_FRAMES).astype("int64")
    return table.loc[number.index], number.to_numpy(), int(number.iloc[0])


def _check_milliseconds(told: pd.Series, number: pd.Series, fps: Fraction, path: Path) -> None:
    """Raises BadFile for times of another unit, another beginning or another rate.

    told: timestamps in their order. number: the frames that they mean.
    """
    step = int(number.diff().median()) if len(number) > 1 else 1
    expected = f"milliseconds since the video's first frame, {1000 / float(fps):.4g} a frame"
    if told.iloc[0] > LATEST:
        found = f"{told.iloc[0]:.10g} in the first row"
        remedy = "Subtract the time of the video's first frame from all of them."
    elif step > fps:
        found = f"{told.diff().median():.10g} from row to row"
        remedy = "Write them in milliseconds: seconds x 1000, microseconds / 1000."
    elif step > 1:
        found, expected = f"a row every {step} frames", f"{fps} rows per second"
        remedy = f"Set ingest.mediapipe.fps to {float(fps / step):g}."
    else:
        return
    raise BadFile(path, place="column timestamp_ms", found=found, expected=expected, remedy=remedy)


def _matrix_columns(names: Iterable[str], path: Path) -> list[str]:
    """The columns of the matrix's sixteen numbers in their order; none where there is no matrix.

    Raises BadFile where columns look like a matrix's and are not numbered as one.
    """
    names = [name for name in names if len(name) <= LONGEST]
    numbered: dict[str, dict[int, str]] = {}
    for name in names:
        if match := re.fullmatch(r"(?i)(.*(?:matrix|transform)\D*)(\d{1,2})", name):
            numbered.setdefault(match[1], {})[int(match[2])] = name
        elif match := re.fullmatch(r"(?i)m_?([0-3])_?([0-3])", name):
            numbered.setdefault("m", {})[4 * int(match[1]) + int(match[2])] = name
    for cells in numbered.values():
        if set(cells) == set(range(16)):
            return [cells[place] for place in range(16)]
    named = [name for name in names if re.search(r"(?i)matrix|transform", name)]
    lettered = [name for name in names if re.fullmatch(r"(?i)m_?\d_?\d", name)]
    alike = named or (lettered if len(lettered) >= FEWEST_CELLS else [])
    if alike:
        raise BadFile(
            path,
            place="line 1",
            found=f"{alike[0]} ... {alike[-1]}",
            expected="a matrix's columns as matrix_0 ... matrix_15, or m00 ... m33",
            remedy="Rename the columns, or take them out: the head is then not measured.",
        )
    return []


def _rotations(matrices: np.ndarray, path: Path) -> np.ndarray:
    """Rotations (n, 3, 3) of matrices (n, 4, 4), NaN where one is not whole.

    Raises BadFile where rows cannot be told from columns, or a matrix is no turned and scaled face.
    """
    told = np.isfinite(matrices).all(axis=(1, 2))
    whole = matrices[told]
    last = np.array([0.0, 0.0, 0.0, 1.0])
    by_rows = np.isclose(whole[:, 3, :], last, atol=1e-4).all()
    by_columns = np.isclose(whole[:, :, 3], last, atol=1e-4).all()
    if by_columns and not by_rows:
        whole = whole.swapaxes(1, 2)
    turned = whole[:, :3, :3]
    ambiguous = by_rows and by_columns and not np.allclose(turned, turned.swapaxes(1, 2), atol=1e-4)
    U, stretch, Vt = np.linalg.svd(turned)
    whole_turn = (stretch[:, 0] < STRETCH * stretch[:, 2]) & (np.linalg.det(turned) > 0)
    if ambiguous or not (by_rows or by_columns) or not whole_turn.all():
        raise BadFile(
            path,
            place="facial transformation matrix",
            found="no translation, so that rows cannot be told from columns"
            if ambiguous
            else "another matrix",
            expected="rotation, uniform scale and translation, with 0, 0, 0, 1 last",
            remedy="Write the matrix as FaceLandmarker gives it, or leave it out.",
        )
    rotations = np.full((len(matrices), 3, 3), np.nan)
    rotations[told] = U @ Vt
    return rotations


def _gaze(channels: pd.DataFrame) -> tuple[dict[str, pd.Series], Origin]:
    """gaze_left and gaze_up, radians in the head, from the eyeLook coefficients."""
    look = {f"{way}{side}" for way in ("Up", "Down", "In", "Out") for side in ("Left", "Right")}
    if not {f"eyeLook{name}" for name in look} <= set(channels):
        return {}, Origin("some eyeLook coefficients are not there", measured=False)
    eye = {name: channels[f"eyeLook{name}"] for name in look}
    left = (eye["OutLeft"] - eye["InLeft"] + eye["InRight"] - eye["OutRight"]) / 2
    up, down = (eye["UpLeft"] + eye["UpRight"]) / 2, (eye["DownLeft"] + eye["DownRight"]) / 2
    gaze = {"gaze_left": LOOK_SIDEWAYS * left, "gaze_up": LOOK_UP * up - LOOK_DOWN * down}
    return gaze, Origin("worked out from eyeLook coefficients, by the slopes of Live Link Face")


def _origin(channel: str, given: bool) -> Origin:
    if channel == NEVER:
        return Origin("MediaPipe does not look for the tongue", measured=False)
    if not given:
        return Origin(f"no score {channel}", measured=False)
    known = "; known to move hardly ever" if channel in DEAD else ""
    return Origin(f"score {channel}{known}")
