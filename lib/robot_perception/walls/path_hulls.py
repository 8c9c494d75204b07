r"""Simplification with path hulls: the farthest vertex by binary search on convex hulls.

The vertex farthest from a line is a vertex of the convex hull. A *path hull* grows the hull of a
chain from one vertex, the tag, outwards to one end and remembers every change, so that it can be
shrunk again to any earlier vertex. A sub-chain is kept as two path hulls that meet at its tag;
a split at a vertex of one hull shrinks that hull, keeps the other as it is, and only the part cut
off (less than half of the chain the hulls were built for) must be built anew.

The hulls are grown with Melkman's algorithm, which is right only for a chain that does not
intersect itself, and with exact orientations: rounding among vertices in one line would otherwise
collapse a hull.
"""

import math
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception.checks import flag
from robot_perception.kernels import kernel
from robot_perception.walls.chains import (
    as_chain,
    bad_point,
    check_tolerance,
    farthest_kernel,
    first_bad_point,
)
from robot_perception.walls.simplicity import exact_side, require_simple

_PUSH, _POP_TOP, _POP_BOTTOM = 0, 1, 2  # events in a hull's history
_SMALL = 10  # hulls of fewer vertices are searched one by one
_ROUNDING = 16 * np.finfo(np.float64).eps


def simplify_path_hull(
    chain: Float[np.ndarray, "n 2"], tolerance: float, *, assume_simple: bool = False
) -> Int[np.ndarray, " kept"]:
    """Simplify a chain that does not intersect itself, in O(n log n), check included.

    The same vertices as :func:`~robot_perception.walls.simplify`. Where two vertices are farthest
    up to rounding, or the farthest is at the tolerance up to rounding, all vertices are looked at,
    as the plain algorithm does, until that has cost ``4 n log2 n`` steps; from then on the lowest
    index among the hull's farthest vertices splits.

    Parameters
    ----------
    chain
        Vertices in order, m.
    tolerance
        Largest distance from the line that is let go, m.
    assume_simple
        ``True`` skips the check for self-intersection; on a chain that intersects itself the
        result may then lack vertices that lie farther than the tolerance.

    Returns
    -------
    Indices of the vertices kept, increasing.

    Raises
    ------
    ValueError
        If the chain has fewer than two points, a point is not finite, the tolerance is not
        positive, or the chain intersects itself; the error names edges, which can take
        quadratic time to list.

    References
    ----------
    Hershberger and Snoeyink (1992); Melkman (1987); Andrade-Cetto, section 2.1.
    """
    chain = as_chain(chain)
    check_tolerance(tolerance)
    if not flag("assume_simple", assume_simple):
        require_simple(chain)
    return _simplified(chain, tolerance)[0]


def count_hull_steps(chain: Float[np.ndarray, "n 2"], tolerance: float) -> int:
    """Return how many elementary steps the path hulls take on a chain assumed to be simple.

    A step is one orientation test, one slope or distance evaluation, or one event undone.
    """
    chain = as_chain(chain)
    check_tolerance(tolerance)
    return _simplified(chain, tolerance)[1]


def _simplified(chain: np.ndarray, tolerance: float) -> tuple[np.ndarray, int]:
    bad = first_bad_point(chain)
    if bad >= 0:
        raise bad_point(chain, bad)
    if not _has_repeats(chain):
        return path_hull_kernel(chain, float(tolerance))
    # a point repeated on the spot can only split a chain where it stands first
    last = len(chain) - 1
    firsts = np.flatnonzero(np.r_[True, (chain[1:] != chain[:-1]).any(axis=1)])
    if firsts.size == 1:
        return np.array([0, last]), last
    kept, steps = path_hull_kernel(chain[firsts], float(tolerance))
    kept = firsts[kept]
    kept[-1] = last
    return kept, steps + last


@kernel()
@no_type_check
def _has_repeats(points):
    repeats = False
    for k in range(1, points.shape[0]):
        repeats |= points[k, 0] == points[k - 1, 0] and points[k, 1] == points[k - 1, 1]
    return repeats


@kernel()
@no_type_check
def _outside(points, a, b, p, side):
    """Tell whether ``p`` is outside of the hull edge from ``a`` to ``b``, or extends it."""
    ex, ey = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    left, right = ex * (points[p, 1] - points[a, 1]), ey * (points[p, 0] - points[a, 0])
    turn = left - right
    if abs(turn) <= _ROUNDING * (abs(left) + abs(right)):
        turn = float(exact_side(points, a, b, p))
    if turn != 0.0:
        return side * turn < 0.0
    return ex * (points[p, 0] - points[b, 0]) + ey * (points[p, 1] - points[b, 1]) > 0.0


