"""Places and pairs: brute force over all assignments, and what is no distance."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.people.places import pairs_within, points

seeds, sizes = st.integers(0, 10**6), st.integers(0, 4)


def test_places_are_ahead_and_to_the_left():
    polar = np.array([[[1.0, 0.0], [2.0, np.pi / 2]], [[3.0, np.pi], [0.0, 1.0]]])
    expected = [[[1, 0], [0, 2]], [[-3, 0], [0, 0]]]
    np.testing.assert_allclose(points(polar), expected, atol=1e-15)


def best(apart, reach):
    """Return the most pairs within reach, and the least sum of so many."""
    n, m = apart.shape
    found = []
    for order in permutations([*range(m), *[-1] * n], n):
        gaps = [apart[i, j] for i, j in enumerate(order) if j >= 0 and apart[i, j] <= reach]
        found.append((-len(gaps), sum(gaps)))
    return min(found)


@given(seeds, sizes, sizes, st.floats(0.05, 1.5), st.sampled_from([1e-9, 1.0, 1e9]))
@settings(max_examples=60)
def test_pairs_are_as_many_as_can_be_and_then_as_near_in_any_unit(seed, n, m, reach, unit):
    apart = np.random.default_rng(seed).uniform(0, 1, (n, m))
    apart[apart > 0.9] = np.inf
    i, j = pairs_within(apart * unit, reach * unit)
    assert np.unique(i).size == np.unique(j).size == i.size
    gaps = apart[i, j]
    assert (gaps <= reach).all()
    assert (-gaps.size, gaps.sum()) == pytest.approx(best(apart, reach))


def test_what_is_in_reach_is_at_most_so_far():
    assert [k.tolist() for k in pairs_within(np.array([[0.5, 2.0]]), 0.5)] == [[0], [0]]
    assert pairs_within(np.array([[0.5]]), 0.499)[0].size == 0


@pytest.mark.parametrize("entry", [-0.1, np.nan])
def test_no_distance_is_refused(entry):
    with pytest.raises(ValueError, match="apart must not be negative or NaN"):
        pairs_within(np.array([[0.2, entry]]), 0.5)
