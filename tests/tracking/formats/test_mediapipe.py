import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.errors import BadFile, MimelineError
from mimeline.face.motion import LOOK_SIDEWAYS, LOOK_UP
from mimeline.face.rotations import turned
from mimeline.tracking.formats import mediapipe
from mimeline.vocabulary import CHANNELS, EXPRESSIONS, GAZE, HEAD

GOLDEN = Path(__file__).parents[1] / "golden" / "mediapipe"
SCORES = ["_neutral", *(name for name in EXPRESSIONS if name != "tongueOut")]
CELLS = [f"matrix_{place}" for place in range(16)]


def table(frames: int = 4, seed: int = 0) -> pd.DataFrame:
    rng = np.random.default_rng(seed)
    return pd.DataFrame({name: rng.uniform(0, 1, frames).round(4) for name in SCORES})


def read(content, tmp_path, bad_values="fail", fps="30"):
    if isinstance(content, pd.DataFrame):
        path = tmp_path / "clip.csv"
        content.to_csv(path, index=False)
    else:
        path = tmp_path / "clip.json"
        path.write_text(content if isinstance(content, str) else json.dumps(content))
    return mediapipe.read(path, bad_values, fps)


def frames_of(rows: pd.DataFrame) -> list[dict]:
    return rows.to_dict("records")


def categories(named: dict, spelling: str = "categoryName") -> list[dict]:
    return [
        {"index": at, "score": score, spelling: name, "displayName": ""}
        for at, (name, score) in enumerate(named.items())
    ]


def matrix(angles=(0.2, -0.3, 0.1), scale=1.0) -> np.ndarray:
    whole = np.eye(4)
    whole[:3, :3] = scale * turned(*np.array(angles)[:, None])[0]
    whole[:3, 3] = 1, 2, -40
    return whole


def test_columns_are_known_by_name_in_any_order(tmp_path):
    rows = table()
    motion = read(rows[rows.columns[::-1]], tmp_path).motion
    for name in SCORES[1:]:
        np.testing.assert_allclose(motion[name], rows[name], rtol=1e-6)
    assert motion["tongueOut"].isna().all()


def test_the_tongue_is_never_measured_though_a_script_fills_its_column(tmp_path):
    take = read(table().assign(tongueOut=0.0), tmp_path)
    assert take.motion["tongueOut"].isna().all()
    assert not take.origins["tongueOut"].measured


def test_every_channel_has_an_origin_and_the_dead_ones_are_named(tmp_path):
    origins = read(table(), tmp_path).origins
    assert set(origins) == set(CHANNELS)
    assert "hardly ever" in origins["cheekPuff"].text and origins["cheekPuff"].measured
    assert origins["jawOpen"].text == "score jawOpen"
    assert not origins["head_yaw_left"].measured
    assert "worked out" in origins["gaze_left"].text


def spellings() -> dict:
    named = frames_of(table())
    faces = [categories(frame) for frame in named]
    snake = [categories(frame, "category_name") for frame in named]
    return {
        "names": named,
        "categories": faces,
        "faces": [[face] for face in snake],
        "javascript": [
            {"faceLandmarks": [], "faceBlendshapes": [{"categories": f}]} for f in faces
        ],
        "python": [{"face_blendshapes": [face], "face_landmarks": []} for face in snake],
    }


@pytest.mark.parametrize("spelling", list(spellings()))
def test_every_way_to_write_json_says_what_the_table_says(tmp_path, spelling):
    expected = read(table(), tmp_path).motion
    motion = read(spellings()[spelling], tmp_path).motion
    pd.testing.assert_frame_equal(motion, expected)
    assert mediapipe.holds(tmp_path / "clip.json")


@pytest.mark.parametrize("empty", [None, [], {}, [[]], {"faceBlendshapes": []}])
def test_a_frame_without_a_face_is_not_valid(tmp_path, empty):
    frames = frames_of(table())
    frames[1] = empty
    assert read(frames, tmp_path).motion["valid"].tolist() == [True, False, True, True]


