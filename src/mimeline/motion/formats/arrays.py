"""npz: the motion as an array beside the names of its columns, for numpy."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.archives.npz import array_names, read_arrays
from mimeline.atomic import whole
from mimeline.errors import BadFile
from mimeline.motion import about
from mimeline.motion.motion import Motion
from mimeline.tracking.take import assemble
from mimeline.vocabulary import CHANNELS

ARRAYS = {"channels", "motion", "valid", "fps", "about"}
REMEDY = "Write the motion again; docs/motion.md names the arrays."


def write(motion: Motion, path: Path) -> None:
    """Write arrays: channels (D,) names, motion (n, D) float32 with NaN where nothing is known,
    valid (n,) bool, fps (2,) the rate as a fraction, about () JSON."""
    moved = motion.moved
    told = json.dumps(about.about(motion), ensure_ascii=False, allow_nan=False)
    with whole(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(
            file,
            channels=np.array(moved, np.str_),
            motion=motion.frames[moved].to_numpy(np.float32),
            valid=motion.frames["valid"].to_numpy(bool),
            fps=np.array(motion.fps.as_integer_ratio()),
            about=np.array(told),
        )


def holds(path: Path) -> bool:
    """Whether an npz file is a motion of ours."""
    try:
        return set(array_names(path, REMEDY)) >= ARRAYS
    except BadFile:
        return False


def read(path: Path) -> Motion:
    """The motion of a file. Raises BadFile where its arrays do not fit each other."""
    held = read_arrays(path, REMEDY, ARRAYS)
    names, values, valid = (held[name] for name in ("channels", "motion", "valid"))
    fits = (
        names.dtype.kind == "U"
        and len(names) == len({*names.tolist()})
        and values.dtype.kind == "f"
        and values.ndim == 2
        and values.shape[1:] == names.shape
        and valid.shape == values.shape[:1]
        and valid.dtype == bool
        and len(values)
        and held["fps"].shape == (2,)
        and held["fps"].dtype.kind in "iu"
        and (held["fps"] > 0).all()
    )
    if not fits:
        raise BadFile(
            path,
            found=", ".join(f"{n} {held[n].dtype} {held[n].shape}" for n in sorted(held)),
            expected="channels (D,) text, motion (n, D) float, valid (n,) bool, fps (2,)",
            remedy=REMEDY,
        )
    if np.isinf(values).any():
        raise BadFile(
            path,
            place="array motion",
            found="a value without end",
            expected="numbers, NaN where nothing is known",
            remedy=REMEDY,
        )
    if unknown := sorted({*names.tolist()} - {*CHANNELS}):
        raise BadFile(
            path,
            place="array channels",
            found=", ".join(unknown[:5]),
            expected="names of channels",
            remedy="resources/channels.csv has them all.",
        )
    table = pd.DataFrame(values, columns=names.tolist())
    frames = assemble(np.arange(len(table)), valid, table, np.nan, path)
    motion = Motion(frames, Fraction(*held["fps"].tolist()))
    return about.informed(motion, about.parsed(str(held["about"]), path))
