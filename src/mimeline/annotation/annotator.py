"""Annotates motion that the clusters were not fitted on: unseen clips, generated motion."""

from collections.abc import Mapping

import pandas as pd

from mimeline.annotation.annotate import annotate_frames
from mimeline.annotation.region_model import RegionModel
from mimeline.annotation.thresholds import Limits


class Annotator:
    """models: by series region; labels: the `labels` table that names their clusters."""

    def __init__(self, models: Mapping[str, RegionModel], labels: pd.DataFrame, limits: Limits):
        self.models, self.labels, self.limits = models, labels, limits

    def clusters(self, motion: pd.DataFrame) -> dict[str, pd.DataFrame]:
        """The `clusters` table of each region for motion, sorted by clip_id and frame."""
        valid = motion[motion["valid"].astype(bool)]
        return {region: model.decode(valid) for region, model in self.models.items()}

    def frames(self, motion: pd.DataFrame) -> pd.DataFrame:
        """The `frames` table of motion, a `motion` table sorted by clip_id and frame."""
        return annotate_frames(motion, self.clusters(motion), self.labels, self.limits)