def test_an_empty_row_is_a_frame_without_a_face(tmp_path):
    rows = table()
    rows.loc[1] = np.nan
    motion = read(rows, tmp_path).motion
    assert motion["valid"].tolist() == [True, False, True, True]
    assert motion.loc[1, list(CHANNELS)].isna().all()


@pytest.mark.parametrize("frames", [[[0.1] * 52] * 3, [[[0.1] * 52]] * 3, [3.0], ["eyeBlinkLeft"]])
def test_scores_without_names_are_refused(tmp_path, frames):
    with pytest.raises(BadFile, match="categories' names"):
        read(frames, tmp_path)


def test_names_of_another_vocabulary_are_refused(tmp_path):
    with pytest.raises(BadFile, match="frame 0.*no ARKit name"):
        read([{"smile": 0.3}], tmp_path)


def test_two_faces_are_refused_since_nothing_tells_them_apart(tmp_path):
    face = categories(frames_of(table())[0])
    with pytest.raises(BadFile, match="2 faces.*num_faces"):
        read([{"faceBlendshapes": [{"categories": face}, {"categories": face}]}], tmp_path)


@pytest.mark.parametrize("score", ["high", None, True, [1], {"a": 1}])
def test_a_score_that_is_no_number_is_named_or_masks_its_frame(tmp_path, score):
    frames = frames_of(table())
    frames[2]["jawOpen"] = score
    with pytest.raises(BadFile, match="frame 2.*jawOpen.*a number"):
        read(frames, tmp_path)
    assert read(frames, tmp_path, "mask").motion["valid"].tolist() == [True, True, False, True]


def test_per_cent_is_refused(tmp_path):
    frames = frames_of(table() * 100)
    with pytest.raises(BadFile, match="between 0 and 1"):
        read(frames, tmp_path)
    with pytest.raises(BadFile, match="between 0 and 1"):
        read(table() * 100, tmp_path)


HOSTILE = {
    "not a number": '[{"jawOpen": NaN}]',
    "endless": '[{"jawOpen": -Infinity}]',
    "key twice": '[{"jawOpen": 0.1, "jawOpen": 0.2}]',
    "key twice of many": "[{" + "".join(f'"{n}": 0,' for n in range(300_000)) + '"0": 1}]',
    "channel twice": '[{"jawOpen": 0.1, "JawOpen": 0.2}]',
    "beyond a float": '[{"jawOpen": 1e999}]',
    "many digits": '[{"jawOpen": ' + "9" * 9999 + "}]",
    "deep": "[" * 100_000 + "]" * 100_000,
    "deep faces": '[{"categories":' * 600 + "[]" + "}]" * 600,
    "no frame": "[]",
    "no face anywhere": "[[], null, []]",
    "one result": '{"faceBlendshapes": []}',
    "text": '"jawOpen"',
    "cut off": '[{"jawOpen": 0.1}, {"jaw',
    "nothing": "",
}


@pytest.mark.parametrize("kind", list(HOSTILE))
def test_hostile_json_gives_our_error(tmp_path, kind):
    with pytest.raises(BadFile):
        read(HOSTILE[kind], tmp_path)


def test_bytes_that_are_no_text_and_files_past_the_limits_are_refused(tmp_path):
    path = tmp_path / "clip.json"
    path.write_bytes(b"[\xff\xfe\x00]")
    with pytest.raises(BadFile):
        mediapipe.read(path, "fail", "30")
    with pytest.raises(BadFile, match="no such file"):
        mediapipe.read(tmp_path / "none.json", "fail", "30")
    with open(path, "wb") as file:
        file.truncate(300 * 2**20)  # a sparse file: no byte is written
    with pytest.raises(BadFile, match="300 MiB"):
        mediapipe.read(path, "fail", "30")
    path.write_bytes(
        b"[" + b"[]," * 2_100_000 + b"[]]"
    )  # 6 MB of text, thirty times that in memory
    with pytest.raises(BadFile, match="parts"):
        mediapipe.read(path, "fail", "30")


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("names", [CELLS, [f"m{r}{c}" for r in range(4) for c in range(4)]])
def test_the_matrix_is_read_by_rows_or_by_columns(tmp_path, order, names):
    cells = pd.DataFrame([matrix().flatten(order)] * 4, columns=names)
    take = read(pd.concat([table(), cells], axis=1), tmp_path)
    np.testing.assert_allclose(take.motion[list(HEAD)], [[0.2, -0.3, 0.1]] * 4, atol=1e-5)
    assert take.origins["head_pitch_up"].text == "facial transformation matrix"


