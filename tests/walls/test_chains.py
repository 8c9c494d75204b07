"""Simplification against fastrdp, a brute-force reference and the text version."""

import inspect
import itertools
import subprocess
import sys

import fastrdp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from jaxtyping import TypeCheckError

from robot_perception.walls import (
    count_distances,
    count_hull_steps,
    find_split,
    is_simple,
    simplify,
    simplify_path_hull,
    simplify_recursive,
)

ALL = [simplify, simplify_recursive, simplify_path_hull]


def brute_force(chain, tolerance):
    """Every distance by solving for the foot of the perpendicular; no code in common with ours."""
    kept, todo = {0, len(chain) - 1}, [(0, len(chain) - 1)]
    while todo:
        i, j = todo.pop()
        inner = chain[i + 1 : j]
        if not len(inner):
            continue
        chord = (chain[j] - chain[i])[:, None]
        foot = np.linalg.lstsq(chord, (inner - chain[i]).T, rcond=None)[0]
        distance = np.linalg.norm(inner - chain[i] - (chord @ foot).T, axis=1)
        if distance.max() > tolerance:
            f = i + 1 + int(distance.argmax())
            kept.add(f)
            todo += [(i, f), (f, j)]
    return sorted(kept)


def star_shaped(rng, n):
    """A chain around the origin, as a scanner sees it: increasing angle, arbitrary range."""
    angles = np.sort(rng.uniform(-np.pi / 2, np.pi / 2, n))
    ranges = rng.uniform(0.5, 8, n)
    return np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)


def spiral(rng, n):
    turns = np.linspace(0, min(n / 5, 6 * np.pi), n)
    radius = 1 + turns + rng.uniform(-0.5, 0.5, n)
    return np.stack([radius * np.cos(turns), radius * np.sin(turns)], axis=-1)


def monotone(rng, n):
    return np.stack([np.cumsum(rng.uniform(0.1, 1, n)), rng.normal(0, 3, n).cumsum()], axis=-1)


def box_rotated(rng, n):
    """A noise-free room: long runs of points on a wall, ties that only rounding breaks."""
    s = np.linspace(0, 3.9, n)
    corners = np.array([[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]], dtype=float)
    chain = np.stack([np.interp(s, range(5), corners[:, c]) for c in range(2)], axis=-1)
    a = rng.uniform(0, 2 * np.pi)
    return chain @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])


SIMPLE_CHAINS = [star_shaped, spiral, monotone, box_rotated]


@pytest.mark.parametrize("make", SIMPLE_CHAINS)
@pytest.mark.parametrize("n", [2, 3, 4, 7, 30, 361, 2000])
@pytest.mark.parametrize("tolerance", [0.01, 0.3, 2.0, 50.0])
def test_plain_and_path_hull_agree_with_fastrdp(make, n, tolerance):
    chain = make(np.random.default_rng(n), n)
    expected = fastrdp.rdp_index(chain, tolerance).astype(int)
    if make is not box_rotated:  # rounding decides its ties, and differs between programs
        np.testing.assert_array_equal(simplify(chain, tolerance), expected)
    np.testing.assert_array_equal(simplify_path_hull(chain, tolerance), simplify(chain, tolerance))


@pytest.mark.parametrize("make", [star_shaped, spiral, monotone])
@pytest.mark.parametrize("algorithm", ALL)
def test_brute_force_finds_the_same_vertices(make, algorithm):
    for seed in range(5):
        chain = make(np.random.default_rng(seed), 90)
        for tolerance in (0.05, 0.7, 3.0):
            assert algorithm(chain, tolerance).tolist() == brute_force(chain, tolerance)


@pytest.mark.parametrize("algorithm", ALL)
def test_distance_is_to_the_line_not_to_the_segment(algorithm):
    # the middle vertex overshoots the chord by 5 m along it, but lies 0.1 m from its line
    chain = np.array([[0.0, 0.0], [15.0, 0.1], [10.0, 0.0]])
    assert algorithm(chain, 0.2).tolist() == [0, 2]
    assert algorithm(chain, 0.05).tolist() == [0, 1, 2]
    for turned in (chain[:, ::-1], -chain):
        assert algorithm(turned, 0.2).tolist() == [0, 2]
        assert algorithm(turned, 0.05).tolist() == [0, 1, 2]
    f, d = find_split(chain, 0, 2)
    assert (f, d) == (1, pytest.approx(0.1))


