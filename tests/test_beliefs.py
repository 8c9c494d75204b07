"""Beliefs refuse what is no belief."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robot_perception.beliefs import Gaussian, ParticleSet, normalise
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


def test_moments_of_particles_are_numpys_of_a_batch_too():
    rng = np.random.default_rng(0)
    states, logs = rng.normal(size=(4, 30, 3)), rng.normal(size=(4, 30))
    batch = ParticleSet(states, logs)
    for k in range(4):
        one, weights = ParticleSet(states[k], logs[k]), np.exp(logs[k])
        assert one.weights.sum() == pytest.approx(1, rel=1e-12)
        np.testing.assert_allclose(one.weights, weights / weights.sum(), rtol=1e-12)
        np.testing.assert_allclose(one.mean, np.average(states[k], axis=0, weights=weights))
        np.testing.assert_allclose(one.cov, np.cov(states[k].T, aweights=weights, ddof=0))
        np.testing.assert_allclose(batch.mean[k], one.mean, rtol=0, atol=1e-14)
        np.testing.assert_allclose(batch.cov[k], one.cov, rtol=0, atol=1e-14)
        check_covariance("cov", one.cov)
    equal = ParticleSet.uniform(states)
    np.testing.assert_array_equal(equal.weights, np.full(30, equal.weights[0]))
    np.testing.assert_allclose(equal.mean, states.mean(axis=1), rtol=0, atol=1e-14)
    assert ParticleSet(states, logs[0]).cov.shape == (4, 3, 3)  # one set of weights for all


@given(hnp.arrays(float, (2, 5), elements=st.floats(-5, 5)), st.sampled_from([-1e4, 0.0, 1e4]))
def test_a_constant_of_the_logarithms_does_not_matter(logs, constant):
    logs[0, 0] = -np.inf  # a particle without weight
    logs, sums = normalise(logs + constant)
    np.testing.assert_allclose(np.exp(logs).sum(axis=1), 1, rtol=1e-9)
    again, sums_again = normalise(logs)
    np.testing.assert_allclose(again, logs, rtol=0, atol=1e-9)
    np.testing.assert_allclose(sums_again, 0, rtol=0, atol=1e-9)
    assert logs[0, 0] == -np.inf
    assert sums.shape == (2,)
    assert (np.abs(sums - constant) < 7).all()


@given(
    hnp.arrays(float, st.integers(1, 6), elements=st.floats(-1e300, 1e300) | st.just(-np.inf)),
    st.sampled_from([-1e300, -1e16, -1e8, 0.0, 1e10, 1e17]),
)
def test_weights_sum_to_one_however_far_the_logarithms_are(logs, first):
    logs[0] = first
    weights = np.exp(normalise(logs)[0])
    assert weights.sum() == pytest.approx(1, rel=1e-7)
    assert 1 - 1e-7 <= 1 / (weights**2).sum() <= len(logs) * (1 + 1e-7)
    alike = normalise(np.full(4, first))[0]
    assert np.exp(alike) == pytest.approx(0.25, rel=1e-7)


@given(hnp.arrays(float, (2, 5), elements=st.floats(-1e8, 1e8) | st.floats(-9, 9)))
def test_ordinary_weights_are_rounded_as_they_were_when_results_were_recorded(logs):
    top = logs.max(axis=1, keepdims=True)
    sums = top + np.log(np.exp(logs - top).sum(axis=1, keepdims=True))
    assert (normalise(logs)[0] == logs - sums).all()


def test_the_sum_of_the_weights_comes_back():
    logs, total = normalise(np.log([0.5, 1.5, 2.0]))
    assert total == pytest.approx(np.log(4))
    np.testing.assert_allclose(np.exp(logs), [0.125, 0.375, 0.5])


HALF = np.array([[0.0, 0.0], [-np.inf, -np.inf]])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: ParticleSet(np.ones(3), np.ones(3)), r"states must be \(…, m, n\), got \(3,\)"),
        (lambda: ParticleSet(np.ones((0, 2)), np.ones(0)), "at least one particle, got \\(0, 2"),
        (lambda: ParticleSet.uniform(np.ones((0, 2))), "at least one particle"),
        (lambda: ParticleSet(np.ones((3, 2)), np.ones(2)), r"log_weights must be \(…, 3\) for sta"),
        (lambda: ParticleSet(np.ones((4, 3, 2)), np.ones((2, 3))), "leading axes must broadcast"),
        (lambda: ParticleSet(np.full((3, 2), np.nan), np.ones(3)), "states must be finite, got 6"),
        (lambda: normalise(np.full(3, -np.inf)), "must not all be -inf, got 1 of 1 sets so"),
        (lambda: normalise(HALF), "must not all be -inf, got 1 of 2 sets so"),
        (lambda: normalise(np.array([0, np.nan])), "must be finite or -inf, got 1 of 2 otherwise"),
        (lambda: normalise(np.array([0, np.inf, np.nan])), "finite or -inf, got 2 of 3 otherwise"),
        (lambda: normalise(np.empty((2, 0))), r"must hold at least one weight, got \(2, 0\)"),
    ],
)
def test_bad_particles_are_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
