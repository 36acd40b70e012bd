"""ICT-FaceKit Light (Li et al. 2020): its folder of OBJ files, or the same packed in an npz.

Centimetres; +X is the subject's left, +Y up, +Z out of the face; vertex ranges as its README lists
them. Its shapes move no eyeball (PupilDilate aside), so the eyes turn by joints alone. What lies
over the eyes to be shaded as a fluid, and the lashes, are left undrawn.
"""

from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from mimeline.errors import BadFile
from mimeline.face.falloff import smoothstep
from mimeline.face.fitting import fitted, names_of, vertex_numbers
from mimeline.face.formats import eyes
from mimeline.face.formats.obj import IDENTITY, read_offsets, read_triangles, read_vertices, stacked
from mimeline.face.formats.shapes import metres_per_unit, named
from mimeline.face.model import SKIN_GLOSS, Face, Joint

NEUTRAL = "generic_neutral_mesh.obj"
PACKED = ("neutral", "expr_names", "expr_delta", "ident_names", "ident_delta_face", "quads")
METRES = 0.01
N_VERTICES, N_FACE, N_DRAWN = 26719, 9409, 24591
MOUTH, SOCKETS, GUMS, TEETH = (
    slice(11248, 13294),
    slice(13294, 14062),
    slice(14062, 17039),
    slice(17039, 21451),
)
BALLS = {"left_eye": slice(21451, 23021), "right_eye": slice(23021, 24591)}
IRISES = {"left_eye": slice(22221, 23021), "right_eye": slice(23791, 24591)}  # behind the cornea
LANDMARKS = (
    *(1225, 1888, 1052, 367, 1719, 1722, 2199, 1447, 966, 3661, 4390, 3927, 3924, 2608, 3272),
    *(4088, 3443, 268, 493, 1914, 2044, 1401, 3615, 4240, 4114, 2734, 2509, 978, 4527, 4942),
    *(4857, 1140, 2075, 1147, 4269, 3360, 1507, 1542, 1537, 1528, 1518, 1511, 3742, 3751, 3756),
    *(3721, 3725, 3732, 5708, 5695, 2081, 0, 4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841),
    *(5702, 5711, 5533, 6216, 6207, 6470, 5517, 5966),
)
SKIN, LIPS, BROW, SOCKET = (222, 172, 146), (190, 118, 108), (112, 80, 62), (196, 132, 116)
CAVITY, GUM, TOOTH = (70, 28, 28), (150, 72, 70), (214, 206, 192)
BROWS = ((17, 22), (22, 27))  # landmarks
BROW_HALF_WIDTH, SOFT = 0.0042, 0.0022  # metres
MOUTH_DEPTHS = (0.055, 0.11)  # metres of z: the throat is dark, the front teeth are lit
CORNEA = 0.0005  # metres: the tip of an eyeball, evenly round its axis
HEAD_PIVOT = np.float32([0, -0.05, 0.0])  # metres: the top of the neck
NECK = (-0.14, -0.05)  # metres along the neck: still below, with the head above
NECK_LEAN = 0.6  # how far the neck's border rises per metre towards the back
FOLLOWED, FOLLOWED_SOFT = 32, 0.3  # vertices of the face; centimetres
REMEDY = "Fetch FaceXModel of ICT-FaceKit again, whole."


def from_folder(folder: Path) -> Face:
    """The face of ICT-FaceKit's folder FaceXModel.

    Raises BadFile where a file is missing, broken, or not of this model.
    """
    neutral, _ = read_vertices(folder / NEUTRAL)
    if len(neutral) != N_VERTICES:
        found, expected = f"{len(neutral)} vertices", str(N_VERTICES)
        raise BadFile(folder / NEUTRAL, found=found, expected=expected, remedy=REMEDY)
    _refuse_other_unit(folder / NEUTRAL, neutral)
    triangles = read_triangles(folder / NEUTRAL, len(neutral))
    offsets = read_offsets(folder, NEUTRAL, neutral)
    people = [name for name in offsets if name.startswith(IDENTITY)]
    names = [name for name in offsets if not name.startswith(IDENTITY)]
    identities = stacked(offsets, people, neutral)
    shapes = stacked(offsets, names, neutral)
    return _assembled(folder, neutral, triangles, shapes, names, identities, people)


