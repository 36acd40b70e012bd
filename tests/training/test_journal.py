import pytest

from mimeline.training import journal
from mimeline.training.journal import Journal


@pytest.fixture
def clock(monkeypatch):
    """A clock that a test sets: clock[0] seconds."""
    now = [0.0]
    monkeypatch.setattr(journal.time, "monotonic", lambda: now[0])
    return now


def steps(told: Journal, clock, first: int, last: int, each_s: float) -> None:
    for step in range(first, last + 1):
        clock[0] += each_s
        told.note(step, 0.31, 1.0, 1e-3, lambda: None)


def test_the_time_left_is_told_by_the_rate_of_late(clock, caplog):
    told = Journal(1000, None)
    with caplog.at_level("INFO"):
        steps(told, clock, 1, 100, 1.0)
        caplog.clear()
        steps(told, clock, 101, 500, 0.125)
    assert caplog.messages[-1] == "step 500 of 1000, loss 0.31, 8 steps/s, about 62 s left"


def test_a_resumed_training_tells_the_time_left_by_its_own_rate(clock, caplog):
    facts = {"rows": [[300, 0.4, None, 1e-3, 1.0, 600.0]], "recent": [], "seconds": 600.0}
    told = Journal(1000, None)
    with caplog.at_level("INFO"):
        told.resume(300, facts)
        steps(told, clock, 301, 400, 0.125)
    assert caplog.messages[0] == "resumed at step 300 of 1000"
    assert caplog.messages[-1].endswith("8 steps/s, about 78 s left")
    assert told.losses()["seconds"].iloc[-1] == pytest.approx(612.5)


def test_a_short_training_has_fifty_rows_and_a_long_one_a_row_each_250_steps(clock):
    brief, long = Journal(100, None), Journal(1_000_000, None)
    steps(brief, clock, 1, 100, 0.0)
    steps(long, clock, 1, 750, 0.0)
    assert len(brief.losses()) == 50
    assert long.losses()["step"].tolist() == [250, 500, 750]


def test_a_row_s_means_leave_out_what_was_too_large_for_float16():
    told, large = Journal(100, None), float("inf")  # a row each two steps
    for step, norm in enumerate((large, 3.0, 1.0, 3.0, large, large), start=1):
        told.note(step, step / 2, norm, 1e-3, lambda: None)
    assert [row[1] for row in told.rows] == [0.75, 1.75, 2.75]
    assert [row[4] for row in told.rows] == [3.0, 2.0, None]
