"""A region's fitted TICC together with the channels that it takes, by name."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mimeline.annotation.fitted import (
    CHANNELS_FILE,
    FINGERPRINT_FILE,
    broken,
    is_fitted,
    read_channels,
)
from mimeline.annotation.series import sequences
from mimeline.ticc import TICC


@dataclass(frozen=True)
class RegionModel:
    """ticc: fitted on the columns `channels`, in that order."""

    ticc: TICC
    channels: tuple[str, ...]

    def decode(self, frames: pd.DataFrame) -> pd.DataFrame:
        """The `clusters` table of frames.

        frames: clip_id, frame and the channels, sorted; rows where a channel is missing are left
        out. A sequence ends where the clip or the count of frames breaks.
        """
        channels = list(self.channels)
        measured = frames.loc[frames[channels].notna().all(axis=1), ["clip_id", "frame", *channels]]
        points, lengths = sequences(measured)
        if points.empty:
            return points[["clip_id", "frame"]].assign(cluster=0, margin=0.0)
        labels, margins = self.ticc.decode(points[channels].to_numpy("float64"), lengths)
        return points[["clip_id", "frame"]].assign(
            cluster=labels.astype("int64"), margin=margins.astype(np.float32)
        )

    def save(self, folder: Path) -> None:
        """Write the model into a folder."""
        folder = Path(folder)
        self.ticc.save(folder)
        (folder / FINGERPRINT_FILE).write_text(self.ticc.fingerprint() + "\n", encoding="utf-8")
        names = json.dumps(list(self.channels), indent=2)
        (folder / CHANNELS_FILE).write_text(names + "\n", encoding="utf-8")

    @classmethod
    def load(cls, folder: Path) -> "RegionModel":
        """The model that `save` wrote. Raises BadFile where the folder holds none."""
        try:
            return cls(TICC.load(folder), read_channels(folder))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise broken(folder, error) from error


def read_models(folders: Mapping[str, Path]) -> dict[str, RegionModel]:
    """The fitted models by region; a region that could not be segmented is absent."""
    fitted = {region: folder for region, folder in folders.items() if is_fitted(folder)}
    return {region: RegionModel.load(folder) for region, folder in fitted.items()}
