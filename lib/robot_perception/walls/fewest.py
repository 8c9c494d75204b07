r"""The fewest vertices: the best chain that polyline simplification is an answer to.

Splitting at the farthest vertex looks at one chord after the other and never goes back. Here every
chord from which no vertex between its ends is farther than the tolerance is an edge of a graph, and
the shortest way through this graph is the chain with the fewest segments (Imai and Iri, 1988).
"""

import math
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception.kernels import kernel
from robot_perception.walls.chains import as_chain, bad_point, check_tolerance, first_bad_point


def simplify_fewest(chain: Float[np.ndarray, "n 2"], tolerance: float) -> Int[np.ndarray, " kept"]:
    r"""Simplify a chain to the fewest segments that stay within the tolerance.

    .. math:: c_j = 1 + \min_{i < j,\; d_{ij} \le \varepsilon} c_i , \qquad c_0 = 0 ,

    with :math:`d_{ij}` the distance of the vertex farthest from the line through the vertices i and
    j, as in :func:`~robot_perception.walls.simplify`. Of several chains with as few segments the
    one whose left-out vertices have the least sum of squared distances is returned. The time is
    cubic in the worst case: for scans, not for coastlines.

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
    Imai and Iri (1988).
    """
    chain = as_chain(chain)
    check_tolerance(tolerance)
    kept, bad = fewest_kernel(chain, float(tolerance))
    if bad >= 0:
        raise bad_point(chain, bad)
    return kept


@kernel()
@no_type_check
def fewest_kernel(points, tolerance):
    """Return the indices kept, and -1 or the first point that is bad."""
    n = points.shape[0]
    bad = first_bad_point(points)
    if bad >= 0:
        return np.empty(0, np.int64), bad
    segments, squares = np.full(n, n, np.int64), np.zeros(n)
    before = np.zeros(n, np.int64)
    segments[0] = 0
    for j in range(1, n):
        for i in range(j - 1, -1, -1):
            if segments[i] + 1 > segments[j]:
                continue
            left_out = chord_kernel(points, i, j, tolerance)
            if left_out < 0.0:
                continue
            total = squares[i] + left_out
            if segments[i] + 1 < segments[j] or total < squares[j]:
                segments[j], squares[j], before[j] = segments[i] + 1, total, i
    kept = np.empty(segments[n - 1] + 1, np.int64)
    kept[0], last = 0, n - 1
    for place in range(segments[n - 1], 0, -1):
        kept[place], last = last, before[last]
    return kept, -1


@kernel()
@no_type_check
def chord_kernel(points, i, j, tolerance):
    """Return the sum of squared distances from a chord, or -1 if one exceeds the tolerance."""
    x, y = points[i, 0], points[i, 1]
    dx, dy = points[j, 0] - x, points[j, 1] - y
    length, total = math.hypot(dx, dy), 0.0
    for k in range(i + 1, j):
        if length == 0.0:  # no line: the distance to the point
            d = math.hypot(points[k, 0] - x, points[k, 1] - y)
        else:
            d = abs(dx * (points[k, 1] - y) - dy * (points[k, 0] - x)) / length
        if d > tolerance:
            return -1.0
        total += d * d
    return total
