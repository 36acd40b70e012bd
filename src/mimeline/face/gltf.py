"""A face that moves, as glTF 2.0: morph targets by name, joints that turn, and their key times.

glTF's frame is the subject's: +X the subject's left, +Y up, +Z forward; metres. A file is read for
its motion alone: any that has morph targets with channel names, whoever wrote it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from mimeline import __version__
from mimeline.face import glb
from mimeline.face.model import Face
from mimeline.face.motion import Pose, driver
from mimeline.face.raster import vertex_normals
from mimeline.face.render import LINEAR
from mimeline.vocabulary import canonical

JOINTS = {"head": "head", "left_eye": "leftEye", "right_eye": "rightEye"}  # ours → the node's name
NODES = {"head": "head", "lefteye": "left_eye", "eyeleft": "left_eye"}  # and back, letters alone
NODES |= {"righteye": "right_eye", "eyeright": "right_eye"}
INFLUENCES = 4  # of joints on a vertex, at most, that every reader takes
WET = 0.5  # gloss from which a surface is drawn wet
OURS = "mimeline"  # what is ours among the extras
DRY_ROUGHNESS, WET_ROUGHNESS = 0.65, 0.12


@dataclass(frozen=True, eq=False)
class Performance:
    """What a file's face does. times (n,): seconds of its keys, rising.

    weights: morph target → (n,). turns: head, left_eye or right_eye → (n, 3, 3), in the joint that
    carries it. extras: what its writer left under `mimeline` in the asset's extras, unchecked.
    """

    times: np.ndarray
    weights: Mapping[str, np.ndarray]
    turns: Mapping[str, np.ndarray]
    extras: Mapping[str, Any]


def write(
    path: Path, face: Face, posed: Pose, times: np.ndarray, extras: Mapping[str, Any]
) -> tuple[str, ...]:
    """Write what a face does, posed in n frames, with a key for each of times (n,), seconds.

    There is a morph target for each channel that moves the face, named by it: shapes that halve a
    channel are one target. Other shapes of the face keep their names and rest at 0. extras: plain
    values, kept under `mimeline` in the asset's extras.
    Returns what glTF cannot say of this face.
    """
    names, offsets, weights = _targets(face, posed.coefficients)
    arrays = glb.Arrays()
    mesh = _mesh(face, names, offsets, arrays)
    joints = [
        {"name": JOINTS.get(joint.name, joint.name), "translation": offset.tolist()}
        for joint, offset in zip(face.joints, _from_parent(face), strict=True)
    ]
    for number, joint in enumerate(face.joints):
        if joint.parent is not None:
            joints[joint.parent].setdefault("children", []).append(number + 1)
    centres = np.stack([joint.centre for joint in face.joints])  # (J, 3)
    bind = np.tile(np.eye(4, dtype=np.float32), (len(centres), 1, 1))
    bind[:, :3, 3] = -centres
    skin = {
        "joints": [number + 1 for number in range(len(joints))],
        "inverseBindMatrices": arrays.add(bind),
    }
    turns = {"head": posed.head, "left_eye": posed.left_eye, "right_eye": posed.right_eye}
    turns = {name: turn for name, turn in turns.items() if name in face.joint_names}
    nodes = {name: face.joint_names.index(name) + 1 for name in turns}
    animation = _animation(times, weights, turns, nodes, arrays)
    roots = [number + 1 for number, joint in enumerate(face.joints) if joint.parent is None]
    document = {
        "asset": {"version": "2.0", "generator": f"mimeline {__version__}"}
        | ({"extras": {OURS: dict(extras)}} if extras else {}),
        "scene": 0,
        "scenes": [{"name": "face", "nodes": [0, *roots]}],
        "nodes": [{"name": "face", "mesh": 0, "skin": 0}, *joints],
        "skins": [skin],
        "meshes": [mesh],
        "materials": [
            _material("skin", DRY_ROUGHNESS),
            _material("wet", WET_ROUGHNESS),
        ],
        "animations": [animation],
    }
    glb.write(path, document, arrays)
    return unsaid(face)


def read(path: Path) -> Performance:
    """What the face of a file does: of its first animation with morph targets.

    Targets are named by `targetNames` in the mesh's extras; joints by the names that nodes have:
    head, leftEye, rightEye, in any case and with - or _. Keys of other times, or a joint's, are
    brought to the morph targets' key times, halfway by halfway.
    Raises BadFile where the file is damaged, or has no animated morph targets with names.
    """
    file = glb.Glb(path)
    try:
        return _performance(file)
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise file.bad(f"a document that does not hold together ({error!r})", "glTF 2.0") from error


def _targets(face: Face, coefficients: np.ndarray) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names, offsets (T, V, 3) and weights (n, T): one of each for what a channel drives."""
    sources: dict[str, list[int]] = {}
    for number, shape in enumerate(face.shape_names):
        sources.setdefault(driver(shape) or shape, []).append(number)
    offsets = np.stack([face.shapes[own].sum(axis=0) for own in sources.values()])  # (T, V, 3)
    weights = coefficients[:, [own[0] for own in sources.values()]]  # halves are driven alike
    return list(sources), offsets, np.asarray(weights, np.float32)


