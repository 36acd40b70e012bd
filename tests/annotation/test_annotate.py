import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline import tables
from mimeline.annotation.annotate import (
    annotate,
    annotate_frames,
    intervals_of,
    track_codes,
    unmeasured_actions,
)
from mimeline.annotation.annotator import Annotator
from mimeline.annotation.region_model import read_models
from mimeline.annotation.thresholds import Limits
from mimeline.vocabulary import ACTIONS, CHANNELS, TRACKS, series_actions, track_actions

LIMITS = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 8.0, "hysteresis": 0.0}
NAMES = {
    "brow": ["Neutral", "BrowUp", "BrowDown", "BrowUp"],
    "eye": ["Neutral", "EyeSquint", "EyeWiden"],
    "mouth": ["Neutral", "Smile", "SoftSmile", "MouthFrown"],
}
MEASURED = {"eyeBlinkLeft": 0.0, "eyeBlinkRight": 0.0, "gaze_left": 0.0, "gaze_up": 0.0} | {
    "head_yaw_left": 0.0,
    "head_pitch_up": 0.0,
}


def labels_of(names=NAMES, unmeasured=()) -> pd.DataFrame:
    """The `labels` table; a name of None is none. unmeasured: actions, of whichever region."""
    rows = [
        (r, k, action, [name for name in unmeasured if name in series_actions(r)])
        for r, actions in names.items()
        for k, action in enumerate(actions)
    ]
    table = pd.DataFrame(rows, columns=["region", "cluster", "action", "unmeasured"])
    return table.assign(note=None, source="proposed", share=0.0, confidence=np.nan, why=None)


def clusters_of(motion, ids, margin=1.0) -> pd.DataFrame:
    """The `clusters` table of motion's valid frames; ids: a digit per frame, a dot for none."""
    rows = motion[["clip_id", "frame"]].assign(cluster=list(ids), margin=margin)
    rows = rows[(rows["cluster"] != ".") & motion["valid"].to_numpy()]
    return rows.astype({"cluster": "int64"}).reset_index(drop=True)


def told(found, track):
    """The intervals of a track as tuples."""
    rows = found.loc[found["track"] == track, ["clip_id", "action", "start_frame", "end_frame"]]
    return [tuple(row) for row in rows.to_numpy().tolist()]


def annotated(motion, clusters, min_frames=1, names=NAMES, unmeasured=()):
    frames = annotate_frames(
        motion, clusters, labels_of(names, unmeasured), Limits(**LIMITS, min_frames=min_frames)
    )
    return frames, intervals_of(frames, clusters)


def rebuilt(frames, found) -> pd.DataFrame:
    """The booleans that intervals tell, False where they tell nothing."""
    clip, frame = frames["clip_id"].to_numpy(), frames["frame"].to_numpy()
    marks = {name: np.zeros(len(frames), dtype=bool) for name in ACTIONS}
    for run in found.itertuples():
        inside = (clip == run.clip_id) & (frame >= run.start_frame) & (frame < run.end_frame)
        marks[run.action][inside] = True
    return pd.DataFrame(marks, index=frames.index)


def test_names_of_clusters_become_half_open_intervals(motion_of):
    motion = motion_of({"a": 8})
    frames, found = annotated(motion, {"brow": clusters_of(motion, "00112200")})
    assert frames["BrowUp"].tolist() == [False, False, True, True] + [False] * 4
    assert told(found, "brow") == [("a", "BrowUp", 2, 4), ("a", "BrowDown", 4, 6)]


def test_clusters_of_one_name_are_one_interval_that_tells_the_commonest(motion_of):
    motion = motion_of({"a": 6})
    margin = [0.0, 0.0, 1.0, 2.0, 3.0, 0.0]
    clusters = {"brow": clusters_of(motion, "013330", margin)}
    _, found = annotated(motion, clusters)
    (row,) = found.to_dict("records")
    assert (row["action"], row["start_frame"], row["end_frame"]) == ("BrowUp", 1, 5)
    assert (row["cluster"], row["source"]) == (3, "ticc")
    expected = np.mean(1 / (1 + np.exp([-0.0, -1.0, -2.0, -3.0])))
    assert row["confidence"] == pytest.approx(expected)


