"""Normalised errors against whitening by hand and against SciPy's χ²."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from robot_perception.evaluation.consistency import average_bounds, coverage, normalised_squared
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


def test_coverage_of_a_consistent_filter_is_its_level():
    rng = np.random.default_rng(3)
    found = coverage(rng.chisquare(3, size=(40, 2000)), 3)
    assert stats.binomtest(round(2000 * found.averaged_share), 2000, 0.95).pvalue > 1e-3
    assert found.single_interval[0] < 0.95 < found.single_interval[1]
    assert (found.low[0], found.high[-1]) == pytest.approx(average_bounds(3, 40))
    np.testing.assert_allclose(found.averages.mean(), 3, atol=0.05)


@pytest.mark.parametrize(("factor", "share"), [(2.0, 0.95), (0.5, 0.9999)])
def test_coverage_tells_too_sure_from_too_cautious(factor, share):
    rng = np.random.default_rng(4)
    found = coverage(factor * rng.chisquare(3, size=(60, 300)), 3)
    assert found.averaged_share < 0.1
    quantile = stats.chi2.cdf(stats.chi2.ppf(0.95, 3) / factor, 3)
    assert found.single_share == pytest.approx(quantile, abs=0.01)
    assert (found.averages > found.high).mean() == pytest.approx(float(factor > 1), abs=0.05)


def test_each_step_may_have_its_own_degrees_of_freedom():
    rng = np.random.default_rng(5)
    freedom = rng.integers(1, 9, size=400)
    found = coverage(rng.chisquare(freedom, size=(25, 400)), freedom)
    assert stats.binomtest(round(400 * found.averaged_share), 400, 0.95).pvalue > 1e-3
    one = coverage(np.full((25, 1), 4.0), int(freedom[7]))
    assert (found.low[7], found.high[7]) == (one.low[0], one.high[0])


@pytest.mark.parametrize(("hits", "count"), [(0, 7), (3, 7), (7, 7), (19, 20)])
def test_interval_of_the_share_is_scipys(hits, count):
    values = np.where(np.arange(count) < hits, 0.0, 99.0)[None]
    expected = stats.binomtest(hits, count).proportion_ci(0.95, method="exact")
    found = coverage(values, 2)
    assert found.single_share == pytest.approx(hits / count)
    assert found.single_interval == pytest.approx((expected.low, expected.high))


def test_values_that_hang_together_say_less():
    values = np.random.default_rng(1).chisquare(3, size=(20, 50))
    narrow, wide = coverage(values, 3), coverage(values, 3, independent=20)
    assert wide.single_share == narrow.single_share
    assert wide.single_interval[0] < narrow.single_interval[0]
    assert wide.single_interval[1] > narrow.single_interval[1]


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: normalised_squared(np.zeros(2), np.eye(3)), r"cov must be \(…, 2, 2\) for error"),
        (
            lambda: normalised_squared(np.zeros(0), np.zeros((0, 0))),
            r"error must be \(…, n\) with n >= 1",
        ),
        (lambda: normalised_squared(np.array([np.nan]), np.eye(1)), "error must be finite"),
        (lambda: normalised_squared(np.zeros(2), np.ones((2, 2))), "positive definite"),
        (lambda: normalised_squared(np.zeros(2), -np.eye(2)), "cov must be positive semi-definite"),
        (lambda: average_bounds(0, 5), "dimension must be at least 1, got 0"),
        (lambda: coverage(np.zeros(3), 2), r"values must be \(runs, steps\)"),
        (lambda: coverage(np.zeros((0, 3)), 2), r"hold some, got \(0, 3\)"),
        (lambda: coverage(np.array([[np.inf]]), 2), "values must be finite, got 1 of 1"),
        (lambda: coverage(np.array([[-1.0, 4.0]]), 2), "values are squares, got -1"),
        (lambda: coverage(np.ones((2, 3)), np.array([1, 2])), r"one or 3 numbers, got \(2,\)"),
        (
            lambda: coverage(np.ones((2, 2)), np.array([1, 0])),
            "dimension must be at least 1, got 0",
        ),
        (lambda: coverage(np.ones((2, 2)), 1, independent=5), "from 1 to 4, got 5"),
        (lambda: coverage(np.ones((2, 2)), 1, 0.0), "level must be between 0 and 1, got 0.0"),
        (lambda: coverage(np.ones((2, 2)), np.nan), "dimension must be integers, got nan"),
        (lambda: average_bounds(2, 5, 1.0), "level must be between 0 and 1, got 1.0"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
