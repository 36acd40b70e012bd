"""The picture of docs/conventions.md: what each channel's positive numbers look like.

`python docs/conventions_picture.py` draws docs/conventions.png anew.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pandas as pd

from mimeline.face.load import load_face
from mimeline.face.model import Face
from mimeline.face.motion import perform
from mimeline.face.render import Camera, draw

PICTURE = Path(__file__).with_name("conventions.png")
PAPER, INK, SOFT, ACCENT = (251, 250, 246), (34, 33, 30), (106, 102, 93), (166, 58, 36)
SIDE, GUTTER, CAPTION, MARGIN, FOOT = 288, 16, 66, 20, 44
CLOSER = 1.7  # how much larger the eyes are shown than the head
EYES = slice(36, 48)  # iBUG landmarks


@dataclass(frozen=True)
class Panel:
    """A face that does something, with what a person and what the motion table says of it."""

    title: str
    says: str
    motion: dict[str, float]
    eyes: bool = False
    mirrored: bool = False


PANELS = (
    Panel("at rest", "all channels 0", {}),
    Panel("turns to their left", "head_yaw_left  +0.5", {"head_yaw_left": 0.5}),
    Panel("lifts the head", "head_pitch_up  +0.35", {"head_pitch_up": 0.35}),
    Panel("tilts to their left shoulder", "head_tilt_left  +0.35", {"head_tilt_left": 0.35}),
    Panel("looks to their left", "gaze_left  +0.5", {"gaze_left": 0.5}, eyes=True),
    Panel("looks up", "gaze_up  +0.3", {"gaze_up": 0.3}, eyes=True),
    Panel("closes the left eye", "eyeBlinkLeft  1", {"eyeBlinkLeft": 1.0}, eyes=True),
    Panel(
        "turns left, recording mirrored",
        "read as head_yaw_left  −0.5",
        {"head_yaw_left": 0.5},
        mirrored=True,
    ),
)


def contact_sheet() -> np.ndarray:
    """All panels in two rows of four, (H, W, 3) uint8 RGB."""
    face = load_face(None)
    far = Camera.framing(face, SIDE)
    eyes = face.landmarks_at(face.neutral[None])[0, EYES]
    before = (far.position[0], float(eyes[:, 1].mean()), far.position[2])
    near = replace(far, position=before, focal=far.focal * CLOSER)
    columns = len(PANELS) // 2
    width = 2 * MARGIN + columns * SIDE + (columns - 1) * GUTTER
    sheet = np.full((2 * (SIDE + CAPTION) + MARGIN + FOOT, width, 3), PAPER, np.uint8)
    for number, panel in enumerate(PANELS):
        row, column = divmod(number, columns)
        top, left = MARGIN + row * (SIDE + CAPTION), MARGIN + column * (SIDE + GUTTER)
        picture = _panel(face, panel, near if panel.eyes else far)
        sheet[top : top + SIDE, left : left + SIDE] = picture
        for side, x in zip("LR" if panel.mirrored else "RL", (12, SIDE - 26), strict=True):
            _write(sheet, side, (left + x, top + SIDE - 14), 22, 600, ACCENT)
        _write(sheet, panel.title, (left, top + SIDE + 24), 18, 600, INK)
        colour = ACCENT if panel.mirrored else SOFT
        _write(sheet, panel.says, (left, top + SIDE + 46), 16, 400, colour)
    foot = (
        "L and R are the subject's left and right. A camera in front of the face "
        "sees the subject's left on the right of the picture."
    )
    _write(sheet, foot, (MARGIN, sheet.shape[0] - 20), 17, 400, INK)
    return sheet


def _panel(face: Face, panel: Panel, camera: Camera) -> np.ndarray:
    vertices = perform(face, pd.DataFrame([panel.motion or {"jawOpen": 0.0}]))[0]
    picture = draw(face, vertices, camera)
    return picture[:, ::-1] if panel.mirrored else picture


def _write(
    sheet: np.ndarray, text: str, at: tuple[int, int], px: int, weight: int, colour: tuple
) -> None:
    """Write on the sheet. at: the left end of the baseline."""
    cv2.putText(sheet, text, at, colour, cv2.FontFace("sans"), px, weight)


if __name__ == "__main__":
    small = [cv2.IMWRITE_PNG_COMPRESSION, 9, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_ALL_FILTERS]
    cv2.imwrite(str(PICTURE), contact_sheet()[..., ::-1], small)
