"""Golden MediaPipe FaceLandmarker results, from the geometry that MediaPipe publishes.

The facial transformation matrix takes the canonical face into metric space, which is right-handed
with the camera at its origin, looking along -Z; +X is right in an unmirrored picture and +Y is up.
In the canonical face the tip of the nose (point 1) is at (0, -1.1, 7.5), the outer corner of the
subject's left eye (263) at (4.4, 2.7, 3.2) and that of the right one (33) at (-4.4, 2.7, 3.2): the
face looks along +Z, to a camera that stands some 40 cm off, its own left along +X. The columns of
the rotation are where the head's left, top and nose point. The sixteen numbers stand column by
column, as in the packed matrix that the result holds.

Scores are named as the subject sees it: who looks to the own left turns the left eye out and the
right eye in. Heads are written as CSV, eyes as JSON in MediaPipe's JavaScript spelling.
"""

import json
from pathlib import Path

import numpy as np

SIDED = """
browDown browOuterUp cheekSquint eyeBlink eyeLookDown eyeLookIn eyeLookOut eyeLookUp
eyeSquint eyeWide mouthDimple mouthFrown mouthLowerDown mouthPress mouthSmile mouthStretch
mouthUpperUp noseSneer
""".split()  # noqa: SIM905
ALONE = """
browInnerUp cheekPuff jawForward jawLeft jawOpen jawRight mouthClose mouthFunnel mouthLeft
mouthPucker mouthRight mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper
""".split()  # noqa: SIM905
NAMES = [
    "_neutral",
    *sorted([*ALONE, *(f"{name}{side}" for name in SIDED for side in ("Left", "Right"))]),
]
REST = 0.02
LARGEST_TURN, LARGEST_SCORE = 0.3, 0.9
LEFT, TOP, NOSE = np.eye(3)
SCORES = {
    "looks_left": ("eyeLookOutLeft", "eyeLookInRight"),
    "looks_right": ("eyeLookOutRight", "eyeLookInLeft"),
    "looks_up": ("eyeLookUpLeft", "eyeLookUpRight"),
    "closes_left_eye": ("eyeBlinkLeft",),
    "closes_right_eye": ("eyeBlinkRight",),
}
TURNS = ("turns_left", "turns_right", "lifts_head", "tilts_left", "tilts_right")


def between(start, end, angle):
    """The direction that leaves `start` towards `end` by an angle."""
    return np.cos(angle) * start + np.sin(angle) * end


def matrix(move, angle):
    """Sixteen numbers, column by column, of a head 40 cm before the camera."""
    left, top, nose = LEFT, TOP, NOSE
    if move in ("turns_left", "turns_right"):
        nose = between(NOSE, LEFT if move == "turns_left" else -LEFT, angle)
        left = np.cross(top, nose)
    elif move == "lifts_head":
        nose = between(NOSE, TOP, angle)
        top = np.cross(nose, left)
    elif move in ("tilts_left", "tilts_right"):
        top = between(TOP, LEFT if move == "tilts_left" else -LEFT, angle)
        left = np.cross(top, nose)
    columns = [(*left, 0), (*top, 0), (*nose, 0), (0, 0, -40, 1)]
    return [round(float(value) + 0.0, 6) for column in columns for value in column]


def scores(move, share):
    found = dict.fromkeys(NAMES, REST)
    for name in SCORES.get(move, ()):
        found[name] = round(REST + (LARGEST_SCORE - REST) * share, 4)
    return found


def table(move):
    header = ["frame", *NAMES, *(f"matrix_{place}" for place in range(16))]
    rows = [
        [frame, *scores(move, frame / 4).values(), *matrix(move, LARGEST_TURN * frame / 4)]
        for frame in range(5)
    ]
    return "\n".join(",".join(f"{cell:.6g}" for cell in row) for row in rows).join(
        [",".join(header) + "\n", "\n"]
    )


def results(move):
    frames = []
    for frame in range(5):
        named = scores(move, frame / 4).items()
        categories = [{"score": score, "categoryName": name} for name, score in named]
        data = {"rows": 4, "columns": 4, "data": matrix(move, 0.0)}
        face = {"categories": categories}
        frames.append({"faceBlendshapes": [face], "facialTransformationMatrixes": [data]})
    return json.dumps(frames, separators=(",", ":")) + "\n"


if __name__ == "__main__":
    folder = Path(__file__).parent / "mediapipe"
    for move in TURNS:
        (folder / f"{move}.csv").write_text(table(move))
    for move in SCORES:
        (folder / f"{move}.json").write_text(results(move))
