"""How fast the timeline model makes motion, and whether few calls make it as well as many.

python benchmarks/sampling.py speed [--repeats 5] [--threads 2]
python benchmarks/sampling.py quality [--toy-seed 7] [--seeds 0 1 2] [--timelines 40] [--steps N]

speed: the paper's size (8 layers of 512: base 6, branches 2), untrained, makes 100 frames from a
timeline with guidance as configured: 20 calls of dpmpp_2m in float32 and bfloat16, the shortest of
several repeats, against the 1000 calls of ddpm, once. In brackets what guidance at every step would
take; ddpm has it at every step, as the paper's.

quality: a model of the default configuration, trained on 120 clips of the toy world from each seed,
makes motion for the first 100 frames of unseen clips, by 20 calls and by all 1000. SND of both, to
the real motion of these clips; their difference with a 95 % interval over the clips; velocity and
jerk of the 20-call motion by the 1000-step one's, and of both by the real one's. Last, over all
seeds: the mean of each, resampled over clips.
"""

import argparse
import time
from dataclasses import replace

import numpy as np
import torch

from mimeline.annotation.scores import resampled
from mimeline.config.sections import TimelineModel as Training
from mimeline.config.sections import TimelineSampling
from mimeline.dataset.statistics import statistics
from mimeline.dataset.windows import Normaliser, clips, timelines
from mimeline.evaluation.motion_scores import Moments, motion_draws, spread
from mimeline.generation.request import Request
from mimeline.generation.timeline import Sampling, sampled
from mimeline.models.timeline import TimelineModel
from mimeline.toy import simulate
from mimeline.training.families import FAMILIES
from mimeline.training.timeline import train_timeline
from mimeline.vocabulary import CHANNELS

FULL_SIZE = {"width": 512, "heads": 8, "base_layers": 6, "branch_layers": 2}
FRAMES, TRAINED, RESAMPLES, PEOPLE = 100, 120, 400, 40
OPTIONS = TimelineSampling().model_dump()
SAMPLING = Sampling(**{name: OPTIONS[name] for name in Sampling.__dataclass_fields__})
ARCHITECTURE = FAMILIES["timeline"].architecture


def model_of(channels, options) -> TimelineModel:
    return TimelineModel(channels, **{key: options[key] for key in ARCHITECTURE})


def seconds(model: TimelineModel, sampling: Sampling, repeats: int) -> float:
    """The shortest of several samplings of FRAMES frames."""
    request = Request.both_sides(np.zeros((FRAMES, 16)))
    taken = []
    for _ in range(repeats):
        began = time.perf_counter()
        sampled(model, [request], sampling, FRAMES, [(0, 0)])
        taken.append(time.perf_counter() - began)
    return min(taken)


def speed(repeats: int, threads: int) -> None:
    torch.set_num_threads(threads)
    options = Training(**FULL_SIZE).model_dump()
    model = model_of(list(CHANNELS), options).initialise(torch.Generator().manual_seed(0)).eval()
    size = sum(p.numel() for p in model.parameters()) / 1e6
    print(f"{size:.1f} million weights, {FRAMES} frames, {threads} threads", flush=True)
    calls = SAMPLING.sampler_steps
    always = replace(SAMPLING, guidance_interval=(0.0, 1.0))
    short: dict[str, float] = {}
    for precision in ("float32", "bfloat16"):
        own = model.to(getattr(torch, precision))
        short[precision], every = (seconds(own, s, repeats) for s in (SAMPLING, always))
        name = f"{SAMPLING.sampler}, {calls} calls, {precision}"
        print(
            f"{name:32}{short[precision]:8.2f} s ({every:.2f} s)"
            f"{FRAMES / short[precision]:8.0f} frames/s",
            flush=True,
        )
    model = model.to(torch.float32)
    steps = options["diffusion_steps"]
    whole = seconds(model, replace(always, sampler="ddpm", sampler_steps=steps), 1)
    ratio = whole / short["float32"]
    print(f"{f'ddpm, {steps} calls, float32':32}{whole:8.1f} s, {ratio:.0f} times as long")


def trained(seed: int, world, ids, steps: int | None):
    """The model of a seed, and the normaliser of these clips."""
    own = world.motion[world.motion["clip_id"].isin(ids)]
    normaliser = Normaliser.from_statistics(statistics(own))
    options = Training(seed=seed).model_dump() | ({"steps": steps} if steps else {})
    model = model_of(normaliser.channels, options)
    run = train_timeline(model, clips(own, world.frames, normaliser, ids), [], options)
    return run.average.eval().requires_grad_(False), normaliser, options["window"]


def quality(toy_seed: int, seeds: list[int], count: int, steps: int | None) -> None:
    torch.set_num_threads(1)
    world = simulate(PEOPLE, TRAINED + count, toy_seed)
    ids = [clip.clip_id for clip in world.clips]
    unseen = sorted(ids[TRAINED:])
    told = timelines(world.frames)
    requests = [Request.both_sides(told[i][:FRAMES]) for i in unseen]
    weights = resampled(count, RESAMPLES, np.random.default_rng(0))
    samplings = {"few": SAMPLING, "all": replace(SAMPLING, sampler="ddpm", sampler_steps=1000)}
    found: dict[str, list[np.ndarray]] = {}
    for seed in seeds:
        model, normaliser, window = trained(seed, world, ids[:TRAINED], steps)
        channels = list(normaliser.channels)
        real = Moments.of(
            [[world.motion.loc[world.motion["clip_id"] == i, channels].to_numpy()[:FRAMES]]
             for i in unseen]
        )  # fmt: skip
        made = {}
        for name, sampling in samplings.items():
            scores = sampled(model, requests, sampling, window, [(seed, i) for i in range(count)])
            made[name] = Moments.of([[normaliser.undo(own.numpy())] for own in scores])
        few, many = (motion_draws(made[name], real, weights) for name in samplings)
        between = motion_draws(made["few"], made["all"], weights)
        draws = {
            "SND of 20 calls": few["snd"],
            "SND of 1000 steps": many["snd"],
            "difference": few["snd"] - many["snd"],
            "velocity, 20 / 1000": between["velocity_ratio"],
            "jerk, 20 / 1000": between["jerk_ratio"],
            "velocity, 20 / real": few["velocity_ratio"],
            "velocity, 1000 / real": many["velocity_ratio"],
        }
        print(f"seed {seed}", flush=True)
        for name, own in draws.items():
            found.setdefault(name, []).append(own)
            tell(name, own)
    print(f"all {len(seeds)} seeds")
    for name, own in found.items():
        tell(name, np.mean(own, axis=0))


def tell(name: str, draws: np.ndarray) -> None:
    value, low, high = spread(draws)
    print(f"  {name:24}{value:9.4f}  ({low:.4f} to {high:.4f})", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    fast = commands.add_parser("speed")
    fast.add_argument("--repeats", type=int, default=5)
    fast.add_argument("--threads", type=int, default=2)
    good = commands.add_parser("quality")
    good.add_argument("--toy-seed", type=int, default=7)
    good.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    good.add_argument("--timelines", type=int, default=40)
    good.add_argument("--steps", type=int, help="of training; default: as configured")
    options = parser.parse_args()
    if options.command == "speed":
        speed(options.repeats, options.threads)
    else:
        quality(options.toy_seed, options.seeds, options.timelines, options.steps)
