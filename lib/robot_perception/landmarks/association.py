r"""Distances from descriptors to classes of descriptors, as products of matrices.

.. math:: E_{ij} = (d_i - \bar d_j)^\top (d_i - \bar d_j)
    = |d_i|^2 - 2 d_i^\top \bar d_j + |\bar d_j|^2

.. math:: L_{ij} = (d_i - \bar d_j)^\top S_j^{-1} (d_i - \bar d_j) = (d_i \circ d_i)^\top w_j
    - 2 d_i^\top (w_j \circ \bar d_j) + \bar d_j^\top (w_j \circ \bar d_j), \quad
    w_j = \operatorname{diag} S_j^{-1}

One product for the Euclidean distance (eq. 8), two for the Mahalanobis distance (eq. 9). In single
precision they take half the time and lose the last digits; the two nearest are exact all the same,
since every class that may be one of them within the bound of rounding is looked at again in double
precision.
"""

from dataclasses import dataclass, field
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.fields import OPEN, checked
from robot_perception.kernels import kernel

UNIT = 2.0**-24  # half the distance from 1 to the next number in single precision
LARGEST = 1e30  # of what single precision can still square and add
LANES = 64
CACHE = 5 * 2**17  # single numbers that a processor has at hand: 2.5 MB


def _numbers(name: str, value: np.ndarray) -> np.ndarray:
    if np.isnan(value).any():
        raise ValueError(f"{name} must be numbers, got {np.isnan(value).sum()} NaN")
    return value


@dataclass(frozen=True, eq=False, slots=True)
class Nearest:
    """The two nearest classes of each of m descriptors.

    Parameters
    ----------
    classes : (m, 2)
        The nearest and the second; -1 where there are fewer classes.
    distances : (m, 2)
        Their squared distances, below zero only where a log-determinant is added; infinite where
        there are fewer classes.
    """

    classes: Int[np.ndarray, "m 2"]
    distances: Annotated[Float[np.ndarray, "m 2"], OPEN, _numbers]
    __post_init__ = checked

    def within(self, limit: float, *, ratio: float = 1.0) -> Int[np.ndarray, " m"]:
        r"""Return the nearest class of each descriptor, or -1 for a new landmark.

        Parameters
        ----------
        limit
            Largest squared distance to a class.
        ratio
            Largest ratio of the distances (not squared) to the nearest and to the second.

        Raises
        ------
        ValueError
            If the limit is not a number or the ratio not from 0 to 1.

        References
        ----------
        Gil et al. (2006), §4: threshold. Lowe (2004), §7.1: ratio.
        """
        limit = checks.number("limit", limit, finite=False)
        ratio = checks.share("ratio", ratio)
        first, second = self.distances.T
        near = (first <= limit) & (self.classes[:, 0] >= 0)
        if ratio < 1:
            near &= first <= ratio**2 * second
        return np.where(near, self.classes[:, 0], -1)


@dataclass(frozen=True, eq=False, slots=True)
class Euclidean:
    """The squared Euclidean distance of eq. (8).

    Parameters
    ----------
    means : (n, d)
        Mean descriptor of each class.

    Raises
    ------
    ValueError
        If the means are not (n, d) or not finite.
    """

    means: Float[np.ndarray, "n d"]
    _single: np.ndarray = field(init=False, repr=False)
    _squares: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        means, single, squares = _rounded("means", self.means, ("n", "d"))
        object.__setattr__(self, "means", means)
        object.__setattr__(self, "_single", single)
        object.__setattr__(self, "_squares", squares)

    def distances(self, descriptors: Float[np.ndarray, "m d"]) -> Float[np.ndarray, "m n"]:
        """Return the squared distance of each descriptor to each class.

        Parameters
        ----------
        descriptors : (m, d)
            Descriptors of the length of the means.

        Raises
        ------
        ValueError
            If the descriptors are not (m, d) or not finite.
        """
        found = checks.array("descriptors", descriptors, ("m", self.means.shape[1]))
        own = np.einsum("md,md->m", found, found)[:, None]
        squares = np.einsum("nd,nd->n", self.means, self.means)
        return np.maximum(own - 2 * found @ self.means.T + squares, 0.0)

    def two_nearest(self, descriptors: Float[np.ndarray, "m d"]) -> Nearest:
        """Return the two nearest classes of each descriptor; of equal ones the first.

        Parameters
        ----------
        descriptors : (m, d)
            Descriptors of the length of the means.

        Raises
        ------
        ValueError
            If the descriptors are not (m, d) or not finite.
        """
        size = ("m", self.means.shape[1])
        found, factors, _ = _rounded("descriptors", descriptors, size, -2.0)
        return _two_nearest(
            factors,
            self._single,
            np.sqrt(self._squares.max(initial=0.0)),
            self._squares,
            found,
            self.means,
            np.empty((len(self.means), 0)),
            np.zeros(len(self.means)),
        )


