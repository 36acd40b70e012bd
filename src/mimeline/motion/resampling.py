"""Motion and timelines at another rate."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
from scipy.interpolate import PchipInterpolator

from mimeline.motion.motion import Motion
from mimeline.timeline.clock import nearest_frame
from mimeline.timeline.timeline import Timeline
from mimeline.tracking.take import assemble


def resampled(motion: Motion, fps: Fraction, n_frames: int | None = None) -> Motion:
    """The motion at another rate, as long as it was; n_frames: where that is to the frame.

    Between frames it follows a curve that does not overshoot (Fritsch & Carlson 1980, PCHIP),
    through the frames that a channel is known in; a frame is valid, and a channel is known in it,
    where that holds for the frame that was shown at the time.
    """
    n = n_frames or max(1, nearest_frame(Fraction(len(motion)) / motion.fps, fps))
    if fps == motion.fps and n == len(motion):
        return motion
    frame = np.arange(n)
    at = frame * float(motion.fps / fps)  # (n,) in frames of the motion
    shown = np.minimum(at.astype(int), len(motion) - 1)
    channels = motion.frames[motion.moved].iloc[shown].reset_index(drop=True)
    for name in motion.moved:
        values = motion.frames[name].to_numpy(np.float64, na_value=np.nan)
        known = np.flatnonzero(np.isfinite(values))
        if len(known) > 1:
            inside = np.clip(at, known[0], known[-1])
            smooth = PchipInterpolator(known, values[known])(inside)
            channels[name] = np.where(channels[name].notna(), smooth, np.nan)
    valid = motion.frames["valid"].to_numpy(bool)[shown]
    sure = motion.frames["confidence"].to_numpy(np.float64, na_value=np.nan)[shown]
    timeline = motion.timeline and at_rate(motion.timeline, fps)
    frames = assemble(frame, valid, channels, sure, "motion")
    return replace(motion, frames=frames, fps=fps, timeline=timeline)


def at_rate(timeline: Timeline, fps: Fraction, n_frames: int | None = None) -> Timeline:
    """The timeline on the frames of another rate; n_frames: where its length is to the frame."""
    if fps == timeline.fps and n_frames in (None, timeline.n_frames):
        return timeline
    n = n_frames or max(1, nearest_frame(Fraction(timeline.n_frames) / timeline.fps, fps))

    def moved(frame: int) -> int:
        return min(n, nearest_frame(frame / timeline.fps, fps))

    tracks = {
        track: [
            replace(own, start=start, end=end)
            for own in intervals
            if (start := moved(own.start)) < (end := moved(own.end))
        ]
        for track, intervals in timeline.tracks.items()
    }
    return Timeline(timeline.clip_id, fps, n, tracks)
