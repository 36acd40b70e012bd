"""From the coefficients of one face model to those of another, through what both do to a face."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mimeline.face.bounded import bounded_solutions
from mimeline.face.correspondence import correspondence
from mimeline.face.model import Face
from mimeline.vocabulary import CHANNELS

LEAST_QUALITY = 0.3  # below, a shape is not possible
COVERED = 0.3  # share of a shape's movement that must lie where the source has a surface
LEAST_RIDGE, RIDGE = 1e-7, 0.25  # of a shape's own movement; times the share that stays unexplained
FARTHEST = 3.0  # of a source's coefficient, either way: models count standard deviations
SLIGHT = 1e-9  # of the source's strongest movement: the ridge on its own coefficients
TRIALS, ACTIVE = 1000, 4  # expressions that quality is measured on, and shapes active in each
UNDOING = -0.5  # cosine of two shapes that no face shows at once, as jawLeft and jawRight


@dataclass(frozen=True, eq=False)
class Retargeting:
    """From E coefficients of a source to S of a target.

    names (S,): the target's shapes · quality (S,) in [0, 1], as `retargeting` has it · possible
    (S,) bool: quality enough to be told · solved (S,) bool: the P shapes that take part, possible
    or not · normal (P, P) and cross (E, P): the movements of these against each other, and of the
    source's shapes against them.
    """

    names: tuple[str, ...]
    quality: np.ndarray
    possible: np.ndarray
    solved: np.ndarray
    normal: np.ndarray
    cross: np.ndarray

    def coefficients(self, source: np.ndarray, most: float = 1.0) -> np.ndarray:
        """Coefficients (n, S) in [0, most] of the source's (n, E).

        Each row is the bounded least-squares fit to the source's movement. NaN where a shape is
        not possible, and in rows that are not finite.
        """
        source = np.asarray(source, np.float64)
        told = np.isfinite(source).all(1)
        found = np.full((len(source), len(self.names)), np.nan)
        if self.solved.any():
            right = source[told] @ self.cross  # (n told, P)
            found[np.ix_(told, self.solved)] = bounded_solutions(self.normal, right, most)
        found[:, ~self.possible] = np.nan
        return found


def retargeting(source: Face, target: Face, names: Sequence[str] | None = None) -> Retargeting:
    """The way from a source's shapes to the target's that are named (None: all of them).

    A shape's quality is the R² of its coefficient over random sparse expressions of the target
    that are brought to the source, to the nearest that its shapes can do within FARTHEST, and back.
    So it is high where the source can show the shape with coefficients that trackers give, and
    tells it from the others. It says nothing on whether two models mean the same by a name. A shape
    that moves mostly what the source has no surface for (the tongue) has 0. A shape of which the
    source shows less than LEAST_QUALITY takes no part; one that takes part and comes back with less
    is not possible: no coefficient is told, but it takes its share of the movement from the others.
    The ridge grows with what the source cannot express: where it can do all, it does not count.
    Raises ValueError for a name that the target does not have, and as `correspondence` does.
    """
    names = tuple(target.shape_names if names is None else names)
    wanted = np.float64(target.shapes[[target.shape_names.index(name) for name in names]])
    partners = correspondence(source, target)
    there = wanted[:, partners.vertices]  # (S, n, 3)
    moved = (wanted**2).sum(2) * _areas(target)  # (S, V)
    covered = moved[:, partners.vertices].sum(1) > COVERED * moved.sum(1)
    ours = there.reshape(len(there), -1)  # (S, 3 n)
    theirs = partners.carried(np.float64(source.shapes)).reshape(len(source.shapes), -1)  # (E, 3 n)
    against = theirs @ ours.T  # (E, S)
    between = ours @ ours.T  # (S, S)
    apart = theirs @ theirs.T  # (E, E)
    nearest = _nearest(apart, against.T)  # (S, E)
    own = np.maximum(np.diag(between), np.finfo(float).tiny)
    shown = (nearest * (2 * against.T - nearest @ apart)).sum(1)  # of own: what is not left over
    unexplained = np.clip(1 - shown / own, 0, 1)  # (S,)
    quality = np.where(covered, 1 - unexplained, 0)
    solved = quality >= LEAST_QUALITY
    ridge = LEAST_RIDGE + RIDGE * unexplained[solved].mean() if solved.any() else LEAST_RIDGE
    both = np.ix_(solved, solved)
    normal, cross = between[both] + ridge * np.diag(own[solved]), against[:, solved]
    if solved.any():
        together = between[both] / np.sqrt(np.outer(own[solved], own[solved]))
        kept = [name for name, is_solved in zip(names, solved, strict=True) if is_solved]
        sent = _sent(together, _mirrors(kept))  # (n, P)
        given = np.clip(sent @ nearest[solved], -FARTHEST, FARTHEST)  # (n, E)
        back = bounded_solutions(normal, given @ cross, 1.0)
        quality[solved] = _r_squared(sent, back)
    return Retargeting(names, quality, quality >= LEAST_QUALITY, solved, normal, cross)


def _nearest(apart: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The coefficients (S, E) within FARTHEST that come nearest to each of S movements.

    apart (E, E): the source's movements against each other · right (S, E): against the S.
    """
    ridge = max(SLIGHT * np.diag(apart).max(), np.finfo(float).tiny)
    apart = apart + ridge * np.eye(len(apart))
    return bounded_solutions(apart, right + FARTHEST * apart.sum(0), 2 * FARTHEST) - FARTHEST


def _mirrors(names: Sequence[str]) -> list[int]:
    """Where each name's mirror image is among them; its own place where that is not there."""
    mirrors = [CHANNELS[name].mirror if name in CHANNELS else name for name in names]
    return [names.index(m) if m in names else n for n, m in enumerate(mirrors)]


def _sent(together: np.ndarray, mirrors: Sequence[int]) -> np.ndarray:
    """Random sparse expressions (n, P) and their mirror images. together (P, P): cosines."""
    rng, P = np.random.default_rng(0), len(together)
    sent = rng.uniform(0.2, 1, (TRIALS, P)) * (rng.random((TRIALS, P)) < ACTIVE / P)
    sent = np.concatenate([sent, sent[:, mirrors]])
    for first, second in np.argwhere(np.triu(together < UNDOING)):
        sent[sent[:, first] > 0, second] = 0
    return sent


def _r_squared(sent: np.ndarray, back: np.ndarray) -> np.ndarray:
    """(P,) of what comes back (n, P) of what was sent (n, P), at least 0."""
    spread = ((sent - sent.mean(0)) ** 2).sum(0)
    return np.clip(1 - ((back - sent) ** 2).sum(0) / np.maximum(spread, 1e-12), 0, 1)


def _areas(face: Face) -> np.ndarray:
    """The surface (V,) that belongs to each vertex, square metres."""
    a, b, c = (np.float64(face.neutral[face.triangles[:, k]]) for k in range(3))
    share = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    return np.bincount(face.triangles.ravel(), np.repeat(share, 3), len(face.neutral))
