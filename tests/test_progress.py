import logging

from mimeline import progress
from mimeline.progress import told

log = logging.getLogger("mimeline.test")


def test_every_item_comes_and_long_work_says_what_is_left(monkeypatch, caplog):
    clock = iter(range(0, 1000, 10))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(clock)))
    with caplog.at_level(logging.INFO, logger="mimeline.test"):
        assert list(told("abcd", "clips", log)) == list("abcd")
    assert caplog.messages[0] == "2 of 4 clips, about 20 s left"


def test_short_work_is_silent(caplog):
    with caplog.at_level(logging.INFO, logger="mimeline.test"):
        assert list(told([1, 2], "clips", log)) == [1, 2]
    assert caplog.messages == []
