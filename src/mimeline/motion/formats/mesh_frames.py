"""A folder of OBJ files, one for each frame, for programs that know no more of motion."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mimeline.atomic import whole_folder
from mimeline.face import obj_frames
from mimeline.face.model import Face
from mimeline.face.motion import perform
from mimeline.motion import about
from mimeline.motion.motion import Motion

AT_ONCE = 64  # frames whose vertices are held


def write(motion: Motion, path: Path, face: Face) -> None:
    """Write <name>_00000.obj and on into folder <name>, path without its ending, numbered by frame;
    frames that are not valid are left out."""
    folder = path.with_suffix("")
    with whole_folder(folder) as temporary:
        obj_frames.write(temporary, folder.name, face, _performed(motion, face))
        about.write_beside(temporary / folder.name, motion)


def _performed(motion: Motion, face: Face) -> Iterator[tuple[int, np.ndarray]]:
    frames = motion.frames[motion.frames["valid"].to_numpy(bool)]
    for start in range(0, len(frames), AT_ONCE):
        rows = frames.iloc[start : start + AT_ONCE]
        yield from zip(rows["frame"].tolist(), perform(face, rows), strict=True)
