from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mimeline.ticc.viterbi import best_path, path_margins


@st.composite
def problems(draw):
    n_clusters = draw(st.integers(1, 3))
    lengths = draw(st.lists(st.integers(1, 4), min_size=1, max_size=2))
    amount = sum(lengths) * n_clusters
    numbers = draw(st.lists(st.integers(-20, 20), min_size=amount, max_size=amount))
    costs = np.array(numbers, dtype=float).reshape(-1, n_clusters)
    return costs, np.array(lengths), float(draw(st.integers(0, 15)))


def path_cost(path, costs, lengths, beta):
    total = costs[np.arange(len(path)), path].sum()
    for part in np.split(np.array(path), np.cumsum(lengths)[:-1]):
        total += beta * np.count_nonzero(np.diff(part))
    return total


@settings(deadline=None, max_examples=150)
@given(problems())
def test_the_path_and_its_margins_are_those_of_trying_every_labelling(problem):
    costs, lengths, beta = problem
    labels, total = best_path(costs, lengths, beta)
    every = list(product(range(costs.shape[1]), repeat=len(costs)))
    prices = np.array([path_cost(path, *problem) for path in every])
    assert total == prices.min()
    assert path_cost(labels, *problem) == total
    for t, margin in enumerate(path_margins(costs, lengths, beta, labels)):
        others = [price for path, price in zip(every, prices, strict=True) if path[t] != labels[t]]
        assert margin == (min(others) - total if others else np.inf)


def test_a_switch_between_sequences_is_free():
    costs = np.array([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
    apart, price = best_path(costs, np.array([2, 2]), 100.0)
    assert apart.tolist() == [0, 0, 1, 1] and price == 0
    joined, _ = best_path(costs, np.array([4]), 100.0)
    assert len(set(joined.tolist())) == 1
