"""The 52 ARKit blendshapes as smooth fields over the embedded face's geometry.

Every field is written from where the features are in the geometry that it is given, so another
person's face gets its own movements. Centimetres, frame of anatomy. What each shape does follows
Apple's documentation of ARFaceAnchor.BlendShapeLocation.
"""

import numpy as np

from mimeline.face.embedded import anatomy
from mimeline.face.embedded.mesh import Mesh
from mimeline.face.embedded.parts import BROW_ROWS
from mimeline.face.embedded.skin import LID_RINGS, MEET
from mimeline.face.falloff import bell, folded, smoothstep
from mimeline.vocabulary import CHANNELS, EXPRESSIONS

JAW_TURN = 0.29  # radians at jawOpen 1
LASH_DROOP, LASH_HASTE = 1.15, 2.5  # radians at most that a lash turns; how soon in its lid's way
LID_FOLLOW = 1 - smoothstep(np.array(LID_RINGS), 0.10, 1.0)  # how far a ring goes with the rim


def shapes(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Offsets (52, V, 3) of vocabulary.EXPRESSIONS on a face of the mesh with points (V, 3)."""
    fields = _Fields(mesh, points)
    left_or_both = {}
    for part in (_lids, _brows, _cheeks_and_nose, _jaw, _lips):
        left_or_both |= part(fields)
    out = np.empty((len(EXPRESSIONS), *points.shape))
    for number, name in enumerate(EXPRESSIONS):
        mirror = CHANNELS[name].mirror
        if name == mirror:
            out[number] = mesh.symmetric(left_or_both[name])
        elif name in left_or_both:
            out[number] = left_or_both[name]
        else:
            out[number] = mesh.mirrored(left_or_both[mirror])
    return out


class _Fields:
    """A face's geometry, where its features are, and the weights that fields are made of."""

    def __init__(self, mesh: Mesh, points: np.ndarray):
        self.mesh, self.points, self.folded = mesh, points, folded(points)
        self.x, self.y, self.z = points.T
        ball = points[mesh.left("eye")]
        self.eye = (ball.min(0) + ball.max(0)) / 2
        self.eye_scale = np.ptp(ball[:, 0]) / 2 / anatomy.EYE_RADIUS
        brow = points[mesh.left("brow")].reshape(BROW_ROWS, -1, 3).mean(0)
        self.inner_brow, self.mid_brow, self.outer_brow = brow[[1, len(brow) // 2, -3]]
        meet = mesh.skin.lips[MEET]
        middle = len(meet) // 2
        upper = points[meet[: middle + 1]]  # from the midline to the corner
        self.mouth, self.corner = upper[0], upper[-1]
        self.eye_moved = self.eye - anatomy.EYE
        self.corner_moved = self.corner - mesh.points[meet[middle]]
        self.height = self.y - np.interp(self.folded[:, 0], upper[:, 0], upper[:, 1])
        # 1 on the midline, 0 at the corner of the mouth
        self.arch = np.sqrt(np.clip(1 - (self.x / self.corner[0]) ** 2, 0, 1))
        self.on_left = smoothstep(self.x, -0.7, 0.7)
        over_eye = self.y - self.eye[1]
        self.above_lids = smoothstep(over_eye, 0.75 * self.eye_scale, 1.6 * self.eye_scale)
        # how far from the fold between nose and cheek
        fold = self.near_mouth(1.8, -4.4, 9), self.near_mouth(3.8, -7.0, 8)
        self.beside_nose = _off_line(points, *fold)

    def near_eye(self, *at_rest: float) -> np.ndarray:
        """Where a point (3,) of the resting face is, which moves with the left eye."""
        return np.array(at_rest) + self.eye_moved

    def near_mouth(self, *at_rest: float) -> np.ndarray:
        """Where a point (3,) of the resting face is, which moves with the mouth's left corner."""
        return np.array(at_rest) + self.corner_moved

    def flesh(self, centre, size) -> np.ndarray:
        """A bell (V,) of the flesh round a point (3,), with its sizes along the axes (3,)."""
        return self.mesh.soft * bell(self.points, centre, size)

    def both(self, centre, size) -> np.ndarray:
        """The same round a point on the left and its mirror image."""
        return self.mesh.soft * bell(self.folded, centre, size)

    def lip(self, reach: float) -> np.ndarray:
        """1 (V,) on the lips, falling over `reach` around them."""
        return self.mesh.soft * np.exp(-((self.mesh.lip_distance / reach) ** 2))

    def lids_turned(self, upper, lower) -> np.ndarray:
        """Offsets (V, 3) of the left eye's lids turned on the ball.

        upper, lower: how far each lid's rim moves up, as a share of the opening.
        """
        lids = self.mesh.skin.lids
        columns = lids.shape[1]
        ring = self.points[lids] - self.eye  # (rings, columns, 3)
        facing = -np.arange(columns) % columns  # the column of the other lid at the same place
        height = np.arctan2(ring[1, :, 1], ring[1, :, 2])  # of the rim
        is_upper = np.arange(columns) <= columns // 2
        opening = np.abs(height - height[facing])
        turn = np.where(is_upper, upper, lower) * opening  # (columns,)
        follow = LID_FOLLOW[:, None]  # (rings, 1)
        radius = self.eye_scale * (anatomy.EYE_RADIUS + anatomy.LID_THICKNESS)
        reach = np.hypot(ring[..., 1], ring[..., 2])
        on_ball = np.sqrt(np.maximum(radius**2 - ring[..., 0] ** 2, (0.3 * radius) ** 2))
        on_ball += np.where(is_upper, 0.2, -0.25) * np.abs(turn) * self.eye_scale  # over the lower
        on_ball[0] = reach[0]
        settling = follow * np.minimum(1, np.abs(turn) / 0.5)
        settled = reach + (on_ball - reach) * settling  # a lid that comes down lies on the ball
        angle = np.arctan2(ring[..., 1], ring[..., 2]) + turn * follow
        out = np.zeros_like(self.points)
        out[lids, 1] = settled * np.sin(angle) - ring[..., 1]
        out[lids, 2] = settled * np.cos(angle) - ring[..., 2]
        lash = self.mesh.left("lash").reshape(2, -1)  # roots and tips
        hair = self.points[lash[1]] - self.points[lash[0]]
        droop = LASH_DROOP * np.tanh(LASH_HASTE * turn[1 : columns // 2])
        cosine, sine = np.cos(droop), np.sin(droop)
        out[lash] = out[lids[1, 1 : columns // 2]]
        out[lash[1], 1] += hair[:, 1] * (cosine - 1) + hair[:, 2] * sine
        out[lash[1], 2] += hair[:, 2] * (cosine - 1) - hair[:, 1] * sine
        return out


def _beside(point: np.ndarray, outwards: float, up: float) -> np.ndarray:
    return point + np.array([outwards, up, 0])


def _off_line(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance (V,) of points from a straight line from start to end (3,), seen from the front."""
    along = (end - start)[:2]
    away = (points - start)[:, :2]
    share = np.clip(away @ along / (along @ along), 0, 1)
    return np.linalg.norm(away - share[:, None] * along, axis=1)


def _moved(weight: np.ndarray, *direction: float) -> np.ndarray:
    """Offsets (V, 3): a weight (V,) times a direction in centimetres."""
    return weight[:, None] * np.array(direction)


def _lids(f: _Fields) -> dict[str, np.ndarray]:
    lids = f.mesh.skin.lids
    follow = np.zeros(len(f.points))
    follow[lids] = LID_FOLLOW[:, None]
    follow[f.mesh.left("lash")] = 1
    under = f.flesh(f.near_eye(3.3, -1.7, 7.8), (2.0, 0.8, 2.5)) * (1 - follow)
    return {
        "eyeBlinkLeft": f.lids_turned(-0.94, 0.13),
        "eyeSquintLeft": f.lids_turned(-0.12, 0.36) + _moved(under, 0, 0.22, 0.10),
        "eyeWideLeft": f.lids_turned(0.30, -0.10),
        "eyeLookDownLeft": f.lids_turned(-0.60, -0.20),
        "eyeLookUpLeft": f.lids_turned(0.12, 0.14),
        "eyeLookInLeft": _moved(follow, -0.07, 0, 0.0),
        "eyeLookOutLeft": _moved(follow, 0.07, 0, 0.0),
    }


def _brows(f: _Fields) -> dict[str, np.ndarray]:
    inner = f.above_lids * f.flesh(f.inner_brow, (1.5, 1.2, 3))
    middle = f.above_lids * f.flesh(f.mid_brow, (1.7, 1.1, 3))
    lifted = f.above_lids * f.both(_beside(f.inner_brow, -0.2, 0.3), (1.5, 1.7, 3))
    outer = f.above_lids * f.flesh(_beside(f.outer_brow, 0.2, 0.1), (2.1, 1.8, 2.2))
    return {
        "browDownLeft": _moved(inner, -0.28, -0.55, 0.12) + _moved(middle, -0.12, -0.35, 0.05),
        "browInnerUp": _moved(lifted, 0, 0.9, -0.05),
        "browOuterUpLeft": _moved(outer, 0, 0.75, -0.15) + _moved(middle, 0, 0.3, -0.05),
    }


def _cheeks_and_nose(f: _Fields) -> dict[str, np.ndarray]:
    puffed = f.both(f.near_mouth(4.6, -5.2, 6.2), (2.0, 2.5, 3))
    side = np.sign(f.x)
    puff = np.stack([0.95 * side * puffed, 0 * puffed, 0.75 * puffed], axis=-1)
    raised = smoothstep(f.eye[1] - f.y, 0.6, 1.4) * f.flesh(
        f.near_eye(3.9, -2.6, 7.8), (1.7, 1.2, 2.5)
    )
    wing = f.flesh(f.near_mouth(1.2, -4.0, 9.4), (0.9, 0.9, 1.6))
    above_lip = f.flesh(f.near_mouth(1.1, -5.7, 9.3), (1.2, 1.2, 2))
    above_lip = f.on_left * (1 - f.mesh.below) * above_lip
    root = f.flesh(f.near_eye(0.9, -0.7, 8.9), (0.7, 1.1, 1.5))
    frown = f.above_lids * f.flesh(f.inner_brow, (1.2, 0.9, 3))
    return {
        "cheekPuff": puff,
        "cheekSquintLeft": _moved(raised, 0, 0.5, 0.50) + f.lids_turned(0, 0.22),
        "noseSneerLeft": _moved(f.on_left * wing, 0.08, 0.52, 0.04)
        + _moved(above_lip, 0, 0.40, 0.08)
        + _moved(f.on_left * root, 0, 0.16, 0.18)
        + _moved(frown, -0.08, -0.26, 0.06),
    }


def _jaw(f: _Fields) -> dict[str, np.ndarray]:
    jaw = f.mesh.jaw
    arm = f.points - anatomy.HINGE_AT
    cosine, sine = np.cos(JAW_TURN), np.sin(JAW_TURN)
    swing = np.stack(
        [
            0 * f.x,
            arm[:, 1] * (cosine - 1) - arm[:, 2] * sine,
            arm[:, 1] * sine + arm[:, 2] * (cosine - 1),
        ],
        axis=-1,
    )
    corner = f.both(f.corner, (1.3, 1.6, 3))
    drawn_in = np.stack([-0.30 * np.sign(f.x) * corner, 0 * f.x, 0 * f.x], axis=-1)
    bared = _moved((1 - f.mesh.below) * f.lip(0.6) * f.arch, 0, 0.20, 0)  # the upper teeth
    meeting = np.array([0, 0.42, 0.25])  # where the lips meet, as a share of the jaw's way
    closing = (meeting - jaw[:, None]) * f.lip(1.0)[:, None] * swing
    tip = np.where(f.mesh.part == "tongue", np.clip((f.z - 3.6) / 4.6, 0, 1), 0)  # 0 at the root
    arc = 0.80 * np.sin(2.4 * tip) - 0.90 * tip**3
    tongue = np.stack([-0.15 * tip * f.x, arc, 3.4 * tip], axis=-1)
    side = 2 * f.mesh.below - 1  # -1 above the mouth, 1 below
    parted = f.lip(0.8) * f.arch * np.exp(-((f.x / 1.7) ** 2))
    parted *= np.where(side > 0, -0.80, -0.25) * side
    return {
        "jawOpen": jaw[:, None] * swing + drawn_in + bared,
        "jawForward": _moved(jaw, 0, 0.06, 0.65),
        "jawLeft": _moved(jaw, 1.05, 0, -0.1),
        "mouthClose": closing - drawn_in * f.lip(1.0)[:, None] - bared,
        "tongueOut": tongue + _moved(parted, 0, 1, 0),
    }


def _lips(f: _Fields) -> dict[str, np.ndarray]:
    below, above = f.mesh.below, 1 - f.mesh.below
    left = f.on_left
    outwards = np.clip(f.x / f.corner[0], 0, None) ** 1.3  # 0 on the midline, 1 at the corner
    round_corner = f.flesh(f.corner, (2.0, 1.8, 2.5)) * outwards
    raised = f.flesh(f.corner, (2.0, 1.8, 2.5)) * smoothstep(f.x / f.corner[0], 0.15, 1.15)
    at_corner = f.flesh(f.corner, (1.3, 1.3, 2.0)) * outwards
    under_eye = smoothstep(f.eye[1] - f.y, 1.0, 2.6)
    apple = under_eye * f.flesh(f.near_mouth(3.85, -3.3, 7.8), (1.5, 1.4, 2.5))
    crease = f.flesh(f.near_mouth(2.7, -5.4, 8.4), (1.6, 1.7, 1.5))
    crease *= left * np.exp(-((f.beside_nose / 0.5) ** 2))
    fold = f.flesh(f.near_mouth(2.2, -4.9, 8.7), (1.0, 1.0, 2.0)) * above
    near, around, wide = f.lip(0.45), f.lip(1.3), f.lip(2.0)
    middle = np.exp(-((f.x / 1.7) ** 2))
    # up and down amid each half of a lip
    haunch = 4 * f.arch**2 * (1 - f.arch**2) * (above - below) * f.lip(0.6)
    flat = np.zeros_like(f.x)

    def rolled(lip: np.ndarray) -> np.ndarray:
        close = f.lip(0.35) * lip * np.exp(-((f.x / 2.2) ** 4))
        return np.stack([flat, -0.72 * f.height * close, -0.38 * close], axis=-1)

    lower_centre = _beside(f.mouth, 1.0, -0.5)
    upper_centre = _beside(f.mouth, 1.0, 0.6)
    lower_left = left * below * f.flesh(lower_centre, (1.5, 1.5, 3))
    upper_left = left * above * f.flesh(upper_centre, (1.5, 1.5, 3))
    pressed = left * f.lip(0.5)
    return {
        "mouthSmileLeft": _moved(round_corner, 0.55, 0, -0.60)
        + _moved(raised, 0, 0.72, 0)
        + _moved(left * f.lip(0.8) * (0.06 + 0.06 * above), 0, 1, -0.6)
        + _moved(apple, 0.12, 0.45, 0.46)
        + _moved(crease, 0, 0.10, -0.22)
        + f.lids_turned(0, 0.03),
        "mouthFrownLeft": _moved(round_corner, 0.10, -0.80, -0.15),
        "mouthDimpleLeft": _moved(at_corner, 0.50, 0.12, -0.65),
        "mouthStretchLeft": _moved(round_corner, 0.85, -0.40, -0.55),
        "mouthPressLeft": np.stack(
            [flat, -0.5 * f.height * pressed, -0.22 * pressed * middle], axis=-1
        )
        + _moved(at_corner, 0.12, 0.08, -0.12),
        "mouthLowerDownLeft": _moved(lower_left, 0.1, -0.80, -0.1),
        "mouthUpperUpLeft": _moved(upper_left, 0.05, 0.62, 0.0) + _moved(fold, 0.1, 0.22, 0.14),
        "mouthLeft": _moved(wide, 0.95, 0, 0) + _moved(wide * left, 0, 0, -0.25),
        "mouthRollLower": rolled(below),
        "mouthRollUpper": rolled(above),
        "mouthShrugLower": _moved(
            below * f.flesh(_beside(f.mouth, 0, -1.3), (2.3, 2.2, 3)), 0, 0.50, 0.28
        )
        + _moved(above * near * middle, 0, 0.25, 0.12),
        "mouthShrugUpper": _moved(
            above * f.flesh(_beside(f.mouth, 0, 0.6), (2.0, 1.3, 3)), 0, 0.30, 0.36
        ),
        "mouthFunnel": np.stack(
            [
                -0.32 * f.x * around,
                around * (0.42 * above - 0.62 * below) * f.arch + 0.22 * haunch,
                0.85 * around * middle**0.5,
            ],
            axis=-1,
        ),
        "mouthPucker": np.stack(
            [
                -0.50 * f.x * around,
                0.10 * f.height * near + 0.22 * haunch * np.minimum(np.abs(f.height) / 0.5, 1),
                0.95 * around * middle**0.5,
            ],
            axis=-1,
        ),
    }