def test_an_interval_of_a_threshold_has_neither_cluster_nor_confidence(motion_of):
    motion = motion_of({"a": 4}, head_yaw_left=np.radians([0.0, 20.0, 20.0, -20.0]))
    _, found = annotated(motion, {})
    assert told(found, "head_h") == [("a", "HeadLeft", 1, 3), ("a", "HeadRight", 3, 4)]
    assert set(found["source"]) == {"threshold"}
    assert found["cluster"].isna().all()
    assert found["confidence"].isna().all()


def test_intervals_end_with_the_clip_and_start_anew_in_the_next(motion_of):
    motion = motion_of({"a": 3, "b": 3}, eyeBlinkLeft=0.9, eyeBlinkRight=0.9)
    _, found = annotated(motion, {"brow": clusters_of(motion, "011110")})
    assert told(found, "brow") == [("a", "BrowUp", 1, 3), ("b", "BrowUp", 0, 2)]
    assert told(found, "closure") == [("a", "EyeClose", 0, 3), ("b", "EyeClose", 0, 3)]


def test_intervals_never_reach_over_masked_frames_even_if_these_hold_numbers(motion_of):
    motion = motion_of({"a": 5}, **MEASURED | {"eyeBlinkLeft": 0.9, "eyeBlinkRight": 0.9})
    motion.loc[2, "valid"] = False
    frames, found = annotated(motion, {"mouth": clusters_of(motion, "11111")})
    assert told(found, "closure") == [("a", "EyeClose", 0, 2), ("a", "EyeClose", 3, 5)]
    assert told(found, "mouth") == [("a", "Smile", 0, 2), ("a", "Smile", 3, 5)]
    assert frames.loc[2, list(ACTIONS)].isna().all()


def test_intervals_never_reach_over_frames_that_have_no_row(motion_of):
    motion = motion_of({"a": 5}).drop(index=2).reset_index(drop=True)
    _, found = annotated(motion, {"brow": clusters_of(motion, "1111")})
    assert told(found, "brow") == [("a", "BrowUp", 0, 2), ("a", "BrowUp", 3, 5)]


def test_intervals_shorter_than_the_least_become_neutral_and_not_unknown(motion_of):
    motion = motion_of({"a": 9}, **MEASURED | {"gaze_up": np.radians([20.0] * 2 + [0.0] * 7)})
    frames, found = annotated(motion, {"brow": clusters_of(motion, "011022201")}, min_frames=3)
    assert told(found, "brow") == [("a", "BrowDown", 4, 7)]
    assert told(found, "gaze_v") == []
    assert frames["BrowUp"].tolist() == [False] * 9
    assert frames["GazeUp"].tolist() == [False] * 9


def test_a_short_interval_at_a_clips_end_is_not_joined_with_the_next_clip(motion_of):
    motion = motion_of({"a": 4, "b": 4})
    _, found = annotated(motion, {"brow": clusters_of(motion, "00111100")}, min_frames=3)
    assert found.empty


def test_what_was_not_measured_is_unknown_and_absent_from_intervals(motion_of):
    motion = motion_of({"a": 4}, gaze_left=0.0)
    frames, found = annotated(motion, {"eye": clusters_of(motion, "1..1")})
    known = {name for name in ACTIONS if frames[name].notna().all()}
    assert known == {"GazeLeft", "GazeRight"}
    assert frames["EyeSquint"].fillna(False).tolist() == [True, False, False, True]
    assert frames["EyeSquint"].isna().tolist() == [False, True, True, False]
    assert set(found["track"]) == {"lid"}
    assert track_codes(frames, "lid").tolist() == [1, -1, -1, 1]
    assert set(track_codes(frames, "brow")) == {-1}


