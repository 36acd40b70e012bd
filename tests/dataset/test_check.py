import numpy as np
import pandas as pd
import pytest

from mimeline.dataset.check import check
from mimeline.dataset.part_sizes import times_seen
from mimeline.dataset.statistics import statistics
from mimeline.dataset.windows import Clip
from mimeline.vocabulary import ACTIONS, CHANNELS

PARTS = {f"clip{i:02d}": "train" for i in range(12)} | {"clip12": "val", "clip13": "test"}
LENGTH = 80
PLAN = {"window": 32, "batch": 4, "steps": 100, "least_frames": 8}


class World:
    """The tables of a sound data set; each test plants a fault in one of them."""

    def __init__(self):
        rng = np.random.default_rng(0)
        n = len(PARTS) * LENGTH
        keys = {
            "clip_id": np.repeat(list(PARTS), LENGTH),
            "frame": np.tile(np.arange(LENGTH), len(PARTS)),
        }
        values = {name: rng.uniform(0.1, 0.6, n).astype("float32") for name in CHANNELS}
        self.motion = pd.DataFrame({**keys, "valid": True, **values})
        runs = rng.random((n // 10, len(ACTIONS))) < 0.4
        told = dict(zip(ACTIONS, np.repeat(runs, 10, axis=0).T, strict=True))
        self.frames = pd.DataFrame(keys | told).astype(dict.fromkeys(ACTIONS, "boolean"))
        names = list(PARTS)
        self.clips = pd.DataFrame(
            {
                "clip_id": names,
                "source_id": [f"film of {name}" for name in names],
                "subject_id": [f"person of {name}" for name in names],
                "fps_num": 25,
                "fps_den": 1,
            }
        )
        self.split = pd.DataFrame(
            {"clip_id": names, "part": list(PARTS.values()), "group": [f"g{n}" for n in names]}
        )

    def rows(self, table: pd.DataFrame, clip: str) -> pd.Series:
        return table["clip_id"] == clip

    def check(self, **plan):
        seen = self.motion.copy()
        train = self.split.loc[self.split["part"] == "train", "clip_id"]
        seen["valid"] &= seen["clip_id"].isin(train)
        made = self.clips, self.motion, self.frames, self.split, statistics(seen)
        return check(*made, **PLAN | plan)


@pytest.fixture
def world():
    return World()


def told(found, words: str):
    """The one finding that says so, or None."""
    says = [finding for finding in found.findings if words in finding.what]
    assert len(says) <= 1
    return says[0] if says else None


def test_nothing_is_said_of_a_sound_data_set(world):
    found = world.check()
    assert found.findings == () and found.sound
    train = found.parts.loc["train"]
    assert (train["clips"], train["frames"], train["persons"]) == (12, 960, 12)
    assert train["windows"] == 12 * (LENGTH - 32 + 1) and train["short"] == 0
    assert train["hours"] == pytest.approx(960 / 25 / 3600)
    assert found.seen == pytest.approx(100 * 4 * 32 / 960)


def test_a_part_without_clips_is_a_problem_for_training_and_else_a_remark(world):
    world.split.loc[world.split["part"] == "val", "part"] = "test"
    found = world.check()
    assert told(found, "no validation loss").where == "val" and found.sound
    world.split["part"] = "test"
    assert told(world.check(), "no clip to train on").problem


def test_too_few_valid_frames_are_a_problem(world):
    world.motion.loc[7:, "valid"] = False
    found = world.check()
    assert told(found, "7 valid frames").problem and not found.sound
    assert found.parts.loc["train", "unusable"] == 11
    assert told(found, "without a valid frame of a learnt channel (11)").where == "train"


def test_clips_shorter_than_a_window_are_told(world):
    short = world.rows(world.motion, "clip03") & (world.motion["frame"] >= 20)
    world.motion = world.motion[~short]
    found = world.check()
    assert told(found, "1 of 12 clips shorter than a window of 32").where == "clip03"
    assert found.parts.loc["train", "windows"] == 11 * (LENGTH - 32 + 1) + 1


def test_a_clip_of_mostly_invalid_frames_is_told(world):
    world.motion.loc[world.rows(world.motion, "clip12") & (world.motion["frame"] > 9), "valid"] = (
        False
    )
    found = world.check()
    assert told(found, "frames are invalid").where == "clip12"
    assert found.parts.loc["val", "invalid"] == pytest.approx(70 / 80)


def test_too_few_steps_to_see_every_frame_are_told(world):
    assert told(world.check(steps=2), "seen 0.27 times").remedy.startswith("train.timeline.steps")


def test_frame_rates_that_differ_are_told_and_none_is_a_problem(world):
    world.clips.loc[3, "fps_num"] = 30
    found = world.check()
    assert told(found, "differ in frame rate").where == "25 fps (11), 30 fps (1)" and found.sound
    world.clips["fps_num"] = pd.array([pd.NA] * len(PARTS), dtype="Int64")
    assert told(world.check(), "no frame rate is known").problem


@pytest.mark.parametrize(
    ("column", "word"), [("source_id", "source"), ("subject_id", "person"), ("group", "group")]
)
def test_what_is_in_two_parts_leaks(world, column, word):
    table = world.split if column == "group" else world.clips
    table.loc[[0, 12], column] = "both"
    leak = told(world.check(), f"the same {word} in several parts")
    assert leak.problem and leak.where == "both"


def test_a_division_by_time_is_a_remark(world):
    world.clips["source_id"] = world.split["group"] = "one film"
    found = world.check()
    assert "blocks of time" in told(found, "the same source in several parts").what and found.sound


def test_channels_that_are_not_learnt_say_why(world):
    world.motion["tongueOut"] = np.nan
    few = world.motion["clip_id"] > "clip02"
    world.motion.loc[few, "jawOpen"] = np.nan
    found = world.check()
    assert found.channels.loc["tongueOut", "why_not"] == "not measured"
    assert found.channels.loc["jawOpen", "why_not"] == "measured in too few frames"
    assert told(found, "measured in too few frames").where == "jawOpen"
    assert found.channels["learnt"].sum() == len(CHANNELS) - 2


def test_a_channel_that_some_clips_lack_is_learnt_and_told(world):
    world.motion.loc[world.rows(world.motion, "clip05"), "jawOpen"] = np.nan
    found = world.check()
    assert told(found, "in some training clips only").where == "jawOpen (not in 1)"
    assert found.channels.loc["jawOpen", "learnt"]


def test_constant_channels_are_told_and_nothing_but_them_is_a_problem(world):
    world.motion["jawOpen"] = np.float32(0.3)
    found = world.check()
    assert told(found, "do not move").where == "jawOpen" and found.sound
    world.motion[list(CHANNELS)] = np.float32(0.3)
    assert told(world.check(), "all channels are constant").problem


def test_no_channel_is_a_problem(world):
    world.motion[list(CHANNELS)] = np.float32(np.nan)
    assert told(world.check(), "no channel is measured").problem


@pytest.mark.parametrize(
    ("clip", "channel", "value"), [("clip04", "jawOpen", 1.6), ("clip13", "head_yaw_left", -3.0)]
)
def test_a_value_that_no_face_has_is_told_with_clip_and_frame(world, clip, channel, value):
    where = world.rows(world.motion, clip) & (world.motion["frame"] == 17)
    world.motion.loc[where, channel] = np.float32(value)
    found = world.check()
    assert told(found, "leave what a face can do").where == f"{channel} (frames: 1)"
    worst = found.channels.loc[channel]
    assert (worst["outliers"], worst["clip_id"], worst["frame"]) == (1, clip, 17)
    assert worst["value"] == pytest.approx(value)
    assert found.channels["outliers"].sum() == 1


def test_what_lies_in_an_invalid_frame_is_nobodys_business(world):
    world.motion.loc[3, ["valid", "jawOpen"]] = False, np.float32(1.9)
    assert world.check().findings == ()


def test_actions_that_training_lacks_are_told_and_those_of_a_later_part_too(world):
    train = world.frames["clip_id"] < "clip12"
    world.frames.loc[train, ["BrowUp", "GazeLeft"]] = False
    found = world.check()
    lacking = [f for f in found.findings if f.what == "no training clip shows"]
    assert [f.where for f in lacking] == ["BrowUp", "GazeLeft"]
    assert "mimeline label" in lacking[0].remedy and "annotate" in lacking[1].remedy
    assert told(found, "actions of val that training never sees").where == "BrowUp, GazeLeft"


def test_actions_that_are_seldom_seen_or_not_measured_are_told(world):
    world.frames.loc[5:, "HeadUp"] = False
    world.frames.loc[:5, "HeadUp"] = True
    world.frames["Smile"] = pd.array([pd.NA] * len(world.frames), dtype="boolean")
    found = world.check()
    assert told(found, "seen fewer than 10 times").where == "HeadUp"
    assert told(found, "not measured in training").where == "Smile"
    of_smile = found.actions[found.actions["action"] == "Smile"]
    assert of_smile["share"].isna().all() and not of_smile["measured"].any()


def test_timelines_without_any_action_are_a_problem(world):
    world.frames[list(ACTIONS)] = False
    assert told(world.check(), "no action in any frame").problem


def test_actions_that_come_together_or_never_are_habits(world):
    world.frames["EyeSquint"] = world.frames["Smile"]
    world.frames["GazeUp"] = ~world.frames["HeadDown"]
    first, second, *others = world.check().habits.itertuples()
    assert {(h.action, h.other) for h in (first, second)} == {
        ("EyeSquint", "Smile"),
        ("GazeUp", "HeadDown"),
    }
    by_name = {h.action: h for h in (first, second)}
    assert by_name["EyeSquint"].phi == pytest.approx(1) and by_name["EyeSquint"].lift > 1.5
    assert by_name["GazeUp"].phi == pytest.approx(-1) and by_name["GazeUp"].lift == 0
    assert all(abs(h.phi) < 0.5 for h in others)
    tracks = {(ACTIONS[h.action].track, ACTIONS[h.other].track) for h in (first, second, *others)}
    assert all(one != other for one, other in tracks)


def test_a_run_ends_with_its_clip(world):
    world.frames["BrowUp"] = True
    found = world.check().actions.set_index(["part", "action"])
    assert found.loc[("train", "BrowUp"), ["runs", "clips"]].to_list() == [12, 12]


@pytest.mark.parametrize("seed", range(3))
def test_every_frame_seen_by_a_training_is_counted(seed):
    rng = np.random.default_rng(seed)
    lengths = rng.integers(1, 90, 6)
    train = [
        Clip(str(i), np.zeros((n, 1)), np.zeros((n, 16)), np.ones(n, bool), np.ones((n, 1), bool))
        for i, n in enumerate(lengths)
    ]
    weights = lengths / lengths.sum()
    drawn = rng.choice(lengths, size=20000, p=weights)
    seen = np.minimum(drawn, 32).sum() / lengths.sum()
    assert times_seen(train, 32, batch=10, steps=2000) == pytest.approx(seen, rel=0.02)
