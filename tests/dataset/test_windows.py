import numpy as np
import pandas as pd
import pytest
import torch

from mimeline import tables
from mimeline.dataset.windows import Normaliser, clips, collate, random_batches, timelines
from mimeline.vocabulary import ACTIONS, CHANNELS

NORMALISER = Normaliser(
    ("browInnerUp", "jawOpen"),
    mean=np.array([0.5, 0.0]),
    std=np.array([0.1, 0.5]),
    low=np.array([0.0, 0.0]),
    high=np.array([0.9, 1.0]),
)


def motion_of(lengths: dict[str, int]) -> pd.DataFrame:
    """browInnerUp tells the frame (in hundredths), jawOpen is 0.25, the rest is not measured."""
    rows = [
        {"clip_id": clip, "frame": i, "valid": True, "browInnerUp": i / 100, "jawOpen": 0.25}
        for clip, length in lengths.items()
        for i in range(length)
    ]
    return pd.DataFrame(rows, columns=tables.MOTION.schema.names)


def frames_of(motion: pd.DataFrame) -> pd.DataFrame:
    """BrowUp in every frame, Smile not measured, the rest absent."""
    values = {name: pd.array([False] * len(motion), dtype="boolean") for name in ACTIONS}
    values["BrowUp"] = pd.array([True] * len(motion), dtype="boolean")
    values["Smile"] = pd.array([pd.NA] * len(motion), dtype="boolean")
    return motion[["clip_id", "frame"]].assign(**values)


def test_only_channels_that_were_mostly_measured_are_learnt():
    names = list(CHANNELS)
    facts = {"mean": 0.1, "std": 0.0, "low": 0.0, "high": 1.0}
    statistics = pd.DataFrame({"channel": names, "measured": 0.0, **facts})
    statistics.loc[statistics["channel"] == "jawOpen", "measured"] = 0.9
    statistics.loc[statistics["channel"] == "cheekPuff", "measured"] = 0.2
    found = Normaliser.from_statistics(statistics)
    assert found.channels == ("jawOpen",)
    assert found.std == pytest.approx([1e-3])


def test_normalising_is_undone_within_what_training_has_seen():
    values = np.array([[0.2, 0.4], [0.9, 0.0]])
    assert NORMALISER.undo(NORMALISER.apply(values)) == pytest.approx(values)
    assert NORMALISER.undo(np.array([[99.0, -99.0]])) == pytest.approx(np.array([[0.9, 0.0]]))


def test_a_clip_is_scores_timeline_and_valid_frames():
    motion = motion_of({"b": 4, "a": 3})
    found = clips(motion, frames_of(motion), NORMALISER, ["a", "b"])
    assert [clip.clip_id for clip in found] == ["a", "b"]
    assert found[1].motion[:, 0] == pytest.approx([-5.0, -4.9, -4.8, -4.7])
    assert found[1].motion[:, 1] == pytest.approx(0.5)
    assert found[1].timeline.shape == (4, 16)
    assert set(found[1].timeline[:, list(ACTIONS).index("BrowUp")]) == {1.0}
    assert set(found[1].timeline[:, list(ACTIONS).index("Smile")]) == {-1.0}
    assert set(found[1].timeline[:, list(ACTIONS).index("HeadUp")]) == {0.0}


def test_a_frame_that_is_masked_or_lacks_every_channel_is_zero_and_not_valid():
    motion = motion_of({"a": 5})
    motion.loc[1, "valid"] = False
    motion.loc[3, ["browInnerUp", "jawOpen"]] = np.nan
    (clip,) = clips(motion, frames_of(motion), NORMALISER, ["a"])
    assert clip.valid.tolist() == [True, False, True, False, True]
    assert (clip.motion[~clip.valid] == 0).all()
    assert (clip.motion[clip.valid] != 0).all()
    assert (clip.measured == clip.valid[:, None]).all()


def test_a_frame_that_lacks_one_channel_is_valid_and_that_channel_zero():
    motion = motion_of({"a": 3})
    motion.loc[1, "jawOpen"] = np.nan
    (clip,) = clips(motion, frames_of(motion), NORMALISER, ["a"])
    assert clip.valid.all()
    assert clip.measured.tolist() == [[True, True], [True, False], [True, True]]
    assert clip.motion[:, 1].tolist() == [0.5, 0.0, 0.5]


