"""Crossings against shapely and against all pairs."""

from fractions import Fraction

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.walls import (
    count_sweep_steps,
    find_crossings,
    is_simple,
    require_simple,
    simplify,
    simplify_path_hull,
)
from robot_perception.walls.simplicity import exact_side
from tests.unchecked import unchecked


def all_pairs(chain):
    """Pairs of non-neighbouring edges that shapely says have a point in common."""
    edges = shapely.linestrings(np.stack([chain[:-1], chain[1:]], axis=1))
    closed = (chain[0] == chain[-1]).all()
    return [
        [a, b]
        for a in range(len(edges))
        for b in range(a + 2, len(edges))
        if edges[a].intersects(edges[b]) and not (closed and a == 0 and b == len(edges) - 1)
    ]


def overlapping_neighbours(chain):
    """Pairs of edges that share a vertex, and more than that by shapely."""
    edges = shapely.linestrings(np.stack([chain[:-1], chain[1:]], axis=1))
    pairs = [(a, a + 1) for a in range(len(edges) - 1)]
    pairs += [(0, len(edges) - 1)] if len(edges) > 2 and (chain[0] == chain[-1]).all() else []
    return [[a, b] for a, b in pairs if edges[a].intersection(edges[b]).length > 0]


@pytest.mark.parametrize("seed", range(300))
def test_lattice_rings_have_the_crossings_that_shapely_finds(seed):
    """Rings close straight on, by folding back and at a corner, and cross elsewhere or not."""
    ring = np.random.default_rng(seed).integers(0, 4, (9, 2)).astype(float)
    chain = np.vstack([ring, ring[:1]])
    chain = chain[np.r_[True, (np.diff(chain, axis=0) != 0).any(axis=1)]]
    expected = sorted(all_pairs(chain) + overlapping_neighbours(chain))
    assert find_crossings(chain).tolist() == expected


@pytest.mark.parametrize("seed", range(20))
def test_random_chains_have_the_crossings_that_shapely_finds(seed):
    rng = np.random.default_rng(seed)
    chain = rng.normal(0, 1, (60, 2)) if seed % 2 else rng.normal(0, 1, (300, 2)).cumsum(axis=0)
    assert find_crossings(chain, at_most=10_000).tolist() == all_pairs(chain)


