"""How hard the toy world is: macro-F1 of frame-wise baselines with oracle names, over seeds.

python benchmarks/toy_difficulty.py [--people 40] [--clips 120] [--seeds 7 1 2 3]

gmm: eight full-covariance Gaussians on single frames, each named by its frames' majority class.
median: the same on channels smoothed by a median over nine frames of the clip. clean: the same on
the channels before tracker noise. threshold: closure, gaze and head at the default limits. Lid is
scored on frames whose eye is not closed.
"""

import argparse

import numpy as np
import pandas as pd
from scipy.ndimage import median_filter
from sklearn.metrics import f1_score
from sklearn.mixture import GaussianMixture

from mimeline.config.sections import Annotate
from mimeline.toy import World, simulate
from mimeline.vocabulary import SERIES_REGIONS, series_actions, series_channels, track_actions

COMPONENTS, MEDIAN_FRAMES = 8, 9
ANGLES = {
    "gaze_h": ("gaze_left", 1),
    "gaze_v": ("gaze_up", 1),
    "head_h": ("head_yaw_left", 1),
    "head_v": ("head_pitch_up", 1),
}


def classes(frames: pd.DataFrame, actions: tuple[str, ...]) -> np.ndarray:
    """0 for Neutral, k for the k-th action, (n,)."""
    return frames[list(actions)].to_numpy() @ np.arange(1, len(actions) + 1)


def gmm_score(values: np.ndarray, truth: np.ndarray, count: int) -> float:
    """Macro-F1 over Neutral and count actions. values (n, channels), truth (n,)."""
    model = GaussianMixture(COMPONENTS, covariance_type="full", random_state=0)
    component = model.fit_predict(values)  # (n,)
    votes = np.zeros((COMPONENTS, count + 1))
    np.add.at(votes, (component, truth), 1)
    found = votes.argmax(axis=1)[component]  # (n,)
    return f1_score(truth, found, labels=range(count + 1), average="macro", zero_division=0)


def smoothed(motion: pd.DataFrame, channels: list[str]) -> np.ndarray:
    parts = [
        median_filter(clip.to_numpy(), size=(MEDIAN_FRAMES, 1), mode="nearest")
        for _, clip in motion.groupby("clip_id", sort=True)[channels]
    ]
    return np.concatenate(parts)  # (n, channels)


def region_scores(world: World, region: str) -> dict[str, float]:
    channels, actions = list(series_channels(region, "left")), series_actions(region)
    truth, counted = classes(world.frames, actions), np.ones(len(world.frames), dtype=bool)
    if region == "eye":
        counted = ~world.frames["EyeClose"].to_numpy()
    inputs = {
        "gmm": world.motion[channels].to_numpy(),
        "median": smoothed(world.motion, channels),
        "clean": world.clean[channels].to_numpy(),
    }
    return {n: gmm_score(v[counted], truth[counted], len(actions)) for n, v in inputs.items()}


def threshold_scores(world: World) -> dict[str, float]:
    limits = Annotate()
    blink = world.motion[["eyeBlinkLeft", "eyeBlinkRight"]].to_numpy().mean(axis=1)
    closed = world.frames["EyeClose"].to_numpy()
    scores = {"closure": f1_score(closed, blink > limits.closed, average="macro")}
    for track, (channel, sign) in ANGLES.items():
        limit = np.radians(limits.gaze_deg if track.startswith("gaze") else limits.head_deg)
        angle = sign * world.motion[channel].to_numpy()
        found = np.where(angle > limit, 1, np.where(angle < -limit, 2, 0))
        truth = classes(world.frames, track_actions(track))
        scores[track] = f1_score(truth, found, average="macro")
    return scores


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--people", type=int, default=40)
    parser.add_argument("--clips", type=int, default=120)
    parser.add_argument("--seeds", type=int, nargs="+", default=[7, 1, 2, 3])
    options = parser.parse_args()
    for seed in options.seeds:
        world = simulate(options.people, options.clips, seed)
        for region in SERIES_REGIONS:
            scores = region_scores(world, region)
            cells = "  ".join(f"{name} {value:.3f}" for name, value in scores.items())
            print(f"seed {seed:<4} {region:<6} {cells}", flush=True)
        cells = "  ".join(
            f"{track} {value:.3f}" for track, value in threshold_scores(world).items()
        )
        print(f"seed {seed:<4} threshold  {cells}", flush=True)


if __name__ == "__main__":
    main()
