"""A face model: a mesh, named shapes that are added to it, and joints that turn parts of it.

Subject's frame: +X is the subject's left, +Y up, +Z forward out of the face; metres.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mimeline.face.fitting import Unfit, fitted, vertex_numbers

SKIN = (226, 174, 146)  # sRGB, where a model brings no colours
SKIN_GLOSS = 0.07  # of dry skin, where a model brings no gloss


@dataclass(frozen=True, eq=False)
class Joint:
    """A point about which a part of the face turns.

    parent: position of the joint in Face.joints that carries this one, before it; or None.
    centre: (3,) in the neutral face.
    """

    name: str
    parent: int | None
    centre: np.ndarray


@dataclass(frozen=True, eq=False)
class Face:
    """A linear face model with linear blend skinning.

    neutral (V, 3) · triangles (F, 3), counter-clockwise seen from outside · shapes (S, V, 3)
    offsets at 1, named by shape_names (ARKit channels where the model has them) ·
    joints, skin (V, J) weights that sum to 1 · colours (V, 3) uint8 sRGB albedo ·
    identities (I, V, 3) offsets at 1, named by identity_names ·
    correctives (I, S, V, 3): what a unit of an identity adds to a shape ·
    landmarks (68,) vertex numbers in iBUG order (0 the subject's right jaw, 60-67 inner lips) ·
    pose_shapes (9 (J - 1), V, 3): offsets per element of R - 1 of every joint but the first
    (Li et al. 2017, FLAME, equation 3) · regressor (J, V): joint centres from vertices ·
    gloss (V,) from 0 dull to 1 wet; without it, all is as dry skin.

    Raises Unfit where shapes, names or numbers do not fit each other.
    """

    neutral: np.ndarray
    triangles: np.ndarray
    shapes: np.ndarray
    shape_names: Sequence[str]
    joints: Sequence[Joint]
    skin: np.ndarray
    colours: np.ndarray | None = None
    identities: np.ndarray | None = None
    identity_names: Sequence[str] = ()
    correctives: np.ndarray | None = None
    landmarks: np.ndarray | None = None
    pose_shapes: np.ndarray | None = None
    regressor: np.ndarray | None = None
    gloss: np.ndarray | None = None
    _centre_shapes: np.ndarray | None = field(init=False, repr=False, default=None)

    def __post_init__(self):
        def put(name, value):
            object.__setattr__(self, name, value)

        def fit(name, *shape):
            put(name, fitted(name, getattr(self, name), np.float32, shape))

        for name in ("shape_names", "identity_names", "joints"):
            put(name, tuple(getattr(self, name)))
        _refuse_twice("shape", self.shape_names)
        _refuse_twice("identity", self.identity_names)
        _refuse_twice("joint", self.joint_names)
        S, J, n_identities = len(self.shape_names), len(self.joints), len(self.identity_names)
        fit("neutral", None, 3)
        V = len(self.neutral)
        if not V:
            raise Unfit("array neutral", "no vertices", "some")
        put("triangles", vertex_numbers("triangles", self.triangles, np.int32, (None, 3), V))
        fit("shapes", S, V, 3)
        fit("skin", V, J)
        if not np.allclose(self.skin.sum(1), 1, atol=1e-3):
            raise Unfit("array skin", "weights that do not sum to 1", "1 for every vertex")
        colours = np.tile(np.uint8(SKIN), (V, 1)) if self.colours is None else self.colours
        put("colours", fitted("colours", colours, np.uint8, (V, 3)))
        if self.gloss is None:
            put("gloss", np.full(V, SKIN_GLOSS))
        fit("gloss", V)
        if self.gloss.min() < 0 or self.gloss.max() > 1:
            found = f"numbers from {self.gloss.min():g} to {self.gloss.max():g}"
            raise Unfit("array gloss", found, "0 dull to 1 wet")
        if self.identities is None and not n_identities:
            put("identities", np.zeros((0, V, 3), np.float32))
        fit("identities", n_identities, V, 3)
        if self.correctives is not None:
            fit("correctives", n_identities, S, V, 3)
        if self.landmarks is not None:
            put("landmarks", vertex_numbers("landmarks", self.landmarks, np.int64, (68,), V))
        if self.pose_shapes is not None:
            fit("pose_shapes", 9 * (J - 1), V, 3)
        if self.regressor is not None:
            fit("regressor", J, V)
            centres = np.einsum("jv,svx->sjx", self.regressor, self.shapes)  # (S, J, 3)
            put("_centre_shapes", centres)
        put("joints", tuple(_placed(joint, number) for number, joint in enumerate(self.joints)))

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    def of(self, identity: Mapping[str, float]) -> "Face":
        """The face of a person: neutral, shapes and joints with the identity folded in.

        identity: identity name → coefficient; absent names count 0. The result has no identities.
        Raises ValueError for a name that the model does not have.
        """
        _refuse_unknown("identity", identity, self.identity_names)
        weights = np.array([identity.get(name, 0) for name in self.identity_names], np.float32)
        offset = np.tensordot(weights, self.identities, 1)  # (V, 3)
        shapes = self.shapes
        if self.correctives is not None:
            shapes = shapes + np.tensordot(weights, self.correctives, 1)  # (S, V, 3)
        if self.regressor is not None:
            moves = self.regressor @ offset  # (J, 3)
        else:
            held = self.skin.sum(0)[:, None]  # (J, 1)
            moves = (self.skin.T @ offset) / np.maximum(held, 1e-6)  # (J, 3)
        joints = [
            replace(joint, centre=joint.centre + move)
            for joint, move in zip(self.joints, moves, strict=True)
        ]
        return replace(
            self,
            neutral=self.neutral + offset,
            shapes=shapes,
            joints=joints,
            identities=None,
            identity_names=(),
            correctives=None,
        )

    def vertices(
        self, coefficients: np.ndarray, rotations: Mapping[str, np.ndarray] | None = None
    ) -> np.ndarray:
        """Vertices of a sequence: shapes added, then turned about the joints.

        coefficients (n, S) in the order of shape_names · rotations: joint name → (n, 3, 3), on
        top of the parent's; absent joints rest.
        Returns (n, V, 3) float32, metres.
        Raises ValueError for other array shapes and for joints that the face does not have.
        """
        coefficients = np.ascontiguousarray(coefficients, np.float32)
        if coefficients.ndim != 2 or coefficients.shape[1] != len(self.shape_names):
            raise ValueError(
                f"coefficients have shape {coefficients.shape}, "
                f"expected (frames, {len(self.shape_names)})"
            )
        n, rotations = len(coefficients), dict(rotations or {})
        _refuse_unknown("joint", rotations, self.joint_names)
        for name, rotation in rotations.items():
            if np.shape(rotation) != (n, 3, 3):
                shape = np.shape(rotation)
                raise ValueError(f"rotations of {name} have shape {shape}, expected ({n}, 3, 3)")
        shapes = self.shapes.reshape(len(self.shapes), self.neutral.size)
        posed = (coefficients @ shapes).reshape(n, *self.neutral.shape)  # (n, V, 3)
        posed += self.neutral
        if not rotations:
            return posed
        turns = np.broadcast_to(np.eye(3, dtype=np.float32), (len(self.joints), n, 3, 3)).copy()
        for name, rotation in rotations.items():
            turns[self.joint_names.index(name)] = rotation
        if self.pose_shapes is not None:
            features = (turns[1:] - np.eye(3, dtype=np.float32)).transpose(1, 0, 2, 3)
            flat = self.pose_shapes.reshape(len(self.pose_shapes), self.neutral.size)
            posed += (features.reshape(n, -1) @ flat).reshape(posed.shape)
        return self._skinned(posed, turns, self._centres(coefficients))

    def landmarks_at(self, vertices: np.ndarray) -> np.ndarray:
        """The 68 landmarks (n, 68, 3) of vertices (n, V, 3).

        Raises ValueError where the model names no landmarks.
        """
        if self.landmarks is None:
            raise ValueError("this face model names no landmarks")
        return vertices[..., self.landmarks, :]

    def _centres(self, coefficients: np.ndarray) -> np.ndarray:
        """Joint centres (n or 1, J, 3); a regressor lets them follow the shapes."""
        centres = np.array([joint.centre for joint in self.joints], np.float32)[None]  # (1, J, 3)
        if self._centre_shapes is None:
            return centres
        return centres + np.tensordot(coefficients, self._centre_shapes, 1)  # (n, J, 3)

    def _skinned(self, posed: np.ndarray, turns: np.ndarray, centres: np.ndarray) -> np.ndarray:
        """Linear blend skinning: posed (n, V, 3) · turns (J, n, 3, 3) · centres (n or 1, J, 3)."""
        linear, shift = [], []
        out = np.zeros_like(posed)
        for number, joint in enumerate(self.joints):
            centre = centres[:, number]  # (n or 1, 3)
            own = centre - np.einsum(
                "nij,nj->ni", turns[number], np.broadcast_to(centre, (len(posed), 3))
            )  # (n, 3)
            if joint.parent is None:
                linear.append(turns[number])
                shift.append(own)
            else:
                up = linear[joint.parent]
                linear.append(up @ turns[number])
                shift.append(np.einsum("nij,nj->ni", up, own) + shift[joint.parent])
            held = np.flatnonzero(self.skin[:, number])
            turned = posed[:, held] @ linear[-1].transpose(0, 2, 1) + shift[-1][:, None]
            out[:, held] += self.skin[held, number, None] * turned
        return out


def _refuse_twice(what: str, names: Sequence[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise Unfit(f"{what} names", f"{', '.join(twice)} twice", "every name once")


def _placed(joint: Joint, number: int) -> Joint:
    """The numbered joint with its centre as float32. Raises Unfit where its parent comes later."""
    if joint.parent is not None and not 0 <= joint.parent < number:
        found = f"parent {joint.parent} of joint {number}"
        raise Unfit(f"joint {joint.name}", found, "a joint before it")
    centre = fitted(f"centre of joint {joint.name}", joint.centre, np.float32, (3,))
    return replace(joint, centre=centre)


def _refuse_unknown(what: str, names: Mapping, known: Sequence[str]) -> None:
    unknown = sorted(set(names) - set(known))
    if unknown:
        listed = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
        raise ValueError(f"no {what} {', '.join(unknown)}; this face has {listed or 'none'}")
