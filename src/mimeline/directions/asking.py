"""A language model asked for a timeline (Ma et al. 2025, 3.3), shown a few of ours first."""

import json
from collections.abc import Iterator
from fractions import Fraction

from mimeline.directions.answer import Answer, Refused, read
from mimeline.directions.endpoint import Endpoint
from mimeline.errors import MimelineError
from mimeline.vocabulary import ACTIONS, TRACKS, resource, track_actions

TRIES = 2


class NoTimeline(MimelineError):
    """A language model answered, but not with a timeline."""


def ask(
    endpoint: Endpoint, text: str, fps: Fraction, n_frames: int | None, clip_id: str = "text"
) -> Answer:
    """The timeline that a model makes of a text. An answer that is refused is sent back once, with
    the reason. Raises NoTimeline where the second is refused too or the text is empty; NoAnswer.
    """
    if not text.strip():
        raise NoTimeline(
            "the text",
            found="an empty text",
            expected="what the face is to do",
            remedy='Say it: --text "she remembers something and smiles".',
        )
    messages = [*_messages(text, None if n_frames is None else n_frames / fps)]
    for _ in range(TRIES):
        said = endpoint.answer(messages)
        try:
            return read(said, fps, n_frames, clip_id)
        except Refused as error:
            reason = str(error)
        messages += [
            _message("assistant", said),
            _message("user", f"That cannot be used: {reason}. Answer with the JSON object alone."),
        ]
    raise NoTimeline(
        endpoint.model,
        found=reason,
        expected="a timeline as JSON",
        remedy="Say it more simply, name a larger model, or leave --endpoint out and say it as "
        '"smile from 1 s to 2 s, then look left".',
    )


def _messages(text: str, seconds: Fraction | None) -> Iterator[dict[str, str]]:
    yield _message("system", _rules())
    examples = json.loads(resource("direction_examples.json").read_text(encoding="utf-8"))
    for example in examples:
        yield _message("user", example["text"])
        yield _message("assistant", json.dumps(example["answer"]))
    length = "" if seconds is None else f"\nThe clip lasts {float(seconds):g} seconds."
    yield _message("user", text + length)


def _rules() -> str:
    tracks = "\n".join(f"- {', '.join(track_actions(track))}" for track in TRACKS)
    return (
        "You turn a description of what a face does into a timeline of facial actions. "
        'Answer with one JSON object and nothing else: {"seconds": length of the clip, "actions": '
        '[{"action": name, "start_s": seconds, "end_s": seconds, "side": "left" or "right"}]}. '
        "Leave side out where both halves of the face act; sides, and left and right of gaze and "
        f"head, are the person's own. There are {len(ACTIONS)} actions, and those of a line "
        f"exclude each other at a time:\n{tracks}\n"
        "Everything else is neutral. People begin to look before they turn their head, expressions "
        "take a quarter of a second to come and longer to go, and a blink lasts 0.2 seconds. "
        "Speech, and what none of these actions is, is left out."
    )


def _message(role: str, content: str) -> dict[str, str]:
    return {"role": role, "content": content}
