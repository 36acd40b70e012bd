"""Other ways to cluster frames: planted states, several sequences, and a program of its own."""

import logging
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from sklearn.metrics import adjusted_rand_score

from mimeline.errors import BadConfig
from mimeline.evaluation import baselines
from mimeline.evaluation.baselines import (
    UNTRIED,
    by_clap,
    by_hidden_markov,
    by_mixture,
    drawn,
)

LEVELS = np.array([[0.1, 0.1], [0.6, 0.1], [0.1, 0.7]])


def planted(noise: float, sequences: int = 6, seed: int = 1):
    """X (T, 2), lengths (S,) and state (T,): stretches of 30 frames at one of three levels."""
    rng = np.random.default_rng(seed)
    order = [rng.permutation(np.tile(np.arange(3), 2)) for _ in range(sequences)]
    state = np.repeat(np.concatenate(order), 30)
    X = LEVELS[state] + rng.normal(0, noise, (len(state), 2))
    return X, np.full(sequences, 180), state


def stand_in(folder: Path, body: str) -> str:
    """Path of a program that is called as an interpreter is: -I SCRIPT ASKED FOUND."""
    program = folder / "python"
    lines = [f"#!{sys.executable} -I", "import sys", "import numpy as np", body]
    program.write_text("\n".join(lines) + "\n")
    program.chmod(0o755)
    return str(program)


GIVES_SIGNS = """
given = np.load(sys.argv[3])
np.savez(sys.argv[4], labels=(given["values"][:, 0] > 0).astype(int))
"""


@pytest.mark.parametrize("by", ["mixture", "chain"])
def test_planted_states_are_found_and_found_again(by):
    X, lengths, state = planted(noise=0.05)
    found, again = (
        by_mixture(X, 3, 0) if by == "mixture" else by_hidden_markov(X, lengths, 3, 0)
        for _ in range(2)
    )
    assert found.shape == (len(X),)
    assert found.dtype == np.int64
    assert adjusted_rand_score(state, found) > 0.98
    assert np.array_equal(found, again)


def test_a_chain_sees_through_noise_that_single_frames_drown_in():
    X, lengths, state = planted(noise=0.18, sequences=12)
    alone = adjusted_rand_score(state, by_mixture(X, 3, 0))
    assert adjusted_rand_score(state, by_hidden_markov(X, lengths, 3, 0)) > alone + 0.2


def test_no_chain_reaches_over_the_border_of_two_sequences():
    rng = np.random.default_rng(0)
    level = np.tile(np.repeat([0.0, 1.0], 40), 10)
    X, lengths = rng.normal(level, 0.3)[:, None], np.full(20, 40)
    found = by_hidden_markov(X, lengths, 2, 0)
    # within a sequence no state ever changes: a lone frame of the other level cannot
    assert adjusted_rand_score(level, found) == 1
    assert adjusted_rand_score(level, by_mixture(X, 2, 0)) < 0.9


def test_more_states_than_different_frames_leave_some_without_frames():
    X, lengths, state = planted(noise=0.0, sequences=2)
    found = by_hidden_markov(X, lengths, 6, 0)
    assert found.max() < 6
    assert adjusted_rand_score(state, found) > 0.5


def test_a_library_that_complains_is_heard_in_our_log_alone(caplog, capsys):
    theirs = logging.getLogger("hmmlearn.base")
    with caplog.at_level(logging.INFO, logger="mimeline"), baselines._into_our_log("hmmlearn"):
        theirs.warning("Model is not converging")
    told = [(record.name, record.levelname) for record in caplog.records]
    assert told == [("mimeline.evaluation.baselines", "INFO")]
    assert capsys.readouterr().err == ""
    assert logging.getLogger("hmmlearn").propagate


def test_numbers_that_no_chain_fits_are_refused():
    with pytest.raises(ValueError, match="degenerates"):
        by_hidden_markov(np.zeros((3, 1)), np.array([3]), 5, 0)


def test_another_interpreter_is_given_the_sequences_and_gives_labels(tmp_path):
    X, lengths, state = planted(noise=0.05)
    found = by_clap(X, lengths, stand_in(tmp_path, GIVES_SIGNS), 0)
    assert adjusted_rand_score(state == 1, found) == 1


