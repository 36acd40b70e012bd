"""The block-Toeplitz graphical lasso by ADMM, for all clusters at once."""

import logging
from dataclasses import dataclass

import numpy as np

from .toeplitz import project_toeplitz

log = logging.getLogger(__name__)

RELAXATION = 1.6  # Boyd et al. 2011, section 3.4.3
BALANCE = 2.0  # ratio of the residuals past which rho moves
RHO_EVERY = 10  # iterations between moves of rho: more often and the residuals chase each other
TINY = 1e-12  # of a relative residual: what is less is zero


@dataclass
class Lasso:
    """Where ADMM stands, a row per cluster: the solution and what a warm start needs.

    precisions (K, wn, wn) exactly block-Toeplitz, positive definite · duals (K, wn, wn) scaled ·
    rho (K,) · iterations (K,).
    """

    precisions: np.ndarray
    duals: np.ndarray
    rho: np.ndarray
    iterations: np.ndarray


def toeplitz_lasso(
    covariances,
    window: int,
    sparsity: float,
    start: Lasso | None = None,
    *,
    tol=1e-5,
    max_iter=1000,
) -> Lasso:
    """Minimise -log det P + tr(S P) + sparsity * sum |P_ij| over block-Toeplitz P.

    covariances (K, wn, wn) · sparsity >= 0, of every entry, the diagonal's too: that bounds the
    problem for a cluster whose windows are all alike (S = 0 gives P = I / sparsity) · start: an
    earlier solution. tol is relative to the size of P; rho adapts (Boyd et al. 2011, 3.4.1).
    Each cluster is solved with its channels in units of its own deviations, where one rho suits
    them all: quiet and loud channels side by side cost half as many iterations again otherwise.
    Source: Hallac et al. 2017, eq. 4 and section 5.2, with one sparsity for all clusters' S.
    """
    n_clusters, size, _ = covariances.shape
    diagonal = np.einsum("kii->ki", covariances).reshape(n_clusters, window, -1)
    deviation = np.sqrt(diagonal.mean(axis=1) + max(sparsity, 1e-8))  # (K, n)
    deviation = np.tile(deviation, (1, window))  # (K, wn)
    units = 1 / (deviation[:, :, None] * deviation[:, None, :])
    scaled, weights = covariances * units, sparsity * units
    if start is None:
        curvature = np.einsum("kii->ki", scaled + weights)  # root of that of -log det at the start
        Z = np.zeros_like(scaled)
        Z[:, np.arange(size), np.arange(size)] = 1 / curvature
        Z = project_toeplitz(Z, window)
        U = np.zeros_like(Z)
        rho = (curvature**2).mean(axis=1)
    else:
        Z, U, rho = start.precisions / units, start.duals / units, start.rho.copy()
    iterations = np.zeros(n_clusters, np.int64)
    active = np.arange(n_clusters)
    for step in range(1, max_iter + 1):
        S, r = scaled[active], rho[active, None, None]
        values, vectors = np.linalg.eigh(r * (Z[active] - U[active]) - S)
        roots = (values + np.sqrt(values**2 + 4 * r[:, 0])) / (2 * r[:, 0])  # (A, wn)
        P = (vectors * roots[:, None, :]) @ np.swapaxes(vectors, 1, 2)
        old = Z[active]
        relaxed = RELAXATION * P + (1 - RELAXATION) * old
        mean = project_toeplitz(relaxed + U[active], window)
        new = np.sign(mean) * np.maximum(np.abs(mean) - weights[active] / r, 0)
        Z[active] = new
        U[active] += relaxed - new
        iterations[active] = step

        primal = _norm(P - new)
        dual = rho[active] * _norm(new - old)
        near = primal <= tol * np.maximum(_norm(P), _norm(new))
        near &= dual <= tol * np.maximum(rho[active] * _norm(U[active]), _norm(S))
        if step % RHO_EVERY == 0:
            p = primal / np.maximum(_norm(new), TINY)
            d = dual / np.maximum(rho[active] * _norm(U[active]), TINY)
            wish = np.sqrt(np.clip(p / np.maximum(d, TINY), 1e-4, 1e4))
            factor = np.where((wish**2 > BALANCE) | (wish**2 < 1 / BALANCE), wish, 1.0)
            rho[active] *= factor
            U[active] /= factor[:, None, None]
        active = active[~near]
        if not len(active):
            break
    else:
        log.debug("%d clusters of %d short of the tolerance", len(active), n_clusters)
    return Lasso(_positive(Z * units), U * units, rho, iterations)


def _positive(Z: np.ndarray) -> np.ndarray:
    """Z made positive definite where an unfinished ADMM left it short of that."""
    least = np.linalg.eigvalsh(Z)[:, 0]
    floor = 1e-9 * np.einsum("kii->ki", Z).mean(axis=1)
    short = np.maximum(floor - least, 0)
    return Z + short[:, None, None] * np.eye(Z.shape[1])


def _norm(A: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("kij,kij->k", A, A))
