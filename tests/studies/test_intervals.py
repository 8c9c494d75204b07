"""Intervals cover what they say, agree with formulas written out here, and refuse bad input."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from studies import intervals
from studies.intervals import Interval

RNG = np.random.default_rng
Z = 1.959963984540054


def covered(make, truth, runs):
    """How often intervals made from fresh samples hold the truth."""
    made = [make(rng) for rng in RNG(0).spawn(runs)]
    return sum(i.low <= truth <= i.high for i in made)


def chance(runs, level=0.95):
    """The counts that four standard deviations of luck allow."""
    return runs * level + np.array([-4, 4]) * math.sqrt(runs * level * (1 - level))


@pytest.mark.parametrize(
    ("make", "truth", "runs", "slack"),
    [
        (lambda rng: intervals.mean(rng.normal(3, 2, 12)), 3.0, 2000, 0),
        (lambda rng: intervals.root_mean_square(rng.normal(0, 2, 9)), 2.0, 2000, 0),
        (
            lambda rng: intervals.variance_ratio(rng.normal(0, 3, 20), rng.normal(1, 2, 15)),
            2.25,
            2000,
            0,
        ),
        (
            lambda rng: intervals.slope(np.arange(8.0), 2 * np.arange(8) + rng.normal(0, 1, 8)),
            2,
            2000,
            0,
        ),
        (
            lambda rng: intervals.correlation(
                *rng.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], 60).T
            ),
            0.6,
            2000,
            0.01,  # Fisher's transformation is nearly exact only
        ),
        (lambda rng: intervals.bootstrap_mean(rng.exponential(2, 60)), 2.0, 300, 0.04),
        (
            lambda rng: intervals.bootstrap_ratio(rng.normal(4, 1, 60), rng.normal(2, 0.5, 60)),
            2.0,
            300,
            0.04,
        ),
    ],
    ids=["mean", "rms", "variances", "slope", "correlation", "bootstrap", "ratio"],
)
def test_the_truth_is_covered_as_often_as_stated(make, truth, runs, slack):
    low, high = chance(runs)
    assert low - slack * runs < covered(make, truth, runs) < high


def test_student_and_wilson_are_the_formulas():
    x = RNG(1).normal(size=7)
    half = stats.t.ppf(0.995, 6) * x.std(ddof=1) / math.sqrt(7)
    got = intervals.mean(x, level=0.99)
    assert (got.low, got.high) == pytest.approx((x.mean() - half, x.mean() + half))
    got = intervals.proportion(8, 10)
    centre = (0.8 + Z**2 / 20) / (1 + Z**2 / 10)
    half = Z / (1 + Z**2 / 10) * math.sqrt(0.16 / 10 + Z**2 / 400)
    assert (got.low, got.high) == pytest.approx((centre - half, centre + half))


def test_slope_ratio_of_variances_and_root_mean_square_are_the_formulas():
    """Pivots: Student's t with n - 2, F with both n - 1, χ² with n degrees of freedom."""
    x, y = np.arange(6.0), RNG(5).normal(size=6)
    got = intervals.slope(x, y)
    design = np.column_stack([np.ones(6), x])
    found = np.linalg.lstsq(design, y, rcond=None)
    error = math.sqrt(found[1][0] / 4 * np.linalg.inv(design.T @ design)[1, 1])
    pivot = (found[0][1] - np.array([got.low, got.high])) / error
    np.testing.assert_allclose(stats.t.cdf(pivot, 4), [0.975, 0.025])
    few, many = RNG(6).normal(size=4), RNG(7).normal(size=30)
    got = intervals.variance_ratio(few, many)
    assert got.estimate == pytest.approx(np.cov(few) / np.cov(many))
    pivot = got.estimate / np.array([got.low, got.high])
    np.testing.assert_allclose(stats.f.cdf(pivot, 3, 29), [0.975, 0.025])
    got = intervals.root_mean_square(few)
    pivot = (few**2).sum() / np.array([got.low, got.high]) ** 2
    np.testing.assert_allclose(stats.chi2.cdf(pivot, 4), [0.975, 0.025])


def test_a_bootstrap_takes_the_percentiles_of_what_was_drawn():
    """Of samples that are 1 once in twelve the mean is a share k/12: none is below zero."""
    samples = np.eye(12)[0]
    got = intervals.bootstrap_mean(samples)
    share = stats.binom(12, 1 / 12)
    assert (got.low, got.high) == pytest.approx(np.array(share.interval(0.95)) / 12)
    assert intervals.bootstrap_ratio(samples, np.ones(12)).high == got.high


def test_correlation_is_fishers_and_its_square_starts_at_zero_if_in_doubt():
    x, y = RNG(2).normal(size=(2, 40))
    r = intervals.correlation(x, y)
    z = math.atanh(np.corrcoef(x, y)[0, 1])
    half = Z / math.sqrt(37)
    assert (r.low, r.high) == pytest.approx((math.tanh(z - half), math.tanh(z + half)))
    share = intervals.explained(x, y)
    assert r.low < 0 < r.high
    assert (share.low, share.high) == (0, pytest.approx(max(r.low**2, r.high**2)))
    against = intervals.explained(x, -x + 0.1 * y)
    assert 0.9 < against.low < against.estimate < against.high < 1


