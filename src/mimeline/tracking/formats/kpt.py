"""The landmarks that metrical-tracker lays beside a video: kpt/00001.npy and kpt_dense/00001.npy.

They are numbered as the video's pictures are, from 1, where the tracker's frames count from 0. A
picture without a face has landmarks that are all 0, and still a frame. There are landmarks of every
picture before the tracker begins: where it skipped the first (begin_frames) or last ones, nothing
tells which, and the landmarks are refused.
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import BadFile, unreadable
from mimeline.tables import COEFFICIENTS

COLUMNS = COEFFICIENTS["landmarks"].value_names
SPARSE, DENSE = "kpt", "kpt_dense"
N_POINTS = {SPARSE: 68, DENSE: 478}
NAME = re.compile(r"[0-9]{1,9}\.npy")
MOST_BYTES = 1_000_000  # of a file
MOST_MISSING = 0.1  # of the frames, or one; more are of another numbering
REMEDY = (
    "Let the tracker find the landmarks again, or take the folders kpt and kpt_dense away: then "
    "lost frames are not known."
)


def landmarks_of(
    folder: Path, frames: np.ndarray, bad_values: str
) -> tuple[pd.DataFrame | None, np.ndarray]:
    """The landmarks in a take's folder, and which of its frames show no face.

    frames: (n,) numbers from 0. bad_values: "fail", or "mask" to leave out what cannot be read.
    Returns columns of the landmarks table, a row per frame, NaN where there are none, or None where
    there is no folder kpt; and lost (n,) bool.
    Raises BadFile where a file holds no landmarks, or the files cannot be those of the frames: one
    lies past the last frame, or more than MOST_MISSING of the frames have none.
    """
    points = {name: _points(folder / name, frames, bad_values) for name in N_POINTS}
    lost = np.zeros(len(frames), bool)
    for found in points.values():
        if found is not None:
            lost |= (found == 0).all(axis=(1, 2))
    if points[SPARSE] is None:
        return None, lost
    sparse = np.where(lost[:, None, None], np.nan, points[SPARSE])  # (n, 68, 2)
    return pd.DataFrame(np.concatenate([sparse[..., 0], sparse[..., 1]], 1), columns=COLUMNS), lost


def _points(folder: Path, frames: np.ndarray, bad_values: str) -> np.ndarray | None:
    """Landmarks (n, points, 2) of a folder, NaN where it has none of a frame; None: no folder."""
    if not folder.is_dir():
        return None
    files = {int(file.stem): file for file in folder.iterdir() if NAME.fullmatch(file.name)}
    first = 0 if 0 in files else 1
    _refuse_other_numbering(folder, {number - first for number in files}, frames)
    points = np.full((len(frames), N_POINTS[folder.name], 2), np.nan)
    for row, frame in enumerate(frames):
        file = files.get(int(frame) + first)
        if file is None:
            continue
        try:
            points[row] = _read(file, N_POINTS[folder.name])
        except BadFile:
            if bad_values == "fail":
                raise
    return points


def _refuse_other_numbering(folder: Path, numbers: set[int], frames: np.ndarray) -> None:
    last = int(frames[-1])
    missing = len(set(frames.tolist()) - numbers)
    beyond = max(numbers, default=0) > last
    if not beyond and missing <= max(1, MOST_MISSING * len(frames)):
        return
    raise BadFile(
        folder,
        found=f"landmarks up to frame {max(numbers)} (from 0)" if beyond else f"{missing} missing",
        expected=f"landmarks of the {len(frames)} frames, the last of which is {last}",
        remedy="Take away the landmarks of pictures that were not tracked: the first, where the "
        "tracker began later (begin_frames), and number the others anew from 1; the last, where "
        "it ended earlier or was stopped. Without kpt and kpt_dense lost frames are not known.",
    )


def _read(file: Path, n_points: int) -> np.ndarray:
    expected = f"an npy file of {n_points} points"
    try:
        if not file.is_file() or file.stat().st_size > MOST_BYTES:
            raise ValueError("no file, or one that is too large")
        points = np.load(file, mmap_mode="r", allow_pickle=False)  # mapped: as large as the file
    except Exception as error:  # a damaged file raises whatever its bytes ask for
        raise unreadable(file, error, expected=expected, remedy=REMEDY) from error
    numbers = isinstance(points, np.ndarray) and points.dtype.kind in "fiu"
    if not numbers or points.ndim != 2 or len(points) != n_points or points.shape[1] not in (2, 3):
        found = f"{points.dtype} {points.shape}" if isinstance(points, np.ndarray) else "no array"
        raise BadFile(file, found=found, expected=expected, remedy=REMEDY)
    if not np.isfinite(points).all():
        raise BadFile(file, found="a NaN or infinity", expected=expected, remedy=REMEDY)
    return points[:, :2]
