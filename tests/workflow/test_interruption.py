"""A run that is stopped at random moments and resumed gives what an undisturbed one gives."""

from .whole_runs import assert_same_tables, tables_in


def test_a_run_that_is_killed_and_resumed_gives_the_same_tables(toy_run, killed_run):
    reference = toy_run.root / "results"
    assert tables_in(killed_run) == tables_in(reference)
    assert_same_tables(killed_run, reference)
    weights = "train/timeline/checkpoint/model.safetensors"
    assert (killed_run / weights).read_bytes() == (reference / weights).read_bytes()