def from_arrays(path: Path, arrays: dict[str, np.ndarray]) -> Face:
    """The face of a packed ICT-FaceKit.

    Arrays: neutral (V, 3), quads (Q, 4), expr_names, expr_delta (S, V, 3), ident_names,
    ident_delta_face (I, 9409, 3): identities of the face alone; the rest of the head follows it.
    Raises BadFile where an array is missing and for another size, Unfit where an array is not of
    this model.
    """
    missing = [name for name in PACKED if name not in arrays]
    if missing:
        found, expected = f"no array {', '.join(missing)}", f"arrays {', '.join(PACKED)}"
        raise BadFile(path, found=found, expected=expected, remedy=REMEDY)
    neutral = fitted("neutral", arrays["neutral"], np.float32, (N_VERTICES, 3))
    _refuse_other_unit(path, neutral)
    quads = vertex_numbers("quads", arrays["quads"], np.int32, (None, 4), N_VERTICES)
    shapes = fitted("expr_delta", arrays["expr_delta"], np.float32, (None, N_VERTICES, 3))
    names = names_of("expr_names", arrays["expr_names"], len(shapes))
    offsets = fitted("ident_delta_face", arrays["ident_delta_face"], np.float32, (None, N_FACE, 3))
    people = names_of("ident_names", arrays["ident_names"], len(offsets))
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    triangles = np.concatenate([triangles, _left_out(triangles, neutral)])
    identities = _following(neutral, offsets)
    return _assembled(path, neutral, triangles, shapes, names, identities, people)


def _refuse_other_unit(path: Path, neutral: np.ndarray) -> None:
    """Raises BadFile where vertices (V, 3) are no head in centimetres."""
    if metres_per_unit(path, neutral) != METRES:
        found = f"a neutral face {np.ptp(neutral[:, 1]):.3g} high along y"
        raise BadFile(path, found=found, expected="a head in centimetres", remedy=REMEDY)


def _assembled(path, neutral, triangles, shapes, names, identities, people) -> Face:
    """The Face of ICT's arrays, in centimetres."""
    neutral = np.float32(neutral * METRES)
    hidden = np.zeros(N_VERTICES, bool)
    hidden[N_DRAWN:] = True
    for iris in IRISES.values():
        hidden[iris] = True
    joints, skin = _joints(neutral)
    return named(
        path,
        neutral=neutral,
        triangles=triangles[~hidden[triangles].any(1)],
        shapes=shapes * METRES,
        shape_names=names,
        joints=joints,
        skin=skin,
        colours=_colours(neutral),
        gloss=np.where(np.arange(N_VERTICES) >= BALLS["left_eye"].start, 1.0, SKIN_GLOSS),
        identities=identities * METRES,
        identity_names=people,
        landmarks=np.array(LANDMARKS),
    )


def _joints(neutral: np.ndarray) -> tuple[list[Joint], np.ndarray]:
    """A still neck, a head that carries the eyes, and their weights (V, 4)."""
    along = neutral[:, 1] + NECK_LEAN * neutral[:, 2]  # (V,)
    held = smoothstep(along, *NECK)
    skin = np.zeros((len(neutral), 4), np.float32)
    skin[:, 0], skin[:, 1] = 1 - held, held
    joints = [Joint("neck", None, neutral.min(0) * [0, 1, 0]), Joint("head", 0, HEAD_PIVOT)]
    for number, (name, ball) in enumerate(BALLS.items(), start=2):
        skin[ball] = np.eye(4)[number]
        joints.append(Joint(name, 1, eyes.centre_of(neutral[ball])))
    return joints, skin


def _colours(neutral: np.ndarray) -> np.ndarray:
    tint = np.tile(np.float32(SKIN), (N_VERTICES, 1))
    front = neutral[:N_FACE]
    for first, last in BROWS:
        off = _distance(front, neutral[list(LANDMARKS[first:last])])  # (9409,)
        _blend(tint[:N_FACE], BROW, (BROW_HALF_WIDTH - off) / SOFT)
    rim = neutral[[*LANDMARKS[48:60], LANDMARKS[48]]]
    off = _distance(front, rim) * np.where(_inside(front, rim), 1, -1)
    _blend(tint[:N_FACE], LIPS, off / SOFT + 0.5)
    depth = np.clip((neutral[:, 2] - MOUTH_DEPTHS[0]) / np.ptp(MOUTH_DEPTHS), 0.12, 1)[:, None]
    for part, colour in ((MOUTH, CAVITY), (GUMS, GUM), (TEETH, TOOTH)):
        tint[part] = colour * depth[part]
    tint[SOCKETS] = SOCKET
    colours = np.rint(tint).astype(np.uint8)
    for ball in BALLS.values():
        centre = eyes.centre_of(neutral[ball])
        tip = neutral[ball][neutral[ball][:, 2] > neutral[ball][:, 2].max() - CORNEA]
        gaze = tip.mean(0) - centre
        eyes.paint(colours, neutral, np.arange(ball.start, ball.stop), gaze / np.linalg.norm(gaze))
    return colours


