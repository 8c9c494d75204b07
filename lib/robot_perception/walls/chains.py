r"""Polyline simplification: iterative end-point fit, as text and as a compiled loop.

A chain is an array of shape ``(n, 2)``. All functions return the indices of the vertices kept,
always including the first and the last, and share three conventions.

* The distance of a vertex is taken to the *line* through the end points of its sub-chain,
  :math:`|(v_j - v_i) \times (v_k - v_i)| / \lVert v_j - v_i \rVert`, not to the segment between
  them. A vertex beyond an end point but near the line counts as near.
* If the end points coincide there is no line, and the distance is taken to the point.
* Of several farthest vertices the one of lowest index splits the chain. What is compared is the
  determinant, before it is divided by the length, so that one rounding rule decides all ties.
"""

import math
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception.checks import LARGEST, array, positive, reals, whole
from robot_perception.kernels import kernel

LIMIT = 1e150  # products of two coordinates must stay finite


def check_tolerance(tolerance: float) -> None:
    """Raise ``ValueError`` unless the tolerance is a positive finite number."""
    if type(tolerance) is float and 1 / LARGEST <= tolerance <= LARGEST:
        return  # a check of any number takes half as long as a scan
    positive("tolerance", tolerance)


def as_chain(points: np.ndarray) -> Float[np.ndarray, "n 2"]:
    """Return the points as a contiguous array of floats.

    Raises
    ------
    ValueError
        If the shape is not ``(n, 2)`` with at least two points.
    """
    points = np.ascontiguousarray(reals("chain", points), dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ValueError(f"a chain must be (n, 2) with n >= 2, got {points.shape}")
    return points


def bad_point(points: np.ndarray, index: int) -> ValueError:
    """Return the error that names the first point that is not finite."""
    place = points[index].tolist()
    return ValueError(
        f"chain: point {index} is {place}: coordinates must be finite and below {LIMIT:g}"
    )


def find_split(chain: Float[np.ndarray, "n 2"], i: int, j: int) -> tuple[int, float]:
    r"""Find the vertex farthest from the line through two vertices.

    .. math:: d_k = \frac{|\tilde v_i\; \tilde v_j\; \tilde v_k|}{\lVert v_i - v_j \rVert}

    Parameters
    ----------
    chain
        Vertices, m.
    i, j
        Ends of the sub-chain, ``i < j``.

    Returns
    -------
    f, d
        Index of the farthest vertex strictly between ``i`` and ``j`` and its distance, m;
        ``(i, 0.0)`` if every vertex lies on the line.

    Raises
    ------
    ValueError
        If the chain is not (n, 2) and finite, or an end is none of its vertices.

    References
    ----------
    Andrade-Cetto, Perception Issues in Mobile Robotics, Table 2. The table divides by the square
    of the length; a distance needs the length (erratum-table2).
    """
    chain = array("chain", chain, ("n", 2))
    i = whole("i", i, 0, len(chain) - 1)
    j = whole("j", j, i, len(chain) - 1)
    chord = chain[j] - chain[i]
    length = np.hypot(*chord)
    f, height = i, 0.0
    for k in range(i + 1, j):
        arm = chain[k] - chain[i]
        turn = chord[0] * arm[1] - chord[1] * arm[0]
        height_k = abs(turn) if length > 0.0 else np.hypot(*arm)  # chain closed
        if height_k > height:
            f, height = k, height_k
    return f, float(height / length if length > 0.0 else height)  # Table 2, mended


def simplify_recursive(
    chain: Float[np.ndarray, "n 2"], tolerance: float
) -> Int[np.ndarray, " kept"]:
    """Simplify a chain by splitting it at the farthest vertex: the version to read.

    It needs one level of Python's call stack for every level of splitting and is slow; use
    :func:`simplify` for work, whose parameters, returns and errors it has.

    Raises
    ------
    RecursionError
        If the chain is split more levels deep than Python's stack allows.

    References
    ----------
    Andrade-Cetto, Table 1; Douglas and Peucker (1973); Ramer (1972).
    """
    chain = as_chain(chain)
    check_tolerance(tolerance)
    bad = np.flatnonzero(~(np.abs(chain) < LIMIT).all(axis=1))
    if bad.size:
        raise bad_point(chain, int(bad[0]))

    def line_simplification(i: int, j: int) -> list[int]:  # Table 1
        f, d = find_split(chain, i, j)
        if d > tolerance:
            return line_simplification(i, f) + line_simplification(f, j)
        return [j]

    return np.array([0, *line_simplification(0, len(chain) - 1)])


def simplify(chain: Float[np.ndarray, "n 2"], tolerance: float) -> Int[np.ndarray, " kept"]:
    """Simplify a chain by splitting it at the farthest vertex: the version to use.

    The same vertices as :func:`simplify_recursive`, from a compiled loop with an explicit stack.
    The time is quadratic in the worst case; see
    :func:`~robot_perception.walls.simplify_path_hull` for long chains without self-intersection.

    Parameters
    ----------
    chain
        Vertices in order, m.
    tolerance
        Largest distance from the line that is let go, m.

    Returns
    -------
    Indices of the vertices kept, increasing.

    Raises
    ------
    ValueError
        If the chain has fewer than two points, a point is not finite, or the tolerance is not
        positive.

    References
    ----------
    Andrade-Cetto, Tables 1 and 2; Douglas and Peucker (1973).
    """
    return _simplified(chain, tolerance)[0]


def count_distances(chain: Float[np.ndarray, "n 2"], tolerance: float) -> int:
    """Return how many distances :func:`simplify` evaluates on a chain."""
    return _simplified(chain, tolerance)[1]


def _simplified(chain: np.ndarray, tolerance: float) -> tuple[np.ndarray, int]:
    chain = as_chain(chain)
    check_tolerance(tolerance)
    kept, count = simplify_kernel(chain, float(tolerance))
    if count < 0:
        raise bad_point(chain, -1 - count)
    return kept, count


@kernel()
@no_type_check
def first_bad_point(points):
    """Return the index of the first point that is not finite or too large, or -1."""
    bad = False
    for k in range(points.shape[0]):
        bad |= not (abs(points[k, 0]) < LIMIT) or not (abs(points[k, 1]) < LIMIT)
    if bad:
        for k in range(points.shape[0]):
            if not (abs(points[k, 0]) < LIMIT and abs(points[k, 1]) < LIMIT):
                return k
    return -1


@kernel()
@no_type_check
def farthest_kernel(points, i, j):
    """Return the farthest vertex between two others, its height and the height's unit.

    The height is the determinant of Table 2, or the squared distance if the ends coincide; times
    the unit it is a distance.
    """
    x, y = points[i, 0], points[i, 1]
    dx, dy = points[j, 0] - x, points[j, 1] - y
    f, height = i, 0.0
    if dx == 0.0 and dy == 0.0:
        for k in range(i + 1, j):
            h = math.hypot(points[k, 0] - x, points[k, 1] - y)
            if h > height:
                f, height = k, h
        return f, height, 1.0
    for k in range(i + 1, j):
        h = abs(dx * (points[k, 1] - y) - dy * (points[k, 0] - x))
        if h > height:
            f, height = k, h
    return f, height, math.hypot(dx, dy)


@kernel()
@no_type_check
def simplify_kernel(points, tolerance):
    """Return the indices kept and the number of distances; ``-1 - k`` if point ``k`` is bad."""
    n = points.shape[0]
    bad = first_bad_point(points)
    if bad >= 0:
        return np.empty(0, np.int64), -1 - bad
    kept = np.empty(n, np.int64)
    ends = np.empty(n, np.int64)  # right ends of the sub-chains still to be looked at
    kept[0], ends[0] = 0, n - 1
    count, waiting, distances = 1, 1, 0
    i = 0
    while waiting > 0:
        j = ends[waiting - 1]
        f, height, length = farthest_kernel(points, i, j)
        distances += j - i - 1
        if height / length > tolerance:
            ends[waiting] = f
            waiting += 1
        else:
            kept[count] = j
            count += 1
            waiting -= 1
            i = j
    return kept[:count].copy(), distances
