import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mimeline import tables
from mimeline.evaluation.requests import SMILES, as_frames, conflict, requests
from mimeline.evaluation.variants import ASKED, CONFLICT, UNSEEN
from mimeline.vocabulary import ACTIONS, TRACKS, track_actions

lengths, seeds = st.integers(136, 400), st.integers(0, 2**32 - 1)


def told(timeline, actions) -> np.ndarray:
    return timeline[:, [list(ACTIONS).index(action) for action in actions]]


def runs(on) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.r_[0, on.astype(int), 0]))
    return list(zip(edges[::2], edges[1::2], strict=True))


@given(length=lengths, seed=seeds)
def test_no_two_actions_of_a_track_overlap(length, seed):
    timeline = conflict(length, np.random.default_rng(seed))
    assert timeline.shape == (length, len(ACTIONS))
    for track in TRACKS:
        assert told(timeline, track_actions(track)).sum(axis=1).max() <= 1


@given(length=lengths, seed=seeds)
def test_every_smile_has_raised_brows_about_it_and_nothing_else_is_asked(length, seed):
    timeline = conflict(length, np.random.default_rng(seed))
    assert not told(timeline, set(ACTIONS) - {*SMILES, "BrowUp"}).any()
    smiles = runs(told(timeline, SMILES).any(axis=1))
    assert smiles
    raised = runs(told(timeline, ["BrowUp"])[:, 0])
    for (first, last), (start, end) in zip(smiles, raised, strict=True):
        assert 30 <= last - first <= 80
        assert abs(start - first) <= 8
        assert abs(end - last) <= 8


def test_long_timelines_of_a_seed_ask_for_every_smile():
    assert told(conflict(2000, np.random.default_rng(0)), SMILES).any(axis=0).all()


@pytest.fixture
def drawn(tmp_path):
    def drawn(absent=(), seed=0):
        rng = np.random.default_rng(1)
        marked = as_frames("clip", [rng.random((50, len(ACTIONS))) < 0.3] * 6, set(ACTIONS))
        marked.loc[:, list(absent)] = pd.NA
        ids = sorted(marked["clip_id"].unique())
        split = pd.DataFrame({"clip_id": ids, "part": ["test"] * 4 + ["train"] * 2, "group": ids})
        tables.write(tables.FRAMES, marked, tmp_path / "frames.parquet")
        tables.write(tables.SPLIT, split, tmp_path / "split.parquet")
        paths = {name: tmp_path / f"{name}.parquet" for name in ASKED}
        requests(
            frames=[tmp_path / "frames.parquet"],
            split=tmp_path / "split.parquet",
            asked=paths,
            unseen=100,
            choice_seed=0,
            timelines=3,
            length=136,
            seed=seed,
        )
        return paths, {name: tables.read(tables.FRAMES, path) for name, path in paths.items()}

    return drawn


def test_unseen_clips_are_asked_for_as_they_are_annotated(drawn):
    _, asked = drawn()
    assert sorted(asked[UNSEEN]["clip_id"].unique()) == [f"clip-{n:03d}" for n in range(4)]
    assert asked[CONFLICT].groupby("clip_id").size().to_dict() == {
        f"conflict-{n:03d}": 136 for n in range(3)
    }


def test_a_seed_gives_the_same_timelines_and_another_gives_others(drawn):
    first, again, other = (drawn(seed=seed)[1] for seed in (4, 4, 5))
    for name in ASKED:
        pd.testing.assert_frame_equal(first[name], again[name])
    assert not first[CONFLICT].equals(other[CONFLICT])
    assert first[UNSEEN].equals(other[UNSEEN])


def test_what_the_recordings_do_not_measure_is_not_told(drawn):
    _, asked = drawn(absent=["EyeClose"])
    assert asked[CONFLICT]["EyeClose"].isna().all()
    paths, asked = drawn(absent=["EyeClose", "BrowUp"])
    assert asked[CONFLICT].empty
    assert tables.reason(paths[CONFLICT]) == "not measured: BrowUp"
