"""The Kalman filter against filterpy, SciPy's Riccati solver, brute force, and its own laws."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.linalg import solve_discrete_are

from robot_perception.beliefs import Gaussian
from robot_perception.kalman import (
    Motion,
    Sensor,
    fisher_information,
    predict,
    scale_free_rank,
    start_information,
    state_information,
    steady_state,
    update,
)
from tests.unchecked import unchecked

PHI = (1 + np.sqrt(5)) / 2


def covariance(n, rng, rank=None):
    factor = rng.normal(size=(n, n if rank is None else rank))
    return factor @ factor.T


def system(n, m, rng):
    """Return a random system; its transition is far from symmetric."""
    F = rng.normal(size=(n, n)) + np.triu(rng.normal(size=(n, n)), 1)
    return (
        Motion(F, covariance(n, rng), rng.normal(size=n)),
        Sensor(rng.normal(size=(m, n)), covariance(m, rng) + 0.1 * np.eye(m)),
    )


def belief(n, rng):
    return Gaussian(rng.normal(size=n), covariance(n, rng))


systems = st.tuples(st.integers(1, 5), st.integers(1, 4), st.integers(0, 2**32 - 1))


@pytest.mark.parametrize("seed", range(5))
def test_ten_steps_equal_filterpy_with_a_transition_that_is_not_symmetric(seed):
    rng = np.random.default_rng(seed)
    n, m = 4, 2
    motion, sensor = system(n, m, rng)
    assert not np.allclose(motion.transition, motion.transition.T)
    ours = belief(n, rng)
    peer = KalmanFilter(dim_x=n, dim_z=m, dim_u=n)
    peer.x, peer.P = ours.mean[:, None].copy(), ours.cov.copy()
    peer.F, peer.Q, peer.B = motion.transition, motion.noise, np.eye(n)
    peer.H, peer.R = sensor.matrix, sensor.noise
    for _ in range(10):
        z = rng.normal(size=m)
        ours, info = update(predict(ours, motion), z, sensor)
        peer.predict(u=motion.shift[:, None])
        peer.update(z[:, None])
        np.testing.assert_allclose(ours.mean, peer.x[:, 0], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(ours.cov, peer.P, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(info.innovation, peer.y[:, 0], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(info.innovation_cov, peer.S, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(info.gain, peer.K, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(info.log_likelihood, peer.log_likelihood, rtol=1e-9)
        np.testing.assert_allclose(
            info.normalised_innovation_squared, peer.mahalanobis**2, rtol=1e-9
        )


@given(systems)
@settings(max_examples=40)
def test_update_is_conditioning_of_the_joint_gaussian(case):
    n, m, seed = case
    rng = np.random.default_rng(seed)
    prior = Gaussian(rng.normal(size=n), covariance(n, rng) + 0.1 * np.eye(n))
    (_, sensor), z = system(n, m, rng), rng.normal(size=m)
    posterior, info = update(prior, z, sensor)
    # Bayes' rule in information form
    prior_information = np.linalg.inv(prior.cov)
    weight = sensor.matrix.T @ np.linalg.inv(sensor.noise)
    cov = np.linalg.inv(prior_information + weight @ sensor.matrix)
    mean = cov @ (prior_information @ prior.mean + weight @ z)
    np.testing.assert_allclose(posterior.cov, cov, rtol=0, atol=1e-9 * np.abs(prior.cov).max())
    np.testing.assert_allclose(posterior.mean, mean, rtol=1e-7, atol=1e-7)
    density = stats.multivariate_normal(
        sensor.matrix @ prior.mean, sensor.matrix @ prior.cov @ sensor.matrix.T + sensor.noise
    )
    np.testing.assert_allclose(info.log_likelihood, density.logpdf(z), rtol=1e-6, atol=1e-6)


@given(systems)
@settings(max_examples=40)
def test_a_measurement_never_adds_uncertainty_and_a_motion_never_removes_it(case):
    n, m, seed = case
    rng = np.random.default_rng(seed)
    prior, (motion, sensor) = belief(n, rng), system(n, m, rng)
    posterior, _ = update(prior, rng.normal(size=m), sensor)
    scale = np.abs(prior.cov).max()
    assert np.linalg.eigvalsh(prior.cov - posterior.cov).min() >= -1e-9 * scale
    still = Motion(np.eye(n), motion.noise)
    moved = predict(prior, still)
    assert np.linalg.eigvalsh(moved.cov - prior.cov).min() >= -1e-9 * scale


@given(systems)
@settings(max_examples=30)
def test_two_independent_sensors_may_speak_together_or_in_turn(case):
    n, m, seed = case
    rng = np.random.default_rng(seed)
    prior, (_, first), (_, second) = belief(n, rng), system(n, m, rng), system(n, m, rng)
    z = rng.normal(size=2 * m)
    together = Sensor(
        np.vstack([first.matrix, second.matrix]),
        np.block([[first.noise, np.zeros((m, m))], [np.zeros((m, m)), second.noise]]),
    )
    at_once, info = update(prior, z, together)
    half, info_first = update(prior, z[:m], first)
    in_turn, info_second = update(half, z[m:], second)
    scale = 1 + np.abs(prior.cov).max()
    np.testing.assert_allclose(in_turn.mean, at_once.mean, rtol=0, atol=1e-7 * scale)
    np.testing.assert_allclose(in_turn.cov, at_once.cov, rtol=0, atol=1e-7 * scale)
    np.testing.assert_allclose(
        info_first.log_likelihood + info_second.log_likelihood, info.log_likelihood, rtol=1e-6
    )


def test_batch_equals_loop():
    rng = np.random.default_rng(3)
    motion, sensor = system(3, 2, rng)
    means, covs = rng.normal(size=(4, 5, 3)), np.stack([covariance(3, rng) for _ in range(5)])
    z = rng.normal(size=(4, 5, 2))
    batch, info = update(predict(Gaussian(means, covs), motion), z, sensor)
    assert batch.mean.shape == (4, 5, 3)
    assert batch.cov.shape == (5, 3, 3), "one covariance serves the outer axis"
    for i in range(4):
        for j in range(5):
            one, one_info = update(predict(Gaussian(means[i, j], covs[j]), motion), z[i, j], sensor)
            np.testing.assert_allclose(batch.mean[i, j], one.mean, rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(batch.cov[j], one.cov, rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(info.log_likelihood[i, j], one_info.log_likelihood)


def test_inputs_are_not_written_to():
    rng = np.random.default_rng(4)
    prior, (motion, sensor), z = belief(3, rng), system(3, 2, rng), rng.normal(size=2)
    before = [a.copy() for a in (prior.mean, prior.cov, motion.transition, sensor.matrix, z)]
    update(predict(prior, motion), z, sensor)
    after = (prior.mean, prior.cov, motion.transition, sensor.matrix, z)
    for old, new in zip(before, after, strict=True):
        np.testing.assert_array_equal(old, new)


def test_joseph_form_stays_a_covariance_where_the_short_form_does_not():
    """A measurement far more accurate than the prior: the rest is its own, or (I - KH)P is broken.

    The prior spans eight decades and the sensor sees all of the state, so that the posterior is
    the noise; the short form leaves rounding of the prior's size there.
    """
    noise, broken = 1e-10, 0
    for seed in range(50):
        rng = np.random.default_rng(seed)
        axes, rows = np.linalg.qr(rng.normal(size=(2, 3, 3)))[0]
        cov = axes @ np.diag([1e8, 1e4, 1.0]) @ axes.T
        prior = Gaussian(np.zeros(3), (cov + cov.T) / 2)
        sensor = Sensor(rows, noise * np.eye(3))
        posterior, info = update(prior, np.zeros(3), sensor)
        np.testing.assert_allclose(posterior.cov, noise * np.eye(3), rtol=0, atol=1e-4 * noise)
        short = (np.eye(3) - info.gain @ sensor.matrix) @ prior.cov
        broken += np.linalg.eigvalsh((short + short.T) / 2)[0] < -noise
    assert broken > 25, "the example is to be one on which the short form fails"


def test_information_is_the_sum_of_the_terms():
    rng = np.random.default_rng(5)
    H = rng.normal(size=(2, 3))
    S = np.stack([covariance(2, rng) + np.eye(2) for _ in range(6)])
    J = fisher_information(H, S)
    expected = np.cumsum([H.T @ np.linalg.inv(s) @ H for s in S], axis=0)
    np.testing.assert_allclose(J, expected, rtol=1e-12)
    np.testing.assert_allclose(fisher_information(H, np.stack([S, S]))[1], expected, rtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_information_on_the_start_equals_the_joint_likelihood_of_all_measurements(seed):
    """Oracle: write all measurements as one Gaussian vector, z = O x0 + noise, and take OᵀC⁻¹O."""
    rng = np.random.default_rng(seed)
    n, m, steps = 3, 2, 6
    motions = [Motion(rng.normal(size=(n, n)), covariance(n, rng)) for _ in range(steps)]
    sensors = [
        Sensor(rng.normal(size=(m, n)), covariance(m, rng) + np.eye(m)) for _ in range(steps)
    ]
    to_start, to_noise = np.eye(n), np.zeros((n, n * steps))
    rows, noise_rows = [], []
    for k, (motion, sensor) in enumerate(zip(motions, sensors, strict=True)):
        to_start, to_noise = motion.transition @ to_start, motion.transition @ to_noise
        to_noise[:, n * k : n * (k + 1)] += np.eye(n)
        rows.append(sensor.matrix @ to_start)
        noise_rows.append(sensor.matrix @ to_noise)
    Q = np.zeros((n * steps, n * steps))
    R = np.zeros((m * steps, m * steps))
    for k in range(steps):
        Q[n * k : n * (k + 1), n * k : n * (k + 1)] = motions[k].noise
        R[m * k : m * (k + 1), m * k : m * (k + 1)] = sensors[k].noise
    stacked, spread = np.vstack(rows), np.vstack(noise_rows)
    ours = start_information(motions, sensors)
    for k in range(1, steps + 1):
        seen = stacked[: m * k]
        cov = (spread @ Q @ spread.T + R)[: m * k, : m * k]
        np.testing.assert_allclose(ours[k - 1], seen.T @ np.linalg.solve(cov, seen), rtol=1e-7)


@pytest.mark.parametrize("seed", range(6))
def test_information_on_the_state_with_a_prior_is_the_inverse_covariance_of_the_filter(seed):
    """Oracle: the covariance form, which never sees an information matrix."""
    rng = np.random.default_rng(seed)
    n, m, steps = 3, 2, 6
    motions = [Motion(rng.normal(size=(n, n)), covariance(n, rng)) for _ in range(steps)]
    sensors = [
        Sensor(rng.normal(size=(m, n)), covariance(m, rng) + np.eye(m)) for _ in range(steps)
    ]
    now = Gaussian(np.zeros(n), covariance(n, rng))
    ours = state_information(motions, sensors, np.linalg.inv(now.cov))
    for found, motion, sensor in zip(ours, motions, sensors, strict=True):
        now, _ = update(predict(now, motion), np.zeros(m), sensor)
        np.testing.assert_allclose(found @ now.cov, np.eye(n), atol=1e-8)


def test_information_without_a_prior_is_the_limit_of_ever_weaker_ones():
    rng = np.random.default_rng(3)
    n, steps = 3, 4
    motions = [Motion(rng.normal(size=(n, n)), covariance(n, rng)) for _ in range(steps)]
    sensors = [Sensor(rng.normal(size=(1, n)), np.eye(1)) for _ in range(steps)]
    ours = state_information(motions, sensors)
    assert scale_free_rank(ours).tolist() == [1, 2, 3, 3]
    weak = state_information(motions, sensors, 1e-9 * np.eye(n))
    np.testing.assert_allclose(ours, weak, rtol=1e-5, atol=1e-7)


def test_information_on_a_state_that_does_not_move_is_the_sum_over_the_measurements():
    still, sensor = Motion(np.eye(2), np.zeros((2, 2))), Sensor(np.array([[1.0, -1.0]]), np.eye(1))
    found = state_information([still] * 5, [sensor] * 5)
    term = np.array([[1.0, -1.0], [-1.0, 1.0]])
    np.testing.assert_allclose(found, np.arange(1, 6)[:, None, None] * term)


@pytest.mark.parametrize("seed", range(6))
def test_steady_state_equals_scipy_and_the_recursion(seed):
    rng = np.random.default_rng(seed)
    n, m = 3, 2
    motion, sensor = system(n, m, rng)
    motion = Motion(motion.transition / 2, motion.noise)
    ours = steady_state(motion, sensor)
    peer = solve_discrete_are(motion.transition.T, sensor.matrix.T, motion.noise, sensor.noise)
    np.testing.assert_allclose(ours.predicted, peer, rtol=1e-8)
    recursion = Gaussian(np.zeros(n), np.eye(n))
    for _ in range(300):
        predicted = predict(recursion, motion)
        recursion, info = update(predicted, np.zeros(m), sensor)
    np.testing.assert_allclose(ours.predicted, predicted.cov, rtol=1e-8)
    np.testing.assert_allclose(ours.posterior, recursion.cov, rtol=1e-8)
    np.testing.assert_allclose(ours.gain, info.gain, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(ours.innovation_cov, info.innovation_cov, rtol=1e-8)
    errors = np.eye(n)  # of the recursion: one step further each shrinks by its pole
    for _ in range(20):
        errors = (np.eye(n) - info.gain @ sensor.matrix) @ motion.transition @ errors
    moduli = np.abs(ours.poles)
    assert 1 > moduli[0] >= moduli[1] >= moduli[2]
    assert np.abs(np.linalg.eigvals(errors)).max() == pytest.approx(moduli[0] ** 20, rel=1e-6)
    assert np.exp(-1 / ours.time_constant) == pytest.approx(moduli[0], rel=1e-12)


def test_random_walk_seen_directly_settles_at_the_golden_ratio():
    one = np.eye(1)
    state = steady_state(Motion(one, one), Sensor(one, one))
    assert state.predicted[0, 0] == pytest.approx(PHI, rel=1e-12)
    assert state.gain[0, 0] == pytest.approx(1 / PHI, rel=1e-12)
    assert state.poles[0] == pytest.approx(PHI**-2, rel=1e-12)
    assert state.time_constant == pytest.approx(1 / (2 * np.log(PHI)), rel=1e-12)


@pytest.mark.parametrize(("growth", "variance"), [(1.5, 1.25), (-1.5, 1.25), (2.0, 3.0)])
def test_a_growing_mode_without_plant_noise_is_never_known(growth, variance):
    one = np.eye(1)
    state = steady_state(Motion(growth * one, 0 * one), Sensor(one, one))
    assert state.predicted[0, 0] == pytest.approx(variance, rel=1e-12)  # growth² - 1
    assert state.poles[0] == pytest.approx(1 / growth, rel=1e-12)  # mirrored on the unit circle
    assert state.time_constant == pytest.approx(1 / np.log(abs(growth)), rel=1e-12)


@pytest.mark.parametrize("noisy", [0, 1, 2])
@pytest.mark.parametrize("seed", range(5))
def test_growing_modes_equal_scipy_and_the_recursion(seed, noisy):
    rng = np.random.default_rng(seed)
    modes = np.diag([*rng.uniform(1.1, 1.6, 3 - noisy) * rng.choice([-1, 1]), *[0.7, 0.4][:noisy]])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    F, root = turn @ modes @ turn.T, turn[:, 3 - noisy :] @ rng.normal(size=(noisy, noisy))
    Q, R = root @ root.T, np.diag([0.5, 2.0])  # noise on the other modes, or on none
    motion, sensor = Motion(F, (Q + Q.T) / 2), Sensor(rng.normal(size=(2, 3)), R)
    state = steady_state(motion, sensor)
    peer = solve_discrete_are(F.T, sensor.matrix.T, motion.noise, R)
    np.testing.assert_allclose(state.predicted, peer, atol=1e-8 * np.abs(peer).max())
    belief = Gaussian(np.zeros(3), np.eye(3))
    for _ in range(400):
        predicted = predict(belief, motion)
        belief, _ = update(predicted, np.zeros(2), sensor)
    error = np.abs(state.predicted - predicted.cov).max()
    assert error < 1e-8 * np.abs(peer).max()
    assert np.abs(state.poles[0]) < 1


def test_a_pole_on_the_unit_circle_takes_for_ever():
    one = np.eye(1)
    assert steady_state(Motion(one, 0 * one), Sensor(one, one)).time_constant == np.inf
    assert steady_state(Motion(0 * one, one), Sensor(one, one)).time_constant == 0


def test_a_steady_state_lost_to_rounding_is_refused():
    rng = np.random.default_rng(4)
    growing = Motion(np.diag([1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.5]), np.zeros((7, 7)))
    with pytest.raises(ValueError, match="lost to rounding"):
        steady_state(growing, Sensor(rng.normal(size=(1, 7)), np.eye(1)))


def test_constant_velocity_equals_scipy():
    F = np.array([[1.0, 0.5], [0.0, 1.0]])
    Q = 0.3 * np.array([[0.125 / 3, 0.125], [0.125, 0.5]])
    H = np.array([[1.0, 0.0]])
    state = steady_state(Motion(F, Q), Sensor(H, 2.0 * np.eye(1)))
    np.testing.assert_allclose(
        state.predicted, solve_discrete_are(F.T, H.T, Q, 2.0 * np.eye(1)), rtol=1e-9
    )


def test_steady_state_refuses_a_direction_that_is_never_seen():
    H = np.array([[-1.0, 1.0]])
    with pytest.raises(ValueError, match="1 undamped direction"):
        steady_state(Motion(np.eye(2), np.diag([1.0, 0.0])), Sensor(H, np.eye(1)))


@pytest.mark.parametrize("turn", [0.0, 0.3, np.pi / 2, np.pi])
@pytest.mark.parametrize("growth", [1.0, 1.5])
def test_no_undamped_direction_may_be_unseen_whatever_its_pole(turn, growth):
    """Poles ±1, ±i and complex ones, on the unit circle and outside; damped ones may be unseen."""
    c, s = np.cos(turn), np.sin(turn)
    rotation, sensor = np.array([[c, -s], [s, c]]), Sensor(np.array([[0.0, 0.0, 1.0]]), np.eye(1))
    F = np.eye(3) / 2
    F[:2, :2] = growth * rotation
    with pytest.raises(ValueError, match=r"undamped direction\(s\) are never seen"):
        steady_state(Motion(F, np.eye(3)), sensor)
    F[:2, :2] = 0.9 * rotation
    seen = (0.25 + np.sqrt(0.25**2 + 4)) / 2  # p = p / 4 / (p + 1) + 1
    settled = np.diag([1 / (1 - 0.9**2), 1 / (1 - 0.9**2), seen])
    P = steady_state(Motion(F, np.eye(3)), sensor).predicted
    np.testing.assert_allclose(P, settled, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("rounding", "rank"), [(0, 1), (8, 1), (64, 2), (1e6, 2)])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e5])
def test_rank_counts_what_is_above_rounding(rounding, rank, unit):
    """Two directions that are almost one; their smaller eigenvalue in units of rounding."""
    almost = 1 - rounding * np.finfo(float).eps
    matrix = np.array([[1.0, almost * unit], [almost * unit, unit**2]])
    assert scale_free_rank(matrix) == rank


@given(st.integers(1, 6), st.integers(0, 6), st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_rank_does_not_depend_on_units(n, rank, seed):
    rank = min(n, rank)
    rng = np.random.default_rng(seed)
    factor = np.linalg.qr(rng.normal(size=(n, n)))[0][:, :rank]
    units = np.diag(10.0 ** rng.uniform(-5, 5, n))
    assert scale_free_rank(factor @ factor.T) == rank
    scaled = units @ factor @ factor.T @ units
    assert scale_free_rank((scaled + scaled.T) / 2) == rank


GOOD = Gaussian(np.zeros(2), np.eye(2))
EYE, NAN = np.eye(2), np.full((2, 2), np.nan)
STILL, FORGETFUL = Motion(EYE, EYE), Motion(np.diag([1.0, 0.0]), EYE)
WHOLE, EXACT = Sensor(EYE, EYE), Sensor(EYE, 0 * EYE)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Motion(np.ones((2, 3)), EYE), r"transition must be \(…, n, n\), got \(2, 3\)"),
        (lambda: Motion(EYE, np.eye(3)), r"noise must be \(…, 2, 2\) .*got \(3, 3\)"),
        (lambda: Motion(EYE, -EYE), "noise must be positive semi-definite"),
        (lambda: Motion(EYE, np.array([[1.0, 0.5], [0.0, 1.0]])), "noise must be symmetric"),
        (lambda: Motion(NAN, EYE), "transition must be finite"),
        (lambda: Motion(EYE, NAN), "noise must be finite"),
        (lambda: Motion(EYE, EYE, np.zeros(3)), r"shift must be \(…, 2\), got \(3,\)"),
        (lambda: Motion(EYE, EYE, np.array([0.0, np.inf])), "shift must be finite"),
        (lambda: Sensor(np.zeros((0, 2)), np.zeros((0, 0))), "m, n >= 1"),
        (lambda: Sensor(EYE, np.eye(3)), r"noise must be \(…, 2, 2\)"),
        (lambda: Sensor(NAN, EYE), "matrix must be finite"),
        (lambda: predict(GOOD, Motion(np.eye(3), np.eye(3))), "motion is of 3 states"),
        (lambda: update(GOOD, np.zeros(3), Sensor(np.eye(3), np.eye(3))), "sensor is of 3 states"),
        (lambda: update(GOOD, np.zeros(1), Sensor(EYE, EYE)), r"measurement must be \(…, 2\)"),
        (lambda: update(GOOD, np.array([0, np.nan]), Sensor(EYE, EYE)), "measurement must be fin"),
        (
            lambda: update(Gaussian(np.zeros(2), 0 * EYE), np.zeros(2), Sensor(EYE, 0 * EYE)),
            "covariance is singular",
        ),
        (lambda: fisher_information(EYE, np.ones((4, 3, 3))), "innovation_covs must be"),
        (lambda: fisher_information(EYE, np.zeros((4, 2, 2))), "innovation_covs is singular"),
        (lambda: start_information([], []), "as many motions as sensors"),
        (lambda: state_information([], []), "as many motions as sensors"),
        (lambda: state_information([STILL], [Sensor(np.eye(3), np.eye(3))]), "all be of 2 states"),
        (lambda: state_information([FORGETFUL], [WHOLE]), "motions: a transition is singular"),
        (lambda: state_information([STILL], [WHOLE], -np.eye(2)), "start"),
        (lambda: state_information([STILL], [EXACT]), "noise of a sensor is singular"),
        (lambda: steady_state(Motion(EYE, EYE), Sensor(EYE, 0 * EYE)), "the sensor is singular"),
        (lambda: fisher_information(EYE, np.full((4, 2, 2), np.nan)), "innovation_covs must be fi"),
        (
            lambda: Motion(np.ones((2, 1, 1)), np.ones((3, 1, 1))),
            r"\(2,\) of transition and \(3,\)",
        ),
        (lambda: steady_state(Motion(EYE[None], EYE), Sensor(EYE, EYE)), "need one system"),
        (lambda: scale_free_rank(-EYE), "matrix must be positive semi-definite"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
