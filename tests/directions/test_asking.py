"""A language model behind an address: what it is asked, and what becomes of any answer."""

import time
from fractions import Fraction

import pytest

from mimeline.directions import endpoint as endpoints
from mimeline.directions.asking import NoTimeline, ask
from mimeline.directions.endpoint import Endpoint, NoAnswer
from mimeline.vocabulary import ACTIONS

from .serving import GOOD, babble, chat, drip, hang_up, reply, serving

FPS = Fraction(25)
ADDRESSES = ["localhost:11434", "file:///etc/passwd", "http://", "", "x", "http://h:99999/v1"]
ADDRESSES += ["http://h:x/v1", "http://me:secret@h/v1", "http://[::1/v1", "http://h/v1?key=secret"]
KEY = "sk-very-secret"


def asked(served, text="she smiles", n_frames=None, key=KEY):
    return ask(Endpoint(served.address, "a-model", key), text, FPS, n_frames)


def test_a_model_is_asked_with_the_vocabulary_and_examples():
    with serving(chat(GOOD)) as served:
        answer = asked(served, n_frames=50)
    assert [(own.action, own.start, own.end) for own in answer.timeline] == [("Smile", 13, 38)]
    ((path, headers, body),) = served.asked
    assert path == "/v1/chat/completions"
    assert headers["Authorization"] == f"Bearer {KEY}"
    assert body["model"] == "a-model" and body["temperature"] == 0
    first, *middle, last = body["messages"]
    assert first["role"] == "system" and all(action in first["content"] for action in ACTIONS)
    assert last["content"] == "she smiles\nThe clip lasts 2 seconds."
    assert {message["role"] for message in middle} == {"user", "assistant"} and len(middle) >= 4
    assert KEY not in str(body)


def test_no_key_no_header():
    with serving(chat(GOOD)) as served:
        asked(served, key="")
    assert "Authorization" not in served.asked[0][1]


def test_the_examples_are_timelines_themselves():
    with serving(chat(GOOD)) as served:
        asked(served)
    for message in served.asked[0][2]["messages"]:
        if message["role"] == "assistant":
            with serving(chat(message["content"])) as example:
                assert not asked(example).repairs


def test_nonsense_is_sent_back_once_with_the_reason():
    with serving(chat("I would rather not."), chat(GOOD)) as served:
        assert len([*asked(served).timeline]) == 1
    again = served.asked[1][2]["messages"]
    assert again[-2] == {"role": "assistant", "content": "I would rather not."}
    assert "no JSON object" in again[-1]["content"]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("I would rather not.", "no JSON object"),
        ("", "no JSON object"),
        ('{"actions": [{"action": "Smile", "start_s": 0', "breaks off"),
        ("{" * 100_000, "breaks off or is none"),
        ('{"actions": ' + "[" * 100_000, "breaks off or is none"),
        ({"actions": [{"action": "Juggle", "start_s": 0, "end_s": 1}]}, "Juggle"),
        ({"actions": []}, "no action"),
        ({"actions": "Smile"}, 'no list "actions"'),
    ],
)
def test_an_answer_that_is_no_timeline_twice_is_given_up(content, reason):
    with serving(chat(content)) as served, pytest.raises(NoTimeline, match=reason) as caught:
        asked(served)
    assert len(served.asked) == 2 and "a-model" in str(caught.value)


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (b"<html>Welcome to nginx</html>", "no chat completion: <html>Welcome"),
        (b"", "no chat completion"),
        (b"[1, 2]", "no chat completion"),
        (b'{"choices": []}', "no chat completion"),
        (b'{"choices": [{"message": {"content": null}}]}', "a message without text"),
        (b'{"choices": [{"message": {"content": 7}}]}', "a message without text"),
        (b"[" * 200_000, "no chat completion"),
        (b"\xff\xfe\x00", "no chat completion"),
        (b" " * 10_000_000, "more than 2 MB"),
        (reply(401, b'{"error": "bad key"}'), "401 .*bad key.*MIMELINE_API_KEY"),
        (reply(401, f"not {KEY}".encode()), "401 .*not …"),
        (reply(403, b""), "403 .*MIMELINE_API_KEY"),
        (reply(404, b"no such model"), "404 .*ends in /v1"),
        (reply(429, b"slow down"), "429 .*try again later"),
        (reply(500, b"x" * 5000), r"500 .*x{200}….*server logs"),
        (hang_up, "no server that answers|no chat completion"),
        (babble, "no server that answers"),
    ],
)
def test_a_server_that_does_not_answer_as_one_is_told_in_a_line(answer, told):
    with serving(answer) as served, pytest.raises(NoAnswer, match=told) as caught:
        asked(served)
    message = str(caught.value)
    assert served.address in message and len(message) < 600 and "\n" not in message
    assert KEY not in message and len(served.asked) == 1


def test_a_redirect_is_not_followed_with_the_key():
    with serving(chat(GOOD)) as elsewhere:
        to = reply(302, b"", Location=f"{elsewhere.address}/chat/completions")
        with serving(to) as served, pytest.raises(NoAnswer, match="302"):
            asked(served)
        assert not elsewhere.asked


def test_a_key_is_never_shown_by_what_holds_it():
    assert KEY not in repr(Endpoint("http://localhost:1/v1", "m", KEY))


def test_a_server_that_is_down_or_silent_is_told(monkeypatch):
    with serving(chat(GOOD)) as served:
        pass
    with pytest.raises(NoAnswer, match=r"no server that answers .*leave --endpoint out"):
        asked(served)
    monkeypatch.setattr(endpoints, "TIMEOUT_S", 0.2)
    with serving(drip) as dripping, pytest.raises(NoAnswer, match="too slowly"):
        asked(dripping)
    with serving(lambda handler: time.sleep(1)) as slow, pytest.raises(NoAnswer, match="timed out"):
        asked(slow)


@pytest.mark.parametrize("address", ADDRESSES)
def test_an_address_that_is_none_is_told_before_anything_is_asked(address):
    with pytest.raises(NoAnswer, match="as http://localhost:11434/v1") as caught:
        Endpoint(address, "m")
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize("key", ["two\nlines", "schlüssel", "two words"])
def test_a_key_that_is_none_is_told_and_not_shown(key):
    with pytest.raises(NoAnswer, match="MIMELINE_API_KEY") as caught:
        Endpoint("http://localhost:1/v1", "m", key)
    assert key not in str(caught.value)
    assert Endpoint("http://localhost:1/v1", "m", " sk-1\n").key == "sk-1"


def test_an_empty_text_asks_nobody():
    with serving(chat(GOOD)) as served, pytest.raises(NoTimeline, match="an empty text"):
        asked(served, " \n")
    assert not served.asked
