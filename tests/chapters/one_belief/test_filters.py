"""The page's filters against exact beliefs, other libraries and laws of their own."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from hypothesis import given
from hypothesis import strategies as st

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.book import one_belief as page
from robot_perception.kalman import Motion, Sensor
from tests.chapters.exercises import assert_judged, assert_told

places = st.floats(3.0, 17.0)
deviations = st.floats(0.2, 1.0)


# Lists of numbers --------------------------------------------------------------------------------


def test_the_list_is_bayes_rule_by_counting():
    """Robots are drawn, those whose word is another are sent away, and those left are counted."""
    rng = np.random.default_rng(0)
    x = rng.uniform(0, page.LENGTH, 400_000)

    def hear(x, word):
        fits = page.near_door(x) == (word == "door")
        return x[rng.random(len(x)) < np.where(fits, 0.95, 0.05)]

    x = hear(x, "door") + 3.0
    x = x + 0.2 * rng.standard_normal(len(x))
    x = hear(x[(x > 0) & (x < page.LENGTH)], "door")
    counted = np.histogram(x, 40, (0, page.LENGTH))[0] / len(x)
    listed = page.CELL * page.told().beliefs[-1].reshape(40, -1).sum(axis=1)
    assert np.abs(counted - listed).max() < 6e-3


def test_likelihoods_of_both_words_add_up_to_one():
    assert np.allclose(page.says("door") + page.says("wall"), 1)
    assert page.says("door").sum() == pytest.approx(0.95 * 30 + 0.05 * 170)


def test_a_motion_moves_the_mean_and_adds_variances():
    before = page.update(page.ANYWHERE, page.gaussian(page.PLACES, 6.0, 0.5**2))
    mean, variance = page.moments(page.predict(before, 5.0, 0.4))
    assert (mean, variance) == pytest.approx((11.0, 0.5**2 + 0.4**2), abs=1e-4)


def test_nobody_is_behind_the_end_wall():
    last = np.zeros(len(page.PLACES))
    last[[20, -20]] = 0.5
    moved = page.predict(last, 3.0, 0.1)
    assert moved.sum() == pytest.approx(1)
    assert page.moments(moved)[0] == pytest.approx(page.PLACES[20] + 3.0, abs=1e-6)


# Two numbers -------------------------------------------------------------------------------------


@given(places, deviations, st.floats(-2, 2), deviations)
def test_the_product_is_that_of_the_curves(mean, prior, apart, measurement):
    z = mean + apart
    x = np.linspace(min(mean, z), max(mean, z) + 0.1, 11)
    curve = np.log(page.gaussian(x, mean, prior**2)) + np.log(page.gaussian(x, z, measurement**2))
    found = np.log(page.gaussian(x, *page.gaussian_update(mean, prior**2, z, measurement**2)))
    assert np.ptp(curve - found) < 1e-8


@pytest.mark.parametrize("seed", range(3))
def test_the_filter_is_the_exact_belief_and_filterpys(seed):
    x, u, z = page.drive(np.random.default_rng(seed))
    q, r = page.WHEELS**2, page.LASER**2
    found = np.array(page.kalman_filter(z, u, page.START, 1.0, q, r))
    belief = page.gaussian(page.PLACES, page.START, 1.0)
    peer = KalmanFilter(dim_x=1, dim_z=1, dim_u=1)
    peer.x, peer.P, peer.Q, peer.R = np.array([[page.START]]), 1.0, q, r
    peer.F = peer.H = peer.B = np.eye(1)
    for k in range(len(z)):
        belief = page.update(
            page.predict(belief, u[k], page.WHEELS), page.gaussian(page.PLACES, z[k], r)
        )
        peer.predict(u=u[k])
        peer.update(z[k])
        assert found[:, k] == pytest.approx([peer.x[0, 0], peer.P[0, 0]], abs=1e-12)
        if k > 1:  # at first the list ends at the wall, and the Gaussian does not
            assert found[:, k] == pytest.approx(page.moments(belief), abs=3e-3)
    assert len(x) == page.STEPS


def test_matrices_do_what_numbers_do_and_the_librarys_filter_too():
    x, z = page.pushed(np.random.default_rng(3))
    Q, R = 0.1**2 * np.outer(page.HALF_STEP, page.HALF_STEP), page.LASER**2 * np.eye(1)
    means, covs = page.matrix_filter(
        z[:, None], np.array([2.0, 0.0]), np.eye(2), page.F, Q, page.H, R
    )
    ours = Gaussian(np.array([2.0, 0.0]), np.eye(2))
    for measurement, mean, cov in zip(z[:, None], means, covs, strict=True):
        ours, _ = kalman.update(
            kalman.predict(ours, Motion(page.F, Q)), measurement, Sensor(page.H, R)
        )
        np.testing.assert_allclose(ours.mean, mean, atol=1e-11)
        np.testing.assert_allclose(ours.cov, cov, atol=1e-11)
    one = np.eye(1)
    alone, variances = page.matrix_filter(
        z[:, None], np.array([2.0]), one, one, 0.01 * one, one, 0.16 * one
    )
    by_numbers = page.kalman_filter(z, np.zeros(len(z)), 2.0, 1.0, 0.01, 0.16)
    np.testing.assert_allclose((alone[:, 0], variances[:, 0, 0]), by_numbers, atol=1e-12)
    assert len(x) == page.PUSHES


def test_the_lag_is_what_the_gain_foretells():
    steps = np.arange(1, 200)
    means, variances = page.kalman_filter(0.5 * steps, 0 * steps, 0.0, 1.0, 0.1**2, 0.4**2)
    assert 0.5 * steps[-1] - means[-1] == pytest.approx(page.foretold(), rel=1e-6)
    gain = (variances[-1] + 0.1**2) / (variances[-1] + 0.1**2 + 0.4**2)
    assert page.settled() == pytest.approx(gain, rel=1e-9)


# By an angle -------------------------------------------------------------------------------------


@given(st.floats(0, 20))
def test_slopes_are_finite_differences(x):
    step = 1e-5
    ends = np.array([x - step, x + step])
    assert page.slope(x) == pytest.approx(np.diff(page.bearing(ends))[0] / (2 * step), rel=1e-6)
    far = np.hypot(ends - page.LAMP[0], page.LAMP[1])
    assert page.range_slope(x) == pytest.approx(np.diff(far)[0] / (2 * step), abs=1e-6)


def test_the_extended_filter_is_filterpys_and_near_the_lamp_the_exact_belief():
    x, u, _ = page.drive(np.random.default_rng(1))
    rng, r = np.random.default_rng(2), page.CAMERA_VARIANCE
    z = page.bearing(x) + np.sqrt(r) * rng.standard_normal(len(x))
    means, variances = page.extended_filter(z, u, page.START, 1.0, page.WHEELS**2, r)
    peer = ExtendedKalmanFilter(dim_x=1, dim_z=1, dim_u=1)
    peer.x, peer.P, peer.Q, peer.R = np.array([[page.START]]), 1.0, page.WHEELS**2, r
    peer.B = np.eye(1)
    for k, angle in enumerate(z):
        peer.predict(u=u[k])
        peer.update(np.array([[angle]]), lambda s: np.atleast_2d(page.slope(s[0, 0])), page.bearing)
        assert (means[k], variances[k]) == pytest.approx((peer.x[0, 0], peer.P[0, 0]), abs=1e-12)
    drawn = page.past(x, u, z, means, variances)
    near = x > page.LAMP[0]
    assert np.abs(drawn.exact_means - means)[near].max() < 0.05
    assert np.abs(drawn.exact_deviations / np.sqrt(variances) - 1)[near].max() < 0.1


def test_a_straight_curve_makes_the_extended_filter_exact(monkeypatch):
    monkeypatch.setattr(page, "bearing", lambda x: 0.3 * x + 0.1)
    monkeypatch.setattr(page, "slope", lambda x: 0.3)
    assert page.look(8, 3.0, 15.0).off < 1e-3
    assert page.look(8, 3.0, 15.0).ratio == pytest.approx(1, abs=1e-2)


# Exercises ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "right"),
    [
        ("belief-word", page.foreseen),
        ("belief-fuse", page.fused),
        ("belief-range", page.range_slope),
    ],
)
def test_answers_are_judged_and_mistakes_have_hints_that_differ(key, right):
    assert_judged(page.EXERCISES[key], right)


@pytest.mark.parametrize(
    ("key", "wrong", "said"),
    [
        ("belief-word", lambda _, word: page.says(word).sum(), "equally likely"),
        ("belief-word", lambda b, word: page.says(word) * b, "one number"),
        ("belief-fuse", lambda m, v: (np.mean(m), np.mean(v)), "sharp"),
        ("belief-fuse", lambda m, v: (page.fused(m, v)[0], np.sum(v)), "inverses"),
        ("belief-range", lambda x: -page.range_slope(x), "sign"),
        ("belief-range", page.slope, "angle"),
    ],
)
def test_typical_mistakes_are_told_apart(key, wrong, said):
    assert_told(page.EXERCISES[key], wrong, said)


def test_a_gate_locks_out_what_a_weight_that_never_vanishes_lets_back():
    exercise = page.EXERCISES["belief-gate"]

    def weight(innovation, S):
        return 1 / (1 + innovation**2 / S / 9)

    assert_judged(exercise, weight)
    assert_told(exercise, lambda i, S: np.ones_like(i), "led astray")
    assert_told(exercise, lambda i, S: i**2 < 9 * S, "led astray")
    assert_told(exercise, lambda i, S: i**2 < S, "without people")
    tried = (lambda i, S: np.ones_like(i), lambda i, S: i**2 < 9 * S, weight)
    assert np.round([page.wander(one) for one in tried], 2).tolist() == [0.56, 0.56, 0.23]
    assert page.wander(tried[0], people=0.0) == pytest.approx(0.19, abs=5e-3)


def test_readings_one_by_one_are_readings_together():
    mean, variance = 7.0, 1.0
    for z, r in ((9.0, 0.25), (8.5, 0.5)):
        mean, variance = page.gaussian_update(mean, variance, z, r)
    assert (mean, variance) == pytest.approx(page.fused([7.0, 9.0, 8.5], [1.0, 0.25, 0.5]))
