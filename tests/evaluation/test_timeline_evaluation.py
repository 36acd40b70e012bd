from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.evaluation.timeline import (
    alignment,
    choose,
    clip_values,
    evaluate_timeline,
    liveliness,
)
from mimeline.vocabulary import ACTIONS, CHANNELS

ANNOTATE = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 8.0, "hysteresis": 0.0, "min_frames": 1}
OPTIONS = {"sampler_steps": 3, "guidance": 2.0, "timelines": 3, "seed": 0}


@pytest.fixture(scope="session")
def scored(world, tmp_path_factory):
    return evaluate(world, world.untrained, tmp_path_factory.mktemp("scored"))


def evaluate(world, checkpoint, folder):
    """The metrics and the generated motion, as files."""
    metrics, generated = folder / "metrics.parquet", folder / "generated.parquet"
    files = ([world.motion], [world.frames], world.split, {}, world.labels, metrics, generated)
    evaluate_timeline(checkpoint, *files, ANNOTATE, 50, OPTIONS)
    return metrics, generated


def test_every_variant_is_scored_on_clips_kept_out_of_training(scored):
    rows = tables.read(tables.METRICS, scored[0])
    assert set(rows["variant"]) == {"real", "request", "empty", "unconditional"}
    assert set(rows["part"]) == {"test+val"}
    assert set(rows["n"]) == {3}
    own = rows[rows["variant"] == "request"].set_index("metric")
    measured = {"tas", "tas_closure", "tas_gaze", "tas_head"}  # no cluster was named here
    natural = {"var", "velocity", "fid_fm", "fid_delta_fm", "snd"}
    assert set(own.index) == measured | natural
    assert own.loc["tas", "low"] <= own.loc["tas", "value"] <= own.loc["tas", "high"]
    regions = own.loc[list(measured - {"tas"}), "value"]
    assert own.loc["tas", "value"] == pytest.approx(regions.mean())


def test_the_floor_is_nearer_to_real_motion_than_an_untrained_model(scored):
    rows = tables.read(tables.METRICS, scored[0]).set_index(["variant", "metric"])["value"]
    assert 0 < rows["real", "snd"] < rows["request", "snd"]


def test_generated_motion_has_the_frames_that_were_asked_for(scored, world):
    made = tables.read(tables.MOTION, scored[1])
    asked = tables.read(tables.FRAMES, world.frames)
    asked = asked[asked["clip_id"].isin(made["clip_id"])].reset_index(drop=True)
    assert made["clip_id"].nunique() == 3
    pd.testing.assert_frame_equal(made[["clip_id", "frame"]], asked[["clip_id", "frame"]])
    assert made[list(CHANNELS)].notna().all(axis=None)


def test_a_seed_settles_the_scores(scored, world, tmp_path):
    again = evaluate(world, world.untrained, tmp_path)
    for first, second in zip(scored, again, strict=True):
        pd.testing.assert_frame_equal(pd.read_parquet(first), pd.read_parquet(second))


def test_an_empty_checkpoint_gives_empty_tables_that_say_why(world, tmp_path):
    for path in evaluate(world, world.empty, tmp_path):
        assert tables.reason(path) == "the train part is empty"
        assert pd.read_parquet(path).empty


def part_of(**parts):
    rows = [(f"{part}{i}", part) for part, count in parts.items() for i in range(count)]
    split = pd.DataFrame(rows, columns=["clip_id", "part"])
    return split, split[["clip_id"]]


@pytest.mark.parametrize(
    ("parts", "used", "asked"),
    [
        ({"train": 20, "val": 5, "test": 9}, "test", 6),
        ({"train": 20, "val": 5, "test": 4}, "test+val", 6),
        ({"train": 20, "val": 2, "test": 2}, "test+val", 4),
        ({"train": 20, "val": 1, "test": 2}, "test+val+train", 6),
        ({"train": 20}, "train", 6),
        ({}, "none", 0),
    ],
)
def test_training_clips_are_asked_for_only_where_others_are_few(parts, used, asked):
    split, frames = part_of(**parts)
    part, ids, others = choose(split, frames, 6, np.random.default_rng(0))
    assert part == used
    assert len(ids) == len(set(ids)) == asked
    assert not set(ids) & set(others)
    assert len(others) == asked or not parts


