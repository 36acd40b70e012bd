"""A moving face as glTF: what we write, what other libraries read of it, what we read of theirs."""

import json

import numpy as np
import pandas as pd
import pygltflib
import pytest

from mimeline.errors import BadFile
from mimeline.face import glb, gltf
from mimeline.face.embedded import embedded_face
from mimeline.face.model import Face
from mimeline.face.motion import perform, pose
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, GAZE, HEAD

FRAMES = 12
TIMES = np.arange(FRAMES) * 1001 / 30_000


@pytest.fixture(scope="module")
def face() -> Face:
    return embedded_face()


@pytest.fixture(scope="module")
def motion() -> pd.DataFrame:
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(0, 1, FRAMES) for name in EXPRESSIONS}
    values |= {name: rng.uniform(-0.5, 0.5, FRAMES) for name in (*HEAD, *GAZE)}
    return pd.DataFrame(values)


@pytest.fixture(scope="module")
def written(face, motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("gltf") / "face.glb"
    assert gltf.write(path, face, pose(face, motion), TIMES, {"made": {"by": "us"}}) == ()
    return path


def accessor(file: pygltflib.GLTF2, number: int) -> np.ndarray:
    """An accessor's array as the other library has it; its sparse part by hand."""
    own, blob = file.accessors[number], file.binary_blob()
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[own.type]
    dtypes = {5126: "<f4", 5123: "<u2", 5125: "<u4"}

    def view(index, dtype, count, columns):
        start = file.bufferViews[index].byteOffset
        found = np.frombuffer(blob, dtype, count * columns, start)
        return found.reshape(count, columns) if columns > 1 else found

    if own.sparse is None:
        return view(own.bufferView, dtypes[own.componentType], own.count, width)
    found = np.zeros((own.count, width), "<f4")
    sparse = own.sparse
    kind = dtypes[sparse.indices.componentType]
    at = view(sparse.indices.bufferView, kind, sparse.count, 1)
    found[at] = view(sparse.values.bufferView, "<f4", sparse.count, width)
    return found


def test_another_library_reads_the_same_names_and_key_times(written, motion):
    file = pygltflib.GLTF2().load(str(written))
    names = file.meshes[0].extras["targetNames"]
    assert sorted(names) == sorted(EXPRESSIONS)
    assert len(file.meshes[0].primitives[0].targets) == len(names) == len(file.meshes[0].weights)
    (animation,) = file.animations
    for sampler in animation.samplers:
        np.testing.assert_array_equal(accessor(file, sampler.input), TIMES.astype(np.float32))
    paths = {
        channel.target.path: animation.samplers[channel.sampler] for channel in animation.channels
    }
    weights = accessor(file, paths["weights"].output).reshape(FRAMES, len(names))
    np.testing.assert_array_equal(weights, motion[names].to_numpy(np.float32))
    turned = {
        file.nodes[c.target.node].name for c in animation.channels if c.target.path == "rotation"
    }
    assert turned == {"head", "leftEye", "rightEye"}


def test_another_library_s_arrays_give_the_face_that_we_draw(written, face, motion):
    """Morph targets, then skin, as glTF 2.0 has it (3.7.2.2, 3.7.3.3)."""
    file = pygltflib.GLTF2().load(str(written))
    (mesh,), primitive = file.meshes, file.meshes[0].primitives[0]
    vertices = accessor(file, primitive.attributes.POSITION).astype(np.float64)
    weights = motion[mesh.extras["targetNames"]].to_numpy()
    targets = np.stack([accessor(file, target["POSITION"]) for target in primitive.targets])
    joints = accessor(file, primitive.attributes.JOINTS_0).reshape(-1, 4)
    shares = accessor(file, primitive.attributes.WEIGHTS_0)
    (skin,), (animation,) = file.skins, file.animations
    inverse = accessor(file, skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
    for frame in (0, FRAMES - 1):
        turns = {
            channel.target.node: accessor(file, animation.samplers[channel.sampler].output)[frame]
            for channel in animation.channels
            if channel.target.path == "rotation"
        }
        matrices = np.stack([world(file, node, turns) for node in skin.joints]) @ inverse
        moved = vertices + np.einsum("t,tvc->vc", weights[frame], targets)
        whole = np.concatenate([moved, np.ones((len(moved), 1))], axis=1)
        skinned = np.einsum("vj,vjab,vb->va", shares, matrices[joints], whole)[:, :3]
        ours = perform(face, motion.iloc[[frame]])[0]
        np.testing.assert_allclose(skinned, ours, atol=2e-6)


def world(file: pygltflib.GLTF2, number: int, turns: dict[int, np.ndarray]) -> np.ndarray:
    """A node's matrix, with those above it."""
    from scipy.spatial.transform import Rotation

    node, own = file.nodes[number], np.eye(4)
    own[:3, 3] = node.translation or (0, 0, 0)
    own[:3, :3] = Rotation.from_quat(turns.get(number, (0, 0, 0, 1))).as_matrix()
    above = [n for n, other in enumerate(file.nodes) if number in (other.children or [])]
    return world(file, above[0], turns) @ own if above else own


def test_what_is_written_reads_back(written, face, motion):
    found, posed = gltf.read(written), pose(face, motion)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-7)
    for name in EXPRESSIONS:
        np.testing.assert_allclose(found.weights[name], motion[name], atol=1e-7)
    for name in ("head", "left_eye", "right_eye"):
        np.testing.assert_allclose(found.turns[name], getattr(posed, name), atol=1e-6)
    assert found.extras == {"made": {"by": "us"}}


def test_halves_of_a_channel_are_one_target_by_its_name(face, motion, tmp_path):
    at = face.shape_names.index("browInnerUp")
    shapes = np.concatenate([face.shapes, face.shapes[[at]] * 0.5])
    shapes[at] *= 0.5
    names = [*face.shape_names, "browInnerUp_R"]
    names[at] = "browInnerUp_L"
    halved = Face(
        neutral=face.neutral,
        triangles=face.triangles,
        shapes=shapes,
        shape_names=names,
        joints=face.joints,
        skin=face.skin,
    )
    gltf.write(tmp_path / "a.glb", halved, pose(halved, motion), TIMES, {})
    document = glb.Glb(tmp_path / "a.glb").document
    assert sorted(document["meshes"][0]["extras"]["targetNames"]) == sorted(EXPRESSIONS)
    np.testing.assert_allclose(
        gltf.read(tmp_path / "a.glb").weights["browInnerUp"], motion["browInnerUp"], atol=1e-7
    )


def test_a_rotation_never_takes_the_long_way_between_keys(face, tmp_path):
    """The quaternions of a full circle: each on the side of the one before."""
    yaw = np.linspace(-3, 3, 40)
    motion = pd.DataFrame({name: np.zeros(40) for name in CHANNELS} | {"head_yaw_left": yaw})
    gltf.write(tmp_path / "a.glb", face, pose(face, motion), np.arange(40) / 30, {})
    file = glb.Glb(tmp_path / "a.glb")
    (animation,) = file.document["animations"]
    head = next(
        channel["sampler"]
        for channel in animation["channels"]
        if file.document["nodes"][channel["target"]["node"]].get("name") == "head"
    )
    turns = file.values(animation["samplers"][head]["output"])
    assert (np.einsum("ni,ni->n", turns[1:], turns[:-1]) > 0).all()


def test_a_file_of_another_program_is_read_by_its_names(written, tmp_path):
    """As Blender leaves it: other names' spelling, a rig that lies down, times of its own."""
    file = glb.Glb(written)
    document = json.loads(json.dumps(file.document))
    names = document["meshes"][0]["extras"]["targetNames"]
    document["meshes"][0]["extras"]["targetNames"] = [n[0].upper() + n[1:] for n in names]
    for node in document["nodes"]:
        spelt = {"head": "Head", "leftEye": "Eye_Left", "rightEye": "eye-right"}
        node["name"] = spelt.get(node.get("name"), node.get("name"))
    root = next(n for n, node in enumerate(document["nodes"]) if node.get("name") == "neck")
    half = 0.5**0.5
    document["nodes"].append({"name": "rig", "children": [root], "rotation": [half, 0, 0, half]})
    document["scenes"][0]["nodes"] = [0, len(document["nodes"]) - 1]
    del document["asset"]["extras"]
    rewritten(tmp_path / "b.glb", document, file)
    found, ours = gltf.read(tmp_path / "b.glb"), gltf.read(written)
    np.testing.assert_array_equal(found.weights["JawOpen"], ours.weights["jawOpen"])
    laid = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    for name, turns in ours.turns.items():
        np.testing.assert_allclose(found.turns[name], laid @ turns @ laid.T, atol=1e-6)
    assert found.extras == {}


def rewritten(path, document, file: glb.Glb) -> None:
    """A file of another document over the same arrays."""
    arrays = glb.Arrays()
    arrays.binary = bytearray(file._binary)
    arrays.accessors, arrays.views = document["accessors"], document["bufferViews"]
    glb.write(path, document, arrays)


SPOILT = {
    "no animation": lambda d: d.pop("animations"),
    "an animation of nothing": lambda d: d["animations"][0].update(channels=[]),
    "no names": lambda d: d["meshes"][0].pop("extras"),
    "names of nothing": lambda d: d["meshes"][0].update(extras={"targetNames": ["a"]}),
    "names that are no list": lambda d: d["meshes"][0].update(extras={"targetNames": {"a": 1}}),
    "extras that are a list": lambda d: d["meshes"][0].update(extras=[1]),
    "a sampler of no accessor": lambda d: d["animations"][0]["samplers"][0].update(input=10**6),
    "a negative accessor": lambda d: d["animations"][0]["samplers"][0].update(output=-1),
    "an accessor that is a word": lambda d: d["animations"][0]["samplers"][0].update(input="x"),
    "a count beyond the file": lambda d: d["accessors"][-1].update(count=10**9),
    "a count below 0": lambda d: d["accessors"][-1].update(count=-1),
    "another type": lambda d: d["accessors"][-1].update(type="MAT9"),
    "a view beyond the file": lambda d: d["bufferViews"][-1].update(byteOffset=10**9),
    "nodes that go in a circle": lambda d: d["nodes"][2].update(children=[1, 2]),
    "no nodes": lambda d: d.update(nodes=[]),
    "nodes that are words": lambda d: d.update(nodes=["a"] * 9),
    "a buffer elsewhere": lambda d: d["buffers"][0].update(uri="../secret.bin"),
    "an asset that is a word": lambda d: d.update(asset="x"),
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_document_that_does_not_hold_together_is_one_typed_error_or_read(written, tmp_path, how):
    file = glb.Glb(written)
    document = json.loads(json.dumps(file.document))
    SPOILT[how](document)
    path = tmp_path / "bad.glb"
    container(path, json.dumps(document).encode(), file._binary)
    if how == "nodes that go in a circle":
        assert len(gltf.read(path).times) == FRAMES
        return
    with pytest.raises(BadFile) as caught:
        gltf.read(path)
    assert str(caught.value).startswith(str(path)) and "found" in str(caught.value)


def container(path, document: bytes, binary: bytes) -> None:
    """A .glb of these two parts, whatever they are."""
    document += b" " * (-len(document) % 4)
    parts = [(b"JSON", document), (b"BIN\0", bytes(binary))]
    size = 12 + sum(8 + len(content) for _, content in parts)
    content = b"glTF" + (2).to_bytes(4, "little") + size.to_bytes(4, "little")
    for kind, own in parts:
        content += len(own).to_bytes(4, "little") + kind + own
    path.write_bytes(content)


def test_keys_that_are_no_numbers_or_do_not_rise_are_refused(written, tmp_path):
    file = glb.Glb(written)
    number = file.document["animations"][0]["samplers"][0]["input"]
    view = file.document["bufferViews"][file.document["accessors"][number]["bufferView"]]
    for bad in (np.full(FRAMES, np.nan), TIMES[::-1], np.zeros(FRAMES)):
        binary = bytearray(file._binary)
        start = view["byteOffset"]
        binary[start : start + 4 * FRAMES] = bad.astype("<f4").tobytes()
        container(tmp_path / "bad.glb", json.dumps(file.document).encode(), binary)
        with pytest.raises(BadFile, match="rise"):
            gltf.read(tmp_path / "bad.glb")
