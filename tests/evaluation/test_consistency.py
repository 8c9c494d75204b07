"""Normalised errors against whitening by hand and against SciPy's χ²."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from tests.unchecked import unchecked


@given(st.integers(1, 5), st.integers(0, 2**31))
@settings(max_examples=40)
def test_no_change_of_coordinates_changes_the_value(n, seed):
    rng = np.random.default_rng(seed)
    factor, error = rng.normal(size=(n, n)) + 3 * np.eye(n), rng.normal(size=n)
    cov = factor @ factor.T
    value = normalised_squared(error, cov)
    assert value == pytest.approx(error @ np.linalg.inv(cov) @ error, rel=1e-6)
    change = rng.normal(size=(n, n)) + 3 * np.eye(n)
    moved = change @ cov @ change.T
    assert normalised_squared(change @ error, (moved + moved.T) / 2) == pytest.approx(
        value, rel=1e-5
    )


def test_batch_equals_loop():
    rng = np.random.default_rng(0)
    errors, covs = rng.normal(size=(4, 6, 2)), np.stack([np.diag([1.0, k + 1.0]) for k in range(6)])
    batch = normalised_squared(errors, covs)
    for i in range(4):
        for j in range(6):
            assert batch[i, j] == pytest.approx(normalised_squared(errors[i, j], covs[j]))


def test_errors_drawn_from_their_covariance_fall_inside_the_bounds():
    rng, inside = np.random.default_rng(7), 0
    cov = np.array([[2.0, 0.7], [0.7, 0.5]])
    low, high = average_bounds(2, 50, 0.9)
    for _ in range(400):
        values = normalised_squared(rng.multivariate_normal([0, 0], cov, size=50), cov)
        inside += low < values.mean() < high
    assert stats.binomtest(inside, 400, 0.9).pvalue > 1e-3
    too_sure = normalised_squared(rng.multivariate_normal([0, 0], 2 * cov, size=50), cov)
    assert too_sure.mean() > high


def test_bounds_close_around_the_dimension():
    low, high = average_bounds(3, 1)
    assert stats.chi2.cdf(high, 3) - stats.chi2.cdf(low, 3) == pytest.approx(0.95)
    low, high = average_bounds(3, 100_000)
    assert low == pytest.approx(3, rel=0.01)
    assert high == pytest.approx(3, rel=0.01)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: normalised_squared(np.zeros(2), np.eye(3)), r"need errors \(…, n\)"),
        (lambda: normalised_squared(np.zeros(0), np.zeros((0, 0))), "need errors"),
        (lambda: normalised_squared(np.array([np.nan]), np.eye(1)), "error must be finite"),
        (lambda: normalised_squared(np.zeros(2), np.ones((2, 2))), "positive definite"),
        (lambda: normalised_squared(np.zeros(2), -np.eye(2)), "cov must be positive semi-definite"),
        (lambda: average_bounds(0, 5), "at least 1, got 0, 5"),
        (lambda: average_bounds(2, 5, 1.0), "level must be between 0 and 1, got 1.0"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
