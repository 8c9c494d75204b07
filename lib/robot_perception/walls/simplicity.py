"""Does a chain intersect itself, and where?

Path hulls are right only for simple chains. A sweep line decides (Shamos and Hoey, 1976): it meets
the vertices from left to right, keeps the edges that it cuts in their order from below to above,
and compares each edge with those that ever stand next to it, for the first crossing is between two
such edges. Orientations that rounding leaves open are computed exactly, so that the order is never
wrong. The order is kept in a treap, which makes O(n log n) steps for any chain.

Where a chain crosses itself, all crossings are listed by enclosing the edges of every stretch in an
octagon (the bounds of u, v, u + v and u - v, with axes u and v along the chain's most common
directions), in a binary tree over the chain, and comparing only those stretches whose octagons
overlap.
"""

import math
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception.checks import whole
from robot_perception.kernels import kernel
from robot_perception.walls.chains import as_chain, bad_point, first_bad_point

_LEAF = 4  # edges per leaf of the tree
_NAMED = 5  # crossings named in an error
_SPLITTER = 2.0**27 + 1.0  # splits a number into two of half as many digits
_ROUNDING = 8 * np.finfo(np.float64).eps


def find_crossings(
    chain: Float[np.ndarray, "n 2"], *, at_most: int = 1000
) -> Int[np.ndarray, "crossings 2"]:
    """Find the pairs of edges in which a chain crosses, touches or overlaps itself.

    That there are none is found in O(n log n); to list them can take quadratic time.

    Edge ``k`` leads from vertex ``k`` to ``k + 1``. Neighbouring edges share a vertex and count
    only if one folds back over the other; the last edge may end where the first begins. Edges of
    no length (repeated points) are left out. Contact within rounding counts.

    Parameters
    ----------
    chain
        Vertices in order, m.
    at_most
        The search stops after this many pairs, at most ten million.

    Returns
    -------
    Pairs of edge indices, the lower first, in increasing order.

    Raises
    ------
    ValueError
        If the chain has fewer than two points, a point is not finite, or ``at_most`` is out of
        range.
    """
    chain = as_chain(chain)
    at_most = whole("at_most", at_most, 1, 10**7)
    if not _contact(chain)[0].size:
        return np.empty((0, 2), np.int64)
    pairs = _crossings(chain, _edges(chain), at_most)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def is_simple(chain: Float[np.ndarray, "n 2"]) -> bool:
    """Return whether a chain neither crosses, touches nor overlaps itself; it may be closed.

    The time is O(n log n).
    """
    return not _contact(as_chain(chain))[0].size


def count_sweep_steps(chain: Float[np.ndarray, "n 2"]) -> int:
    """Return how many elementary steps :func:`is_simple` takes on a chain.

    A step is one vertex read, or one comparison of an edge with another under the sweep line.
    """
    return _contact(as_chain(chain))[1]


def require_simple(chain: Float[np.ndarray, "n 2"]) -> None:
    """Raise ``ValueError`` with the crossing edges if a chain intersects itself."""
    pairs = find_crossings(chain, at_most=_NAMED + 1)
    if len(pairs):
        named = ", ".join(f"{a} and {b}" for a, b in pairs[:_NAMED])
        more = ", and more" if len(pairs) > _NAMED else ""
        raise ValueError(f"the chain intersects itself: edges {named}{more}")


def _contact(chain: np.ndarray) -> tuple[np.ndarray, int]:
    """Return two edges in contact, or none if the chain is simple, and the steps taken."""
    bad = first_bad_point(chain)
    if bad >= 0:
        raise bad_point(chain, bad)
    edges = np.empty(0, np.int64) if _is_monotone(chain) else _edges(chain)
    if edges.size < 2:
        return np.empty(0, np.int64), len(chain)
    vertices = chain[np.r_[edges, edges[-1] + 1]]
    is_closed = bool((vertices[0] == vertices[-1]).all())
    order = np.lexsort((vertices[:, 1], vertices[:, 0]))
    if is_closed:
        order = order[order < edges.size]
    pair, steps = _sweep(vertices, is_closed, order)
    return edges[pair], len(chain) + steps


def _edges(chain: np.ndarray) -> np.ndarray:
    """Return the indices of the edges that have a length."""
    return np.flatnonzero((chain[1:] != chain[:-1]).any(axis=1))


@kernel()
@no_type_check
def _is_monotone(points):
    """Tell whether x or y strictly rises or falls along the chain, which makes it simple."""
    n = points.shape[0]
    for axis in range(2):
        sign = 1.0 if points[n - 1, axis] > points[0, axis] else -1.0
        k = 1
        while k < n and sign * (points[k, axis] - points[k - 1, axis]) > 0.0:
            k += 1
        if k == n:
            return True
    return False


@kernel()
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


@kernel()
@no_type_check
def _between(points, a, b, p):
    """Tell whether ``p`` lies in the box of ``a`` and ``b``."""
    for axis in range(2):
        low, high = points[a, axis], points[b, axis]
        if low > high:
            low, high = high, low
        if not low <= points[p, axis] <= high:
            return False
    return True


@kernel()
@no_type_check
def _meet(points, e, f, neighbours, closed):
    """Tell whether edges ``e < f`` of the chain have a point in common that they should not."""
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


@kernel()
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


@kernel()
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


@kernel()
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