def test_a_cluster_that_fitting_left_without_frames_is_unknown(motion_of):
    motion = motion_of({"a": 4})
    frames, found = annotated(motion, {"brow": clusters_of(motion, "1191")})
    assert track_codes(frames, "brow").tolist() == [1, 1, -1, 1]
    assert told(found, "brow") == [("a", "BrowUp", 0, 2), ("a", "BrowUp", 3, 4)]


def test_a_region_without_any_name_is_unknown(motion_of):
    motion = motion_of({"a": 2})
    frames, found = annotated(
        motion, {"brow": clusters_of(motion, "11")}, names={"eye": ["Neutral"]}
    )
    assert frames["BrowUp"].isna().all()
    assert found.empty


def test_a_cluster_without_a_name_is_unknown_and_not_neutral(motion_of):
    motion = motion_of({"a": 8})
    names = NAMES | {"brow": ["Neutral", "BrowUp", None]}
    frames, found = annotated(motion, {"brow": clusters_of(motion, "00112211")}, names=names)
    assert told(found, "brow") == [("a", "BrowUp", 2, 4), ("a", "BrowUp", 6, 8)]
    assert track_codes(frames, "brow").tolist() == [0, 0, 1, 1, -1, -1, 1, 1]
    assert frames.loc[4:5, ["BrowUp", "BrowDown"]].isna().all(axis=None)
    assert unmeasured_actions(frames, "brow") == []


def test_a_region_whose_clusters_all_lack_a_name_is_unknown(motion_of):
    motion = motion_of({"a": 3})
    frames, found = annotated(motion, {"brow": clusters_of(motion, "000")}, names={"brow": [None]})
    assert frames[["BrowUp", "BrowDown"]].isna().all(axis=None)
    assert found.empty


def test_an_unmeasured_action_is_unknown_also_where_others_of_its_track_are_known(motion_of):
    motion = motion_of({"a": 6})
    clusters = {"mouth": clusters_of(motion, "001120")}
    frames, found = annotated(motion, clusters, unmeasured=["MouthFrown"])
    assert frames["MouthFrown"].isna().all()
    assert frames["Smile"].tolist() == [False, False, True, True, False, False]
    assert told(found, "mouth") == [("a", "Smile", 2, 4), ("a", "SoftSmile", 4, 5)]
    assert track_codes(frames, "mouth").tolist() == [-1, -1, 2, 2, 1, -1]
    assert track_codes(frames, "mouth", ["MouthFrown"]).tolist() == [0, 0, 2, 2, 1, 0]
    assert unmeasured_actions(frames, "mouth") == ["MouthFrown"]


def test_a_cluster_that_a_person_named_by_an_unmeasured_action_shows_it(motion_of):
    motion = motion_of({"a": 4})
    clusters = {"mouth": clusters_of(motion, "0330")}
    frames, found = annotated(motion, clusters, unmeasured=["MouthFrown"])
    assert told(found, "mouth") == [("a", "MouthFrown", 1, 3)]
    assert frames["MouthFrown"].isna().tolist() == [True, False, False, True]
    assert unmeasured_actions(frames, "mouth") == ["MouthFrown"]


def test_a_short_interval_is_unknown_where_its_neighbour_is_and_neutral_elsewhere(motion_of):
    motion = motion_of({"a": 8, "b": 3})
    names = NAMES | {"brow": ["Neutral", "BrowUp", None]}
    clusters = {"brow": clusters_of(motion, "00100221" + "100")}
    frames, found = annotated(motion, clusters, min_frames=3, names=names)
    assert found.empty
    assert track_codes(frames, "brow").tolist() == [0] * 5 + [-1] * 3 + [0] * 3
    assert frames["BrowDown"].isna().tolist() == [False] * 5 + [True] * 2 + [False] * 4


