from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.ticc.viterbi import Trellis


@st.composite
def problems(draw):
    n_clusters = draw(st.integers(1, 3))
    lengths = draw(st.lists(st.integers(1, 4), min_size=1, max_size=2))
    amount = sum(lengths) * n_clusters
    numbers = draw(st.lists(st.integers(-20, 20), min_size=amount, max_size=amount))
    costs = np.array(numbers, dtype=float).reshape(-1, n_clusters)
    return costs, np.array(lengths), float(draw(st.integers(0, 15)))


def trellis(costs, lengths, beta, block=3):
    opens = np.zeros(len(costs), dtype=bool)
    opens[np.cumsum(lengths) - lengths] = True
    begins = range(0, len(costs), block)
    blocks = [(begin, min(begin + block, len(costs))) for begin in begins]
    return Trellis(lambda b, e: costs[b:e], blocks, opens, costs.shape[1], beta)


def path_cost(path, costs, lengths, beta):
    total = costs[np.arange(len(path)), path].sum()
    for part in np.split(np.array(path), np.cumsum(lengths)[:-1]):
        total += beta * np.count_nonzero(np.diff(part))
    return total


@settings(deadline=None, max_examples=150)
@given(problems())
def test_the_path_and_its_margins_are_those_of_trying_every_labelling(problem):
    costs, lengths, beta = problem
    path = trellis(costs, lengths, beta)
    labels, total = path.labels, path.objective
    every = list(product(range(costs.shape[1]), repeat=len(costs)))
    prices = np.array([path_cost(path, *problem) for path in every])
    assert total == prices.min()
    assert path_cost(labels, *problem) == total
    for t, margin in enumerate(path.margins()):
        others = [price for path, price in zip(every, prices, strict=True) if path[t] != labels[t]]
        assert margin == (min(others) - total if others else np.inf)


def test_a_switch_between_sequences_is_free():
    costs = np.array([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
    apart = trellis(costs, np.array([2, 2]), 100.0)
    assert apart.labels.tolist() == [0, 0, 1, 1] and apart.objective == 0
    joined = trellis(costs, np.array([4]), 100.0)
    assert len(set(joined.labels.tolist())) == 1


def test_the_path_is_the_same_whatever_the_blocks_and_with_many_clusters():
    rng = np.random.default_rng(0)
    costs, lengths = rng.normal(size=(400, 19)), np.array([150, 1, 249])
    whole = trellis(costs, lengths, 1.0, block=400)
    parts = trellis(costs, lengths, 1.0, block=7)
    assert np.array_equal(whole.labels, parts.labels) and len(set(whole.labels)) > 10
    assert np.allclose(whole.margins(), parts.margins())
    assert path_cost(whole.labels, costs, lengths, 1.0) == pytest.approx(whole.objective)
