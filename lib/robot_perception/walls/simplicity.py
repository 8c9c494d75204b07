"""Does a chain intersect itself, and where?

Path hulls are right only for simple chains. The check encloses the edges of every stretch of the
chain in an octagon (the bounds of u, v, u + v and u - v, with axes u and v along the chain's most
common directions), in a binary tree over the chain, and compares only those stretches whose
octagons overlap. On scans, spirals and zigzags that is nearly linear; long edges packed side by
side in many directions can still make it quadratic.
"""

import math
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int
from numba import njit

from robot_perception.walls.chains import as_chain, bad_point, first_bad_point

_LEAF = 4  # edges per leaf of the tree
_NAMED = 5  # crossings named in an error
_ROUNDING = 8 * np.finfo(np.float64).eps


def find_crossings(
    chain: Float[np.ndarray, "n 2"], *, at_most: int = 1000
) -> Int[np.ndarray, "crossings 2"]:
    """Find the pairs of edges in which a chain crosses, touches or overlaps itself.

    Edge ``k`` leads from vertex ``k`` to ``k + 1``. Neighbouring edges share a vertex and count
    only if one folds back over the other; the last edge may end where the first begins. Edges of
    no length (repeated points) are left out. Contact within rounding counts.

    Parameters
    ----------
    chain
        Vertices in order, m.
    at_most
        The search stops after this many pairs.

    Returns
    -------
    Pairs of edge indices, the lower first, in increasing order.

    Raises
    ------
    ValueError
        If the chain has fewer than two points or a point is not finite.
    """
    chain = as_chain(chain)
    bad = first_bad_point(chain)
    if bad >= 0:
        raise bad_point(chain, bad)
    if _is_monotone(chain):
        return np.empty((0, 2), np.int64)
    edges = np.flatnonzero((chain[1:] != chain[:-1]).any(axis=1))
    if edges.size < 2:
        return np.empty((0, 2), np.int64)
    pairs = _crossings(chain, edges, at_most)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def is_simple(chain: Float[np.ndarray, "n 2"]) -> bool:
    """Return whether a chain neither crosses, touches nor overlaps itself; it may be closed."""
    return len(find_crossings(chain, at_most=1)) == 0


def require_simple(chain: Float[np.ndarray, "n 2"]) -> None:
    """Raise ``ValueError`` with the crossing edges if a chain intersects itself."""
    pairs = find_crossings(chain, at_most=_NAMED + 1)
    if len(pairs):
        named = ", ".join(f"{a} and {b}" for a, b in pairs[:_NAMED])
        more = ", and more" if len(pairs) > _NAMED else ""
        raise ValueError(f"the chain intersects itself: edges {named}{more}")


@njit(cache=True)
@no_type_check
def _is_monotone(points):
    """Whether x or y strictly increases or decreases along the chain, which makes it simple."""
    n = points.shape[0]
    for axis in range(2):
        sign = 1.0 if points[n - 1, axis] > points[0, axis] else -1.0
        k = 1
        while k < n and sign * (points[k, axis] - points[k - 1, axis]) > 0.0:
            k += 1
        if k == n:
            return True
    return False


@njit(cache=True)
@no_type_check
def _side(points, a, b, p):
    """Side of ``p`` from the line through ``a`` and ``b``: 1, -1, or 0 within rounding."""
    ex, ey = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    px, py = points[p, 0] - points[a, 0], points[p, 1] - points[a, 1]
    left, right = ex * py, ey * px
    turn = left - right
    if abs(turn) <= _ROUNDING * (abs(left) + abs(right)):
        return 0
    return 1 if turn > 0.0 else -1


@njit(cache=True)
@no_type_check
def _between(points, a, b, p):
    """Whether ``p`` lies in the box of ``a`` and ``b``."""
    for axis in range(2):
        low, high = points[a, axis], points[b, axis]
        if low > high:
            low, high = high, low
        if not low <= points[p, axis] <= high:
            return False
    return True