@kernel()
@no_type_check
def exact_side(points, a, b, p):
    """Side of ``p`` from the line through ``a`` and ``b``: the sign of the exact determinant.

    Its six products are split into twelve numbers without rounding and added as an expansion,
    whose last component that is not zero has the sign of the sum (Shewchuk, 1997).
    """
    parts = np.empty(12)
    corners = (a, b, p, a)
    size = 0
    for k in range(3):
        for axis in range(2):
            one, other = points[corners[k], axis], points[corners[k + 1], 1 - axis]
            if axis == 1:
                other = -other
            high = _SPLITTER * one - (_SPLITTER * one - one)
            high_other = _SPLITTER * other - (_SPLITTER * other - other)
            low, low_other = one - high, other - high_other
            product = one * other
            error = high * high_other - product
            error = low * low_other + (error + low * high_other + high * low_other)
            for term in (error, product):
                for q in range(size):
                    total = term + parts[q]
                    part = total - term
                    parts[q], term = (term - (total - part)) + (parts[q] - part), total
                parts[size] = term
                size += 1
    for q in range(size - 1, -1, -1):
        if parts[q] != 0.0:
            return 1 if parts[q] > 0.0 else -1
    return 0


@kernel()
@no_type_check
def _touch(points, e, f, is_closed):
    """Tell whether edges ``e`` and ``f``, in any order, meet; both have a length."""
    e, f = min(e, f), max(e, f)
    return _meet(points, e, f, f == e + 1, is_closed and e == 0 and f == points.shape[0] - 2)


@kernel()
@no_type_check
def _priorities(m):
    """Numbers in an order that looks random: the generator splitmix64."""
    priority = np.empty(m, np.uint64)
    state = np.uint64(0)
    for e in range(m):
        state += np.uint64(0x9E3779B97F4A7C15)
        bits = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        priority[e] = bits ^ (bits >> np.uint64(31))
    return priority


@kernel()
@no_type_check
def _take_out(e, child, parent, priority):
    """Take an edge out of the treap by merging the subtrees below it."""
    at = parent[e]
    side = 0 if child[at, 0] == e else 1
    low, high = child[e, 0], child[e, 1]
    while low >= 0 or high >= 0:
        if high < 0 or (low >= 0 and priority[low] > priority[high]):
            child[at, side], parent[low] = low, at
            at, side, low = low, 1, child[low, 1]
        else:
            child[at, side], parent[high] = high, at
            at, side, high = high, 0, child[high, 0]
    child[at, side] = -1


@kernel()
@no_type_check
def _sweep(points, is_closed, order):
    """Find two edges in contact in a chain without edges of no length, and count the steps.

    Parameters
    ----------
    points
        Vertices, the first repeated at the end if the chain is closed.
    is_closed
        Whether it is.
    order
        Distinct vertices by x, then y.

    Returns
    -------
    pair, steps
        The edges, the lower first, or an empty array; comparisons made.
    """
    m = points.shape[0] - 1
    rank = np.empty(m + 1, np.int64)
    for q in range(order.size):
        rank[order[q]] = q
        i, j = min(order[q - 1], order[q]), max(order[q - 1], order[q])
        if q > 0 and points[i, 0] == points[j, 0] and points[i, 1] == points[j, 1]:
            return np.array([i, j - 1]), q  # two vertices in one place
    if is_closed:
        rank[m] = rank[0]
    # The treap: node m is above the root, child -1 is none; neighbour m is none.
    child, parent = np.full((m + 1, 2), -1), np.full(m, m)
    beside = np.full((m + 1, 2), m)  # the edges next below and above
    priority = _priorities(m)
    steps = 0
    for v in order:
        edges = (v - 1 if v > 0 or not is_closed else m - 1, v if v < m else -1)
        for e in edges:
            if e < 0 or min(rank[e], rank[e + 1]) == rank[v]:
                continue  # the edges that end here
            _take_out(e, child, parent, priority)
            below, above = beside[e, 0], beside[e, 1]
            beside[below, 1], beside[above, 0] = above, below
            steps += 1
            if below < m and above < m and _touch(points, below, above, is_closed):
                return np.array([min(below, above), max(below, above)]), steps
        for e in edges:
            if e < 0 or max(rank[e], rank[e + 1]) == rank[v]:
                continue  # the edges that start here
            end = e + 1 if rank[e] == rank[v] else e
            node, below, above = child[m, 0], m, m
            hung = False  # on the way down the edge takes its place and splits what is below it
            low = high = m, 0  # where the next node below it and the next above it hang
            while node >= 0 or not hung:
                if not hung and (node < 0 or priority[e] > priority[node]):
                    child[low[0], low[1]], parent[e] = e, low[0]
                    low, high, hung = (e, 0), (e, 1), True
                    continue
                steps += 1
                a, b = (node, node + 1) if rank[node] < rank[node + 1] else (node + 1, node)
                p = end if rank[a] == rank[v] else v
                side = _side(points, a, b, p)
                if side == 0:
                    if _touch(points, e, node, is_closed):
                        return np.array([min(e, node), max(e, node)]), steps
                    side = exact_side(points, a, b, p)
                if side > 0:
                    if hung:
                        child[low[0], low[1]], parent[node] = node, low[0]
                    low, below, node = (node, 1), node, child[node, 1]
                    high = high if hung else low
                else:
                    if hung:
                        child[high[0], high[1]], parent[node] = node, high[0]
                    high, above, node = (node, 0), node, child[node, 0]
                    low = low if hung else high
            child[low[0], low[1]] = child[high[0], high[1]] = -1
            beside[e, 0], beside[e, 1] = below, above
            beside[below, 1], beside[above, 0] = e, e
            for other in (below, above):
                steps += 1
                if other < m and _touch(points, e, other, is_closed):
                    return np.array([min(e, other), max(e, other)]), steps
    return np.empty(0, np.int64), steps
