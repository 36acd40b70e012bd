from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from mimeline import tables
from mimeline.config.sections import TimelineModel
from mimeline.training.train import train
from mimeline.vocabulary import ACTIONS, CHANNELS

OPTIONS = TimelineModel(
    window=16,
    width=16,
    heads=2,
    base_layers=1,
    branch_layers=1,
    diffusion_steps=100,
    steps=60,
    batch=8,
    learning_rate=3e-3,
    ema=0.9,
).model_dump()


@dataclass(frozen=True)
class Tables:
    """Files of a world where the brow is up in every other ten frames, and its channels obey."""

    motion: Path
    frames: Path
    clips: Path
    origins: Path
    split: Path
    statistics: Path

    def train(
        self, checkpoint: Path, state=None, tensorboard=None, hardware=None, **changes
    ) -> Path:
        train(
            model="timeline",
            motions=[self.motion],
            frames=[self.frames],
            clips=[self.clips],
            origins=[self.origins],
            split=self.split,
            statistics=self.statistics,
            checkpoint=checkpoint,
            options=OPTIONS | changes,
            hardware=hardware or {"device": "cpu"},
            state=state,
            tensorboard=tensorboard,
        )
        return checkpoint


def write_tables(
    folder: Path, lengths: dict[str, int], fps: dict[str, int] | None = None
) -> Tables:
    rng = np.random.default_rng(0)
    keys = [(clip, i) for clip, length in lengths.items() for i in range(length)]
    frames = pd.DataFrame(keys, columns=["clip_id", "frame"])
    up = frames["frame"] // 10 % 2 == 1
    motion = frames.assign(
        valid=True,
        browInnerUp=np.where(up, 0.9, 0.1) + rng.normal(0, 0.02, len(frames)),
        jawOpen=0.5 + rng.normal(0, 0.02, len(frames)),
        head_yaw_left=np.where(up, 0.3, -0.3) + rng.normal(0, 0.02, len(frames)),
    ).reindex(columns=tables.MOTION.schema.names)
    frames = frames.assign(**{name: up if name == "BrowUp" else False for name in ACTIONS})
    values = motion[list(CHANNELS)].astype(float)
    statistics = pd.DataFrame(
        {
            "channel": list(CHANNELS),
            "measured": values.notna().mean().fillna(0.0).to_numpy(),
            "mean": values.mean().to_numpy(),
            "std": values.std().to_numpy(),
            "low": values.min().to_numpy(),
            "high": values.max().to_numpy(),
        }
    )
    unknown = dict.fromkeys(tables.CLIPS.schema.names)
    told = {"start_s": 0.0, "end_s": 1.0, "fps_den": 1, "shard": 0}
    told |= {name: [] for name in ("actions", "emotions", "attributes", "texts")}
    clips = pd.DataFrame(
        [
            unknown | told | {"clip_id": c, "source_id": c, "fps_num": (fps or {}).get(c, 30)}
            for c in lengths
        ],
        columns=tables.CLIPS.schema.names,
    )
    part = ["val" if clip.startswith("val") else "train" for clip in lengths]
    split = pd.DataFrame({"clip_id": list(lengths), "part": part, "group": list(lengths)})
    found = Tables(*(folder / f"{name}.parquet" for name in Tables.__annotations__))
    tables.write(tables.MOTION, motion, found.motion)
    tables.write(tables.FRAMES, frames, found.frames)
    tables.write(tables.CLIPS, clips, found.clips)
    had = {"measured": values.notna().any().to_numpy(), "origin": "a table", "quality": np.nan}
    origins = pd.DataFrame({"channel": list(CHANNELS)} | had)
    origins.loc[origins["channel"] == "jawOpen", "quality"] = 0.8
    tables.write(tables.ORIGINS, origins, found.origins)
    tables.write(tables.SPLIT, split, found.split)
    tables.write(tables.STATISTICS, statistics, found.statistics)
    return found


@pytest.fixture(scope="session", autouse=True)
def one_thread():
    """Threads only wait for each other on models this small."""
    torch.set_num_threads(1)


@pytest.fixture(scope="session")
def world(tmp_path_factory) -> Tables:
    return write_tables(
        tmp_path_factory.mktemp("world"), {"one": 60, "two": 45, "short": 9, "val": 40}
    )


@pytest.fixture
def other_world(tmp_path) -> Tables:
    return write_tables(tmp_path, {"one": 61, "two": 45, "short": 9, "val": 40})


@pytest.fixture
def of_two_rates(tmp_path) -> Tables:
    rates = {"one": 25, "two": 60, "three": 25, "val": 60}
    return write_tables(tmp_path, dict.fromkeys(rates, 20), rates)


@pytest.fixture(scope="session")
def trained(world, tmp_path_factory) -> Path:
    """A checkpoint that learnt for a second; not to be written to."""
    return world.train(tmp_path_factory.mktemp("trained") / "timeline")


@pytest.fixture
def empty(tmp_path) -> Path:
    """The checkpoint of a training without a training clip."""
    return write_tables(tmp_path, {"val": 40}).train(tmp_path / "timeline")


@pytest.fixture
def unvalidated(tmp_path) -> Path:
    """The checkpoint of two steps without a validation clip."""
    return write_tables(tmp_path, {"one": 30}).train(tmp_path / "timeline", steps=2)


@pytest.fixture
def bare(tmp_path) -> Path:
    """The checkpoint of a training on tables without a row."""
    return write_tables(tmp_path, {}).train(tmp_path / "timeline")