def hostile(rng):
    """A chain on a lattice that avoids itself for a while, then touches, closes or stands still."""
    n, kind = int(rng.integers(2, 50)), rng.integers(5)
    if kind == 0:
        chain = rng.integers(0, rng.integers(2, 9), (n, 2))
    elif kind == 1:  # a polygon in order of angle: many vertices on one ray
        chain = rng.integers(-6, 7, (n, 2))
        chain = chain[np.argsort(np.arctan2(chain[:, 1], chain[:, 0]))]
    elif kind == 2:  # a comb
        k = np.arange(n)
        chain = np.stack([k // 2, np.where((k + 1) // 2 % 2, 5, 0)], axis=-1)
    else:  # a walk that turns away from where it was
        moves = [
            (x, y) for x in (-2, 0, 2) for y in (-2, 0, 2) if abs(x) + abs(y) in (2, 2 * kind - 4)
        ]
        path = [(0, 0)]
        while len(path) < n:
            free = [(path[-1][0] + x, path[-1][1] + y) for x, y in moves]
            free = [point for point in free if point not in path]
            if not free:
                break
            path.append(free[rng.integers(len(free))])
        chain = np.array(path)
    end = rng.integers(7)
    if end == 0:
        chain = np.repeat(chain, rng.integers(1, 3, len(chain)), axis=0)
    elif end == 1:
        chain = np.concatenate([chain, chain[:1]])
    elif end == 2:
        chain = np.concatenate([chain, chain[rng.integers(len(chain), size=1)]])
    elif end == 3 and len(chain) > 1:
        k = rng.integers(len(chain) - 1)
        chain = np.concatenate([2 * chain, chain[k : k + 1] + chain[k + 1 : k + 2]])
    elif end == 4:
        chain = chain[::-1, ::-1]
    return np.concatenate([chain, chain])[: max(2, len(chain))].astype(float)


@pytest.mark.parametrize("seed", range(10))
def test_hostile_chains_are_simple_when_shapely_says_so(seed):
    """Exactly, on a lattice: touching, overlap, folding back, closing, repeated points."""
    rng, simple = np.random.default_rng(seed), 0
    for _ in range(400):
        chain = hostile(rng)
        moved = chain[np.r_[True, (np.diff(chain, axis=0) != 0).any(axis=1)]]
        expected = len(moved) < 2 or shapely.LineString(moved).is_simple
        assert is_simple(chain) == expected, chain.tolist()
        assert (len(find_crossings(chain)) == 0) == expected
        simple += expected
    assert 80 < simple < 320


def gear(n, inner=0.001):
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    radii = np.where(np.arange(n) % 2, 1.0, inner)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=-1)


def pinwheel(n):
    """A gear whose teeth lean by a radian."""
    chain, lean = gear(n, 0.1), np.array([[np.cos(1), np.sin(1)], [-np.sin(1), np.cos(1)]])
    chain[1::2] = chain[1::2] @ lean
    return chain


def coil(n):
    turns = np.linspace(0, n * np.pi / 500, n)
    return np.stack([turns * np.cos(turns), turns * np.sin(turns)], axis=-1)


def comb(n):
    """Teeth as long as the comb, turned out of the axes."""
    k = np.arange(n)
    chain = np.stack([k // 2, np.where((k + 1) // 2 % 2, n, 0)], axis=-1).astype(float)
    return chain @ np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])


def rough_line(n):
    chain = np.stack([np.linspace(0, 10, n), np.random.default_rng(0).normal(0, 0.01, n)], axis=-1)
    return chain @ np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])


@pytest.mark.parametrize("make", [gear, pinwheel, coil, comb, rough_line])
def test_check_takes_n_log_n_steps(make):
    """The constant: 2 ln 2 for the search in a random tree, and five steps a vertex."""
    for n in (1000, 8000, 64_000):
        chain = make(n)
        assert is_simple(chain)
        assert count_sweep_steps(chain) < 1.5 * n * np.log2(n) + 5 * n


@pytest.mark.parametrize("make", [gear, pinwheel])
def test_one_tooth_bent_over_the_next_is_found(make):
    chain = make(5000)
    chain[3001] = 0.5 * (chain[3003] + chain[3005])
    assert not is_simple(chain)
    with pytest.raises(ValueError, match=r"intersects itself: edges 300[01] and 300[23]"):
        require_simple(chain)


ULPS = st.tuples(st.integers(-3, 3), st.integers(-3, 3))


@given(st.integers(0, 10**6), st.floats(0, 1), ULPS)
def test_exact_side_is_that_of_rational_numbers(seed, share, ulps):
    """Points on a line up to some units in the last place, where rounding decides."""
    a, b = np.random.default_rng(seed).normal(0, [[1], [1e3]], (2, 2))
    p = a + share * (b - a)
    p += ulps * np.spacing(p)
    ax, ay, bx, by, px, py = (Fraction(float(x)) for x in (*a, *b, *p))
    turn = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    assert exact_side(np.array([a, b, p]), 0, 1, 2) == (turn > 0) - (turn < 0)


def test_error_names_the_crossing_edges():
    chain = np.array([[0, 0], [2, 2], [2, 0], [0, 2], [-1, 2]], dtype=float)
    assert find_crossings(chain).tolist() == [[0, 2]]
    with pytest.raises(ValueError, match=r"intersects itself: edges 0 and 2$"):
        require_simple(chain)
    with pytest.raises(ValueError, match="edges 0 and 2"):
        simplify_path_hull(chain, 0.1)
    tangle = np.random.default_rng(0).normal(size=(40, 2))
    with pytest.raises(ValueError, match="and more"):
        require_simple(tangle)


