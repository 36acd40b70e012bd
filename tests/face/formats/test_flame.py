"""FLAME's layout with random numbers: no FLAME file is at hand here or needed."""

import io
import pickle
import sys
from types import ModuleType

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import csc_matrix

from mimeline.errors import BadFile
from mimeline.face.formats import flame
from mimeline.face.load import load_driven_face, load_face
from mimeline.face.motion import perform
from mimeline.face.rotations import turned

from .conftest import V, published


class OldPickler(pickle._Pickler):
    """Writes bytes as Python 2 wrote its strings."""

    def save_bytes(self, value):
        self.write(b"T" + len(value).to_bytes(4, "little") + value)
        self.memoize(value)

    dispatch = pickle._Pickler.dispatch | {bytes: save_bytes}


def as_published(content, monkeypatch, protocol=2) -> bytes:
    """A pickle as Python 2 wrote it: with a chumpy array, a sparse matrix and their old names."""
    module = ModuleType("chumpy.ch")
    module.Ch = type("Ch", (), {"__module__": "chumpy.ch", "__qualname__": "Ch"})
    monkeypatch.setitem(sys.modules, "chumpy", ModuleType("chumpy"))
    monkeypatch.setitem(sys.modules, "chumpy.ch", module)
    wrapped = module.Ch()
    wrapped.__dict__.update(x=content["shapedirs"], _dirty_vars=set(), _itr=None, _cache_info={})
    content = content | {"shapedirs": wrapped, "bs_type": "lrotmin"}
    content["J_regressor"] = csc_matrix(content["J_regressor"])
    file = io.BytesIO()
    OldPickler(file, protocol).dump(content)
    raw = file.getvalue().replace(b"cnumpy._core.", b"cnumpy.core.")
    return raw.replace(b"cscipy.sparse._csc\n", b"cscipy.sparse.csc\n")


@pytest.fixture
def face(tmp_path):
    np.savez(tmp_path / "flame.npz", **published())
    return load_face(tmp_path / "flame.npz")


def test_flame_has_identities_expressions_and_five_joints(face):
    assert len(face.identity_names) == 300 and face.identity_names[-1] == "shape299"
    assert len(face.shape_names) == 100 and face.shape_names[0] == "exp000"
    assert face.joint_names == flame.JOINT_NAMES
    arrays = published()
    np.testing.assert_allclose(face.shapes[7], arrays["shapedirs"][..., 307], rtol=1e-6)
    np.testing.assert_allclose([j.centre for j in face.joints], arrays["J"], atol=1e-6)


def test_channels_do_not_drive_flame(tmp_path):
    np.savez(tmp_path / "flame.npz", **published())
    with pytest.raises(BadFile, match=r"flame\.npz: found .* 100 shapes \(exp000.*leave it out"):
        load_driven_face(tmp_path / "flame.npz")


def test_flame_moves_as_its_authors_describe(face):
    """Blendshapes, then pose correctives, then skinning about regressed joints."""
    arrays, rng = published(), np.random.default_rng(1)
    betas, expression = rng.normal(size=300), rng.normal(size=100)
    jaw, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    jaw *= np.sign(np.linalg.det(jaw))
    shaped = arrays["v_template"] + arrays["shapedirs"] @ np.concatenate([betas, expression])
    centre = (arrays["J_regressor"] @ shaped)[2]
    feature = np.zeros((4, 9))
    feature[1] = (jaw - np.eye(3)).ravel()  # neck, jaw, eyes
    posed = shaped + arrays["posedirs"] @ feature.ravel()
    opened = (posed - centre) @ jaw.T + centre
    share = arrays["weights"][:, 2, None]
    expected = share * opened + (1 - share) * posed
    person = face.of({f"shape{n:03d}": b for n, b in enumerate(betas)})
    found = person.vertices(expression[None], {"jaw": jaw[None]})
    np.testing.assert_allclose(found[0], expected, atol=2e-5)