@dataclass(frozen=True, eq=False, slots=True)
class Mahalanobis:
    r"""The Mahalanobis distance of eq. (9), with a variance of each class and entry.

    With the logarithm of the determinant it is, up to a constant, -2 times the log likelihood of a
    normal class; without, a class gains by a large variance.

    .. math:: L_{ij} + \ln \det S_j

    Parameters
    ----------
    means : (n, d)
        Mean descriptor of each class.
    variances : (n, d)
        Variance of each entry.
    log_determinant
        Whether to add it.

    Raises
    ------
    ValueError
        If the shapes disagree, a number is not finite or a variance not positive.
    """

    means: Float[np.ndarray, "n d"]
    variances: Float[np.ndarray, "n d"]
    log_determinant: bool = False
    _centre: np.ndarray = field(init=False, repr=False)
    _logs: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        means = np.ascontiguousarray(checks.array("means", self.means, ("n", "d")))
        variances = checks.array("variances", self.variances, means.shape, f"means {means.shape}")
        if variances.size and not variances.min() > 0:
            raise ValueError(f"variances must be positive, got {variances.min()}")
        logs = np.zeros(len(means))
        if checks.flag("log_determinant", self.log_determinant):
            logs = np.log(variances).sum(axis=1)
        object.__setattr__(self, "means", means)
        object.__setattr__(self, "variances", np.ascontiguousarray(variances))
        # less is lost where the numbers are small
        object.__setattr__(self, "_centre", means.sum(axis=0) / max(len(means), 1))
        object.__setattr__(self, "_logs", logs)

    def distances(self, descriptors: Float[np.ndarray, "m d"]) -> Float[np.ndarray, "m n"]:
        """Return the squared distance of each descriptor to each class.

        Parameters
        ----------
        descriptors : (m, d)
            Descriptors of the length of the means.

        Raises
        ------
        ValueError
            If the descriptors are not (m, d) or not finite.
        """
        found = checks.array("descriptors", descriptors, ("m", self.means.shape[1]))
        apart, weights = found - self._centre, 1 / self.variances
        cross = apart @ (weights * (self.means - self._centre)).T
        own = np.einsum("nd,nd->n", weights, (self.means - self._centre) ** 2)
        return np.maximum(apart**2 @ weights.T - 2 * cross + own, 0.0) + self._logs

    def two_nearest(self, descriptors: Float[np.ndarray, "m d"]) -> Nearest:
        """Return the two nearest classes of each descriptor; of equal ones the first.

        Parameters
        ----------
        descriptors : (m, d)
            Descriptors of the length of the means.

        Raises
        ------
        ValueError
            If the descriptors are not (m, d) or not finite.
        """
        found = checks.array("descriptors", descriptors, ("m", self.means.shape[1]))
        n, d = self.means.shape
        single, offsets = np.empty((n, 2 * d), dtype=np.float32), self._logs.copy()
        _weigh(self.means, self._centre, self.variances, single, offsets)
        apart = found - self._centre
        with np.errstate(over="ignore"):  # what is too large is refused
            factors = np.concatenate([apart**2, -2 * apart], axis=1).astype(np.float32)
        reach = np.sqrt(np.einsum("nk,nk->n", single, single).max(initial=0.0))
        return _two_nearest(
            factors, single, reach, offsets, found, self.means, self.variances, self._logs
        )