def test_a_short_interval_is_no_action_where_only_another_action_is_unmeasured(motion_of):
    motion = motion_of({"a": 6})
    clusters = {"mouth": clusters_of(motion, "010222")}
    frames, found = annotated(motion, clusters, min_frames=3, unmeasured=["MouthFrown"])
    assert told(found, "mouth") == [("a", "SoftSmile", 3, 6)]
    assert frames["Smile"].tolist() == [False] * 6
    assert frames["MouthFrown"].isna().all()


def test_frames_that_a_person_marked_make_intervals_without_clusters(motion_of):
    motion = motion_of({"a": 3})
    frames, _ = annotated(motion, {"brow": clusters_of(motion, "011")})
    assert told(intervals_of(frames, {}), "brow") == [("a", "BrowUp", 1, 3)]


@st.composite
def worlds(draw):
    """Lengths of clips and, per frame, whether it is valid, three clusters and a head angle."""
    lengths = draw(st.lists(st.integers(1, 12), min_size=1, max_size=3))
    n = sum(lengths)

    def per_frame(values):
        return draw(st.lists(values, min_size=n, max_size=n))

    valid = per_frame(st.sampled_from([True] * 6 + [False]))
    ids = {
        region: per_frame(st.sampled_from("0123"[: len(names)] + "."))
        for region, names in NAMES.items()
    }
    angles = per_frame(st.sampled_from([0.0, 0.3, -0.3, np.nan]))
    return lengths, valid, ids, angles, draw(st.integers(1, 4))


DOUBTFUL = NAMES | {"brow": ["Neutral", "BrowUp", None, "BrowUp"]}


@settings(max_examples=30, deadline=None)
@given(world=worlds(), unmeasured=st.sampled_from([(), ("BrowDown", "MouthFrown", "SoftSmile")]))
def test_what_is_not_known_never_becomes_neutral_nor_an_action(motion_of, world, unmeasured):
    lengths, valid, ids, _, min_frames = world
    motion = motion_of(dict(zip("abc", lengths, strict=False))).assign(valid=valid)
    clusters = {region: clusters_of(motion, digits) for region, digits in ids.items()}
    frames, found = annotated(motion, clusters, min_frames, DOUBTFUL, unmeasured)
    whole, _ = annotated(motion, clusters, 1, DOUBTFUL, unmeasured)
    for name in ACTIONS:
        before, after = whole[name], frames[name]
        assert after[before.isna()].isna().all()
        assert not after[~before.fillna(True)].fillna(True).any()
    nameless = np.array([digit == "2" for digit in ids["brow"]]) | ~np.array(valid)
    assert frames.loc[nameless, ["BrowUp", "BrowDown"]].isna().all(axis=None)
    marks = frames[list(ACTIONS)].fillna(False).astype(bool)
    pd.testing.assert_frame_equal(rebuilt(frames, found), marks)


@settings(max_examples=60, deadline=None)
@given(world=worlds())
def test_intervals_and_frames_tell_the_same(motion_of, world):
    lengths, valid, ids, angles, min_frames = world
    clips = dict(zip("abc", lengths, strict=False))
    motion = motion_of(clips, head_yaw_left=angles, gaze_up=angles[::-1]).assign(valid=valid)
    clusters = {region: clusters_of(motion, digits) for region, digits in ids.items()}
    frames, found = annotated(motion, clusters, min_frames)
    marks = frames[list(ACTIONS)].fillna(False).astype(bool)
    pd.testing.assert_frame_equal(rebuilt(frames, found), marks)
    assert (found["end_frame"] - found["start_frame"] >= min_frames).all()
    assert not marks[~np.array(valid)].any(axis=None)
    for track in TRACKS:
        assert marks[list(track_actions(track))].sum(axis=1).max() <= 1
    by_clip = found.groupby(["clip_id", "track"])
    assert (found["start_frame"] >= by_clip["end_frame"].shift().fillna(0)).all()
    assert all(run.end_frame <= clips[run.clip_id] for run in found.itertuples())
    assert found.loc[found["source"] == "ticc", "confidence"].between(0.5, 1).all()