@njit(cache=True)
@no_type_check
def _meet(points, e, f, neighbours, closed):
    """Whether edges ``e < f`` of the chain have a point in common that they should not."""
    a, b, c, d = e, e + 1, f, f + 1
    if neighbours:  # b and c are the same point
        folded = (points[b, 0] - points[a, 0]) * (points[d, 0] - points[c, 0]) + (
            points[b, 1] - points[a, 1]
        ) * (points[d, 1] - points[c, 1]) < 0.0
        return folded and _side(points, a, b, d) == 0
    if closed:  # a and d are the same point
        folded = (points[b, 0] - points[a, 0]) * (points[c, 0] - points[d, 0]) + (
            points[b, 1] - points[a, 1]
        ) * (points[c, 1] - points[d, 1]) > 0.0
        return folded and _side(points, a, b, c) == 0
    side_c, side_d = _side(points, a, b, c), _side(points, a, b, d)
    side_a, side_b = _side(points, c, d, a), _side(points, c, d, b)
    if side_c * side_d < 0 and side_a * side_b < 0:
        return True
    return (
        (side_c == 0 and _between(points, a, b, c))
        or (side_d == 0 and _between(points, a, b, d))
        or (side_a == 0 and _between(points, c, d, a))
        or (side_b == 0 and _between(points, c, d, b))
    )


@njit(cache=True)
@no_type_check
def _axis(points, edges):
    """Direction, modulo a right angle, of the edges weighted by length: its cosine and sine."""
    along = across = 0.0
    for e in edges:
        x, y = points[e + 1, 0] - points[e, 0], points[e + 1, 1] - points[e, 1]
        angle = 4.0 * math.atan2(y, x)
        length = math.hypot(x, y)
        along += length * math.cos(angle)
        across += length * math.sin(angle)
    angle = math.atan2(across, along) / 4.0
    return math.cos(angle), math.sin(angle)


@njit(cache=True)
@no_type_check
def _octagons(points, edges):
    """Bounds of u, v, u + v and u - v for the leaves and inner nodes of a binary heap."""
    cos, sin = _axis(points, edges)
    leaves = 1
    while leaves * _LEAF < edges.size:
        leaves *= 2
    bounds = np.empty((2 * leaves, 8))
    bounds[:, :4] = np.inf
    bounds[:, 4:] = -np.inf
    values = np.empty(4)
    for e in range(edges.size):
        node = leaves + e // _LEAF
        for k in range(edges[e], edges[e] + 2):
            u = cos * points[k, 0] + sin * points[k, 1]
            v = cos * points[k, 1] - sin * points[k, 0]
            values[0], values[1], values[2], values[3] = u, v, u + v, u - v
            for q in range(4):
                bounds[node, q] = min(bounds[node, q], values[q])
                bounds[node, 4 + q] = max(bounds[node, 4 + q], values[q])
    for node in range(leaves - 1, 0, -1):
        for q in range(4):
            bounds[node, q] = min(bounds[2 * node, q], bounds[2 * node + 1, q])
            bounds[node, 4 + q] = max(bounds[2 * node, 4 + q], bounds[2 * node + 1, 4 + q])
    return bounds, leaves


@njit(cache=True)
@no_type_check
def _crossings(points, edges, at_most):
    n = points.shape[0]
    bounds, leaves = _octagons(points, edges)
    slack = _ROUNDING * max(np.max(np.abs(bounds[1])), 0.0)
    is_closed = points[0, 0] == points[n - 1, 0] and points[0, 1] == points[n - 1, 1]
    pairs = np.empty((at_most, 2), np.int64)
    count, waiting = 0, 1
    stack = np.empty((256, 2), np.int64)
    stack[0, 0] = stack[0, 1] = 1
    while waiting > 0 and count < at_most:
        waiting -= 1
        one, other = stack[waiting, 0], stack[waiting, 1]
        apart = False
        for q in range(4):
            apart |= bounds[one, q] > bounds[other, 4 + q] + slack
            apart |= bounds[other, q] > bounds[one, 4 + q] + slack
        if apart:
            continue
        if one < leaves:  # both are inner nodes: they are always on one level
            stack[waiting, 0], stack[waiting, 1] = 2 * one, 2 * other
            stack[waiting + 1, 0], stack[waiting + 1, 1] = 2 * one, 2 * other + 1
            stack[waiting + 2, 0], stack[waiting + 2, 1] = 2 * one + 1, 2 * other + 1
            waiting += 3
            if one != other:
                stack[waiting, 0], stack[waiting, 1] = 2 * one + 1, 2 * other
                waiting += 1
            continue
        for p in range((one - leaves) * _LEAF, min((one - leaves + 1) * _LEAF, edges.size)):
            first = p + 1 if one == other else (other - leaves) * _LEAF
            for q in range(first, min((other - leaves + 1) * _LEAF, edges.size)):
                closed = is_closed and p == 0 and q == edges.size - 1
                if edges.size == 2 and closed:  # there and back again
                    found = True
                else:
                    found = _meet(points, edges[p], edges[q], q == p + 1, closed)
                if found and count < at_most:
                    pairs[count, 0], pairs[count, 1] = edges[p], edges[q]
                    count += 1
    return pairs[:count]
