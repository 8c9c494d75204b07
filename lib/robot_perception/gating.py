r"""Data association of measurements and predictions: gates, nearest neighbour, joint compatibility.

The functions know nothing of robots: they take innovations and their covariances. Pairs are rows
(measurement, target); an assignment gives for each measurement its target, or -1.
"""

from functools import cache
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.kernels import kernel

__all__ = ["chi_squared_quantile", "gate", "joint_compatibility", "nearest_neighbours"]


def chi_squared_quantile(
    level: float, dimension: int | np.integer | Int[np.ndarray, "..."]
) -> float | Float[np.ndarray, "..."]:
    r"""Return the quantile :math:`\chi^2_d(\ell)` for one or many degrees of freedom.

    Raises
    ------
    ValueError
        If the level is not from 0 to 1 or a dimension no whole number of at least 1.
    """
    level = checks.share("level", level)
    dimension = checks.integers("dimension", dimension, least=1)
    return _quantile(level, dimension)


def _quantile(level: float, dimension: int | np.ndarray) -> float | np.ndarray:
    from scipy.special import gammaincinv  # a tenth of the time to import the planar filter

    return 2 * gammaincinv(dimension / 2, level)


def gate(level: float, dimension: int) -> float:
    r"""Return the squared Mahalanobis distance that a right pair exceeds with 1 - level.

    .. math:: \chi^2_d(\ell)

    Parameters
    ----------
    level
        Probability that a right pair passes, between 0 and 1.
    dimension
        Numbers in one measurement, d.

    Raises
    ------
    ValueError
        If the level is not between 0 and 1 or the dimension no whole number of at least 1.
    """
    return _gate(checks.level("level", level), checks.whole("dimension", dimension, 1))


@cache
def _gate(level: float, dimension: int) -> float:
    return float(_quantile(level, dimension))


def nearest_neighbours(
    distances: Float[np.ndarray, "measurements targets"], limit: float
) -> Int[np.ndarray, "measurements"]:
    """Return for each measurement the target that is nearest, each target given once.

    The nearest pair of all is taken first, then the nearest of what is left, while it is nearer
    than the limit.

    Parameters
    ----------
    distances : (m, n)
        Squared Mahalanobis distances; infinite where a pair is out of the question.
    limit
        Largest squared distance of a pair.

    Returns
    -------
    (m,)
        Index of the target, or -1.

    Raises
    ------
    ValueError
        If ``distances`` is not (m, n), holds a number that is negative or not a number, or the
        limit is none.
    """
    distances = checks.array("distances", distances, ("m", "n"), finite=False)
    limit = checks.number("limit", limit, finite=False)
    if not (distances >= 0).all():
        raise ValueError(f"distances must not be negative, got {distances.min()}")
    return greedy(np.ascontiguousarray(distances), limit)


@kernel()
@no_type_check
def greedy(distances, limit):  # pragma: no cover - compiled
    m, n = distances.shape
    assignment = np.full(m, -1)
    taken = np.zeros(n, dtype=np.bool_)
    while True:
        best, at, to = limit, -1, -1
        for i in range(m):
            if assignment[i] < 0:
                for j in range(n):
                    if not taken[j] and distances[i, j] <= best:
                        if distances[i, j] == best and at >= 0:
                            continue
                        best, at, to = distances[i, j], i, j
        if at < 0:
            return assignment
        assignment[at], taken[to] = to, True