@kernel()
@no_type_check
def _grow(points, hull, vertices, events, tag, end):
    """Build the path hull from the tag to an end.

    ``hull[bottom : top + 1]`` lists the vertices counter-clockwise, the latest one at both ends.

    Returns
    -------
    bottom, top, count, steps
        Ends of the hull, length of the history, steps taken.
    """
    step = 1 if end > tag else -1
    middle = hull.shape[0] // 2
    bottom, top, count, steps = middle - 1, middle + 1, 1, 0
    hull[middle] = tag
    hull[bottom] = hull[top] = vertices[0] = tag + step
    events[0] = _PUSH
    p = tag + step
    while p != end:
        p += step
        over = _outside(points, hull[top - 1], hull[top], p, 1.0)
        under = _outside(points, hull[bottom + 1], hull[bottom], p, -1.0)
        steps += 2
        if not (over or under):
            continue
        while over:
            vertices[count], events[count] = hull[top], _POP_TOP
            count += 1
            top -= 1
            over = top > bottom and _outside(points, hull[top - 1], hull[top], p, 1.0)
            steps += 1
        while under:
            vertices[count], events[count] = hull[bottom], _POP_BOTTOM
            count += 1
            bottom += 1
            under = bottom < top and _outside(points, hull[bottom + 1], hull[bottom], p, -1.0)
            steps += 1
        bottom -= 1
        top += 1
        hull[bottom] = hull[top] = vertices[count] = p
        events[count] = _PUSH
        count += 1
    return bottom, top, count, steps


@kernel()
@no_type_check
def _shrink(hull, vertices, events, bottom, top, count, vertex):
    """Undo the history of a path hull back to the moment when a vertex was pushed.

    The count is 0 if it never was: it lies on the hull's boundary and tied with a corner.
    """
    steps = 0
    while count > 0 and (events[count - 1] != _PUSH or vertices[count - 1] != vertex):
        count -= 1
        steps += 1
        if events[count] == _PUSH:
            bottom += 1
            top -= 1
        elif events[count] == _POP_TOP:
            top += 1
            hull[top] = vertices[count]
        else:
            bottom -= 1
            hull[bottom] = vertices[count]
    return bottom, top, count, steps


@kernel()
@no_type_check
def _height(points, i, j, k):
    """Signed determinant of Table 2: distance of ``k`` from the line times the line's length."""
    x, y = points[i, 0], points[i, 1]
    dx, dy = points[j, 0] - x, points[j, 1] - y
    return dx * (points[k, 1] - y) - dy * (points[k, 0] - x)


@kernel()
@no_type_check
def _rises(points, i, j, a, b):
    """Tell whether the hull edge from ``a`` to ``b`` leads away from the line, to its left."""
    dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
    return dx * (points[b, 1] - points[a, 1]) - dy * (points[b, 0] - points[a, 0]) > 0.0


@kernel()
@no_type_check
def _scan(points, hull, bottom, top, i, j):
    """Farthest hull vertex, its height and the second height, by looking at every vertex."""
    best, first, second = hull[bottom], -1.0, -1.0
    for q in range(bottom, top):
        height = abs(_height(points, i, j, hull[q]))
        if height > first:
            best, first, second = hull[q], height, first
        elif height > second:
            second = height
    return best, first, second, top - bottom


@kernel()
@no_type_check
def _search(points, hull, bottom, top, i, j):
    """Farthest hull vertex, its height and the second height, by binary search over slopes.

    Along a convex polygon the signed height rises and falls once. One binary search finds an edge
    of the other direction than the first edge; two more find the highest and lowest vertex.
    """
    rising = _rises(points, i, j, hull[bottom], hull[bottom + 1])
    low, high, steps = bottom, top, 1
    while True:
        middle = (low + high) // 2
        if middle == low:  # rounding hid the turn
            return _scan(points, hull, bottom, top, i, j)
        steps += 2
        if _rises(points, i, j, hull[middle], hull[middle + 1]) != rising:
            break
        if (_height(points, i, j, hull[middle]) > _height(points, i, j, hull[low])) == rising:
            low = middle
        else:
            high = middle
    before, after = bottom, middle  # edge `before` has the first direction, `after` has not
    while after - before > 1:
        m = (before + after) // 2
        steps += 1
        if _rises(points, i, j, hull[m], hull[m + 1]) == rising:
            before = m
        else:
            after = m
    one = after
    before, after = middle, top  # edge `before` has the other direction, `after` has not
    while after - before > 1:
        m = (before + after) // 2
        steps += 1
        if _rises(points, i, j, hull[m], hull[m + 1]) != rising:
            before = m
        else:
            after = m
    other = after
    height_one = abs(_height(points, i, j, hull[one]))
    height_other = abs(_height(points, i, j, hull[other]))
    if height_one >= height_other:
        at, first, second = one, height_one, height_other
    else:
        at, first, second = other, height_other, height_one
    following = at + 1 if at < top else bottom + 1
    second = max(second, abs(_height(points, i, j, hull[following])))
    second = max(second, abs(_height(points, i, j, hull[at - 1 if at > bottom else top - 1])))
    return hull[at], first, second, steps + 4


