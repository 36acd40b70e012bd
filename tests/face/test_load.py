import os
import pickle

import numpy as np
import pytest

from mimeline.errors import BadFile, NoSuchFile
from mimeline.face.formats import shapes
from mimeline.face.load import load_face
from mimeline.face.model import SKIN

from .conftest import chained_face


def obj_text(vertices, triangles=(), colours=None) -> str:
    rows = vertices if colours is None else np.hstack([vertices, colours])
    lines = ["v " + " ".join(f"{x:.6f}" for x in row) for row in rows]
    return "\n".join(lines + [f"f {a}/1 {b}//2 {c}" for a, b, c in np.add(triangles, 1)]) + "\n"


@pytest.fixture
def folder(tmp_path, ball_face):
    """The ball face as OBJ files in centimetres."""

    def write(name, offset=0, **more):
        vertices = 100 * (ball_face.neutral + offset)
        (tmp_path / name).write_text(obj_text(vertices, **more))

    write("neutral.obj", triangles=ball_face.triangles)
    for name, offset in zip(ball_face.shape_names, ball_face.shapes, strict=True):
        write(f"{name}.obj", offset)
    write("identity_wide.obj", ball_face.neutral * [0.1, 0, 0])
    return tmp_path


def refusal(path) -> str:
    with pytest.raises(BadFile) as caught:
        load_face(path)
    return str(caught.value)


def test_no_path_gives_the_embedded_face():
    assert "jawOpen" in load_face(None).shape_names


def test_a_folder_of_obj_files_becomes_the_face_in_metres(folder, ball_face):
    face = load_face(folder)
    assert sorted(face.shape_names) == sorted(ball_face.shape_names)
    np.testing.assert_allclose(face.neutral, ball_face.neutral, atol=1e-7)
    np.testing.assert_array_equal(face.triangles, ball_face.triangles)
    for name in face.shape_names:
        expected = ball_face.shapes[ball_face.shape_names.index(name)]
        np.testing.assert_allclose(face.shapes[face.shape_names.index(name)], expected, atol=1e-7)
    assert face.identity_names == ("identity_wide",)
    assert (face.colours == SKIN).all() and face.joint_names == ("head",)


@pytest.mark.parametrize("unit", [1, 10, 1000])
def test_the_unit_is_told_from_the_height_of_the_head(tmp_path, ball_face, unit):
    text = obj_text(unit * ball_face.neutral, triangles=ball_face.triangles)
    (tmp_path / "neutral.obj").write_text(text)
    (tmp_path / "jawOpen.obj").write_text(obj_text(unit * ball_face.neutral))
    np.testing.assert_allclose(load_face(tmp_path).neutral, ball_face.neutral, atol=1e-6)


def test_colours_of_vertices_are_read(folder, ball_face):
    colours = np.tile([1, 0.5, 0], (len(ball_face.neutral), 1))
    text = obj_text(100 * ball_face.neutral, ball_face.triangles, colours)
    (folder / "neutral.obj").write_text(text)
    assert (load_face(folder).colours == (255, 128, 0)).all()


def test_polygons_become_triangles_and_negative_numbers_count_from_the_end(folder):
    text = (folder / "neutral.obj").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("f ")]
    (folder / "neutral.obj").write_text("\n".join([*lines, "f 1 2 3 4", "f -1 -2 -3"]))
    n = len(lines)
    expected = [(0, 1, 2), (0, 2, 3), (n - 1, n - 2, n - 3)]
    np.testing.assert_array_equal(load_face(folder).triangles, expected)


def test_names_with_a_side_as_suffix_are_the_channels(folder, ball_face):
    (folder / "eyeBlinkLeft.obj").rename(folder / "EyeBlink_L.obj")
    assert "eyeBlinkLeft" in load_face(folder).shape_names


@pytest.fixture
def full_face():
    """A face with every array that there is, the height of a head."""
    rng = np.random.default_rng(0)
    neutral = rng.random((12, 3)) * [0.2, 0.1, 0.2]
    neutral[0, 1], neutral[1, 1] = 0, 0.25
    return chained_face(
        neutral=neutral,
        landmarks=np.arange(68) % 12,
        pose_shapes=rng.random((18, 12, 3)),
        regressor=rng.dirichlet(np.ones(12), 3),
        gloss=rng.random(12),
    )


@pytest.mark.parametrize("which", ["full_face", "ball_face"])
def test_a_face_written_as_npz_is_read_as_it_was(tmp_path, request, which):
    face = request.getfixturevalue(which)
    shapes.to_npz(face, tmp_path / "face.npz")
    found = load_face(tmp_path / "face.npz")
    for name in (*shapes.REQUIRED, *shapes.OPTIONAL, "skin"):
        np.testing.assert_array_equal(getattr(found, name), getattr(face, name))
    for joint, expected in zip(found.joints, face.joints, strict=True):
        assert (joint.name, joint.parent) == (expected.name, expected.parent)
        np.testing.assert_array_equal(joint.centre, np.float32(expected.centre))
    assert [path.name for path in tmp_path.iterdir()] == ["face.npz"]


def arrays_of(face):
    return {
        "neutral": face.neutral,
        "triangles": face.triangles,
        "shapes": face.shapes,
        "shape_names": np.array(face.shape_names),
    }