@pytest.fixture
def run(tmp_path, write_clips):
    def run(kept, motion, clusters, labels):
        write_clips(kept, tmp_path / "clips.parquet")
        tables.write(tables.MOTION, motion, tmp_path / "motion.parquet")
        tables.write(tables.LABELS, labels, tmp_path / "labels.parquet")
        paths = {region: tmp_path / f"{region}.parquet" for region in NAMES}
        for region, path in paths.items():
            rows = clusters.get(region, tables.empty(tables.CLUSTERS))
            tables.write(tables.CLUSTERS, rows, path)
        inputs = [tmp_path / f"{name}.parquet" for name in ("clips", "motion")]
        out = [tmp_path / f"{name}.parquet" for name in ("intervals", "frames")]
        annotate(*inputs, paths, tmp_path / "labels.parquet", *out, **LIMITS, min_frames=2)
        read = tables.read(tables.INTERVALS, out[0]), tables.read(tables.FRAMES, out[1])
        return *read, [tables.reason(path) for path in out]

    return run


def test_the_tables_of_a_shard_hold_its_kept_clips_only(run, motion_of):
    motion = motion_of({"a": 4, "b": 4}, **MEASURED)
    clusters = {region: clusters_of(motion, "00110011") for region in NAMES}
    found, frames, reasons = run(["b"], motion, clusters, labels_of())
    assert set(frames["clip_id"]) == {"b"}
    assert found["action"].tolist() == ["BrowUp", "EyeSquint", "Smile"]
    assert found["cluster"].tolist() == [1, 1, 1]
    assert reasons == ["", ""]


def test_an_empty_shard_gives_empty_tables_with_the_reason(run, motion_of):
    motion = motion_of({"a": 4}, **MEASURED)
    found, frames, reasons = run(
        [], motion.iloc[:0], {"brow": clusters_of(motion, "0011")}, labels_of()
    )
    assert found.empty
    assert frames.empty
    assert reasons == ["no clip came through"] * 2


def test_where_no_region_was_segmented_the_thresholds_go_on(run, motion_of):
    motion = motion_of({"a": 4}, **MEASURED | {"gaze_left": 0.5})
    found, frames, _ = run(["a"], motion, {}, tables.empty(tables.LABELS))
    assert told(found, "gaze_h") == [("a", "GazeLeft", 0, 4)]
    assert len(found) == 1
    assert frames["BrowUp"].isna().all()
    assert frames["HeadUp"].tolist() == [False] * 4


def test_a_face_that_does_nothing_has_frames_and_no_interval(run, motion_of):
    found, frames, reasons = run(["a"], motion_of({"a": 4}, **MEASURED), {}, labels_of())
    assert found.empty
    assert len(frames) == 4
    assert reasons == ["no action was found", ""]


def test_an_annotator_finds_in_fitted_motion_what_the_tables_tell(segmented):
    assigned = {r: tables.read(tables.CLUSTERS, segmented.clusters[r]) for r in ("brow", "eye")}
    limits = Limits(**LIMITS, min_frames=3)
    annotator = Annotator(read_models(segmented.models), labels_of(), limits)
    motion = segmented.motion.astype(dict.fromkeys(CHANNELS, "float32"))
    expected = annotate_frames(motion, assigned, labels_of(), limits)
    pd.testing.assert_frame_equal(annotator.frames(motion), expected)


def test_an_annotator_leaves_out_a_region_that_the_motion_lacks(segmented, motion_of):
    limits = Limits(**LIMITS, min_frames=1)
    annotator = Annotator(read_models(segmented.models), labels_of(), limits)
    motion = motion_of({"new": 30}, eyeSquintLeft=0.5, eyeWideLeft=0.05)
    motion.loc[10, "valid"] = False
    found = annotator.clusters(motion)
    assert found["brow"].empty
    assert found["eye"]["frame"].tolist() == [*range(10), *range(11, 30)]
    frames = annotator.frames(motion)
    assert frames["BrowUp"].isna().all()
    assert np.flatnonzero(frames["EyeSquint"].isna()).tolist() == [10]