def _mesh(
    face: Face, names: Sequence[str], offsets: np.ndarray, arrays: glb.Arrays
) -> dict[str, Any]:
    normals = _normals(face, face.neutral)
    joints, weights = _influences(face.skin)
    attributes = {
        "POSITION": arrays.add(face.neutral, glb.VERTEX_DATA, bounds=True),
        "NORMAL": arrays.add(normals, glb.VERTEX_DATA),
        "COLOR_0": arrays.add(LINEAR[face.colours], glb.VERTEX_DATA),
        "JOINTS_0": arrays.add(joints, glb.VERTEX_DATA),
        "WEIGHTS_0": arrays.add(weights, glb.VERTEX_DATA),
    }
    targets = [
        {
            "POSITION": arrays.add_offsets(offset),
            "NORMAL": arrays.add_offsets(_normals(face, face.neutral + offset) - normals),
        }
        for offset in offsets
    ]
    wet = (face.gloss[face.triangles] >= WET).all(axis=1)  # (F,)
    triangles = [(0, face.triangles[~wet]), (1, face.triangles[wet])]
    primitives = [
        {
            "attributes": attributes,
            "indices": arrays.add(np.uint32(own.reshape(-1)), glb.INDICES),
            "material": material,
            "targets": targets,
        }
        for material, own in triangles
        if len(own)
    ]
    return {
        "name": "face",
        "primitives": primitives,
        "weights": [0.0] * len(names),
        "extras": {"targetNames": list(names)},
    }


def _normals(face: Face, vertices: np.ndarray) -> np.ndarray:
    """Unit normals (V, 3); of a vertex without a surface, any."""
    normals = vertex_normals(np.float32(vertices), face.triangles)
    normals[~normals.any(axis=1)] = (0, 0, 1)
    return normals


