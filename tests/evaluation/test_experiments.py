from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.proposals import read_rules
from mimeline.evaluation import attempts as trying
from mimeline.evaluation.experiments import NO_TRUTH, ONE_CLIP, experiments, recorded, tried
from mimeline.ticc import TICC
from mimeline.toy.world import simulate
from mimeline.vocabulary import DESCRIPTORS, NEUTRAL, resource, series_channels

CONFIGURED = {"n_clusters": 3, "window": 3, "beta": 8.0, "sparsity": 0.11, "boundary": "mask"}
CONFIGURED |= {"max_iter": 4, "seed": 5}
SETTINGS = {
    ("reference", "configured"),
    ("clusters", "2"),
    ("beta", "4"),
    ("beta", "30"),
    ("separators", "null sequences"),
    ("separators", "one sequence"),
    ("descriptors", "action units"),
    ("sides", "both sides"),
    ("unseen", "unseen"),
    ("baselines", "thresholds"),
    ("baselines", "Gaussian mixture"),
    ("baselines", "Gaussian HMM"),
}


@dataclass(frozen=True)
class Files:
    folder: Path
    clips: pd.DataFrame
    motion: pd.DataFrame
    frames: pd.DataFrame


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Files:
    """Six short clips of a simulated world."""
    folder = tmp_path_factory.mktemp("experiments")
    world = simulate(people=3, clips=6, seed=1)
    motion = world.motion[world.motion["frame"] < 90].reset_index(drop=True)
    sizes = motion.groupby("clip_id").size()
    clips = pd.DataFrame(
        {
            "clip_id": [clip.clip_id for clip in world.clips],
            "source_id": [clip.source for clip in world.clips],
            "start_s": 0.0,
            "end_s": 3.0,
            "fps_num": 30,
            "fps_den": 1,
            "texts": [[] for _ in world.clips],
            "shard": 0,
        }
    ).assign(n_frames=lambda t: t["clip_id"].map(sizes))
    for name in tables.CLIPS.schema.names:
        if name not in clips:
            clips[name] = [[]] * len(clips) if name in ("actions", "emotions") else None
    clips["attributes"] = [[]] * len(clips)
    tables.write(tables.CLIPS, clips, folder / "clips.parquet")
    tables.write(tables.MOTION, motion, folder / "motion.parquet")
    table = tables.COEFFICIENTS["action_units"]
    tables.write(table, tables.empty(table), folder / "units.parquet")
    (folder / "truth").mkdir()
    tables.write(tables.FRAMES, world.frames, folder / "truth" / "frames.parquet")
    return Files(folder, clips, motion, world.frames)


@dataclass(frozen=True)
class Outcome:
    """fits: what TICC was fitted to, in order: the estimator with its arguments, X and lengths."""

    rows: pd.DataFrame
    left_out: dict[tuple[str, str], str]
    reason: str
    fits: list[tuple[TICC, np.ndarray, np.ndarray]]


def run(files: Files, folder: Path, motion=None, truth: str | None = "truth", seeds=1) -> Outcome:
    if motion is not None:
        tables.write(tables.MOTION, motion, folder / "motion.parquet")
    fits = []

    class Watched(TICC):
        def fit(self, X, lengths=None, start=None):
            fits.append((self, X, np.array(lengths)))
            return super().fit(X, lengths, start)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trying, "TICC", Watched)
        experiments(
            clips=[files.folder / "clips.parquet"],
            ledgers=[],
            motions=[(files.folder if motion is None else folder) / "motion.parquet"],
            units=[files.folder / "units.parquet"],
            rules=resource("proposals.csv"),
            truth=files.folder / truth if truth else None,
            found=folder / "found.parquet",
            left_out=folder / "left_out.parquet",
            region="brow",
            side="left",
            n_clusters=[2],
            betas=[4.0, 30.0],
            null_length=40,
            null_value=-1.0,
            configured=CONFIGURED,
            seeds=seeds,
            unseen=0.3,
            claspy=None,
        )
    rows = tables.read(tables.EXPERIMENTS, folder / "found.parquet")
    missing = tables.read(tables.LEFT_OUT, folder / "left_out.parquet")
    said = missing.set_index(["experiment", "setting"])["reason"].to_dict()
    return Outcome(rows, said, tables.reason(folder / "found.parquet"), fits)