@pytest.mark.parametrize("power", [-1.0, 0.5, 2.0])
def test_exponent_of_a_power_law_is_found_and_its_unit_does_not_matter(power):
    n = np.array([10.0, 20, 50, 100])
    for factor in (1.0, 1e-6):
        got = intervals.exponent(n, factor * n**power)
        assert got.estimate == pytest.approx(power, abs=1e-12)
        assert got.high - got.low < 1e-6


def test_median_and_its_spread_are_quantiles_and_a_bootstrap_lies_within():
    x = RNG(3).exponential(size=200)
    got = intervals.spread(x, "m", level=0.8)
    assert (got.low, got.estimate, got.high) == pytest.approx(np.quantile(x, [0.1, 0.5, 0.9]))
    assert got.unit == "m"
    middle = intervals.bootstrap_median(x)
    assert got.low < middle.low < np.median(x) == middle.estimate < middle.high < got.high


def test_bootstrap_is_the_same_each_time_and_ignores_a_common_unit():
    a, b = RNG(4).gamma(2, size=(2, 30))
    assert intervals.bootstrap_ratio(a, b) == intervals.bootstrap_ratio(a, b)
    scaled = intervals.bootstrap_ratio(1e3 * a, 1e3 * b)
    assert (scaled.low, scaled.high) == pytest.approx(
        (intervals.bootstrap_ratio(a, b).low, intervals.bootstrap_ratio(a, b).high)
    )
    same = intervals.bootstrap_ratio(a, a)
    assert (same.low, same.high) == (1, 1), "the runs are paired"


def test_samples_without_a_denominator_are_left_out():
    """Eight of 27 draws of three runs miss the one that counts: these have no ratio."""
    got = intervals.bootstrap_ratio(np.array([1.0, 0, 0]), np.array([2.0, 0, 0]))
    assert (got.low, got.estimate, got.high) == (0.5, 0.5, 0.5)
    mixed = intervals.bootstrap_ratio(np.array([1.0, 3, 0]), np.array([2.0, 4, 0]))
    assert (mixed.low, mixed.high) == (0.5, 0.75)
    assert mixed.estimate == pytest.approx(4 / 6)


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_proportion_interval_holds_the_rate(counts):
    interval = intervals.proportion(*counts)
    assert 0 <= interval.low <= interval.estimate <= interval.high <= 1


@pytest.mark.parametrize("bad", [(3, 1, 2), (1, 2, 3), (math.nan, 0, 1), (1, 0, math.inf)])
def test_interval_refuses_disorder_and_non_finite(bad):
    with pytest.raises(ValueError, match="interval must"):
        Interval(*bad)


def test_numbers_are_shown_with_their_interval_and_unit():
    assert str(Interval(1.23456, 1.0, 2.0, "m")) == "1.235 [1, 2] m"
    assert str(intervals.exact(2, "m")) == "2 m"
    assert Interval(1.23456, 1.0, 2.0).shown(2) == "1.2 [1, 2]"


X = np.arange(5.0)


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: intervals.mean(np.array([1.0])), "at least 2 samples, got 1"),
        (lambda: intervals.mean(np.array([1.0, np.nan])), "samples must be finite, got 1 of 2"),
        (lambda: intervals.spread(np.array([])), "at least 1"),
        (lambda: intervals.proportion(3, 2), "3 of 2"),
        (lambda: intervals.proportion(0, 0), "trials must be at least 1, got 0"),
        (lambda: intervals.bootstrap_mean(np.array([np.inf, 1.0])), "must be finite"),
        (lambda: intervals.bootstrap_ratio(X, X[:4]), r"\[4, 5\]"),
        (lambda: intervals.correlation(X, np.ones(5)), "last is constant at 1"),
        (lambda: intervals.correlation(X[:3], X[:3]), "at least 4 first"),
        (lambda: intervals.slope(X[:2], X[:2]), "at least 3 x"),
        (lambda: intervals.exponent(X, X), "positive"),
        (lambda: intervals.variance_ratio(X, np.ones(4)), "below does not vary"),
    ],
)
def test_bad_input_is_named(make, match):
    with pytest.raises(ValueError, match=match):
        make()


def test_intervals_overlap_where_they_share_a_number():
    ours = Interval(2.0, 1.0, 3.0)
    assert all(ours.overlaps(Interval(x, x, x)) for x in (1.0, 2.0, 3.0))
    assert ours.overlaps(Interval(3.5, 3.0, 4.0))
    assert ours.overlaps(Interval(2.0, 0.0, 4.0))
    assert not any(ours.overlaps(Interval(x, x, x)) for x in (0.999, 3.001))


def test_largest_holds_the_largest_of_the_values():
    low, wide = Interval(1.0, 0.9, 1.1, "m", "low"), Interval(0.5, 0.0, 2.0, "m", "wide")
    assert intervals.largest(low, wide) == Interval(1.0, 0.9, 2.0, "m", "low")
    assert intervals.largest(wide) == wide
    for wrong in ((), (low, Interval(1.0, 1.0, 1.0, "s"))):
        with pytest.raises(ValueError, match="must be of one unit"):
            intervals.largest(*wrong)
