"""Least squares with bounds, for many right-hand sides of one small system."""

import numba
import numpy as np

SWEEPS, ROUNDS = 2, 200  # of descent before each Newton step; of both
SMALLEST = 1e-14  # of a shape: what is left of it beside others that are alike
CLOSE = 1e-8  # of the largest right-hand side: a slope that counts as none


def bounded_solutions(normal: np.ndarray, right: np.ndarray, most: float) -> np.ndarray:
    """The x (n, S) in [0, most] that minimise x' normal x / 2 - x' right, row by row.

    normal (S, S): symmetric, positive definite · right (n, S), finite.
    Coordinate descent finds the coefficients that lie on a bound, projected Newton steps the others
    (Bertsekas 1982). A row ends where no slope points inwards (Karush-Kuhn-Tucker): at the minimum.
    """
    unit = np.sqrt(np.diag(normal))  # so that small shapes are found as exactly as large ones
    normal = np.ascontiguousarray(normal / np.outer(unit, unit), np.float64)
    right = np.ascontiguousarray(right / unit, np.float64)
    found = np.clip(np.linalg.solve(normal, right.T).T, 0, most * unit)
    found = np.ascontiguousarray(found)
    _descend(normal, right, most * unit, found)
    return np.minimum(found / unit, most)


@numba.njit(cache=True, error_model="numpy")
def _descend(normal, right, most, found):
    S = len(normal)
    factor, step, free = np.empty((S, S)), np.empty(S), np.empty(S, np.int64)
    for row in range(len(right)):
        x, slope = found[row], normal @ found[row] - right[row]
        limit = CLOSE * np.abs(right[row]).max()
        for _ in range(ROUNDS):
            _sweep(normal, most, x, slope)
            if _ends(x, slope, most, limit):
                break
            n_free = 0
            for i in range(S):
                if 0 < x[i] < most[i]:
                    free[n_free] = i
                    n_free += 1
            _newton(normal, slope, free[:n_free], factor, step)
            _move(normal, most, x, slope, free[:n_free], step)


@numba.njit(cache=True, error_model="numpy")
def _move(normal, most, x, slope, free, step):
    """Move x (S,) by the free coefficients' step, and keep its slope up.

    Each that would pass its bound stops there; where that makes it worse, all go only as far as
    the first can.
    """
    change, reach = np.zeros(len(x)), 1.0
    for k in range(len(free)):
        i = free[k]
        change[i] = min(max(x[i] + step[k], 0.0), most[i]) - x[i]
        if abs(change[i]) < abs(step[k]):
            reach = min(reach, change[i] / step[k])
    bend = normal @ change
    if change @ (slope + 0.5 * bend) > 0:
        for k in range(len(free)):
            change[free[k]] = reach * step[k]
        bend = normal @ change
    slope += bend
    for k in range(len(free)):
        i = free[k]
        x[i] = min(max(x[i] + change[i], 0.0), most[i])


@numba.njit(cache=True, error_model="numpy")
def _sweep(normal, most, x, slope):
    """Each coefficient in turn to its best, SWEEPS times; slope (S,) is kept up."""
    for _ in range(SWEEPS):
        for i in range(len(x)):
            better = min(max(x[i] - slope[i] / normal[i, i], 0.0), most[i])
            if better != x[i]:
                slope += (better - x[i]) * normal[i]
                x[i] = better


@numba.njit(cache=True, error_model="numpy")
def _ends(x, slope, most, limit):
    """Whether no coefficient can move within its bounds to make it better."""
    for i in range(len(x)):
        if (slope[i] < -limit and x[i] < most[i]) or (slope[i] > limit and x[i] > 0):
            return False
    return True


@numba.njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def _newton(normal, slope, free, factor, step):
    """The step to the minimum over the free coefficients, others held, by Cholesky."""
    n = len(free)
    for a in range(n):
        for b in range(a + 1):
            rest = normal[free[a], free[b]]
            for k in range(b):
                rest -= factor[a, k] * factor[b, k]
            factor[a, b] = np.sqrt(max(rest, SMALLEST)) if a == b else rest / factor[b, b]
    for a in range(n):
        rest = -slope[free[a]]
        for k in range(a):
            rest -= factor[a, k] * step[k]
        step[a] = rest / factor[a, a]
    for a in range(n - 1, -1, -1):
        rest = step[a]
        for k in range(a + 1, n):
            rest -= factor[k, a] * step[k]
        step[a] = rest / factor[a, a]