@pytest.fixture(scope="module")
def plain(files, tmp_path_factory) -> Outcome:
    return run(files, tmp_path_factory.mktemp("plain"), seeds=2)


def attempted(files: Files, only: str, units=None, **changed):
    """Tables of one experiment: rows, and left out by setting."""
    units = tables.empty(tables.COEFFICIENTS["action_units"]) if units is None else units
    recordings = recorded(files.clips, files.motion, units, files.frames, "brow")
    rules = read_rules(resource("proposals.csv"))
    plan = trying.Plan("brow", "left", CONFIGURED, [2], [8.0], 0.3, rules, None)
    rows, missing = tried(recordings, replace(plan, **changed), 1, [only])
    return rows, missing.set_index("setting")["reason"].to_dict()


def test_every_setting_has_its_rows_and_what_is_left_out_its_reason(plain):
    rows = plain.rows
    assert plain.reason == ""
    assert set(zip(rows["experiment"], rows["setting"], strict=True)) == SETTINGS
    assert plain.left_out.keys() == {
        ("descriptors", "measured action units"),
        ("baselines", "CLaP"),
    }
    assert "AU01" in plain.left_out["descriptors", "measured action units"]
    assert plain.left_out["baselines", "CLaP"] == trying.NO_CLASPY
    seeds = rows.groupby(["experiment", "setting"])["seed"].agg(set)
    assert seeds.pop(("baselines", "thresholds")) == {5}  # no seed changes them
    assert all(own == {5, 6} for own in seeds)
    frames = rows.groupby(["experiment", "setting", "seed", "clip_id"])["frames"].sum()
    assert set(frames) == {90}


def test_each_setting_is_fitted_as_it_says(plain):
    made = [(t.get_params(), X.shape[1], len(lengths)) for t, X, lengths in plain.fits]
    (own, channels, clips), *others = (fit for fit in made if fit[0]["seed"] == 5)
    assert (channels, clips) == (len(DESCRIPTORS["brow"]), 6)
    assert [p["n_clusters"] for p, _, _ in others if p["n_clusters"] != 3] == [2]
    assert {p["beta"] for p, _, _ in others if p["beta"] != own["beta"]} == {4.0, 30.0}
    paper = [(p["null_length"], count) for p, _, count in others if p["boundary"] == "paper"]
    assert paper == [(40, 6)]
    assert [p["boundary"] for p, _, count in others if count == 1] == ["mask"]
    assert 5 in [n for _, n, _ in others]  # both sides' channels
    known = {key: value for key, value in own.items() if key not in ("n_clusters", "beta")}
    alike = [p.items() >= known.items() for p, _, _ in others if p["boundary"] == "mask"]
    assert all(alike)
    assert {fit[0]["seed"] for fit in made} == {5, 6}


def test_unseen_clips_take_no_part_in_the_fit_and_no_others_are_judged(plain, files):
    rows = plain.rows[plain.rows["seed"] == 5]
    unseen = set(rows.loc[rows["experiment"] == "unseen", "clip_id"])
    sources = files.clips.set_index("clip_id")["source_id"]
    assert 0 < len(unseen) < 6
    assert not set(sources[list(unseen)]) & set(sources.drop(list(unseen)))
    fewer = [
        X for ticc, X, lengths in plain.fits if ticc.seed == 5 and len(lengths) == 6 - len(unseen)
    ]
    assert len(fewer) == 1
    channels = list(series_channels("brow", "left"))
    out = files.motion.loc[files.motion["clip_id"].isin(unseen), channels].to_numpy("float32")
    there = {row.tobytes() for row in fewer[0].astype("float32")}
    assert not there & {row.tobytes() for row in out}
    seen = files.motion.loc[~files.motion["clip_id"].isin(unseen), channels].to_numpy("float32")
    assert there == {row.tobytes() for row in seen}