def _blend(tint: np.ndarray, colour: tuple[int, int, int], share: np.ndarray) -> None:
    """Move tint (n, 3) towards a colour in place, by share (n,) cut to 0-1."""
    tint += np.clip(share, 0, 1)[:, None] * (np.float32(colour) - tint)


def _distance(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distance (n,) seen from the front of points (n, 3) to a line of straight pieces (m, 3)."""
    start, along = line[:-1, :2], np.diff(line[:, :2], axis=0)  # (m - 1, 2)
    away = points[:, None, :2] - start  # (n, m - 1, 2)
    length2 = np.maximum((along**2).sum(1), np.finfo(np.float32).tiny)  # a piece may be a point
    share = np.clip((away * along).sum(2) / length2, 0, 1)[..., None]
    return np.linalg.norm(away - share * along, axis=2).min(1)


def _inside(points: np.ndarray, rim: np.ndarray) -> np.ndarray:
    """Which points (n, 3) a closed line (m, 3) encloses, seen from the front: (n,) bool."""
    x, y = points[:, 0, None], points[:, 1, None]
    (ax, ay), (bx, by) = rim[:-1, :2].T, rim[1:, :2].T  # (m - 1,) each
    crossed = (ay > y) != (by > y)
    right = x < ax + (y - ay) * (bx - ax) / np.where(by == ay, 1, by - ay)
    return (crossed & right).sum(1) % 2 == 1


def _left_out(triangles: np.ndarray, neutral: np.ndarray) -> np.ndarray:
    """The triangles (n, 3) of the model that a list of its quads has not.

    They close three-edged holes, or fan round the poles of an eyeball, which no quad reaches.
    """
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    there = set(map(tuple, edges.tolist()))
    open_edges = {(b, a) for a, b in there if (b, a) not in there}  # as the lost triangle ran
    following: dict[int, list[int]] = {}
    for a, b in open_edges:
        following.setdefault(a, []).append(b)
    lost = {
        (a, b, c)
        for a, b in open_edges
        for c in following.get(b, ())
        if (c, a) in open_edges and a < min(b, c)
    }
    for ball in BALLS.values():
        poles = np.setdiff1d(np.arange(ball.start, ball.stop), triangles)
        for a, b in sorted(edge for edge in open_edges if ball.start <= edge[0] < ball.stop):
            if len(poles):
                off = np.linalg.norm(neutral[poles] - neutral[a], axis=1)
                lost.add((a, b, int(poles[off.argmin()])))
    return np.array(sorted(lost), np.int32).reshape(-1, 3)


def _following(neutral: np.ndarray, face_offsets: np.ndarray) -> np.ndarray:
    """Offsets (I, V, 3) of the whole head from those of the face (I, 9409, 3).

    A vertex outside of the face moves with the nearest of the face, weighted by 1 / distance^2;
    an eyeball as one, so that it stays round.
    """
    distance, nearest = cKDTree(neutral[:N_FACE]).query(neutral[N_FACE:], k=FOLLOWED)
    weights = 1 / (distance**2 + FOLLOWED_SOFT**2)
    weights /= weights.sum(1, keepdims=True)
    rows = np.repeat(np.arange(len(distance)), FOLLOWED)
    shape = len(distance), N_FACE
    follow = csr_array((weights.ravel(), (rows, nearest.ravel())), shape)  # (V - 9409, 9409)
    flat = face_offsets.transpose(1, 0, 2).reshape(N_FACE, -1)  # (9409, 3 I)
    rest = (follow @ flat).reshape(-1, *face_offsets[:, 0].shape)  # (V - 9409, I, 3)
    offsets = np.concatenate([face_offsets, rest.transpose(1, 0, 2)], axis=1)  # (I, V, 3)
    for ball in BALLS.values():
        offsets[:, ball] = offsets[:, ball].mean(1, keepdims=True)
    return offsets
