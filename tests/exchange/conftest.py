"""The command line in this process, a run of three clips, and one that has come to split."""

import json
import shutil
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.annotate import intervals_of
from mimeline.dataset.statistics import statistics
from mimeline.ledger import Ledger
from mimeline.vocabulary import CHANNELS

N_FRAMES, FPS = 90, 30
KEPT = ["-good_0", "good_1", "other_0"]


@pytest.fixture
def run(mimeline, monkeypatch, tmp_path):
    """Runs `mimeline timeline` with arguments, in a folder of its own: code, out, err."""
    monkeypatch.chdir(tmp_path)
    return partial(mimeline, "timeline")


@pytest.fixture(scope="session")
def finished(tmp_path_factory) -> Path:
    """Results up to annotate: three clips that were kept, the first with a film, one dropped."""
    results = tmp_path_factory.mktemp("finished") / "results"
    ids = [*KEPT, "turned_0"]
    blank = dict.fromkeys(tables.CLIPS.schema.names) | {"start_s": 0.0, "end_s": 3.0, "shard": 0}
    blank |= {"fps_num": FPS, "fps_den": 1, "n_frames": N_FRAMES}
    blank |= {name: [] for name in ("actions", "emotions", "attributes", "texts")}
    clips = pd.DataFrame([blank | {"clip_id": i, "source_id": i.split("_")[0]} for i in ids])
    film = results / "fetch" / "00" / "media" / "-good_0.mp4"
    film.parent.mkdir(parents=True)
    film.write_bytes(b"")
    clips["media"] = [str(film), None, None, None]
    for stage in ("catalogue", "fetch", "pose"):
        passed = clips[clips["clip_id"].isin(KEPT)] if stage == "pose" else clips
        ledger = Ledger(stage, clips["clip_id"])
        if stage == "pose":
            ledger.drop("turned_0", "turned", value=41.0, limit=35.0, unit="deg")
        tables.write(tables.CLIPS, passed, results / stage / "00" / "clips.parquet")
        folder = results / stage if stage == "catalogue" else results / stage / "00"
        ledger.close(folder / "ledger.parquet", passed["clip_id"])
    frames = pd.concat([_frames(clip_id) for clip_id in KEPT], ignore_index=True)
    folder = results / "annotate" / "00"
    tables.write(tables.FRAMES, frames, folder / "frames.parquet")
    tables.write(tables.INTERVALS, intervals_of(frames, {}), folder / "intervals.parquet")
    return results


def _frames(clip_id: str, n_frames: int = N_FRAMES) -> pd.DataFrame:
    frame = np.arange(n_frames)
    marks = dict.fromkeys(tables.FRAMES.schema.names[2:], False)
    marks |= {"BrowUp": (frame >= 12) & (frame < 40), "Smile": frame >= 60}
    marks |= {"GazeLeft": pd.NA, "GazeRight": pd.NA}
    rows = pd.DataFrame({"clip_id": clip_id, "frame": frame}).assign(**marks)
    return rows.astype(dict.fromkeys(marks, "boolean"))[tables.FRAMES.schema.names]


# clip → shard, part, frames and rate; the ids begin as no option and no path may
DIVIDED = {
    "-good_0": (0, "train", 90, (30, 1)),
    "good_1": (0, "train", 75, (30, 1)),
    "other_0": (0, "val", 60, (30000, 1001)),
    "gap_0": (1, "train", 80, (25, 1)),
    "mute_0": (1, "train", 50, (25, 1)),
}
LOST = {"broken_0": ("ingest", "unreadable"), "turned_0": ("pose", "turned")}
TEXTS = {
    "-good_0": ["He smiles | nods, 2 times: #1/2", "He smiles | nods, 2 times: #1/2"],
    "other_0": ["Élodie\nlooks <up>"],
}
SENTENCE = "The person smiles."