def test_repeated_points_are_no_crossing_but_folding_back_is():
    line = np.array([[0, 0], [1, 0], [1, 0], [1, 0], [2, 0]], dtype=float)
    assert is_simple(line)
    assert find_crossings(np.array([[0.0, 0], [2, 0], [1, 0]])).tolist() == [[0, 1]]
    assert find_crossings(np.array([[0.0, 0], [2, 0], [0, 0]])).tolist() == [[0, 1]]
    assert is_simple(np.array([[0.0, 0], [2, 0], [2, 1], [0, 0]]))
    assert is_simple(np.zeros((4, 2)))


@pytest.mark.parametrize("limit", [None, 0, 1.5, 10**30, "all"])
def test_a_limit_that_is_none_is_named(limit):
    with unchecked(), pytest.raises((TypeError, ValueError), match="at_most must be"):
        find_crossings(np.eye(3, 2), at_most=limit)


@pytest.mark.parametrize("start", range(6))
def test_a_ring_may_close_straight_on_and_not_by_folding_back(start):
    """Wherever a ring begins: its closing edge is a neighbour of the first."""
    ring = np.array([[0.0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [0, 1]])
    folded = np.array([[0.0, 0], [2, 0], [3, 0], [3, 1], [1, 1], [1, 0]])  # back along [0, 2]
    for points, simple in ((ring, True), (folded, False)):
        turned = np.roll(points, -start, axis=0)
        assert is_simple(np.vstack([turned, turned[:1]])) == simple


def test_touching_counts():
    chain = np.array([[0, 0], [4, 0], [4, 2], [2, 0]], dtype=float)  # ends on edge 0
    assert find_crossings(chain).tolist() == [[0, 2]]


@given(st.integers(0, 10**6), st.integers(3, 200))
def test_scans_in_order_of_angle_are_simple(seed, n):
    """Rays of one origin meet nowhere else, so neither do chords in separate sectors."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(-np.pi / 2, np.pi / 2, n))
    ranges = rng.uniform(0.1, 10, n)
    scan = np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)
    assert is_simple(scan)


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.8, 1.9])
@pytest.mark.parametrize("height", [1.0, 2000.0])
def test_turned_zigzag_of_long_edges_is_simple_until_one_tooth_is_bent(angle, height):
    k = np.arange(50_000.0)
    zigzag = np.stack([k, np.where(k % 2, -height, height)], axis=-1)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    assert is_simple(zigzag @ turn)
    zigzag[20_000, 0] += 5.5
    assert [19_999, 20_001] in find_crossings(zigzag @ turn).tolist()


def test_long_chain_with_one_crossing_is_found():
    n = 200_000
    turns = np.linspace(0, 400 * np.pi, n)
    chain = np.stack([turns * np.cos(turns), turns * np.sin(turns)], axis=-1)
    assert is_simple(chain)
    chain[150_000] *= 1.02  # a spike through the next turn of the spiral
    pairs = find_crossings(chain)
    assert len(pairs) >= 2
    assert {149_999, 150_000} >= {int(a) for a in pairs[:, 0]}


def test_crossing_chain_can_lose_vertices_when_the_check_is_skipped():
    lost = 0
    for seed in range(200):
        chain = np.random.default_rng(seed).normal(0, 1, (40, 2))
        kept = simplify_path_hull(chain, 0.4, assume_simple=True)
        lost += not np.array_equal(kept, simplify(chain, 0.4))
    assert lost > 0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_bad_point_is_named(bad):
    chain = np.eye(5, 2)
    chain[3, 0] = bad
    with pytest.raises(ValueError, match="point 3 is"):
        find_crossings(chain)
    with pytest.raises(ValueError, match="a chain must be"):
        is_simple(np.zeros((1, 2)))
