"""The timeline of a text, by a language model where one is named, else by simple sentences."""

from fractions import Fraction

from mimeline.directions import sentences
from mimeline.directions.asking import ask
from mimeline.directions.endpoint import Endpoint
from mimeline.reporting import words
from mimeline.timeline.clock import nearest_frame
from mimeline.timeline.timeline import Timeline


def timeline_of(
    text: str, endpoint: Endpoint | None, fps: Fraction, seconds: Fraction | None, clip_id: str
) -> tuple[Timeline, list[str]]:
    """The timeline that a text asks for, and what was mended in an endpoint's answer, a line each.

    seconds: how long the clip is; None: as the text, or the endpoint, would have it. Raises
    NotUnderstood, NoAnswer, NoTimeline.
    """
    n_frames = None if seconds is None else max(1, nearest_frame(seconds, fps))
    if endpoint is None:
        return sentences.read(text, fps, n_frames, clip_id)[0], []
    answer = ask(endpoint, text, fps, n_frames, clip_id)
    return answer.timeline, list(answer.repairs)


def in_words(timeline: Timeline) -> str:
    """What happens, in order of time: Smile 1–2 s, GazeLeft 2.27–3.77 s."""
    fps = float(timeline.fps)
    parts = [
        f"{own.action}{f' {own.side}' if own.side else ''} "
        f"{round(own.start / fps, 2):g}–{round(own.end / fps, 2):g} s"
        for own in sorted(timeline, key=lambda own: own.start)
    ]
    return words.listing(parts) or "nothing, a face at rest"