@pytest.mark.parametrize("algorithm", ALL)
def test_closed_chain_is_split_at_the_vertex_farthest_from_its_end(algorithm):
    chain = np.array([[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]], dtype=float)
    assert algorithm(chain, 0.5).tolist() == [0, 1, 2, 3, 4]
    assert algorithm(chain, 2.4 - 1e-9).tolist() == [0, 1, 2, 3, 4]  # 3 · 4 / 5 from the diagonal
    assert algorithm(chain, 2.4 + 1e-9).tolist() == [0, 2, 4]
    assert algorithm(chain, 5.1).tolist() == [0, 4]


@pytest.mark.parametrize("algorithm", ALL)
def test_vertex_at_exactly_the_tolerance_is_let_go(algorithm):
    chain = np.array([[0.0, 0.0], [1.0, 1.0], [4.0, 0.0]])
    assert algorithm(chain, 1.0).tolist() == [0, 2]
    assert algorithm(chain, np.nextafter(1.0, 0.0)).tolist() == [0, 1, 2]


@pytest.mark.parametrize("algorithm", ALL)
def test_of_equally_far_vertices_the_first_splits(algorithm):
    # vertices 1 to 3 are 1 m from the line; after a split at 1 the next is 0.89 m from its line
    chain = np.array([[0, 0], [1, 1], [2, 1], [3, 1], [3, 0]], dtype=float)
    assert algorithm(chain, 0.9).tolist() == [0, 1, 4]
    # both are 5 m from the end, and 1.4 m from the line through the other
    closed = np.array([[0, 0], [3, 4], [4, 3], [0, 0]], dtype=float)
    assert algorithm(closed, 1.5).tolist() == [0, 1, 3]


@given(
    st.lists(st.integers(-3, 3), min_size=2, max_size=60),
    st.sampled_from([0.3, 0.5, 1.0, 1.7, 2.5]),
)
def test_path_hull_settles_exact_ties_like_the_plain_algorithm(heights, tolerance):
    chain = np.stack([np.arange(len(heights)), heights], axis=-1).astype(float)
    expected = simplify_recursive(chain, tolerance)
    np.testing.assert_array_equal(simplify(chain, tolerance), expected)
    np.testing.assert_array_equal(simplify_path_hull(chain, tolerance), expected)
    backwards = np.ascontiguousarray(chain[::-1])
    np.testing.assert_array_equal(
        simplify_path_hull(backwards, tolerance), simplify(backwards, tolerance)
    )


@pytest.mark.parametrize("n", [1024, 16384])
def test_path_hull_gives_up_settling_ties_before_it_costs_the_square(n):
    """A comb: half of the vertices tie at every split."""
    comb = np.stack([np.arange(n), np.arange(n) % 2], axis=-1).astype(float)
    assert count_hull_steps(comb, 0.1) < 8 * n * np.log2(n)
    assert count_distances(comb, 0.1) > n * n / 3
    np.testing.assert_array_equal(simplify_path_hull(comb, 0.1), simplify(comb, 0.1))


def test_path_hull_settles_ties_of_rounding_like_the_plain_algorithm():
    """Turned plateaus: vertices of one height, whose heights differ in the last digit."""
    for rng in np.random.default_rng(0).spawn(300):
        heights, angle = np.repeat(rng.integers(-2, 3, 12), 4), rng.uniform(-3, 3)
        turned = (np.arange(48) + 1j * heights) * np.exp(1j * angle)
        chain = np.stack([turned.real, turned.imag], axis=-1)
        np.testing.assert_array_equal(simplify_path_hull(chain, 0.7), simplify(chain, 0.7))


def test_path_hull_finds_what_lies_before_a_vertex_that_only_rounding_makes_the_farthest():
    """Three in one line, the middle one last: where it is the farthest, it was never a corner."""
    along = np.stack([np.linspace(0, 25, 8), np.linspace(0, 1.6, 8)], axis=-1)
    pocket = [[26, 2], [28, -1], [34, 2], [32, 1.5], [30, 2], [29, 0]]
    x, y = np.vstack([along, pocket]).T
    for rng in np.random.default_rng(0).spawn(300):
        turned = (x + 1j * y) * np.exp(1j * rng.uniform(-3, 3)) * rng.uniform(0.5, 2)
        chain = np.stack([turned.real, turned.imag], axis=-1)
        found = simplify_path_hull(chain, 0.3, assume_simple=True)
        np.testing.assert_array_equal(found, simplify(chain, 0.3))