def _influences(skin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The joints (V, 4) uint16 that hold each vertex most, and their weights, which sum to 1."""
    held = np.pad(skin, ((0, 0), (0, max(0, INFLUENCES - skin.shape[1]))))
    strongest = np.argsort(-held, axis=1, kind="stable")[:, :INFLUENCES]
    weights = np.take_along_axis(held, strongest, axis=1)
    weights = weights / weights.sum(axis=1, keepdims=True)
    return np.where(weights > 0, strongest, 0).astype(np.uint16), weights.astype(np.float32)


def _from_parent(face: Face) -> list[np.ndarray]:
    return [
        joint.centre - (0 if joint.parent is None else face.joints[joint.parent].centre)
        for joint in face.joints
    ]


def _animation(
    times: np.ndarray,
    weights: np.ndarray,
    turns: Mapping[str, np.ndarray],
    nodes: Mapping[str, int],
    arrays: glb.Arrays,
) -> dict[str, Any]:
    keys = arrays.add(np.float32(times), bounds=True)
    outputs = [("weights", 0, weights.reshape(-1))]
    outputs += [("rotation", nodes[name], _quaternions(turn)) for name, turn in turns.items()]
    return {
        "name": "motion",
        "samplers": [
            {"input": keys, "interpolation": "LINEAR", "output": arrays.add(values)}
            for _, _, values in outputs
        ],
        "channels": [
            {"sampler": number, "target": {"node": node, "path": path}}
            for number, (path, node, _) in enumerate(outputs)
        ],
    }


def _quaternions(turns: np.ndarray) -> np.ndarray:
    """Unit quaternions x, y, z, w (n, 4) float32 of turns (n, 3, 3), near their predecessors."""
    found = Rotation.from_matrix(turns).as_quat(canonical=True)
    along = np.einsum("ni,ni->n", found[1:], found[:-1])
    found[1:] *= np.cumprod(np.where(along < 0, -1, 1))[:, None]
    return found.astype(np.float32)


def _material(name: str, roughness: float) -> dict[str, Any]:
    looks = {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": roughness}
    return {"name": name, "pbrMetallicRoughness": looks}


def unsaid(face: Face) -> tuple[str, ...]:
    """What glTF cannot say of a face: it adds shapes and turns joints, and no more."""
    lost = []
    if face.pose_shapes is not None:
        lost.append("what turning does to the skin (pose shapes)")
    if face.regressor is not None:
        lost.append("joints that follow the shapes")
    if (np.sort(face.skin, axis=1)[:, :-INFLUENCES] > 0).any():
        lost.append(f"more than {INFLUENCES} joints on a vertex")
    return tuple(lost)


def _performance(file: glb.Glb) -> Performance:
    document = file.document
    found = [
        (names, animation, channel)
        for animation in document.get("animations", [])
        for channel in animation["channels"]
        if channel["target"].get("path") == "weights"
        and (names := _target_names(document, channel["target"]["node"]))
    ]
    if not found:
        raise file.bad("no animated morph target that has a channel's name", "jawOpen and the like")
    found.sort(key=lambda own: -sum(canonical(name) is not None for name in own[0]))  # stable
    main = found[0][1]
    times, _ = _keys(file, main, found[0][2])
    weights: dict[str, np.ndarray] = {}
    for names, animation, channel in found:  # a face may be of several meshes
        if animation is not main:
            continue
        own_times, values = _keys(file, animation, channel)
        values = values.reshape(len(own_times), len(names))
        for name, column in zip(names, values.T, strict=True):
            weights.setdefault(name, np.interp(times, own_times, column))
    turns = _turns(file, main, times)
    extras = document["asset"].get("extras", {})
    own = extras.get(OURS, {}) if isinstance(extras, dict) else {}
    return Performance(times, weights, turns, own if isinstance(own, dict) else {})


def _target_names(document: Mapping[str, Any], node: int) -> list[str]:
    """What the morph targets of a node's mesh are called; none where no name is a channel's."""
    mesh = document["meshes"][document["nodes"][node]["mesh"]]
    extras = mesh.get("extras", {})
    names = extras.get("targetNames", []) if isinstance(extras, dict) else []
    known = isinstance(names, list) and any(isinstance(n, str) and canonical(n) for n in names)
    return [str(name) for name in names] if known else []


def _turns(file: glb.Glb, animation: Mapping[str, Any], times: np.ndarray) -> dict[str, np.ndarray]:
    """Turns (n, 3, 3) from rest at times, in the file's frame, of the nodes that are known."""
    nodes = file.document["nodes"]
    parents = {child: n for n, node in enumerate(nodes) for child in node.get("children", [])}
    turns: dict[str, np.ndarray] = {}
    for channel in animation["channels"]:
        number = channel["target"].get("node")
        if channel["target"].get("path") != "rotation" or number is None:
            continue
        letters = "".join(filter(str.isalnum, str(nodes[number].get("name", "")))).casefold()
        if (joint := NODES.get(letters)) is None or joint in turns:
            continue
        own_times, values = _keys(file, animation, channel)
        rotations = Rotation.from_quat(values.reshape(len(own_times), 4))
        if len(own_times) > 1:
            inside = np.clip(times, own_times[0], own_times[-1])
            rotations = Slerp(own_times, rotations)(inside)
        above, carrier = Rotation.identity(), parents.get(number)
        for _ in range(len(nodes)):
            if carrier is None:
                break
            above, carrier = _rest(nodes[carrier]) * above, parents.get(carrier)
        turned = above * rotations * _rest(nodes[number]).inv() * above.inv()
        turns[joint] = np.broadcast_to(turned.as_matrix(), (len(times), 3, 3))
    return turns


def _rest(node: Mapping[str, Any]) -> Rotation:
    if "matrix" in node:
        return Rotation.from_matrix(np.reshape(node["matrix"], (4, 4)).T[:3, :3])
    return Rotation.from_quat(node.get("rotation", (0, 0, 0, 1)))


def _keys(
    file: glb.Glb, animation: Mapping[str, Any], channel: Mapping[str, Any]
) -> tuple[np.ndarray, np.ndarray]:
    """Key times (k,) and the values at them, flat; the slopes of a spline are left out."""
    sampler = animation["samplers"][channel["sampler"]]
    times = file.values(sampler["input"]).astype(np.float64)
    values = file.values(sampler["output"]).astype(np.float64)
    if not len(times) or not (np.diff(times) > 0).all() or not np.isfinite(times).all():
        raise ValueError("key times that do not rise")
    if sampler.get("interpolation") == "CUBICSPLINE":
        values = values.reshape(len(times), 3, -1)[:, 1]
    if not np.isfinite(values).all():
        raise ValueError("a key that is no finite number")
    return times, values.reshape(-1)
