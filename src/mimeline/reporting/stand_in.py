"""The face that motion is drawn on where nothing was filmed: the same for everybody."""

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.errors import MimelineError
from mimeline.face.load import load_face
from mimeline.face.model import Face
from mimeline.face.motion import driver, perform
from mimeline.face.render import Camera, film
from mimeline.vocabulary import HEAD, SERIES_REGIONS

log = logging.getLogger(__name__)

GROUND = (214, 211, 204)  # behind the face: neither glares in the dark nor greys in the light
AT_ONCE = 64  # frames whose vertices are held
# What is seen of a series region: points of the 68, and the picture's edge as a multiple of their
# width.
_UPPER = ((*range(17, 28), *range(36, 48)), 1.22)
_LOWER = ((*range(31, 36), *range(48, 68)), 2.0)
CLOSE = {"brow": _UPPER, "eye": _UPPER, "mouth": _LOWER}


@dataclass(frozen=True, eq=False)
class StandIn:
    """face, and why it is not the one that was asked for (empty where it is)."""

    face: Face
    reason: str

    def pictures(
        self,
        motion: pd.DataFrame,
        size: int,
        region: str | None = None,
        ground: tuple[int, int, int] = GROUND,
    ) -> Iterator[np.ndarray]:
        """One (size, size, 3) uint8 RGB picture per row of a motion table.

        region: a series region, which is seen close while the head keeps still; None: the head.
        """
        camera = Camera.framing(self.face, size)
        if region and self.face.landmarks is not None:
            camera = self._close(camera, region)
            motion = motion.drop(columns=list(HEAD), errors="ignore")
        for start in range(0, len(motion), AT_ONCE):
            vertices = perform(self.face, motion.iloc[start : start + AT_ONCE])
            yield from film(self.face, vertices, camera, ground)

    def _close(self, camera: Camera, region: str) -> Camera:
        numbers, share = CLOSE[region]
        points = self.face.landmarks_at(self.face.neutral[None])[0, list(numbers)]  # (n, 3)
        low, high = points.min(axis=0), points.max(axis=0)
        x, y, z = ((low + high) / 2).tolist()
        edge = share * float(high[0] - low[0])
        distance = camera.position[2] - z
        position = (x, y, camera.position[2])
        return replace(camera, position=position, focal=camera.size * distance / edge)


def stand_in(path: str | Path | None) -> StandIn:
    """The face at path, or the embedded one: also where that face cannot show the channels."""
    if path is None:
        return StandIn(load_face(None), "")
    try:
        face = load_face(Path(path))
    except MimelineError as error:
        reason = str(error)
    else:
        if any(driver(name) for name in face.shape_names):
            return StandIn(face, "")
        reason = f"{path}: none of its shapes bears the name of a channel"
    log.warning("the embedded face stands in for report.face: %s", reason)
    return StandIn(load_face(None), reason)


assert set(CLOSE) == set(SERIES_REGIONS)