@given(
    st.lists(st.integers(0, 7), min_size=1, max_size=40),
    st.sampled_from([0.0, 0.3, np.pi / 4, 1.0]),
    st.sampled_from([1.0, 0.1, 1 / 3, 1e5]),
    st.sampled_from([0.5, np.sqrt(0.5), 1.0, np.sqrt(2), 2.0]),
)
def test_one_rule_decides_ties_and_tolerances_that_only_rounding_breaks(moves, turn, scale, tol):
    """Symmetric walks on a lattice, turned and scaled: vertices in line, at the tolerance, tied."""
    eight = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]])
    steps = eight[moves + moves[::-1]]
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    chain = scale * np.cumsum(steps, axis=0, dtype=float) @ turned
    expected = simplify(chain, tol * scale)
    np.testing.assert_array_equal(simplify_recursive(chain, tol * scale), expected)
    if is_simple(chain):
        np.testing.assert_array_equal(simplify_path_hull(chain, tol * scale), expected)


@pytest.mark.parametrize("seed", range(8))
def test_hulls_do_not_collapse_on_vertices_in_one_line(seed):
    """Walks on a lattice that avoid themselves, turned: rounding takes sides, three in a row."""
    rng, simple = np.random.default_rng(seed), 0
    for _ in range(200):
        path = [(0, 0)]
        for _ in range(rng.integers(3, 40)):
            x, y = path[-1]
            free = {(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1), (x + 1, y + 1)} - set(path)
            if free:
                path.append(sorted(free)[rng.integers(len(free))])
        turn, scale = rng.choice([0.3, np.pi / 4, 1.0]), rng.choice([0.1, 1 / 3, 1.0])
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        chain = scale * np.array(path, dtype=float) @ turned
        tolerance = scale * rng.choice([0.1, 0.5, np.sqrt(0.5), 1.0])
        if is_simple(chain):
            simple += 1
            kept = simplify_path_hull(chain, tolerance)
            np.testing.assert_array_equal(kept, simplify(chain, tolerance))
    assert simple > 50


@given(
    st.lists(st.tuples(st.integers(1, 9), st.integers(0, 2)), min_size=2, max_size=40),
    st.sampled_from([0.5, 1.0, 2.0]),
)
def test_path_hull_survives_repeated_and_collinear_points(steps, tolerance):
    """Staircases with runs of repeated points: every third kind of step stands still."""
    moves = np.array([[(kind == 0) * length, (kind == 1) * length] for length, kind in steps])
    chain = np.cumsum(moves, axis=0).astype(float)
    np.testing.assert_array_equal(
        simplify_path_hull(chain, tolerance), simplify_recursive(chain, tolerance)
    )


@settings(max_examples=300)
@given(
    arrays(
        np.float64,
        st.tuples(st.integers(0, 12), st.integers(1, 3)),
        elements=st.floats(width=64, allow_nan=True, allow_infinity=True),
    ),
    st.floats(width=64),
)
def test_hostile_input_gives_vertices_or_a_value_error(points, tolerance):
    for algorithm in (simplify, simplify_recursive, simplify_path_hull):
        try:
            kept = algorithm(points, tolerance)
        except (ValueError, TypeCheckError) as error:
            refused = str(error)
        else:
            refused = ""
        if refused:
            assert any(word in refused for word in ("tolerance", "chain", "point"))
            continue
        assert np.isfinite(points).all()
        assert 0 < tolerance < np.inf
        assert kept[[0, -1]].tolist() == [0, len(points) - 1]
        assert (np.diff(kept) > 0).all()


@given(st.integers(0, 10**6), st.floats(1e-3, 5.0))
def test_kept_chain_is_within_tolerance_of_every_vertex(seed, tolerance):
    chain = star_shaped(np.random.default_rng(seed), 80)
    kept = simplify(chain, tolerance)
    for i, j in itertools.pairwise(kept):
        assert find_split(chain, int(i), int(j))[1] <= tolerance * (1 + 1e-12)