def frames_of(active: dict[str, list[str | None]]):
    """clip → the one action of each frame."""
    rows = [
        {"clip_id": clip, "frame": i, **{name: name == action for name in ACTIONS}}
        for clip, actions in active.items()
        for i, action in enumerate(actions)
    ]
    return pd.DataFrame(rows)


def test_what_was_asked_for_and_done_scores_one():
    truth = frames_of({"a": ["BrowUp", None, "Smile", "HeadUp"], "b": ["GazeLeft", "EyeClose"]})
    scores = alignment(truth, truth, 20, np.random.default_rng(0))
    assert scores["tas"] == (1.0, 1.0, 1.0)


def test_a_region_that_fails_lowers_its_own_score_and_the_mean():
    truth = frames_of({"a": ["BrowUp", None] * 4, "b": ["Smile", None] * 4})
    done = truth.assign(BrowUp=False)
    scores = alignment(truth, done, 50, np.random.default_rng(0))
    assert scores["tas_mouth"][0] == 1.0
    assert scores["tas_brow"][0] == pytest.approx(12 / (12 + 4 / 2) / 2)
    asked = ("tas_mouth", "tas_brow")  # nothing was asked of the others
    assert scores["tas"][0] == pytest.approx(np.mean([scores[name][0] for name in asked]))
    assert scores["tas_brow"][1] < scores["tas_brow"][0] < scores["tas_brow"][2]


def test_real_clips_are_cut_where_frames_are_not_valid():
    motion = pd.DataFrame(
        {
            "clip_id": ["a"] * 6 + ["b"] * 3,
            "frame": [0, 1, 2, 3, 4, 5, 0, 1, 2],
            "valid": [True, True, False, True, True, True, True, True, True],
            "jawOpen": [0.0, 0.1, 9.0, 0.3, 0.4, 0.5, 1.0, np.nan, 1.2],
        }
    )
    found = clip_values(motion, ["a", "b"], ["jawOpen"])
    assert [clip.ravel().tolist() for clip in found] == [[0.0, 0.1], [0.3, 0.4, 0.5]]


def test_a_real_clip_without_a_channel_is_left_out_and_counted(caplog):
    motion = pd.DataFrame(
        {
            "clip_id": ["a"] * 3 + ["b"] * 3,
            "frame": [0, 1, 2] * 2,
            "valid": True,
            "jawOpen": [0.0, 0.1, 0.2, 0.3, 0.4, 0.5],
            "head_yaw_left": [0.0, 0.1, 0.2, np.nan, np.nan, np.nan],
        }
    )
    found = clip_values(motion, ["a", "b"], ["jawOpen", "head_yaw_left"])
    assert [clip.shape for clip in found] == [(3, 2)]
    assert "1 of 2 real clips lack a channel of the model" in caplog.text
    caplog.clear()
    assert len(clip_values(motion, ["a", "b"], ["jawOpen"])) == 2
    assert clip_values(motion, [], ["jawOpen"]) == []
    assert caplog.text == ""


def test_liveliness_is_variance_and_speed_over_channels():
    clip = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 0.0], [2.0, 0.0]])
    assert liveliness([clip]) == {"var": 0.5, "velocity": 1.0}


def test_without_an_annotated_clip_nothing_is_scored(world, tmp_path):
    files = {}
    for table in (tables.MOTION, tables.FRAMES, tables.SPLIT):
        files[table.name] = tmp_path / f"{table.name}.parquet"
        tables.write(table, tables.empty(table), files[table.name])
    bare = replace(world, **files)
    for path in evaluate(bare, world.untrained, tmp_path):
        assert tables.reason(path) == "no clip is annotated"
