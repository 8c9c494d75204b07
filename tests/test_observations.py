"""Observations refuse what is none, and stay what they are under new names."""

import numpy as np
import pytest

from robot_perception.observations import Observations, unnamed
from tests.unchecked import unchecked

IDS, VALUES = np.array([4, -1, 7]), np.arange(6.0).reshape(3, 2)
COVS = np.stack([np.eye(2), 2 * np.eye(2), np.zeros((2, 2))])
SEEN = Observations(IDS, VALUES, COVS)


@pytest.mark.parametrize(
    "rows", [slice(1, 3), np.array([True, False, True]), [2, 0], np.empty(0, dtype=int)]
)
def test_some_of_them_keep_their_names_and_covariances(rows):
    some = SEEN[rows]
    np.testing.assert_array_equal(some.ids, IDS[rows])
    np.testing.assert_array_equal(some.values, VALUES[rows])
    np.testing.assert_array_equal(some.covs, COVS[rows])
    assert len(some) == len(IDS[rows])
    assert Observations(IDS, VALUES)[rows].covs is None


def test_only_the_names_change():
    other = SEEN.named(np.array([-1, 5, 6]))
    assert other.ids.tolist() == [-1, 5, 6]
    assert SEEN.anonymous().ids.tolist() == unnamed(VALUES, COVS).ids.tolist() == [-1, -1, -1]
    for same in (other, SEEN.anonymous(), unnamed(VALUES, COVS)):
        np.testing.assert_array_equal(same.values, VALUES)
        np.testing.assert_array_equal(same.covs, COVS)
    assert SEEN.ids.tolist() == IDS.tolist()


def test_inputs_are_copied():
    ids, values, covs = IDS.copy(), VALUES.copy(), COVS.copy()
    seen = Observations(ids, values, covs)
    ids[0], values[0, 0], covs[0, 0, 0] = 9, 9.0, 9.0
    assert (seen.ids[0], seen.values[0, 0], seen.covs[0, 0, 0]) == (4, 0.0, 1.0)


def test_observations_of_any_dimension():
    assert Observations(np.array([1]), np.zeros((1, 3)), np.eye(3)[None]).values.shape == (1, 3)
    assert len(unnamed(np.empty((0, 2)), np.empty((0, 2, 2)))) == 0


NAN, SKEW = np.nan, np.array([[[1.0, 0.5], [0.0, 1.0]]])
ONE = np.zeros((1, 2))
BAD = [
    (lambda: Observations(np.array([3, 5, 3]), np.zeros((3, 2))), r"got twice: \[3\]"),
    (lambda: Observations(np.array([-2]), ONE), "at least -1, got -2"),
    (lambda: Observations(np.array([0.5]), ONE), "ids must be integers, got array"),
    (lambda: Observations(np.array([1]), np.zeros((2, 2))), r"ids must be \(2,\) .* got \(1,\)"),
    (lambda: Observations(np.array([1]), np.zeros(2)), r"values must be \(m, d\), got \(2,\)"),
    (lambda: Observations(np.array([1]), np.array([[NAN, 0.0]])), "values must be finite"),
    (lambda: Observations(np.array([1]), ONE, np.eye(2)), r"covs must be \(1, 2, 2\) for values"),
    (lambda: Observations(np.array([1]), ONE, SKEW), "covs must be symmetric"),
    (lambda: Observations(np.array([1]), ONE, -np.eye(2)[None]), "positive semi-definite"),
    (lambda: SEEN.named(np.array([2, 2, 3])), r"got twice: \[2\]"),
    (lambda: SEEN.named(np.array([2])), r"ids must be \(3,\)"),
    (lambda: SEEN[[0, 0]], r"got twice: \[4\]"),
    (lambda: SEEN[1], r"ids must be \(2,\) .* got \(\)"),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(call, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        call()