@pytest.mark.parametrize(
    "written",
    [
        lambda m: [{"rows": 4, "columns": 4, "data": m.flatten("F").tolist()}],
        lambda m: [m.tolist()],
        lambda m: [m.flatten("F").tolist()],
        lambda m: m.flatten("F").tolist(),
    ],
)
def test_the_matrix_in_json_in_every_way_it_is_written(tmp_path, written):
    frames = frames_of(table())
    for frame in frames[:3]:
        frame["facialTransformationMatrixes"] = written(matrix(scale=1.3))
    motion = read(frames, tmp_path).motion
    np.testing.assert_allclose(motion.loc[:2, list(HEAD)], [[0.2, -0.3, 0.1]] * 3, atol=1e-5)
    assert motion.loc[3, list(HEAD)].isna().all() and motion["valid"].all()


@pytest.mark.parametrize(
    "names",
    [
        [f"matrix_{place}" for place in range(1, 17)],
        [f"matrix_{place}" for place in range(15)],
        [f"m{row}{column}" for row in range(1, 5) for column in range(1, 5)],
        [f"transform_{row}_{column}" for row in range(4) for column in range(4)],
        ["facialTransformationMatrix"],
    ],
)
def test_a_matrix_that_is_numbered_otherwise_is_refused_and_not_dropped(tmp_path, names):
    cells = pd.DataFrame([matrix().flatten()[: len(names)]] * 4, columns=names)
    with pytest.raises(BadFile, match=f"{names[0]} ... {names[-1]}.*matrix_0 ... matrix_15"):
        read(pd.concat([table(), cells], axis=1), tmp_path)


def test_a_matrix_of_another_name_in_json_is_refused_and_not_dropped(tmp_path):
    frames = [frame | {"matrix": matrix().tolist()} for frame in frames_of(table())]
    with pytest.raises(BadFile, match="frame 0: found matrix, expected facialTransformation"):
        read(frames, tmp_path)


def test_a_very_long_name_is_no_matrix(tmp_path):
    take = read(table().assign(**{"matrix" * 20_000 + "0": 1.0}), tmp_path)
    assert not take.origins["head_yaw_left"].measured


def bad_matrices() -> dict[str, np.ndarray]:
    still, mirrored, sheared = matrix(), matrix(), matrix()
    still[:3, 3] = 0
    mirrored[:3, 0] *= -1
    sheared[0, 1] += 0.3
    return {
        "no translation": still,
        "mirrored": mirrored,
        "sheared": sheared,
        "projection": np.arange(16.0).reshape(4, 4),
        "zero": np.diag([0.0, 0, 0, 1]),
    }


@pytest.mark.parametrize("kind", list(bad_matrices()))
def test_a_matrix_that_is_no_turned_face_is_refused(tmp_path, kind):
    cells = pd.DataFrame([bad_matrices()[kind].flatten()] * 4, columns=CELLS)
    with pytest.raises(BadFile, match="facial transformation matrix"):
        read(pd.concat([table(), cells], axis=1), tmp_path)


def test_the_gaze_follows_the_eyes_coefficients(tmp_path):
    rows = table() * 0
    rows[["eyeLookOutLeft", "eyeLookInRight"]] = 0.5
    rows["eyeLookUpLeft"] = 0.8
    motion = read(rows.assign(_neutral=0.1), tmp_path).motion
    np.testing.assert_allclose(motion["gaze_left"], 0.5 * LOOK_SIDEWAYS, rtol=1e-6)
    np.testing.assert_allclose(motion["gaze_up"], 0.4 * LOOK_UP, rtol=1e-6)
    take = read(rows.drop(columns="eyeLookInLeft"), tmp_path)
    assert take.motion[list(GAZE)].isna().all(axis=None)
    assert not take.origins["gaze_up"].measured


