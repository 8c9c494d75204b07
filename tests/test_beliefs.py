"""Beliefs refuse what is no belief."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robot_perception.beliefs import Gaussian
from robot_perception.checks import check_covariance
from tests.unchecked import unchecked

finite = st.floats(-1e6, 1e6)


@given(hnp.arrays(float, hnp.array_shapes(min_dims=2, max_dims=2, max_side=4), elements=finite))
def test_every_gram_matrix_is_a_covariance(factor):
    check_covariance("cov", factor @ factor.T)
    assert Gaussian(np.zeros(len(factor)), factor @ factor.T).cov.shape == (len(factor),) * 2


@given(st.floats(1e-6, 1e6), st.floats(1.001, 10))
def test_correlation_beyond_one_is_refused_at_every_scale(variance, correlation):
    cov = variance * np.array([[1.0, correlation], [correlation, 1.0]])
    with pytest.raises(ValueError, match="positive semi-definite"):
        Gaussian(np.zeros(2), cov)


def test_singular_covariances_are_allowed():
    for cov in (np.zeros((2, 2)), np.ones((2, 2)), np.diag([0.0, 3.0])):
        Gaussian(np.zeros(2), cov)


def test_one_covariance_serves_a_batch_of_means():
    belief = Gaussian(np.zeros((7, 2)), np.eye(2))
    assert belief.mean.shape == (7, 2)
    assert belief.cov.shape == (2, 2)


def test_one_bad_covariance_in_a_batch_is_found():
    covs = np.stack([np.eye(2), np.diag([1.0, -1.0]), np.eye(2)])
    with pytest.raises(ValueError, match="positive semi-definite, smallest relative"):
        Gaussian(np.zeros((3, 2)), covs)


@pytest.mark.parametrize("scale", [1e-200, 1e-12, 1.0, 1e12])
def test_the_tolerance_is_a_share_of_the_largest_entry_of_each_matrix(scale):
    """Wherever the entries stand, and whatever other matrices there are."""
    rng, huge = np.random.default_rng(0), np.diag([1e20, 1.0, 1.0, 1.0])
    for share, right in ((0.5e-9, True), (2e-9, False)):
        for row, column in rng.permutation([(i, j) for i in range(4) for j in range(4)]):
            cov = np.eye(4)
            if row == column:
                cov[row, row] = -share
            else:
                cov[row, column] = rng.choice([-share, share])
            covs = np.stack([huge, scale * cov])
            if right:
                check_covariance("cov", covs)
            else:
                problem = "positive semi-definite" if row == column else "symmetric"
                with pytest.raises(ValueError, match=f"cov must be {problem}"):
                    check_covariance("cov", covs)


@pytest.mark.parametrize(
    ("mean", "cov", "message"),
    [
        (np.float64(1.0), np.eye(1), r"mean must be \(…, n\)"),
        (np.zeros(2), np.eye(3), r"cov must be \(…, 2, 2\)"),
        (np.zeros(2), np.ones(2), r"cov must be \(…, 2, 2\)"),
        (np.array([0.0, np.nan]), np.eye(2), "mean must be finite, got 1 of 2"),
        (np.zeros(2), np.full((2, 2), np.inf), "cov must be finite"),
        (np.zeros(2), np.array([[1.0, 0.1], [0.0, 1.0]]), "cov must be symmetric"),
        (np.zeros((3, 2)), np.broadcast_to(np.eye(2), (4, 2, 2)), "broadcast"),
    ],
)
def test_bad_input_is_named(mean, cov, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        Gaussian(mean, cov)