@pytest.fixture(scope="session")
def divided_once(tmp_path_factory) -> Path:
    """Results up to split: five clips in two shards, of which two were lost on the way.

    tongueOut is measured nowhere and cheekPuff not in gap_0, which lacks a face in three frames;
    mute_0 has no text; no clip is for testing.
    """
    results = tmp_path_factory.mktemp("divided") / "results"
    ids = [*DIVIDED, *LOST]
    blank = dict.fromkeys(tables.CLIPS.schema.names) | {"start_s": 1.0, "end_s": 4.0}
    rows = []
    for clip_id in ids:
        shard, _, n_frames, (num, den) = DIVIDED.get(clip_id, (0, "", 60, (30, 1)))
        lists = {name: [] for name in ("actions", "emotions", "attributes")}
        own = {"clip_id": clip_id, "source_id": clip_id.rpartition("_")[0], "shard": shard}
        rate = {"fps_num": num, "fps_den": den, "n_frames": n_frames}
        rows.append(blank | lists | own | rate | {"texts": TEXTS.get(clip_id, [])})
    clips = pd.DataFrame(rows).assign(
        subject_id=[f"p{i % 2}" for i in range(len(rows) - 1)] + [None]
    )
    for stage in ("catalogue", "select", "fetch", "ingest", "pose"):
        ledger = Ledger(stage, clips["clip_id"])
        for clip_id, (at, rule) in LOST.items():
            if at == stage:
                (ledger.drop if rule == "turned" else ledger.fail)(clip_id, rule)
        clips = clips[clips["clip_id"].isin(ledger.kept)]
        for shard in (0, 1):
            own = clips[clips["shard"] == shard]
            tables.write(tables.CLIPS, own, results / stage / f"{shard:02d}" / "clips.parquet")
        ledger.close(results / stage / "ledger.parquet", clips["clip_id"])
    _moved(results)
    _parted(results, clips)
    config = {"data_dir": None, "catalogue": {"format": "celebvtext"}}
    config["ingest"] = {"format": "livelink"}
    _write_run(results, config)
    return results


@pytest.fixture
def divided(divided_once, tmp_path):
    """Makes a copy of that run; told: what its configuration says instead. → its results."""

    def copy(**told) -> Path:
        results = tmp_path / "results"
        shutil.copytree(divided_once, results)
        config = json.loads((results / "run.json").read_text())["config"]
        _write_run(results, config | told)
        return results

    return copy


def _write_run(results: Path, config: dict) -> None:
    content = {"config": config, "files": [], "given": []}
    (results / "run.json").write_text(json.dumps(content))


def _moved(results: Path) -> None:
    """The tables with a row per frame, and where their channels come from."""
    for shard in (0, 1):
        ids = sorted(clip_id for clip_id, told in DIVIDED.items() if told[0] == shard)
        motion = pd.concat([_motion(clip_id) for clip_id in ids], ignore_index=True)
        frames = pd.concat([_frames(c, DIVIDED[c][2]) for c in ids], ignore_index=True)
        folder = results / "ingest" / f"{shard:02d}"
        tables.write(tables.MOTION, motion, folder / "motion.parquet")
        origins = pd.DataFrame({"channel": list(CHANNELS), "measured": True, "origin": "a column"})
        origins["quality"] = np.where(origins["channel"] == "cheekPuff", 0.4, np.nan)
        tongue = origins["channel"] == "tongueOut"
        origins.loc[tongue, ["measured", "origin"]] = False, "no column <tongue>"
        tables.write(tables.ORIGINS, origins, folder / "origins.parquet")
        folder = results / "annotate" / f"{shard:02d}"
        tables.write(tables.FRAMES, frames, folder / "frames.parquet")
        tables.write(tables.INTERVALS, intervals_of(frames, {}), folder / "intervals.parquet")


def _motion(clip_id: str) -> pd.DataFrame:
    n_frames = DIVIDED[clip_id][2]
    random = np.random.default_rng(len(clip_id))
    values = random.random((n_frames, len(CHANNELS)), dtype=np.float32)
    rows = pd.DataFrame(values, columns=list(CHANNELS)).assign(tongueOut=np.nan)
    told = {"clip_id": clip_id, "frame": np.arange(n_frames), "valid": True}
    rows = rows.assign(**told, confidence=0.5, tracker_loss=np.nan)
    if clip_id == "gap_0":
        rows.loc[10:12, list(CHANNELS)] = np.nan
        rows.loc[10:12, "valid"] = False
        rows["cheekPuff"] = np.nan
    return rows[tables.MOTION.schema.names]


def _parted(results: Path, clips: pd.DataFrame) -> None:
    """The tables of describe, label and split."""
    told = pd.DataFrame(
        [(c, "timeline", 0, SENTENCE) for c in DIVIDED if c not in ("mute_0",)],
        columns=tables.DESCRIPTIONS.schema.names,
    )
    tables.write(tables.DESCRIPTIONS, told, results / "describe" / "descriptions.parquet")
    parts = pd.DataFrame({"clip_id": list(DIVIDED)})
    parts["part"] = [told[1] for told in DIVIDED.values()]
    parts["group"] = [clip_id.rpartition("_")[0] for clip_id in DIVIDED]
    tables.write(tables.SPLIT, parts, results / "split" / "split.parquet")
    motion = pd.concat([_motion(c) for c, told in DIVIDED.items() if told[1] == "train"])
    tables.write(tables.STATISTICS, statistics(motion), results / "split" / "statistics.parquet")
    Ledger("split", clips["clip_id"]).close(results / "split" / "ledger.parquet", list(DIVIDED))
