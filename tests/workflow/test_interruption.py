"""A run that is stopped at random moments and resumed gives what an undisturbed one gives."""

import re

from .whole_runs import assert_same_tables, tables_in


def test_a_run_that_is_killed_and_resumed_gives_the_same_tables(killed_run):
    results, reference = killed_run
    assert tables_in(results) == tables_in(reference)
    assert_same_tables(results, reference)
    weights = "train/timeline/checkpoint/model.safetensors"
    assert (results / weights).read_bytes() == (reference / weights).read_bytes()


def test_a_training_that_is_killed_goes_on_from_its_last_save(killed_run):
    results, _ = killed_run
    said = (results / "logs" / "train" / "timeline.log").read_text(encoding="utf-8")
    assert re.search(r"resumed at step [1-9]", said), said
    assert not (results / "train" / "timeline.state").exists()
