from fractions import Fraction

import pytest

from mimeline.directions.endpoint import Endpoint
from mimeline.directions.sentences import NotUnderstood
from mimeline.directions.text import in_words, timeline_of
from mimeline.timeline.timeline import Interval, Timeline

from .serving import GOOD, chat, serving

FPS = Fraction(25)


def test_without_an_endpoint_simple_sentences_are_read():
    timeline, repairs = timeline_of("smile from 1 s to 2 s", None, FPS, None, "me")
    assert in_words(timeline) == "Smile 1–2 s" and not repairs
    assert timeline.clip_id == "me" and timeline.seconds == 3
    assert timeline_of("smile", None, FPS, Fraction(5, 2), "me")[0].n_frames == 63
    with pytest.raises(NotUnderstood):
        timeline_of("she remembers her youth", None, FPS, None, "me")


def test_with_an_endpoint_any_text_is_sent_there_and_repairs_come_back():
    with serving(chat(f"Here: {GOOD}".replace("'", '"'))) as served:
        endpoint = Endpoint(served.address, "m")
        timeline, repairs = timeline_of("her youth", endpoint, FPS, None, "me")
    assert in_words(timeline) == "Smile 0.52–1.52 s"
    assert repairs == ["text around the JSON left out"]


def test_a_timeline_is_told_in_order_of_time():
    tracks = {
        "brow": [Interval("BrowUp", 25, 50, side="left")],
        "mouth": [Interval("Smile", 5, 10), Interval("MouthFrown", 30, 40)],
    }
    told = in_words(Timeline("x", FPS, 75, tracks))
    assert told == "Smile 0.2–0.4 s, BrowUp left 1–2 s and MouthFrown 1.2–1.6 s"
    assert in_words(Timeline("x", FPS, 75, {"mouth": []})) == "nothing, a face at rest"