def test_frames_that_are_numbered_leave_gaps(tmp_path):
    take = read(table().assign(frame=[1, 2, 4, 5]), tmp_path)
    assert take.motion["valid"].tolist() == [False, True, True, False, True, True]
    assert take.first_frame == 1
    assert read(table(), tmp_path).first_frame is None


def test_frames_that_are_timed_leave_gaps(tmp_path):
    motion = read(table().assign(timestamp_ms=[0, 33, 100, 133]), tmp_path).motion
    assert motion["valid"].tolist() == [True, True, False, True, True]
    frames = [
        frame | {"timestamp_ms": t}
        for frame, t in zip(frames_of(table()), (0, 33, 100, 133), strict=True)
    ]
    pd.testing.assert_frame_equal(read(frames, tmp_path).motion, motion)


def test_a_take_that_begins_late_says_with_which_frame(tmp_path):
    take = read(table().assign(timestamp_ms=[500, 533, 567, 600]), tmp_path)
    assert take.first_frame == 15
    assert take.motion["valid"].tolist() == [False] * 15 + [True] * 4


@pytest.mark.parametrize(
    ("column", "told", "what"),
    [
        ("frame", [0, 1, 1, 2], "each once"),
        ("frame", [-1, 0, 1, 2], "whole numbers"),
        ("frame", [0, 1.5, 2, 3], "whole numbers"),
        ("frame", [0, 1, 2, 1e30], "frames in a take"),
        ("timestamp_ms", [0, 17, 33, 50], "33.33 from frame to frame"),
        ("timestamp_ms", [0, 67, 133, 200], "a row every 2 frames.*fps to 15"),
        ("timestamp_ms", [0, 33_333, 66_667, 100_000], "33333 from row to row.*milliseconds"),
        ("timestamp_ms", [0, 0.033, 0.067, 0.1], "write milliseconds"),
        ("timestamp_ms", [1.7e12, 1.7e12 + 33, 1.7e12 + 67, 1.7e12 + 100], "Subtract the time"),
    ],
)
def test_numbering_that_fits_no_clock_is_refused(tmp_path, column, told, what):
    with pytest.raises(BadFile, match=what):
        read(table().assign(**{column: told}), tmp_path)


def test_it_is_told_from_other_tables_by_its_header(tmp_path):
    for name, header, is_its_own in [
        ("own", "frame,_neutral,jawOpen", True),
        ("livelink", "Timecode,BlendShapeCount,_neutral,JawOpen", False),
        ("pyfeat", "FaceScore,_neutral,jawOpen", False),
        ("generic", "frame,jawOpen", False),
    ]:
        path = tmp_path / f"{name}.csv"
        path.write_text(header + "\n0,0,0,0\n")
        assert mediapipe.holds(path) == is_its_own
    (tmp_path / "catalogue.json").write_text('{"clips": {"a": {"eyeBlinkLeft": 1}}}')
    assert not mediapipe.holds(tmp_path / "catalogue.json")
    assert not mediapipe.holds(tmp_path / "none.json")


KEYS = ["jawOpen", "eyeBlinkLeft", "frame", "timestamp_ms", "faceBlendshapes", "categories"]
KEYS += ["categoryName", "score", "facialTransformationMatrixes", "data"]
JSON = st.recursive(
    st.none() | st.booleans() | st.floats(0, 2) | st.sampled_from(["jawOpen", "x", ""]),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=4)
    ),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(frames=JSON)
def test_json_of_any_shape_gives_a_take_or_our_error(tmp_path_factory, frames):
    path = tmp_path_factory.getbasetemp() / "mediapipe_any.json"
    path.write_text(json.dumps(frames))
    for bad_values in ("fail", "mask"):
        try:
            motion = mediapipe.read(path, bad_values, "30").motion
        except MimelineError:
            continue
        assert motion.loc[~motion["valid"], list(CHANNELS)].isna().all(axis=None)
