"""The command line in this process, and a finished run of three clips."""

from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mimeline import tables
from mimeline.annotation.annotate import intervals_of
from mimeline.ledger import Ledger

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


def _frames(clip_id: str) -> pd.DataFrame:
    frame = np.arange(N_FRAMES)
    marks = dict.fromkeys(tables.FRAMES.schema.names[2:], False)
    marks |= {"BrowUp": (frame >= 12) & (frame < 40), "Smile": frame >= 60}
    marks |= {"GazeLeft": pd.NA, "GazeRight": pd.NA}
    rows = pd.DataFrame({"clip_id": clip_id, "frame": frame}).assign(**marks)
    return rows.astype(dict.fromkeys(marks, "boolean"))[tables.FRAMES.schema.names]