def _rounded(
    name: str, value: np.ndarray, shape: tuple, factor: float = 1.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Check rows; return them, so many times them in single precision, and their squared lengths.

    All in one pass, as the memory takes longer than the sums: what is not finite has no finite
    length.
    """
    rows = np.ascontiguousarray(checks.array(name, value, shape, finite=False))
    single, squares = np.empty(rows.shape, dtype=np.float32), np.empty(len(rows))
    _round(rows, factor, single, squares)
    if not np.isfinite(squares).all():
        checks.check_finite(name, rows)
    return rows, single, squares


def _two_nearest(
    factors: np.ndarray,
    single: np.ndarray,
    reach: np.floating,
    offsets: np.ndarray,
    found: np.ndarray,
    means: np.ndarray,
    variances: np.ndarray,
    logs: np.ndarray,
) -> Nearest:
    """Return the two classes with the least sums of product and offset.

    No row of ``single`` is longer than the reach. The product of two rows of K numbers in single
    precision is off by no more than (K + 16) units of rounding times their lengths: K for the sum,
    the rest for the factors, the offset, the sum with it and the lengths.
    """
    m = len(found)
    classes, distances = np.full((m, 2), -1), np.full((m, 2), np.inf)
    with np.errstate(over="ignore"):  # what is too large is refused
        offsets, reach = offsets.astype(np.float32), np.float32(reach)
    found = np.ascontiguousarray(found)
    scale = np.sqrt(np.einsum("mk,mk->m", factors, factors)) * reach + np.abs(offsets).max(
        initial=0.0
    )
    bounds = (factors.shape[1] + 16) * UNIT * scale
    if not scale.max(initial=0.0) < LARGEST:
        raise ValueError(
            f"descriptors and means must fit single precision, got {np.abs(found).max():g}"
        )
    most = max(CACHE - single.size, CACHE // 4) // max(len(single), 1)
    rows = max(-(-m // max(-(-m // max(most, 1)), 1)), 1)  # in equal parts
    buffer = np.empty((min(rows, m), len(single)), dtype=np.float32)
    for start in range(0, m, rows):
        part = slice(start, start + rows)
        _pick(
            np.matmul(factors[part], single.T, out=buffer[: len(factors[part])]),
            offsets,
            bounds[part],
            found[part],
            means,
            variances,
            logs,
            classes[part],
            distances[part],
        )
    return Nearest(classes, distances)


@kernel(fastmath={"reassoc"})
@no_type_check
def _round(rows, factor, single, squares):  # pragma: no cover - compiled
    """Write multiples of rows in single precision, and the rows' squared lengths in double."""
    for j in range(len(rows)):
        total = 0.0
        for k in range(rows.shape[1]):
            value = rows[j, k]
            single[j, k] = factor * value
            total += value * value
        squares[j] = total


@kernel(fastmath={"reassoc"})
@no_type_check
def _weigh(means, centre, variances, single, offsets):  # pragma: no cover - compiled
    """Write the weights of the classes and what else the products need."""
    n, d = means.shape
    for j in range(n):
        total = 0.0
        weights, products = single[j, :d], single[j, d:]
        for k in range(d):
            weight, apart = 1 / variances[j, k], means[j, k] - centre[k]
            weights[k], products[k] = weight, weight * apart
            total += weight * apart * apart
        offsets[j] += total


@kernel()
@no_type_check
def _least(products, offsets, minima):  # pragma: no cover - compiled
    """Write the least sum of each lane; so written that the processor takes many at a time."""
    minima[:] = np.inf
    for start in range(0, offsets.size, LANES):
        part, more = products[start : start + LANES], offsets[start : start + LANES]
        for q in range(part.size):
            rounded = part[q] + more[q]
            minima[q] = rounded if rounded < minima[q] else minima[q]


@kernel(fastmath={"reassoc"})
@no_type_check
def _exact(d, mean, variances):  # pragma: no cover - compiled
    """Return a distance in double precision, to which the order of its terms means nothing.

    No variances are as good as ones.
    """
    total = 0.0
    if variances.size == 0:
        for k in range(d.size):
            total += (d[k] - mean[k]) * (d[k] - mean[k])
        return total
    for k in range(d.size):
        step = d[k] - mean[k]
        total += step * step / variances[k]
    return total


@kernel()
@no_type_check
def _pick(
    products, offsets, bounds, found, means, variances, logs, classes, distances
):  # pragma: no cover - compiled
    """Pick by the rounded sums all that may be among the two nearest, and these by exact ones.

    The columns lie in lanes, every 64th in one. The second least of the lanes is not less than the
    second least of all columns.
    """
    minima = np.empty(LANES, dtype=np.float32)
    for i in range(len(products)):
        _least(products[i], offsets, minima)
        first = second = np.inf
        for value in minima:
            first, second = (value, first) if value < first else (first, min(value, second))
        limit = second + 2 * bounds[i]
        for lane in range(LANES):
            if minima[lane] > limit:
                continue
            for j in range(lane, offsets.size, LANES):
                if products[i, j] + offsets[j] <= limit:
                    total = _exact(found[i], means[j], variances[j]) + logs[j]
                    if (total, j) < (distances[i, 0], classes[i, 0]):
                        classes[i, 1], distances[i, 1] = classes[i, 0], distances[i, 0]
                        classes[i, 0], distances[i, 0] = j, total
                    elif (total, j) < (distances[i, 1], classes[i, 1]):
                        classes[i, 1], distances[i, 1] = j, total
