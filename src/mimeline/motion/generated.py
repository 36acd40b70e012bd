"""Motion that a trained model makes of timelines, with all that is to be known of it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from mimeline.errors import MimelineError
from mimeline.generation.timeline import Sampling, generate
from mimeline.inspection.take import POOR
from mimeline.motion.motion import Motion
from mimeline.motion.resampling import at_rate, resampled
from mimeline.timeline.timeline import Timeline
from mimeline.tracking.take import Origin
from mimeline.training.checkpoint import Trained
from mimeline.vocabulary import CHANNELS

MADE = "made by a model"


class TooLong(MimelineError):
    """A timeline is longer than what is to be made at once."""


def generated(
    trained: Trained,
    timelines: Sequence[Timeline],
    fps: Fraction | None,
    sampling: Sampling,
    seed: int,
    made: Mapping[str, Any],
) -> Iterator[Motion]:
    """The motion of each timeline, as long as it is.

    fps: rate of the motion; None: each timeline's own. The model is asked at the rate that it was
    trained at, and what it makes is brought to that one. made: what else is to be told of how the
    motions came about. A channel that the model does not have is not measured.
    """
    asked = [at_rate(timeline, trained.fps) for timeline in timelines]
    origins = origins_of(trained)
    told = {**made, "seed": seed, "sampling": dict(vars(sampling))}
    channels = trained.normaliser.channels
    for own, values in zip(timelines, generate(trained, asked, sampling, seed), strict=True):
        rate = fps or own.fps
        timeline = at_rate(own, rate)
        motion = Motion.of_channels(values, channels, trained.fps, origins, None, told)
        yield replace(resampled(motion, rate, timeline.n_frames), timeline=timeline)


def origins_of(trained: Trained) -> dict[str, Origin]:
    """How each channel of what a model makes is had: no surer than what it learnt it from."""
    origins = {}
    for channel in CHANNELS:
        learnt = trained.origins.get(channel, Origin(""))
        if channel not in trained.normaliser.channels:
            origins[channel] = Origin("not made by the model", measured=False)
        elif learnt.text:
            text = f"{MADE}, which learnt it from: {learnt.text}"
            origins[channel] = Origin(text, quality=learnt.quality)
        else:
            origins[channel] = Origin(MADE)
    return origins


def poor(trained: Trained) -> str:
    """The channels that a model learnt from poor ones, for people; empty where there are none."""
    known = {name: trained.origins.get(name) for name in trained.normaliser.channels}
    least = {name: own.quality for name, own in known.items() if own and own.quality is not None}
    named = [f"{name} ({quality:.2g})" for name, quality in least.items() if quality < POOR]
    return f"learnt with a quality below {POOR}: {', '.join(named)}" if named else ""


def refuse_long(timelines: Sequence[Timeline], trained: Trained) -> None:
    """Raise TooLong for a timeline that is longer than the windows that a model learnt from."""
    for timeline, frames, window in _longer(timelines, trained):
        raise TooLong(
            f"clip {timeline.clip_id}",
            found=f"{frames} frames ({timeline.seconds:g} s) at the model's rate",
            expected=f"at most {window}, the window that it was trained on",
            remedy="Leave --one-window out: it is then made in windows that overlap.",
        )


def in_windows(timelines: Sequence[Timeline], trained: Trained) -> str:
    """What is to be known of timelines that a model makes in windows; empty where it makes none."""
    longer = [*_longer(timelines, trained)]
    if not longer:
        return ""
    window = trained.train["window"]
    seconds = float(window / trained.fps)
    which = "" if len(timelines) == 1 else f"{len(longer)} of {len(timelines)} "
    return (
        f"{which}longer than the {window} frames ({seconds:.2g} s) that the model was "
        "trained on: made in windows that overlap"
    )


def _longer(timelines: Sequence[Timeline], trained: Trained) -> Iterator[tuple[Timeline, int, int]]:
    """Timelines that are longer than a model's window, their frames at its rate, the window's."""
    window = trained.train["window"]
    for timeline in timelines:
        frames = at_rate(timeline, trained.fps).n_frames
        if frames > window:
            yield timeline, frames, window