def joint_compatibility(
    pairs: Int[np.ndarray, "p 2"],
    innovations: Float[np.ndarray, "p d"],
    cov: Float[np.ndarray, "rows rows"],
    limits: Float[np.ndarray, "p"],
) -> Int[np.ndarray, "k"]:
    r"""Return which pairs belong together: the largest jointly compatible set.

    .. math:: D_H^2 = \tilde z_H^\top S_H^{-1} \tilde z_H \le \chi^2_{d |H|}(\ell)

    Branch and bound, depth first. Among sets H with the most pairs, each measurement and each
    target at most once, the one with the least :math:`D_H^2`. The search is exact: a branch is left
    only if no set in it can pass the limit or be better than the best so far. (Neira and Tardós
    also leave a branch when its first few pairs fail the smaller limit for few pairs; then the
    result depends on the order of the measurements.) Time grows exponentially with ambiguity, so
    the pairs should have passed a gate of their own.

    Parameters
    ----------
    pairs : (p, 2)
        Possible pairs (measurement, target), sorted by measurement.
    innovations : (p, d)
        Innovation of each pair.
    cov : (p d, p d)
        Joint covariance S of all innovations. Entries between two pairs of one measurement are
        never used.
    limits : (p,)
        Largest :math:`D_H^2` of a set of 1, 2, … p pairs; must not fall.

    Returns
    -------
    (k,)
        Rows of ``pairs`` that were chosen, ascending.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, the pairs are not sorted or no whole numbers of
        at least 0, a limit is not a number or below the one before it, or S is singular.

    References
    ----------
    Neira and Tardós, "Data association in stochastic mapping using the joint compatibility test",
    IEEE Transactions on Robotics and Automation 17(6), 2001.
    """
    pairs = checks.integers("pairs", pairs, ("p", 2), 0)
    p, beside = len(pairs), f"pairs {pairs.shape}"
    innovations = checks.array("innovations", innovations, (p, "d"), beside)
    size, beside = innovations.size, f"innovations {innovations.shape}"
    cov = checks.covariance("cov", cov, (size, size), beside)
    limits = checks.array("limits", limits, (p,), beside, finite=False)
    if p == 0:
        return np.empty(0, dtype=np.int64)
    if (np.diff(pairs[:, 0]) < 0).any():
        raise ValueError(f"pairs must be sorted by measurement, got {pairs[:, 0].tolist()}")
    if np.isnan(limits).any() or (limits[1:] < limits[:-1]).any():
        raise ValueError(f"limits must be numbers that do not fall, got {limits.tolist()}")
    return branch_and_bound(pairs, innovations, cov, limits)


def branch_and_bound(
    pairs: np.ndarray, innovations: np.ndarray, cov: np.ndarray, limits: np.ndarray
) -> np.ndarray:
    """Return the same as :func:`joint_compatibility`, for input that is known to be right."""
    starts = np.flatnonzero(np.r_[True, np.diff(pairs[:, 0]) > 0, True])
    chosen, regular = _search(starts, np.ascontiguousarray(pairs[:, 1]), innovations, cov, limits)
    if not regular:
        raise ValueError("cov of the innovations is singular")
    return chosen


@kernel()
@no_type_check
def _search(starts, targets, innovations, cov, limits):  # pragma: no cover - compiled
    """Walk the tree with a stack: one level for each measurement that has a pair.

    The Cholesky factor of the chosen pairs' S grows by d rows with each pair and is forgotten with
    it, so that a node costs O(d² k²) and not the inversion of a whole matrix.
    """
    levels, d = starts.size - 1, innovations.shape[1]
    L = np.zeros((levels * d, levels * d))
    white = np.zeros(levels * d)
    rows = np.zeros(levels * d, dtype=np.int64)
    tries = np.zeros(levels, dtype=np.int64)  # next branch of each level
    picked = np.full(levels, -1)
    squared = np.zeros(levels + 1)
    counts = np.zeros(levels + 1, dtype=np.int64)
    best, best_count, best_squared = picked.copy(), 0, 0.0
    level = 0
    while level >= 0:
        if level == levels:
            count = counts[level]
            better = count > best_count or (count == best_count and squared[level] < best_squared)
            if count > 0 and better and squared[level] <= limits[count - 1]:
                best[:], best_count, best_squared = picked, count, squared[level]
            level -= 1
            continue
        count, remaining = counts[level], levels - level
        hopeless = count + remaining < best_count or (
            count + remaining == best_count and squared[level] >= best_squared
        )
        branches = starts[level + 1] - starts[level]
        if hopeless or tries[level] > branches:
            tries[level] = 0
            level -= 1
            continue
        pair = starts[level] + tries[level] if tries[level] < branches else -1
        tries[level] += 1
        picked[level] = pair
        counts[level + 1], squared[level + 1] = count, squared[level]
        if pair >= 0:
            free = True
            for other in picked[:level]:
                free &= other < 0 or targets[other] != targets[pair]
            if not free:
                continue
            for row in range(d):
                r = count * d + row
                rows[r] = pair * d + row
                white[r] = innovations[pair, row]
                for j in range(r + 1):
                    total = cov[rows[r], rows[j]]
                    for q in range(j):
                        total -= L[r, q] * L[j, q]
                    if j < r:
                        L[r, j] = total / L[j, j]
                        white[r] -= L[r, j] * white[j]
                    elif total <= 1e-14 * cov[rows[r], rows[r]]:
                        return best, False
                    else:
                        L[r, r] = np.sqrt(total)
                white[r] /= L[r, r]
                squared[level + 1] += white[r] ** 2
            counts[level + 1] = count + 1
            if squared[level + 1] > limits[count + remaining - 1]:
                continue  # the distance only grows, even the largest set would be too far
        level += 1
    return best[best >= 0], True
