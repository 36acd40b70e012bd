"""A run that is stopped at random moments and resumed gives what an undisturbed one gives."""

import os
import random
import signal
import subprocess

import pyarrow.parquet as pq

KILLS = int(os.environ.get("MIMELINE_KILLS", "3"))
SECONDS = (1.0, 11.0)  # from snakemake's start to the signal
TAKEN = {"seconds"}  # a column that no two runs have in common


def test_a_run_that_is_killed_and_resumed_gives_the_same_tables(toy_run, checkout):
    reference, results = toy_run.root / "results", checkout.root / "results"
    moment = random.Random(KILLS)
    for number in range(KILLS):
        process = checkout.start()
        try:
            process.wait(timeout=moment.uniform(*SECONDS))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL if number % 2 else signal.SIGINT)
            process.wait(timeout=120)
        assert_same_tables(results, reference)  # those that are there are whole
        assert checkout.run("--unlock").returncode == 0
    done = checkout.run()
    assert done.returncode == 0, done.stdout + done.stderr
    assert tables_in(results) == tables_in(reference)
    assert_same_tables(results, reference)
    weights = "train/timeline/checkpoint/model.safetensors"
    assert (results / weights).read_bytes() == (reference / weights).read_bytes()


def assert_same_tables(results, reference):
    for name in tables_in(results):
        tables = [pq.read_table(folder / name) for folder in (results, reference)]
        found, expected = (t.drop_columns(list(TAKEN & {*t.column_names})) for t in tables)
        assert found.equals(expected), name


def tables_in(results) -> set[str]:
    found = {path.relative_to(results) for path in results.rglob("*.parquet")}
    return {str(path) for path in found if not any(part.startswith(".") for part in path.parts)}