def test_the_names_of_unseen_clips_come_from_the_seen(files):
    """Where truth is known of the unseen clips alone, nothing has a name but Neutral."""
    rows, _ = attempted(files, "unseen")
    unseen = rows.loc[rows["experiment"] == "unseen", "clip_id"].unique()
    known = replace(files, frames=files.frames[files.frames["clip_id"].isin(unseen)])
    rows, _ = attempted(known, "unseen")
    assert set(rows.loc[rows["experiment"] == "unseen", "found"]) == {NEUTRAL}
    assert len(set(rows.loc[rows["experiment"] == "reference", "found"])) > 1


def test_action_units_that_the_tracker_measured_are_tried(files):
    table = tables.COEFFICIENTS["action_units"]
    units = files.motion[["clip_id", "frame"]].copy()
    for name in table.schema.names[2:]:
        units[name] = np.nan
    for unit, channel in (("AU01", "browInnerUp"), ("AU02", "browOuterUpLeft")):
        units[f"{unit}_r"] = 5 * files.motion[channel].clip(0, 1)
    units["AU04_r"] = 5 * files.motion["browDownLeft"].clip(0, 1)
    rows, left_out = attempted(files, "descriptors", units)
    assert set(rows["setting"]) == {"configured", "action units", "measured action units"}
    assert not left_out


def test_what_cannot_be_fitted_is_a_reason_and_no_crash(files):
    rows, left_out = attempted(files, "clusters", n_clusters=[2, 400])
    assert "windows of 3 frames are too few for 400 clusters" in left_out["400"]
    assert set(rows["setting"]) == {"configured", "2"}
    rows, left_out = attempted(files, "unseen", unseen=0.99)
    assert "leaves nothing to fit" in left_out["unseen"]
    rows, left_out = attempted(files, "baselines", claspy="/nowhere/python")
    assert "/nowhere/python" in left_out["CLaP"]
    assert {"thresholds", "Gaussian mixture", "Gaussian HMM"} <= set(rows["setting"])


def test_the_same_plan_gives_the_same_counts(files, plain):
    rows, _ = attempted(files, "clusters")
    before = plain.rows[plain.rows["seed"] == 5]
    before = before[before["experiment"].isin(["reference", "clusters"])]
    order = [name for name in before if name != "frames"]
    pd.testing.assert_frame_equal(
        rows[before.columns].sort_values(order, ignore_index=True),
        before.sort_values(order, ignore_index=True),
        check_dtype=False,
    )


def test_without_a_truth_nothing_is_tried(files, tmp_path):
    outcome = run(files, tmp_path, truth=None)
    assert outcome.rows.empty
    assert not outcome.left_out
    assert outcome.reason == NO_TRUTH
    assert not outcome.fits


def test_with_the_truth_of_one_clip_nothing_is_tried(files, tmp_path):
    (files.folder / "one").mkdir()
    own = files.frames[files.frames["clip_id"] == files.clips["clip_id"][0]]
    tables.write(tables.FRAMES, own, files.folder / "one" / "frames.parquet")
    outcome = run(files, tmp_path, truth="one")
    assert outcome.rows.empty
    assert outcome.reason == ONE_CLIP
    assert not outcome.fits


def test_channels_that_tell_nothing_are_the_reason(files, tmp_path):
    brows = [name for name in files.motion if name.startswith("brow")]
    outcome = run(files, tmp_path, files.motion.assign(**dict.fromkeys(brows, np.nan)))
    assert outcome.rows.empty
    assert "not measured: brow" in outcome.reason
    assert outcome.left_out["clusters", "2"] == outcome.left_out["reference", "configured"]
    outcome = run(files, tmp_path, files.motion.assign(**dict.fromkeys(brows, 0.25)))
    assert outcome.rows.empty
    assert "never moves: brow" in outcome.reason
