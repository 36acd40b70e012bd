import numpy as np
import pytest
from scipy.optimize import lsq_linear

from mimeline.face.bounded import bounded_solutions


def problem(seed: int, n: int = 20, S: int = 9):
    """A system of shapes that are much alike, and right-hand sides that reach both bounds."""
    rng = np.random.default_rng(seed)
    shapes = rng.normal(size=(30, S)) @ np.diag(10.0 ** rng.uniform(-2, 0, S))
    shapes[:, 1] = shapes[:, 0] + 0.1 * shapes[:, 2]
    return shapes, rng.normal(0.5, 1, (n, S)) @ shapes.T


@pytest.mark.parametrize("seed", range(5))
def test_it_finds_the_minimum_that_scipy_finds(seed):
    shapes, wanted = problem(seed)
    found = bounded_solutions(shapes.T @ shapes, wanted @ shapes, 1.0)
    assert found.min() >= 0 and found.max() <= 1
    for row, goal in zip(found, wanted, strict=True):
        best = lsq_linear(shapes, goal, (0, 1), method="bvls", tol=1e-14).x
        cost, least = ((shapes @ x - goal) @ (shapes @ x - goal) for x in (row, best))
        assert cost <= least * (1 + 1e-6) + 1e-12


def test_what_lies_within_the_bounds_comes_back():
    shapes, _ = problem(1)
    sent = np.random.default_rng(0).uniform(0, 1, (50, shapes.shape[1]))
    sent[sent < 0.3] = 0
    sent[:, :2] = 0  # the two that are alike
    normal = shapes.T @ shapes
    np.testing.assert_allclose(bounded_solutions(normal, sent @ normal, 1.0), sent, atol=1e-4)


def test_no_rows_give_no_rows():
    assert bounded_solutions(np.eye(3), np.zeros((0, 3)), 1.0).shape == (0, 3)


def test_a_row_of_zeros_is_at_rest():
    shapes, _ = problem(2)
    assert not bounded_solutions(shapes.T @ shapes, np.zeros((2, 9)), 1.0).any()
