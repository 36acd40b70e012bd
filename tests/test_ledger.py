import pytest

from mimeline import tables
from mimeline.ledger import Ledger


def test_every_clip_has_exactly_one_decision(tmp_path):
    ledger = Ledger("select", ["a", "b", "c", "d"])
    ledger.drop("b", "too_short", value=3.0, limit=5.0, unit="s")
    ledger.fail("c", "unreadable", detail="no")
    ledger.note("d", "masked", first_frame=1, last_frame=2)
    ledger.close(tmp_path / "ledger.parquet", kept=["a", "d"])
    rows = tables.read(tables.LEDGER, tmp_path / "ledger.parquet").set_index("clip_id")
    assert rows["status"].to_dict() == {"a": "kept", "b": "dropped", "c": "failed", "d": "kept"}
    assert rows.loc["b", "value"] == 3.0
    assert rows.loc["d", "last_frame"] == 2
    assert str(ledger) == "4 clips in, 2 kept, 1 dropped, 1 failed (too_short 1, unreadable 1)"


def test_a_clip_that_vanishes_is_an_error(tmp_path):
    ledger = Ledger("select", ["a", "b"])
    with pytest.raises(AssertionError, match=r"\['b'\]"):
        ledger.close(tmp_path / "ledger.parquet", kept=["a"])


def test_a_clip_that_never_came_in_is_an_error():
    with pytest.raises(AssertionError, match="never came in"):
        Ledger("select", ["a"]).drop("x", "too_short")


def test_two_decisions_on_a_clip_are_an_error():
    ledger = Ledger("select", ["a"])
    ledger.drop("a", "too_short")
    with pytest.raises(AssertionError, match="twice"):
        ledger.fail("a", "unreadable")


def test_a_kept_clip_has_a_row_for_each_note_and_a_lost_one_only_its_reason(tmp_path):
    ledger = Ledger("ingest", ["a", "b"])
    for clip in ("a", "b"):
        ledger.note(clip, "masked", first_frame=3)
        ledger.note(clip, "frozen")
    ledger.drop("b", "tracking_lost")
    ledger.close(tmp_path / "ledger.parquet", kept=["a"])
    rows = tables.read(tables.LEDGER, tmp_path / "ledger.parquet")
    assert rows.groupby("clip_id")["rule"].apply(list).to_dict() == {
        "a": ["frozen", "masked"],
        "b": ["tracking_lost"],
    }