@given(st.integers(0, 10**6), st.floats(0.1, 30.0), st.floats(-3, 3))
def test_similarity_transforms_keep_the_vertices(seed, scale, angle):
    chain = star_shaped(np.random.default_rng(seed), 50)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = scale * chain @ turn.T + [100.0, -40.0]
    np.testing.assert_array_equal(simplify(moved, 0.31 * scale), simplify(chain, 0.31))


@pytest.mark.parametrize("algorithm", ALL)
@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
def test_tolerance_must_be_positive(algorithm, tolerance):
    with pytest.raises(ValueError, match=f"tolerance must be positive and finite, got {tolerance}"):
        algorithm(np.eye(2), tolerance)


@pytest.mark.parametrize("algorithm", ALL)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_bad_point_is_named(algorithm, bad):
    chain = np.arange(20, dtype=float).reshape(10, 2)
    chain[7, 1] = bad
    with pytest.raises(ValueError, match="point 7 is"):
        algorithm(chain, 1.0)


@pytest.mark.parametrize("algorithm", ALL)
@pytest.mark.parametrize("shape", [(0, 2), (1, 2), (5, 3), (4,)])
def test_chain_needs_two_planar_points(algorithm, shape):
    with pytest.raises(ValueError, match="a chain must be"):
        inspect.unwrap(algorithm)(np.zeros(shape), 1.0)
    with pytest.raises((ValueError, TypeCheckError)):
        algorithm(np.zeros(shape), 1.0)


@pytest.mark.parametrize("algorithm", ALL)
def test_input_is_left_alone_and_any_layout_will_do(algorithm):
    chain = star_shaped(np.random.default_rng(4), 40)
    expected = algorithm(chain, 0.5)
    frozen = np.asfortranarray(chain)
    frozen.flags.writeable = False
    np.testing.assert_array_equal(algorithm(frozen, 0.5), expected)
    np.testing.assert_array_equal(algorithm(chain.astype(np.float32).astype(float), 0.5), expected)


def test_a_million_vertices_do_not_overflow_any_stack():
    n = 10**6
    sign = np.where(np.arange(n) % 2, -1.0, 1.0)
    chain = np.stack([np.arange(n, dtype=float), sign * (2 - np.arange(n) / n)], axis=-1)
    assert len(simplify_path_hull(chain, 0.1)) == n
    few = chain[:20_000]
    assert len(simplify(few, 0.1)) == len(few)
    with pytest.raises(RecursionError):
        simplify_recursive(chain[: 2 * sys.getrecursionlimit()], 0.1)


def test_counts_of_the_worst_case_are_the_closed_form():
    n = 300
    sign = np.where(np.arange(n) % 2, -1.0, 1.0)
    chain = np.stack([np.arange(n, dtype=float), sign * (2 - np.arange(n) / n)], axis=-1)
    # sub-chains of n, n - 1, …, 2 vertices, and one sub-chain of 2 vertices cut off by each split
    assert count_distances(chain, 0.1) == (n - 2) * (n - 1) // 2
    assert count_hull_steps(chain, 0.1) < 6 * n * np.log2(n)


def test_spiral_and_star_cost_n_log_n_steps():
    for make in (spiral, star_shaped, monotone):
        for n in (1000, 4000):
            chain = make(np.random.default_rng(0), n)
            assert count_hull_steps(chain, 1e-9) < 8 * n * np.log2(n)


@pytest.mark.slow
def test_shapely_ends_before_a_hundred_thousand_vertices_of_the_worst_line():
    """What the chapter says of the package: its recursion leaves no stack, and the process ends."""
    pytest.importorskip("shapely")
    program = (
        "import numpy as np, shapely; n = {}; k = np.arange(n)\n"
        "line = np.stack([k, np.where(k % 2, -1, 1) * (1 + np.sqrt(1 - (k / n) ** 2))], axis=-1)\n"
        "print(len(shapely.LineString(line).simplify(0.1, preserve_topology=False).coords))"
    )
    few, many = (
        subprocess.run([sys.executable, "-P", "-c", program.format(n)], capture_output=True)
        for n in (1000, 100_000)
    )
    assert few.stdout.strip() == b"1000"
    assert many.returncode != 0
    assert not many.stdout