@kernel()
@no_type_check
def _extreme(points, hull, bottom, top, i, j):
    if top - bottom < _SMALL:
        return _scan(points, hull, bottom, top, i, j)
    return _search(points, hull, bottom, top, i, j)


@kernel()
@no_type_check
def path_hull_kernel(points, tolerance):
    """Return the indices kept and the number of steps, for finite points without repeats."""
    n = points.shape[0]
    extent = 0.0
    for k in range(n):
        extent = max(extent, abs(points[k, 0] - points[0, 0]), abs(points[k, 1] - points[0, 1]))
    hull_l, hull_r = np.empty(2 * n + 4, np.int64), np.empty(2 * n + 4, np.int64)
    vertices_l, vertices_r = np.empty(3 * n + 4, np.int64), np.empty(3 * n + 4, np.int64)
    events_l, events_r = np.empty(3 * n + 4, np.int8), np.empty(3 * n + 4, np.int8)
    keep = np.zeros(n, np.bool_)
    keep[0] = keep[n - 1] = True
    pending = np.empty((n, 2), np.int64)  # sub-chains that need new hulls
    pending[0, 0], pending[0, 1] = 0, n - 1
    waiting, steps = 1, 0
    budget = int(4 * n * math.log2(n)) + 64  # steps that may go into settling ties
    while waiting > 0:
        waiting -= 1
        i, j = pending[waiting, 0], pending[waiting, 1]
        if j - i < 2:
            continue
        tag = (i + j) // 2
        bottom_l, top_l, count_l, more = _grow(points, hull_l, vertices_l, events_l, tag, i)
        steps += more
        bottom_r, top_r, count_r, more = _grow(points, hull_r, vertices_r, events_r, tag, j)
        steps += more
        while j - i > 1:
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            length = math.hypot(dx, dy)
            if length == 0.0:  # the chain is closed: distances to a point
                f, height, length = farthest_kernel(points, i, j)
                steps += j - i - 1
            else:
                f, height, second, more = _extreme(points, hull_l, bottom_l, top_l, i, j)
                steps += more
                f_r, height_r, second_r, more = _extreme(points, hull_r, bottom_r, top_r, i, j)
                steps += more
                second = max(second, second_r)
                if f_r != f:
                    second = max(second, min(height, height_r))
                slack = _ROUNDING * extent * (abs(dx) + abs(dy))
                margin = max(height, height_r) - tolerance * length
                unsure = abs(margin) <= slack or second >= max(height, height_r) - slack
                if height_r > height or (height_r == height and f_r < f):
                    f, height = f_r, height_r
                if unsure and margin > -slack and budget > 0:
                    f, height, length = farthest_kernel(points, i, j)
                    steps += j - i - 1
                    budget -= j - i - 1
            if not height / length > tolerance:
                break
            keep[f] = True
            if f < tag:
                pending[waiting, 0], pending[waiting, 1] = i, f
                waiting += 1
                i = f
                bottom_l, top_l, count_l, more = _shrink(
                    hull_l, vertices_l, events_l, bottom_l, top_l, count_l, f
                )
                steps += more
                lost = count_l == 0
            elif f > tag:
                pending[waiting, 0], pending[waiting, 1] = f, j
                waiting += 1
                j = f
                bottom_r, top_r, count_r, more = _shrink(
                    hull_r, vertices_r, events_r, bottom_r, top_r, count_r, f
                )
                steps += more
                lost = count_r == 0
            else:
                pending[waiting, 0], pending[waiting, 1] = f, j
                waiting += 1
                j = f
                lost = True
            if lost:
                pending[waiting, 0], pending[waiting, 1] = i, j
                waiting += 1
                break
    return np.flatnonzero(keep), steps