def test_only_whole_sequences_are_tried_and_no_more_than_can_be(tmp_path, monkeypatch):
    X, lengths, _ = planted(noise=0.05)
    monkeypatch.setattr(baselines, "CLAP_FRAMES", 400)
    found = by_clap(X, lengths, stand_in(tmp_path, GIVES_SIGNS), 0)
    tried = (found != UNTRIED).reshape(6, 180)
    assert sorted(tried.mean(axis=1)) == [0, 0, 0, 0, 1, 1]
    monkeypatch.setattr(baselines, "CLAP_FRAMES", 100)
    with pytest.raises(ValueError, match="100 frames"):
        by_clap(X, lengths, stand_in(tmp_path, GIVES_SIGNS), 0)


def test_a_sequence_that_is_too_long_does_not_keep_the_others_out():
    chosen = drawn(np.array([50, 900, 50, 50]), 200, np.random.default_rng(0))
    assert chosen.tolist() == [True, False, True, True]


def test_nothing_of_our_own_environment_is_handed_on(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/ours")
    monkeypatch.setenv("PYTHONHOME", "/ours")
    body = f"""
import os
assert sys.argv[1] == "-I"
assert not [key for key in os.environ if key.startswith("PYTHON")]
{GIVES_SIGNS}"""
    X, lengths, _ = planted(noise=0.05)
    assert by_clap(X, lengths, stand_in(tmp_path, body), 0).max() == 1


BROKEN = {
    "no claspy": (
        f"import runpy; runpy.run_path(sys.argv[2]); {'import claspy_of_nobody'}",
        "No module",
    ),
    "a crash": ("raise SystemExit('Segmentation of nothing')", "Segmentation of nothing"),
    "silence": ("pass", "no labels"),
    "half a file": ("open(sys.argv[4], 'wb').write(b'PK12')", "no labels"),
    "an empty file": ("open(sys.argv[4], 'wb')", "no labels"),
    "too few labels": ("np.savez(sys.argv[4], labels=np.zeros(3, int))", "shape (3,)"),
    "no whole numbers": (
        "np.savez(sys.argv[4], labels=np.load(sys.argv[3])['values'][:, 0])",
        "float64",
    ),
    "objects": ("np.savez(sys.argv[4], labels=np.array([object()]))", "no labels"),
}


@pytest.mark.parametrize("body, told", BROKEN.values(), ids=BROKEN)
def test_an_interpreter_that_gives_no_labels_is_said_to_and_what_to_install(tmp_path, body, told):
    X, lengths, _ = planted(noise=0.05, sequences=2)
    with pytest.raises(BadConfig) as error:
        by_clap(X, lengths, stand_in(tmp_path, body), 0)
    assert told in str(error.value)
    assert "experiments.claspy" in str(error.value)
    assert "pip install claspy" in str(error.value)


def test_an_interpreter_that_is_not_there_is_said_to_be(tmp_path):
    X, lengths, _ = planted(noise=0.05, sequences=2)
    with pytest.raises(BadConfig, match="No such file"):
        by_clap(X, lengths, str(tmp_path / "nowhere"), 0)
    plain = tmp_path / "plain"
    plain.write_text("no program")
    with pytest.raises(BadConfig, match="Permission denied"):
        by_clap(X, lengths, str(plain), 0)


def test_a_program_that_does_not_end_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(baselines, "CLAP_SECONDS", 0.5)
    X, lengths, _ = planted(noise=0.05, sequences=2)
    with pytest.raises(BadConfig, match="no end"):
        by_clap(X, lengths, stand_in(tmp_path, "import time; time.sleep(60)"), 0)


def test_clap_itself_finds_planted_states():
    python = os.environ.get("MIMELINE_CLASPY")
    if not python:
        pytest.skip("MIMELINE_CLASPY names no interpreter that has claspy")
    X, lengths, state = planted(noise=0.02, sequences=3)
    found = by_clap(X, lengths, python, 0)
    assert 1 < found.max() + 1 < len(X) / 20
    assert adjusted_rand_score(state, found) > 0.4
