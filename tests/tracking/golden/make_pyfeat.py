"""What py-feat 2 says of a head that turns, lifts and tilts, of eyes that look and close.

py-feat publishes no axes for its network's angles, so they are read off the tables that it does
publish (docs/data/news_sample of its repository, unmirrored videos), against the face mesh in the
same rows, in picture axes: x right, y down, z away from the camera. There
- Yaw falls as mesh point 263 (the subject's left eye, right in the picture) goes away and 33 (the
  right eye) comes near: yaw is positive toward the subject's right;
- Pitch falls as point 10 (the forehead) goes away and 152 (the chin) comes near: positive is down;
- Roll falls as 263 sinks below 33: positive is toward the right shoulder;
- gaze_yaw grows with eyeLookOutLeft and eyeLookInRight, gaze_pitch with eyeLookUp.
Here a head is moved as a matrix in these axes: to the subject's left the nose goes from -z towards
+x, lifting takes it towards -y, tilting to the left shoulder takes the crown from -y towards +x.
Its angles are then read off where those four points go, and 68 landmarks are drawn of it at a
distance. Blend shapes are named after the subject's own sides, as MediaPipe's are. A mirrored
picture is that of the opposite turn.

Run it in its folder; it writes pyfeat/<name>.csv.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent / "pyfeat"
STEPS = (0.0, 0.075, 0.15, 0.225, 0.3)  # radians
CLOSING = (0.0, 0.225, 0.45, 0.675, 0.9)
SIDED = (
    "browDown,browOuterUp,cheekSquint,eyeBlink,eyeLookDown,eyeLookIn,eyeLookOut,eyeLookUp,"
    "eyeSquint,eyeWide,mouthDimple,mouthFrown,mouthLowerDown,mouthPress,mouthSmile,mouthStretch,"
    "mouthUpperUp,noseSneer"
)
SINGLE = (
    "browInnerUp,cheekPuff,jawForward,jawLeft,jawOpen,jawRight,mouthClose,mouthFunnel,mouthLeft,"
    "mouthPucker,mouthRight,mouthRollLower,mouthRollUpper,mouthShrugLower,mouthShrugUpper"
)
BOTH = [name + side for name in SIDED.split(",") for side in ("Left", "Right")]
SHAPES = ["_neutral", *sorted([*SINGLE.split(","), *BOTH])]
EYE_LEFT, EYE_RIGHT = np.array([0.4, 0, -0.6]), np.array([-0.4, 0, -0.6])
FOREHEAD, CHIN = np.array([0, -0.8, -0.7]), np.array([0, 0.8, -0.7])


def nose_right(angle):
    """Columns: where the right of the picture, down and away go."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T


def nose_up(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T


def crown_right(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]).T


def pose(rotation):
    """Pitch, Roll and Yaw from where the points of the mesh go."""
    across, down = rotation @ (EYE_LEFT - EYE_RIGHT), rotation @ (CHIN - FOREHEAD)
    yaw = -np.arctan2(across[2], np.hypot(*across[:2]))  # the left eye goes away
    pitch = -np.arctan2(-down[2], np.hypot(*down[:2]))  # the chin comes near
    roll = -np.arctan2(across[1], across[0])  # the left eye sinks
    return pitch, roll, yaw


def curve(left, right, top, sag, count):
    """Points of a line from left to right that sags in its middle, on a round face."""
    x = np.linspace(left, right, count)
    y = top + sag * (1 - np.linspace(-1, 1, count) ** 2)
    return np.stack([x, y, -np.sqrt(1 - 0.8 * x**2 - 0.3 * y**2)], axis=1)


def around(x, y, width, height, count):
    """Points around an opening, from the left of the picture over its upper edge."""
    turn = np.linspace(np.pi, 3 * np.pi, count, endpoint=False)
    x, y = x + width * np.cos(turn), y + height * np.sin(turn)
    return np.stack([x, y, -np.sqrt(1 - 0.8 * x**2 - 0.3 * y**2)], axis=1)


FACE = np.concatenate(
    [
        curve(-0.75, 0.75, 0.0, 1.0, 17),  # jaw
        curve(-0.65, -0.15, -0.35, -0.1, 5),
        curve(0.15, 0.65, -0.35, -0.1, 5),
        np.stack([np.zeros(4), np.linspace(-0.2, 0.25, 4), np.linspace(-1.05, -1.25, 4)], axis=1),
        curve(-0.15, 0.15, 0.32, 0.03, 5),
        around(-0.35, -0.18, 0.12, 0.05, 6),
        around(0.35, -0.18, 0.12, 0.05, 6),
        around(0.0, 0.58, 0.28, 0.1, 12),
        around(0.0, 0.58, 0.2, 0.03, 8),
    ]
)


def landmarks(rotation):
    """68 points in pixels of a picture of 400 by 400, x then y."""
    points = FACE @ rotation.T
    return (200 + 120 * points[:, :2] / (1 + points[:, 2:] / 10)).T.ravel()


MOTIONS = {
    "turns_left": (nose_right, 1),
    "turns_right": (nose_right, -1),
    "lifts_head": (nose_up, 1),
    "tilts_left": (crown_right, 1),
    "tilts_right": (crown_right, -1),
}
LOOKS = {"looks_left": ("gaze_yaw", 1), "looks_right": ("gaze_yaw", -1)}
LOOKS |= {"looks_up": ("gaze_pitch", 1)}
POINTS = [f"{axis}_{point}" for axis in "xy" for point in range(68)]
ANGLES = ["Pitch", "Roll", "Yaw"]
BOX = {"FaceRectX": 80, "FaceRectY": 80, "FaceRectWidth": 240, "FaceRectHeight": 240}

if __name__ == "__main__":
    HERE.mkdir(exist_ok=True)
    takes = {n: [(move(sign * s), {}) for s in STEPS] for n, (move, sign) in MOTIONS.items()}
    for name, (column, sign) in LOOKS.items():
        takes[name] = [(np.eye(3), {column: sign * step}) for step in STEPS]
    for side in ("Left", "Right"):
        takes[f"closes_{side.lower()}_eye"] = [(np.eye(3), {f"eyeBlink{side}": c}) for c in CLOSING]
    for name, frames in takes.items():
        header = [*BOX, "FaceScore", *POINTS, *ANGLES, "gaze_pitch", "gaze_yaw", *SHAPES]
        lines = [",".join([*header, "input", "frame"])]
        for number, (rotation, told) in enumerate(frames):
            row = BOX | {"FaceScore": 0.99}
            row |= dict(zip(POINTS, np.round(landmarks(rotation), 1), strict=True))
            row |= dict(zip(ANGLES, np.round(pose(rotation), 4) + 0.0, strict=True)) | told
            cells = [f"{row.get(column, 0.0):g}" for column in header]
            lines.append(",".join([*cells, "clip.mp4", str(number)]))
        (HERE / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8", newline="")