@pytest.mark.parametrize("protocol", [0, 1, 2])
def test_the_published_pickle_is_the_same_face(tmp_path, monkeypatch, face, protocol):
    if protocol == 2:
        raw = as_published(published(), monkeypatch)
    else:
        raw = pickle.dumps(published(), protocol=protocol)
    (tmp_path / "generic_model.pkl").write_bytes(raw)
    found = load_face(tmp_path / "generic_model.pkl")
    for name in ("neutral", "triangles", "shapes", "identities", "skin", "regressor", "colours"):
        np.testing.assert_array_equal(getattr(found, name), getattr(face, name))


def test_a_pickle_of_today_is_read(tmp_path):
    arrays = published(J_regressor=csc_matrix(published()["J_regressor"]))
    (tmp_path / "flame.pkl").write_bytes(pickle.dumps(arrays))
    assert load_face(tmp_path / "flame.pkl").joint_names == flame.JOINT_NAMES


def test_flame_in_millimetres_is_the_same_face(tmp_path, face):
    names = "v_template", "shapedirs", "posedirs", "J"
    larger = {name: 1000 * value for name, value in published().items() if name in names}
    np.savez(tmp_path / "large.npz", **published(**larger))
    found = load_face(tmp_path / "large.npz")
    for name in ("neutral", "shapes", "identities", "pose_shapes", "regressor", "skin"):
        np.testing.assert_allclose(getattr(found, name), getattr(face, name), rtol=1e-5)
    for joint, expected in zip(found.joints, face.joints, strict=True):
        np.testing.assert_allclose(joint.centre, expected.centre, rtol=1e-5, atol=1e-7)


def test_a_motion_table_turns_its_head_and_its_eyes(face):
    motion = pd.DataFrame({"head_yaw_left": [0.0, 0.3], "gaze_left": [0.0, 0.0], "jawOpen": [0, 1]})
    rest, yawed = perform(face, motion)
    turn, centre = turned([0.3], [0], [0])[0], face.joints[0].centre
    np.testing.assert_allclose(rest, face.neutral, atol=1e-6)
    np.testing.assert_allclose(yawed, (face.neutral - centre) @ turn.T + centre, atol=1e-5)
    looking = perform(face, pd.DataFrame({"gaze_left": [0.4]}))[0] - face.neutral
    assert np.linalg.norm(looking[20:], axis=1).mean() > 0.01


def test_the_eyeballs_show_a_gaze(face):
    assert len(np.unique(face.colours[20:30], axis=0)) > 1
    assert len(np.unique(face.colours[:20], axis=0)) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"posedirs": None}, "found no array posedirs"),
        ({"weights": np.ones((V, 4))}, f"array weights: found shape ({V}, 4), expected ({V}, 5)"),
        ({"shapedirs": np.zeros((V, 3, 300))}, "found 300 shapes"),
        ({"kintree_table": np.zeros((2, 5), np.int64)}, "joints with parents (0, 0, 0, 0)"),
        ({"weights": np.ones((V, 5))}, "do not sum to 1"),
        ({"f": np.full((3, 3), V)}, f"array f: found numbers from {V} to {V}"),
        ({"f": np.full((3, 3), np.nan)}, "array f: found numbers that are not finite"),
        ({"f": np.full((3, 3), 0.5)}, "array f: found fractions, expected whole numbers"),
        ({"f": np.full((3, 3), 2**62)}, "array f: found numbers from 4.6"),
        ({"J_regressor": np.full((5, V), np.nan)}, "array J_regressor: found numbers that are not"),
        ({"v_template": np.ones((V, 3))}, "expected a head of 0.12-0.8 m"),
    ],
)
def test_what_is_not_flame_is_refused(tmp_path, change, message):
    np.savez(tmp_path / "flame.npz", **published(**change))
    with pytest.raises(BadFile) as caught:
        load_face(tmp_path / "flame.npz")
    assert message in str(caught.value)