def test_four_named_arrays_are_enough(tmp_path, ball_face):
    np.savez(tmp_path / "face.npz", **arrays_of(ball_face))
    assert load_face(tmp_path / "face.npz").joint_names == ("head",)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shape_names": None}, "found no array shape_names"),
        ({"arr_0": np.zeros(3)}, "found arrays arr_0"),
        ({"skin": np.ones((3, 1))}, "no array joint_names, joint_parents, joint_centres"),
        ({"shape_names": np.arange(4)}, "array shape_names: found type int64, expected text"),
        ({"shape_names": np.array(["a", "b", "c", "d"])}, "found shapes a, b, c, d"),
        ({"neutral": np.zeros((5, 2))}, "array neutral: found shape (5, 2)"),
        (
            {"shape_names": np.array([["a", "b", "c", "d"]])},
            "array shape_names: found shape (1, 4)",
        ),
        (
            {"triangles": np.array([[0, 1, 10**6]])},
            "array triangles: found numbers from 0 to 1000000",
        ),
        ({"shapes": np.zeros((4, 3, 3))}, "array shapes: found shape (4, 3, 3)"),
        ({"gloss": np.ones(3)}, "array gloss: found shape (3,)"),
        ({"shapes": np.zeros((4, 3, 3), "S1")}, "array shapes: found type |S1, expected numbers"),
    ],
)
def test_arrays_that_do_not_make_a_face_are_refused(tmp_path, ball_face, change, message):
    arrays = {k: v for k, v in (arrays_of(ball_face) | change).items() if v is not None}
    np.savez(tmp_path / "face.npz", **arrays)
    assert message in refusal(tmp_path / "face.npz")


def test_a_size_that_no_unit_makes_a_head_is_refused(tmp_path, ball_face):
    arrays = arrays_of(ball_face)
    np.savez(tmp_path / "face.npz", **arrays | {"neutral": 1e-6 * ball_face.neutral})
    assert "expected a head of 0.12-0.8 m" in refusal(tmp_path / "face.npz")


def test_a_face_whose_left_is_its_right_is_refused(tmp_path, ball_face):
    arrays = arrays_of(ball_face)
    np.savez(tmp_path / "face.npz", **arrays | {"neutral": ball_face.neutral * [-1, 1, 1]})
    assert "found shapes named Left that move the half with negative x" in refusal(
        tmp_path / "face.npz"
    )


def test_a_folder_without_a_neutral_face_is_refused(folder):
    (folder / "neutral.obj").unlink()
    message = refusal(folder)
    assert "found a folder of browInnerUp_L.obj" in message and "neutral.obj" in message


def test_a_shape_with_other_vertices_is_refused(folder, ball_face):
    (folder / "jawOpen.obj").write_text(obj_text(ball_face.neutral[:-1]))
    n = len(ball_face.neutral)
    assert f"jawOpen.obj: found {n - 1} vertices, expected {n}" in refusal(folder)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "found no v lines"),
        ("v 1 2\nf 1 1 1\n", "found v lines of 2 numbers"),
        ("v 1 2 x\n", "expected v x y z"),
        ("v 1 2 nan\n", "not all finite"),
        ("v 1 2 3\nv 1 2\n", "not all finite"),
        ("v 1 2 3\nv 1 2 3 4 5 6\n", "expected v x y z"),
        ("v 0 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 4\n", "line 4: found f 1 2 4"),
        ("v 0 0 0\nv 0 1 0\nv 1 0 0\nf 1 2\n", "line 4: found f 1 2"),
        ("v 0 0 0\nv 0 1 0\nv 1 0 0\n", "found no f lines"),
    ],
)
def test_a_broken_obj_file_is_refused(tmp_path, text, message):
    (tmp_path / "neutral.obj").write_text(text)
    assert message in refusal(tmp_path)


def test_a_folder_of_shapes_that_are_no_channels_is_refused(folder, ball_face):
    for name in ball_face.shape_names:
        (folder / f"{name}.obj").rename(folder / f"my_{name}.obj")
    assert "expected shapes named as ARKit channels" in refusal(folder)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "found an empty file"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "Git LFS pointer"),
        (b"<!DOCTYPE html>", "found a file that begins with b'<!DOCTYPE html>'"),
        (b"PK\x03\x04 and no more", "not a zip file"),
    ],
)
def test_a_file_that_is_no_model_is_refused_with_what_it_is(tmp_path, content, message):
    (tmp_path / "face").write_bytes(content)
    assert message in refusal(tmp_path / "face")


def test_a_missing_file_and_an_empty_folder_are_named(tmp_path):
    assert "found an empty folder" in refusal(tmp_path)
    with pytest.raises(NoSuchFile):
        load_face(tmp_path / "none.npz")


def test_an_error_of_our_own_does_not_blame_the_file(tmp_path, ball_face, monkeypatch):
    np.savez(tmp_path / "face.npz", **arrays_of(ball_face))
    monkeypatch.setattr(shapes, "head_only", lambda neutral: neutral[len(neutral)])
    with pytest.raises(IndexError):
        load_face(tmp_path / "face.npz")


def test_a_damaged_npz_is_refused(tmp_path, ball_face):
    np.savez_compressed(tmp_path / "face.npz", **arrays_of(ball_face))
    raw = bytearray((tmp_path / "face.npz").read_bytes())
    raw[200:260] = bytes(60)
    (tmp_path / "face.npz").write_bytes(raw)
    assert "expected an npz file" in refusal(tmp_path / "face.npz")


class Hostile:
    def __reduce__(self):
        return os.system, ("touch harmed",)


@pytest.mark.parametrize("protocol", range(6))
def test_a_hostile_pickle_is_refused_before_anything_runs(tmp_path, monkeypatch, protocol):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "face.pkl").write_bytes(pickle.dumps({"f": Hostile()}, protocol=protocol))
    assert "found the name posix.system in a pickle" in refusal(tmp_path / "face.pkl")
    assert not (tmp_path / "harmed").exists()
