"""Gates, nearest neighbours and joint compatibility against brute force."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.gating import gate, joint_compatibility, nearest_neighbours
from tests.unchecked import unchecked


def test_a_gate_lets_its_share_through():
    rng = np.random.default_rng(0)
    for level, dimension in ((0.95, 1), (0.99, 2), (0.5, 6)):
        passed = (rng.standard_normal((40000, dimension)) ** 2).sum(axis=1) <= gate(
            level, dimension
        )
        assert abs(passed.mean() - level) < 4 * np.sqrt(level * (1 - level) / 40000)


@given(st.integers(0, 10**6), st.integers(0, 5), st.integers(0, 5), st.floats(0, 12))
def test_nearest_neighbours_take_the_nearest_pair_first(seed, m, n, limit):
    distances = 10 * np.random.default_rng(seed).random((m, n))
    if m and n:
        distances[0, 0] = np.inf
    expected, left = np.full(m, -1), {(i, j) for i in range(m) for j in range(n)}
    while left:
        i, j = min(left, key=lambda pair: distances[pair])
        if distances[i, j] > limit:
            break
        expected[i] = j
        left = {(a, b) for a, b in left if a != i and b != j}
    np.testing.assert_array_equal(nearest_neighbours(distances, limit), expected)


def all_sets(pairs):
    """Yield every choice of one pair or none for each measurement, targets at most once."""
    branches = [[None, *np.flatnonzero(pairs[:, 0] == i).tolist()] for i in np.unique(pairs[:, 0])]
    for choice in product(*branches):
        chosen = [p for p in choice if p is not None]
        if len({pairs[p, 1] for p in chosen}) == len(chosen):
            yield chosen


def squared_distance(chosen, innovations, cov):
    d = innovations.shape[1]
    rows = (d * np.array(chosen)[:, None] + np.arange(d)).ravel()
    z = innovations[chosen].ravel()
    return z @ np.linalg.solve(cov[np.ix_(rows, rows)], z)


@given(
    st.integers(0, 10**6),
    st.integers(1, 4),
    st.integers(1, 4),
    st.integers(1, 2),
    st.floats(0.3, 3),
)
@settings(max_examples=150)
def test_joint_compatibility_is_what_brute_force_finds(seed, m, n, d, spread):
    rng = np.random.default_rng(seed)
    pairs = np.array([(i, j) for i in range(m) for j in range(n) if rng.random() < 0.7])
    pairs = pairs.reshape(-1, 2).astype(int)
    size = len(pairs) * d
    innovations = spread * rng.standard_normal((len(pairs), d))
    root = rng.standard_normal((size, size))
    cov = root @ root.T / max(size, 1) + 0.05 * np.eye(size)
    limits = np.array([gate(0.9, d * (k + 1)) for k in range(len(pairs))])
    best, best_key = [], (0, 0.0)
    for chosen in all_sets(pairs):
        if not chosen:
            continue
        distance = squared_distance(chosen, innovations, cov)
        if distance <= limits[len(chosen) - 1] and (-len(chosen), distance) < best_key:
            best, best_key = chosen, (-len(chosen), distance)
    found = joint_compatibility(pairs, innovations, cov, limits)
    assert found.tolist() == sorted(best)


def test_common_errors_are_forgiven_together_and_not_one_by_one():
    """Two measurements are off by the same shift: possible if their errors are the same error."""
    pairs, innovations = np.array([[0, 0], [1, 1]]), np.array([[2.0], [2.0]])
    limits = np.array([gate(0.95, 1), gate(0.95, 2)])
    together = np.array([[1.05, 1.0], [1.0, 1.05]])
    assert joint_compatibility(pairs, innovations, together, limits[[1, 1]]).size == 2
    against = innovations * np.array([[1.0], [-1.0]])
    assert joint_compatibility(pairs, against, together, limits[[1, 1]]).size == 1


ONE = np.array([[0, 0]])
TWO = np.array([[0, 0], [1, 1]])
REST = (np.zeros((1, 1)), np.eye(1), np.ones(1))
BAD = [
    (lambda: gate(1.0, 2), "between 0 and 1, got 1.0"),
    (lambda: gate(0.9, 0), "at least 1, got 0"),
    (lambda: gate(0.9, np.nan), "dimension must be a whole number, got nan"),
    (lambda: joint_compatibility(ONE * np.nan, *REST), "pairs must be integers, got array"),
    (lambda: joint_compatibility(ONE + 0.5, *REST), "pairs must be integers, got array"),
    (lambda: joint_compatibility(ONE - 1, *REST), "pairs must be at least 0, got -1"),
    (lambda: nearest_neighbours(np.ones((1, 1)), np.nan), "limit must be a number, got nan"),
    (lambda: nearest_neighbours(np.zeros(3), 1.0), r"must be \(m, n\), got \(3,\)"),
    (lambda: nearest_neighbours(np.array([[np.nan]]), 1.0), "not be negative, got nan"),
    (lambda: nearest_neighbours(np.array([[-1.0]]), 1.0), "not be negative, got -1.0"),
    (
        lambda: joint_compatibility(ONE, np.zeros((2, 1)), np.eye(2), np.ones(1)),
        "innovations must be",
    ),
    (lambda: joint_compatibility(ONE, np.zeros((1, 2)), np.eye(3), np.ones(1)), "must be"),
    (lambda: joint_compatibility(ONE, np.zeros((1, 1)), np.zeros((1, 1)), np.ones(1)), "singular"),
    (lambda: joint_compatibility(ONE, np.array([[np.inf]]), np.eye(1), np.ones(1)), "finite"),
    (
        lambda: joint_compatibility(ONE, np.zeros((1, 1)), np.eye(1), np.array([np.nan])),
        r"do not fall, got \[nan\]",
    ),
    (
        lambda: joint_compatibility(TWO, np.zeros((2, 1)), np.eye(2), np.array([2.0, 1.0])),
        r"do not fall, got \[2.0, 1.0\]",
    ),
    (
        lambda: joint_compatibility(
            np.array([[1, 0], [0, 0]]), np.zeros((2, 1)), np.eye(2), np.ones(2)
        ),
        r"sorted by measurement, got \[1, 0\]",
    ),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(call, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        call()


def test_no_pairs_give_no_assignment():
    nothing = np.empty((0, 2))
    found = joint_compatibility(nothing.astype(int), nothing, np.empty((0, 0)), np.empty(0))
    assert found.size == 0
