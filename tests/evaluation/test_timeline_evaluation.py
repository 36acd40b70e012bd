from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.config.sections import TimelineSampling
from mimeline.evaluation.clip_motion import clip_values, moving
from mimeline.evaluation.timeline import evaluate_timeline
from mimeline.evaluation.unseen import choose
from mimeline.vocabulary import CHANNELS

ANNOTATE = {"closed": 0.5, "gaze_deg": 8.0, "head_deg": 8.0, "hysteresis": 0.0, "min_frames": 1}
OPTIONS = TimelineSampling(sampler="ddim", sampler_steps=3, timelines=3).model_dump()


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
    own = rows[rows["variant"] == "request"].set_index("metric")
    measured = {"tas", "tas_closure", "tas_gaze", "tas_head"}  # no cluster was named here
    natural = {"var", "velocity", "jerk"}
    compared = {"fid_fm", "fid_delta_fm", "snd", "velocity_ratio", "jerk_ratio"}
    assert set(own.index) == measured | natural | compared
    regions = own.loc[list(measured - {"tas"}), "value"]
    assert own.loc["tas", "value"] == pytest.approx(regions.mean())


def test_every_score_has_its_floor_its_number_of_clips_and_its_interval(scored):
    rows = tables.read(tables.METRICS, scored[0])
    by_variant = {variant: set(own["metric"]) for variant, own in rows.groupby("variant")}
    assert by_variant["real"] == by_variant["request"]
    assert set(rows["n"]) == {3}
    assert (rows["low"] <= rows["value"]).all()
    assert (rows["value"] <= rows["high"]).all()


def test_the_floor_is_nearer_to_real_motion_than_an_untrained_model(scored):
    rows = tables.read(tables.METRICS, scored[0]).set_index(["variant", "metric"])["value"]
    assert 0 < rows["real", "snd"] < rows["request", "snd"]


def test_real_motion_is_aligned_with_its_own_timeline(scored):
    rows = tables.read(tables.METRICS, scored[0]).set_index(["variant", "metric"])["value"]
    assert rows["real", "tas"] > 0.9 > rows["request", "tas"]


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


def test_real_clips_are_cut_where_frames_are_not_valid():
    motion = pd.DataFrame(
        {
            "clip_id": ["a"] * 6 + ["b"] * 3,
            "frame": [0, 1, 2, 3, 4, 5, 0, 1, 2],
            "valid": [True, True, False, True, True, True, True, True, True],
            "jawOpen": [0.0, 0.1, 9.0, 0.3, 0.4, 0.5, 1.0, np.nan, 1.2],
        }
    )
    found = clip_values(motion, ["b", "a"], ["jawOpen"])
    assert [[stretch.ravel().tolist() for stretch in clip] for clip in found] == [
        [[1.0], [1.2]],
        [[0.0, 0.1], [0.3, 0.4, 0.5]],
    ]


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
    assert [[stretch.shape for stretch in clip] for clip in found] == [[(3, 2)], [(0, 2)]]
    assert moving(found) == 1
    assert "1 of 2 real clips lack a channel of the model" in caplog.text
    caplog.clear()
    assert moving(clip_values(motion, ["a", "b"], ["jawOpen"])) == 2
    assert clip_values(motion, [], ["jawOpen"]) == []
    assert caplog.text == ""


def test_without_an_annotated_clip_nothing_is_scored(world, tmp_path):
    files = {}
    for table in (tables.MOTION, tables.FRAMES, tables.SPLIT):
        files[table.name] = tmp_path / f"{table.name}.parquet"
        tables.write(table, tables.empty(table), files[table.name])
    bare = replace(world, **files)
    for path in evaluate(bare, world.untrained, tmp_path):
        assert tables.reason(path) == "no clip is annotated"


def rewritten(world, folder, **changed):
    """The world with other tables."""
    files = {}
    for name, table in changed.items():
        files[name] = folder / f"{name}.parquet"
        tables.write(getattr(tables, name.upper()), table, files[name])
    return replace(world, **files)


def test_one_clip_has_scores_without_intervals_and_without_a_floor(world, tmp_path, caplog):
    marked, split = pd.read_parquet(world.frames), tables.read(tables.SPLIT, world.split)
    only = split.loc[split["part"] == "test", "clip_id"].iloc[0]
    alone = rewritten(world, tmp_path, frames=marked[marked["clip_id"] == only])
    rows = tables.read(tables.METRICS, evaluate(alone, world.untrained, tmp_path)[0])
    assert set(rows["n"]) == {1}
    assert rows["value"].notna().all()
    assert rows[["low", "high"]].isna().all(axis=None)
    assert not rows.loc[rows["variant"] == "real", "metric"].str.startswith("fid").any()
    assert "1 timelines of the 3 wanted" in caplog.text


def test_where_the_real_clips_lack_a_channel_made_motion_is_compared_with_nothing(world, tmp_path):
    motion = pd.read_parquet(world.motion).assign(jawOpen=np.nan)
    lacking = rewritten(world, tmp_path, motion=motion)
    rows = tables.read(tables.METRICS, evaluate(lacking, world.untrained, tmp_path)[0])
    made = set(rows.loc[rows["variant"] == "request", "metric"])
    assert {"tas", "var", "velocity", "jerk"} <= made
    assert not made & {"fid_fm", "snd", "velocity_ratio", "jerk_ratio"}
    assert rows["value"].notna().all()
