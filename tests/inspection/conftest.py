"""A run's results, made by the stages themselves from a catalogue of a few clips."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.clips.pose import pose
from mimeline.clips.select import select
from mimeline.ledger import Ledger

FPS = 30
OPTIONS = {
    "min_s": 5.0,
    "max_s": 10.0,
    "min_side_px": 512,
    "excluded_actions": ["turn"],
    "conditions": [],
    "max_overlap": 0.5,
    "exclusions": None,
}
TURN = [{"name": "turn", "start_s": 1.0, "end_s": 2.0, "uncertainty_s": 1.0}]
CLIPS = [
    {"clip_id": "good_0", "source_id": "good", "width": 600, "height": 700, "emotion": "happy"},
    {"clip_id": "good_1", "source_id": "good", "start_s": 20.0, "end_s": 29.0},
    {"clip_id": "good_1b", "source_id": "good", "start_s": 20.0, "end_s": 29.0},
    {"clip_id": "-long", "source_id": "l", "end_s": 12.7},
    {"clip_id": "short", "source_id": "s", "end_s": 3.4},
    {"clip_id": "turning", "source_id": "t", "actions": TURN},
    {"clip_id": "small", "source_id": "u", "width": 300, "height": 300},
    {"clip_id": "looks_away", "source_id": "v"},
    {"clip_id": "lost", "source_id": "w"},
]
YAW_DEG = {"good_0": 10.0, "good_1": 25.0, "looks_away": 41.2}


@pytest.fixture(scope="session")
def run_results(tmp_path_factory) -> Path:
    """Results up to pose: ten records, one unsafe; five of the others break a rule of select."""
    results = tmp_path_factory.mktemp("run") / "results"
    first = results / "catalogue" / "00" / "clips.parquet"
    tables.write(tables.CLIPS, _clips(), first)
    catalogue = Ledger("catalogue", [*(row["clip_id"] for row in CLIPS), "good_0#2"])
    catalogue.fail("good_0#2", "repeated_id", detail="the second record of that id")
    catalogue.close(results / "catalogue" / "ledger.parquet", catalogue.kept)
    for stage in ("select", "fetch", "ingest", "pose"):
        (results / stage / "00").mkdir(parents=True)
    select(first, *_out(results, "select"), **OPTIONS)
    _pass_on(results, "select", "fetch", {"lost": ("gone", "a removed video")})
    _pass_on(results, "fetch", "ingest", {})
    tables.write(tables.MOTION, _motion(), results / "ingest" / "00" / "motion.parquet")
    pose(
        results / "ingest" / "00" / "clips.parquet",
        results / "ingest" / "00" / "motion.parquet",
        results,
        *_out(results, "pose"),
        format="motion",
        options={},
        max_yaw_deg=35.0,
    )
    return results


def _clips() -> pd.DataFrame:
    blank = dict.fromkeys(tables.CLIPS.schema.names) | {"start_s": 0.0, "end_s": 6.0, "shard": 0}
    rows = [blank | {"actions": []} | row for row in CLIPS]
    return pd.DataFrame([row | {"emotions": [], "attributes": [], "texts": []} for row in rows])


def _out(results: Path, stage: str) -> tuple[Path, Path]:
    return tuple(results / stage / "00" / f"{name}.parquet" for name in ("clips", "ledger"))


def _pass_on(results: Path, before: str, stage: str, failed: dict[str, tuple[str, str]]) -> None:
    """A stage that fails some clips and hands the others on with their frames."""
    clips = tables.read(tables.CLIPS, results / before / "00" / "clips.parquet")
    ledger = Ledger(stage, clips["clip_id"])
    for clip_id, (rule, detail) in failed.items():
        ledger.fail(clip_id, rule, detail=detail)
    clips = clips[clips["clip_id"].isin(ledger.kept)]
    frames = ((clips["end_s"] - clips["start_s"]) * FPS).round().astype(int)
    path, decisions = _out(results, stage)
    tables.write(tables.CLIPS, clips.assign(n_frames=frames, fps_num=FPS, fps_den=1), path)
    ledger.close(decisions, clips["clip_id"])


def _motion() -> pd.DataFrame:
    """Heads that turn to their largest angle in frames 60-89."""
    parts = []
    for clip_id, most in YAW_DEG.items():
        yaw = np.radians(np.where(np.arange(180) // 30 == 2, most, 1.0))
        frames = {"clip_id": clip_id, "frame": np.arange(180), "valid": True, "head_yaw_left": yaw}
        parts.append(pd.DataFrame(frames))
    return pd.concat(parts).reindex(columns=tables.MOTION.schema.names)