def test_a_clip_without_a_channel_keeps_all_its_frames():
    motion = motion_of({"a": 30, "b": 30})
    motion.loc[motion["clip_id"] == "b", "jawOpen"] = np.nan
    data = clips(motion, frames_of(motion), NORMALISER, ["a", "b"])
    assert [int(clip.valid.sum()) for clip in data] == [30, 30]
    batch = next(random_batches(data, 10, 40, torch.Generator().manual_seed(0)))
    assert set(batch.clip_ids) == {"a", "b"}
    assert batch.valid.all()
    assert batch.measured[..., 0].all()
    has = torch.tensor([clip == "a" for clip in batch.clip_ids])
    assert torch.equal(batch.measured[..., 1], has[:, None].expand(40, 10))


def test_a_clip_without_a_valid_frame_and_one_of_another_part_stay_out():
    motion = motion_of({"a": 3, "b": 3, "c": 3})
    motion.loc[motion["clip_id"] == "b", "valid"] = False
    found = clips(motion, frames_of(motion), NORMALISER, ["a", "b"])
    assert [clip.clip_id for clip in found] == ["a"]


def test_a_frame_without_annotation_has_an_unknown_timeline():
    motion = motion_of({"a": 3})
    (clip,) = clips(motion, frames_of(motion).iloc[1:], NORMALISER, ["a"])
    assert (clip.timeline[0] == -1).all()
    assert clip.timeline[1, 0] == 1


def test_a_short_clip_is_padded_with_frames_that_are_not_valid():
    motion = motion_of({"a": 3})
    batch = collate(clips(motion, frames_of(motion), NORMALISER, ["a"]), 5)
    assert batch.motion.shape == (1, 5, 2)
    assert batch.valid.tolist() == [[True, True, True, False, False]]
    assert batch.measured.tolist() == [[[True, True]] * 3 + [[False, False]] * 2]
    assert (batch.motion[0, 3:] == 0).all()
    assert (batch.timeline[0, 3:] == -1).all()


def test_crops_are_windows_of_one_clip_from_anywhere_in_it():
    motion = motion_of({"a": 30, "b": 12})
    data = clips(motion, frames_of(motion), NORMALISER, ["a", "b"])
    source = random_batches(data, window=10, batch=50, generator=torch.Generator().manual_seed(0))
    starts = {"a": set(), "b": set()}
    for _ in range(6):
        batch = next(source)
        assert batch.valid.all()
        frame = (batch.motion[..., 0] * 0.1 + 0.5) * 100  # (B, L)
        assert torch.allclose(frame.diff(dim=1), torch.ones(50, 9), atol=1e-3)
        for clip, start in zip(batch.clip_ids, frame[:, 0].round().int().tolist(), strict=True):
            starts[clip].add(start)
    assert starts == {"a": set(range(21)), "b": set(range(3))}


def test_batches_repeat_for_a_seed():
    motion = motion_of({"a": 30, "b": 12})
    data = clips(motion, frames_of(motion), NORMALISER, ["a", "b"])

    def first(seed):
        source = random_batches(data, 10, 4, torch.Generator().manual_seed(seed))
        return torch.stack([next(source).motion for _ in range(3)])

    assert torch.equal(first(1), first(1))
    assert not torch.equal(first(1), first(2))


def test_a_crop_holds_a_valid_frame_even_where_few_are():
    motion = motion_of({"a": 200})
    motion["valid"] = motion["frame"].between(150, 152)
    data = clips(motion, frames_of(motion), NORMALISER, ["a"])
    batch = next(random_batches(data, 10, 20, torch.Generator().manual_seed(0)))
    assert batch.valid.any(dim=1).all()


def test_a_frames_table_becomes_timelines_by_clip():
    motion = motion_of({"a": 3, "b": 2})
    found = timelines(frames_of(motion))
    assert {clip: values.shape for clip, values in found.items()} == {"a": (3, 16), "b": (2, 16)}
    assert found["b"][0].tolist()[:2] == [1.0, 0.0]
