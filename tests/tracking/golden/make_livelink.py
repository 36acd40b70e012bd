"""What Live Link Face says of a head that turns, lifts and tilts, of eyes that look and close.

The published geometry: ARKit gives the rotation of the face, and of each eye in the face, in a
right-handed frame whose +X goes to the subject's left, +Y up and +Z out of the face. Unreal's axes
are (-Z, X, Y) of it, a left-handed frame, and its rotator is taken from where the rotation sends
its first and second axis: yaw = atan2(y, x) of the first, pitch = atan2(z, hypot(x, y)) of the
first, and roll is how far the second sinks below the level (Unreal's documentation of FRotator: yaw
is positive clockwise seen from above, pitch nose up, roll clockwise seen from behind). As its +X
goes out of the back of the head, "nose up" is face down.

A head that turns to its left takes its nose from +Z towards +X; one that lifts takes it towards +Y;
one that tilts to the left shoulder takes its crown from +Y towards +X. Eyes do the same in the
face. Each is written as a matrix with these images, then taken apart as above; radians, as in
published takes. Coefficients are named after the subject's own sides (Apple's documentation of
ARFaceAnchor.BlendShapeLocation). A mirrored picture is that of the opposite turn.

Run it in its folder; it writes livelink/<name>.csv.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent / "livelink"
STEPS = (0.0, 0.075, 0.15, 0.225, 0.3)  # radians
CLOSING = (0.0, 0.225, 0.45, 0.675, 0.9)
UNREAL = np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0]])  # rows: Unreal's axes in ARKit's
HEADER = (
    "Timecode,BlendShapeCount,"
    "EyeBlinkLeft,EyeLookDownLeft,EyeLookInLeft,EyeLookOutLeft,EyeLookUpLeft,EyeSquintLeft,"
    "EyeWideLeft,EyeBlinkRight,EyeLookDownRight,EyeLookInRight,EyeLookOutRight,EyeLookUpRight,"
    "EyeSquintRight,EyeWideRight,JawForward,JawRight,JawLeft,JawOpen,MouthClose,MouthFunnel,"
    "MouthPucker,MouthRight,MouthLeft,MouthSmileLeft,MouthSmileRight,MouthFrownLeft,"
    "MouthFrownRight,MouthDimpleLeft,MouthDimpleRight,MouthStretchLeft,MouthStretchRight,"
    "MouthRollLower,MouthRollUpper,MouthShrugLower,MouthShrugUpper,MouthPressLeft,MouthPressRight,"
    "MouthLowerDownLeft,MouthLowerDownRight,MouthUpperUpLeft,MouthUpperUpRight,BrowDownLeft,"
    "BrowDownRight,BrowInnerUp,BrowOuterUpLeft,BrowOuterUpRight,CheekPuff,CheekSquintLeft,"
    "CheekSquintRight,NoseSneerLeft,NoseSneerRight,TongueOut,HeadYaw,HeadPitch,HeadRoll,"
    "LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,RightEyePitch,RightEyeRoll"
)


def nose_left(angle):
    """Columns: where the subject's left, the crown and the nose go."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]).T


def nose_up(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T


def crown_left(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


def rotator(rotation):
    """Unreal's yaw, pitch and roll, radians, of a rotation in ARKit's frame."""
    turned = UNREAL @ rotation @ UNREAL.T
    first, second = turned[:, 0], turned[:, 1]
    yaw, pitch = np.arctan2(first[1], first[0]), np.arctan2(first[2], np.hypot(*first[:2]))
    level = np.array([-np.sin(yaw), np.cos(yaw), 0])  # the second axis of a rotator without roll
    above = np.cross(first, level)
    return yaw, pitch, -np.arctan2(second @ above, second @ level)


MOTIONS = {
    "turns_left": ("Head", nose_left, 1),
    "turns_right": ("Head", nose_left, -1),
    "lifts_head": ("Head", nose_up, 1),
    "tilts_left": ("Head", crown_left, 1),
    "tilts_right": ("Head", crown_left, -1),
    "looks_left": ("Eye", nose_left, 1),
    "looks_right": ("Eye", nose_left, -1),
    "looks_up": ("Eye", nose_up, 1),
}

if __name__ == "__main__":
    HERE.mkdir(exist_ok=True)
    takes = {
        name: [
            {
                f"{part}{angle}": value
                for part in (["Head"] if moved == "Head" else ["LeftEye", "RightEye"])
                for angle, value in zip(
                    ("Yaw", "Pitch", "Roll"), rotator(move(sign * step)), strict=True
                )
            }
            for step in STEPS
        ]
        for name, (moved, move, sign) in MOTIONS.items()
    }
    for side in ("left", "right"):
        takes[f"closes_{side}_eye"] = [{f"EyeBlink{side.capitalize()}": c} for c in CLOSING]
    for name, rows in takes.items():
        lines = [HEADER]
        for number, row in enumerate(rows):
            cells = [f"{row.get(column, 0.0):.4f}" for column in HEADER.split(",")[2:]]
            lines.append(",".join([f"10:00:00:{2 * number:02d}.500", "61", *cells]))
        text = "\n".join(lines).replace("-0.0000", "0.0000") + "\n"
        (HERE / f"{name}.csv").write_text(text, encoding="utf-8", newline="")
