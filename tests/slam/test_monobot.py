"""The monobot filter against filterpy, closed forms, SymPy and least squares over the whole run."""

from fractions import Fraction

import numpy as np
import pytest
import sympy
from filterpy.kalman import KalmanFilter
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from robot_perception.beliefs import Gaussian
from robot_perception.kalman import (
    Sensor,
    fisher_information,
    predict,
    scale_free_rank,
    start_information,
    steady_state,
    update,
)
from robot_perception.slam.monobot import (
    Reference,
    first_measurement,
    motion,
    relative_system,
    run_filter,
    run_filter_stepwise,
    run_referenced,
    sensor_matrix,
    settled,
)
from tests.unchecked import unchecked

PHI = (1 + np.sqrt(5)) / 2
FIELDS = ("means", "covs", "innovations", "innovation_covs", "gains")


def start(variance=1.0, mean=-1.0):
    return Gaussian(np.array([mean]), np.array([[variance]]))


def unit_run(n, steps, *, P0=1.0, V=1.0, W=1.0):
    """Return one run with constant noise; the data do not matter for its covariances."""
    z = np.zeros((1, steps + 1, n))
    return run_filter(start(P0), np.zeros(steps), z, motion_variance=V, measurement_variance=W)


@pytest.mark.parametrize("n", [1, 2, 10])
@pytest.mark.parametrize("per_run", [False, True])
def test_equal_to_filterpy(n, per_run):
    rng = np.random.default_rng(n)
    runs, steps = 4, 30
    z, commands = 2 + rng.normal(size=(runs, steps + 1, n)), rng.normal(size=steps)
    V = rng.uniform(0.1, 2, (runs, steps) if per_run else steps)
    W = rng.uniform(0.1, 2, (runs, steps + 1, n) if per_run else (steps + 1, n))
    ours = run_filter(start(), commands, z, motion_variance=V, measurement_variance=W)
    V, W = np.broadcast_to(V, (runs, steps)), np.broadcast_to(W, (runs, steps + 1, n))
    for run in range(runs):
        peer = KalmanFilter(dim_x=n + 1, dim_z=n, dim_u=1)
        peer.F, peer.H = np.eye(n + 1), sensor_matrix(n)
        peer.B = np.eye(n + 1)[:, :1]
        # filterpy has no first measurement: an almost flat prior on the landmarks is the same,
        # so the block matrix is written out here
        peer.x = np.concatenate([[-1.0], -1.0 + z[run, 0]])[:, None]
        peer.P = np.ones((n + 1, n + 1)) + np.diag(np.concatenate([[0.0], W[run, 0]]))
        for k in range(steps):
            peer.predict(u=commands[k], Q=np.diag([V[run, k]] + [0.0] * n))
            peer.update(z[run, k + 1][:, None], R=np.diag(W[run, k + 1]))
            covs = run if per_run else 0
            np.testing.assert_allclose(ours.means[run, k + 1], peer.x[:, 0], rtol=0, atol=1e-9)
            np.testing.assert_allclose(ours.covs[covs, k + 1], peer.P, rtol=0, atol=1e-9)
            np.testing.assert_allclose(ours.gains[covs, k], peer.K, rtol=0, atol=1e-9)
            np.testing.assert_allclose(ours.innovation_covs[covs, k], peer.S, rtol=0, atol=1e-9)
            np.testing.assert_allclose(ours.innovations[run, k], peer.y[:, 0], rtol=0, atol=1e-9)


variances = st.floats(1e-4, 1e4)


@given(
    st.integers(1, 6), st.integers(1, 12), variances, variances, variances, st.integers(0, 2**31)
)
@example(3, 4, 1.0, 1e4, 1e-4, 0)  # measurements that are far better than the motion between them
@settings(max_examples=40)
def test_compiled_equals_plain(n, steps, P0, V, W, seed):
    rng = np.random.default_rng(seed)
    z, commands = rng.normal(size=(3, steps + 1, n)), rng.normal(size=steps)
    own = {
        "motion_variance": V * rng.uniform(0.5, 2, (3, steps)),
        "measurement_variance": W * rng.uniform(0.5, 2, (3, steps + 1, n)),
    }
    for noise in ({"motion_variance": V, "measurement_variance": W}, own):
        fast = run_filter(start(P0), commands, z, **noise)
        plain = run_filter_stepwise(start(P0), commands, z, **noise)
        scale = 1 + np.abs(plain.means).max()
        tolerance = 1e-9 + 1e-14 * (P0 + V + W) / W  # rounding grows with the condition of S
        for name in FIELDS:
            a, b = getattr(fast, name), getattr(plain, name)
            assert a.shape == b.shape
            size = scale if name in {"means", "innovations"} else 1 + np.abs(b).max()
            np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * size, err_msg=name)


def test_first_measurement_carries_the_vehicle_error_into_every_landmark():
    belief = first_measurement(start(0.25), np.array([2.0, 5.0]), np.array([0.04, 0.09]))
    np.testing.assert_allclose(belief.mean, [-1.0, 1.0, 4.0])
    np.testing.assert_allclose(
        belief.cov, [[0.25, 0.25, 0.25], [0.25, 0.29, 0.25], [0.25, 0.25, 0.34]], rtol=1e-12
    )


def test_first_measurement_is_the_limit_of_a_flat_prior_on_the_landmark():
    flat = Gaussian(np.array([-1.0, 0.0]), np.diag([0.25, 1e10]))
    sensor = Sensor(sensor_matrix(1), np.array([[0.04]]))
    limit, _ = update(flat, np.array([2.0]), sensor)
    belief = first_measurement(start(0.25), np.array([2.0]), np.array([0.04]))
    np.testing.assert_allclose(limit.mean, belief.mean, atol=1e-6)
    np.testing.assert_allclose(limit.cov, belief.cov, atol=1e-6)


def test_landmark_gains_are_reciprocals_of_every_second_fibonacci_number():
    """P0 = V = W = 1, landmark from the first measurement, then predict before update."""
    gains = unit_run(1, 8).gains[0, :, 1, 0]
    np.testing.assert_allclose(1 / gains, [3, 8, 21, 55, 144, 377, 987, 2584], rtol=1e-12)


def test_landmark_gains_are_reciprocals_of_lucas_numbers_with_a_unit_prior_on_the_landmark():
    """The other convention: vehicle and landmark start with independent unit variance."""
    belief = Gaussian(np.zeros(2), np.eye(2))
    sensor = Sensor(sensor_matrix(1), np.eye(1))
    gains = []
    for _ in range(7):
        belief, info = update(predict(belief, motion(0.0, 1.0, 1)), np.zeros(1), sensor)
        gains.append(info.gain[1, 0])
    lucas = [2, 1]
    while len(lucas) < 16:
        lucas.append(lucas[-1] + lucas[-2])
    np.testing.assert_allclose(1 / np.array(gains), lucas[3:16:2], rtol=1e-12)


def test_relative_variance_of_one_landmark_in_exact_fractions():
    p = Fraction(1)  # posterior variance of the distance after the first measurement
    run = unit_run(1, 12)
    for k in range(12):
        p += 1
        assert run.innovation_covs[0, k, 0, 0] == pytest.approx(float(p + 1), rel=1e-13)
        p = p / (p + 1)


@pytest.mark.parametrize("n", [1, 2, 5, 20, 50])
@pytest.mark.parametrize(("P0", "V", "W"), [(1.0, 1.0, 1.0), (0.0, 0.5, 2.0), (4.0, 3.0, 0.1)])
def test_closed_forms_are_the_limit_of_the_recursion(n, P0, V, W):
    form = settled(n, start_variance=P0, motion_variance=V, measurement_variance=W)
    run = unit_run(n, 600, P0=P0, V=V, W=W)
    H, ones = sensor_matrix(n), np.ones(n) / np.sqrt(n)
    J = fisher_information(H, run.innovation_covs[0, -2:])
    assert np.diff(J, axis=0)[0, 0, 0] == pytest.approx(form.information_rate, rel=1e-9)
    S = run.innovation_covs[0, -1]
    assert ones @ S @ ones == pytest.approx(form.common_variance + W, rel=1e-9)
    # the covariance of any two landmarks: the error that all of them share
    common = ones @ run.covs[0, -1, 1:, 1:] @ ones / n
    assert common == pytest.approx(form.landmark_variance, rel=1e-9)
    assert run.covs[0, -1, 0, 0] == pytest.approx(form.vehicle_variance, rel=1e-9)
    if n > 1:
        assert run.covs[0, -1, 1, 2] == pytest.approx(form.landmark_variance, abs=W / 300)
    common_gain = ones @ run.gains[0, :, 1:] @ ones
    still = np.flatnonzero(common_gain > 1e-12)
    assert len(still) >= 2
    assert common_gain[still[-1]] / common_gain[still[-2]] == pytest.approx(form.pole, rel=1e-3)


def test_vehicle_variance_settles_at_its_closed_form():
    form = settled(1, start_variance=1, motion_variance=1, measurement_variance=1)
    assert form.vehicle_variance == pytest.approx(np.sqrt(5))
    assert form.landmark_variance == pytest.approx(PHI)
    assert form.information_rate == pytest.approx(PHI**-2)
    assert unit_run(1, 60).covs[0, -1, 0, 0] == pytest.approx(np.sqrt(5), rel=1e-12)


def test_information_rate_tends_to_the_plant_alone():
    rates = [
        settled(n, start_variance=1, motion_variance=0.5, measurement_variance=3).information_rate
        for n in (1, 10, 1_000, 1_000_000)
    ]
    assert np.all(np.diff(rates) > 0)
    assert rates[-1] == pytest.approx(1 / 0.5, rel=1e-4)
    assert rates[-1] < 1 / 0.5


@pytest.mark.parametrize("n", [1, 7])
def test_common_mode_of_the_landmarks_settles_where_scipy_says(n):
    """The mean distance is one state driven by V and seen n times; differences have no noise."""
    V, W = 0.3, 2.0
    peer = solve_discrete_are(np.eye(1), np.eye(1), np.array([[n * V]]), np.array([[W]]))
    state = steady_state(*relative_system(n, motion_variance=V, measurement_variance=W))
    ones = np.ones(n) / np.sqrt(n)
    assert ones @ state.predicted @ ones == pytest.approx(peer[0, 0], rel=1e-10)
    np.testing.assert_allclose(np.sort(np.abs(state.poles))[1:], 1.0, rtol=1e-9)
    form = settled(n, start_variance=1, motion_variance=V, measurement_variance=W)
    assert np.abs(state.poles).min() == pytest.approx(form.pole, rel=1e-9)
    assert form.common_variance == pytest.approx(peer[0, 0], rel=1e-10)


def test_the_full_state_has_no_unique_steady_state():
    with pytest.raises(ValueError, match="never seen"):
        steady_state(motion(0.0, 1.0, 3), Sensor(sensor_matrix(3), np.eye(3)))


@given(
    st.integers(1, 12), st.integers(1, 20), variances, variances, variances, st.integers(0, 2**31)
)
@settings(max_examples=40)
def test_information_has_rank_n_and_is_blind_to_a_shift_of_the_world(n, steps, P0, V, W, seed):
    rng = np.random.default_rng(seed)
    run = run_filter(
        start(P0),
        np.zeros(steps),
        np.zeros((1, steps + 1, n)),
        motion_variance=V * rng.uniform(0.5, 2, steps),
        measurement_variance=W * rng.uniform(0.5, 2, (steps + 1, n)),
    )
    J = fisher_information(sensor_matrix(n), run.innovation_covs[0])
    np.testing.assert_allclose(J.sum(axis=-1), 0, atol=1e-9 * np.abs(J).max())
    np.testing.assert_array_equal(scale_free_rank(J), n)
    small = 1e-12 * np.abs(J).max()  # the entry may be tiny beside those it is the sum of
    np.testing.assert_allclose(J[:, 0, 0], J[:, 1:, 1:].sum(axis=(1, 2)), rtol=1e-8, atol=small)
    assert np.all(np.diff(J[:, 0, 0]) > 0)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_information_is_singular_symbolically(n):
    """SymPy, for any inverse innovation covariance: rank n and the kernel (1, …, 1)."""
    weights = sympy.Matrix(n, n, lambda i, j: sympy.Symbol(f"s{min(i, j)}{max(i, j)}"))
    H = sympy.Matrix(sensor_matrix(n).astype(int).tolist())
    J = (H.T * weights * H).applyfunc(sympy.expand)
    assert list(J * sympy.ones(n + 1, 1)) == [0] * (n + 1)
    others = sum((J[i, :] for i in range(1, n + 1)), sympy.zeros(1, n + 1))
    assert (J[0, :] + others).applyfunc(sympy.expand) == sympy.zeros(1, n + 1)
    # striking out the vehicle leaves the regular matrix itself, so the rank is n, not less
    assert J[1:, 1:] == weights.applyfunc(sympy.expand)


def test_one_landmark_sum_is_the_general_sum():
    steps, rng = 25, np.random.default_rng(2)
    V, W = rng.uniform(0.1, 2, steps), rng.uniform(0.1, 2, (steps + 1, 1))
    z = np.zeros((1, steps + 1, 1))
    run = run_filter(start(0.6), np.zeros(steps), z, motion_variance=V, measurement_variance=W)
    before = run.covs[0, :-1].copy()
    before[:, 0, 0] += V
    deviations = np.sqrt(np.diagonal(before, axis1=1, axis2=2))
    correlation = before[:, 0, 1] / deviations.prod(axis=1)
    r, f = deviations.T
    s = r**2 - 2 * correlation * r * f + f**2 + W[1:, 0]  # eq. (17)
    terms = np.array([[1.0, -1.0], [-1.0, 1.0]]) / s[:, None, None]
    general = fisher_information(sensor_matrix(1), run.innovation_covs[0])
    np.testing.assert_allclose(np.cumsum(terms, axis=0), general, rtol=1e-11)


def test_information_on_the_start_stays_bounded_while_the_sum_of_innovations_grows():
    steps, sensor = 60, Sensor(sensor_matrix(1), np.eye(1))
    about_start = start_information([motion(0.0, 1.0, 1)] * steps, [sensor] * steps)
    assert about_start[-1, 0, 0] == pytest.approx(1 / PHI, rel=1e-12)
    total = fisher_information(sensor_matrix(1), unit_run(1, steps).innovation_covs[0])
    assert total[-1, 0, 0] > 20
    # with the first measurement's own 1/W it explains what the filter ends with: W falls to 1/phi
    assert 1 / (1 + about_start[-1, 0, 0]) == pytest.approx(1 / PHI)


@given(st.integers(1, 5), st.floats(-1e3, 1e3), st.integers(0, 2**31))
@settings(max_examples=30)
def test_a_shift_of_the_origin_shifts_the_map_and_changes_nothing_else(n, shift, seed):
    rng = np.random.default_rng(seed)
    z, commands = rng.normal(size=(2, 9, n)), rng.normal(size=8)
    noise = {"motion_variance": 0.3, "measurement_variance": 0.2}
    here = run_filter(start(0.5, 0.0), commands, z, **noise)
    there = run_filter(start(0.5, shift), commands, z, **noise)
    np.testing.assert_allclose(there.means - here.means, shift, atol=1e-9 * (1 + abs(shift)))
    np.testing.assert_array_equal(there.covs, here.covs)
    np.testing.assert_allclose(there.innovations, here.innovations, atol=1e-9 * (1 + abs(shift)))


@given(st.integers(2, 6), st.integers(0, 2**31))
@settings(max_examples=20)
def test_landmarks_may_be_numbered_in_any_order(n, seed):
    rng = np.random.default_rng(seed)
    z, commands = rng.normal(size=(2, 9, n)), rng.normal(size=8)
    W, order = rng.uniform(0.1, 1, (9, n)), rng.permutation(n)
    state_order = np.concatenate([[0], 1 + order])
    a = run_filter(start(), commands, z, motion_variance=0.3, measurement_variance=W)
    b = run_filter(
        start(),
        commands,
        z[..., order],
        motion_variance=0.3,
        measurement_variance=W[:, order],
    )
    np.testing.assert_allclose(b.means, a.means[..., state_order], atol=1e-10)
    np.testing.assert_allclose(b.covs, a.covs[..., state_order, :][..., state_order], atol=1e-10)


def test_initial_vehicle_variance_changes_no_innovation():
    """With landmarks from the first measurement the information does not depend on P0 at all."""
    small, large = unit_run(3, 20, P0=0.0), unit_run(3, 20, P0=100.0)
    np.testing.assert_allclose(small.innovation_covs, large.innovation_covs, rtol=1e-11)
    np.testing.assert_allclose(large.covs - small.covs, 100.0, rtol=1e-11)


def test_runs_with_shared_noise_share_their_covariances():
    rng = np.random.default_rng(0)
    z, commands = rng.normal(size=(5, 7, 2)), rng.normal(size=6)
    shared = run_filter(start(), commands, z, motion_variance=1.0, measurement_variance=1.0)
    own = run_filter(
        start(), commands, z, motion_variance=np.ones((5, 6)), measurement_variance=1.0
    )
    assert shared.covs.shape[0] == 1
    assert own.covs.shape[0] == 5
    np.testing.assert_allclose(own.means, shared.means, atol=1e-12)
    assert own.deviations.shape == (5, 7, 3)


def test_a_start_of_its_own_for_each_run():
    rng = np.random.default_rng(0)
    z, commands = rng.normal(size=(3, 7, 2)), rng.normal(size=6)
    many = Gaussian(np.array([[-1.0], [0.0], [2.0]]), np.array([0.1, 0.2, 0.3])[:, None, None])
    batch = run_filter(many, commands, z, motion_variance=1.0, measurement_variance=1.0)
    plain = run_filter_stepwise(many, commands, z, motion_variance=1.0, measurement_variance=1.0)
    np.testing.assert_allclose(batch.means, plain.means, atol=1e-12)
    for run in range(3):
        one = Gaussian(many.mean[run], many.cov[run])
        alone = run_filter(
            one,
            commands,
            z[run : run + 1],
            motion_variance=1.0,
            measurement_variance=1.0,
        )
        np.testing.assert_allclose(batch.means[run], alone.means[0], atol=1e-12)
        np.testing.assert_allclose(batch.covs[run], alone.covs[0], atol=1e-12)


# An anchor, or a sensor that watches the vehicle


def referenced_data(n, steps, seed, runs=1):
    rng = np.random.default_rng(seed)
    return {
        "measurements": 2 + rng.normal(size=(runs, steps + 1, n)),
        "commands": rng.normal(size=steps),
        "values": rng.normal(size=(runs, steps)),
        "V": rng.uniform(0.2, 2, steps),
        "W": rng.uniform(0.2, 2, (steps + 1, n)),
        "R": rng.uniform(0.2, 2, steps),
    }


def plain(data):
    noise = {"motion_variance": data["V"], "measurement_variance": data["W"]}
    return run_filter(start(0.7), data["commands"], data["measurements"], **noise)


def referenced(data, sign, position=0.0, P0=0.7, **changes):
    data = data | changes
    reference = Reference(sign, data["values"], data["R"], position)
    noise = {"motion_variance": data["V"], "measurement_variance": data["W"]}
    return run_referenced(start(P0), data["commands"], data["measurements"], reference, **noise)


@pytest.mark.parametrize("sign", [0, -1, 1])
def test_last_estimate_is_weighted_least_squares_over_the_whole_run(sign):
    """Oracle without any recursion: all positions and landmarks at once, from all measurements.

    Of the plain filter, and of those with an anchor and an external sensor.
    """
    n, steps, position = 2, 7, 0.4
    data = referenced_data(n, steps, 12)
    run = referenced(data, sign, position) if sign else plain(data)
    eye = np.eye(steps + 1 + n)
    rows, values, weights = [eye[0]], [-1.0], [1 / 0.7]
    for k in range(steps):
        rows += [eye[k + 1] - eye[k], sign * eye[k + 1]]  # a row of zeros without a reference
        values += [data["commands"][k], abs(sign) * data["values"][0, k] + sign * position]
        weights += [1 / data["V"][k], 1 / data["R"][k]]
    for k in range(steps + 1):
        for i in range(n):
            rows.append(eye[steps + 1 + i] - eye[k])
            values.append(data["measurements"][0, k, i])
            weights.append(1 / data["W"][k, i])
    A, weight = np.array(rows), np.array(weights)
    cov = np.linalg.inv(A.T @ (weight[:, None] * A))
    best = cov @ (A.T @ (weight * np.array(values)))
    kept = [steps, *range(steps + 1, steps + 1 + n)]
    np.testing.assert_allclose(run.means[0, -1], best[kept], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.covs[0, -1], cov[np.ix_(kept, kept)], rtol=0, atol=1e-9)


def test_a_reference_without_weight_changes_nothing():
    data = referenced_data(3, 9, 3, runs=2)
    tied, untied = referenced(data, 1, R=1e14), plain(data)
    np.testing.assert_allclose(tied.means, untied.means, atol=1e-9)
    np.testing.assert_allclose(tied.covs, untied.covs, atol=1e-9)
    np.testing.assert_allclose(tied.innovations[..., 1:], untied.innovations, atol=1e-9)


def test_a_reference_may_have_a_noise_of_its_own_in_each_run():
    data = referenced_data(2, 6, 4, runs=3)
    data["R"] = np.random.default_rng(5).uniform(0.2, 2, (3, 6))
    together = referenced(data, -1)
    for run in range(3):
        own = {name: data[name][run : run + 1] for name in ("values", "measurements", "R")}
        alone = referenced(data, -1, **own)
        np.testing.assert_allclose(together.means[run], alone.means[0], rtol=1e-12)
        np.testing.assert_allclose(together.covs[run], alone.covs[0], rtol=1e-12)


def test_deviations_are_the_roots_of_the_variances():
    run = referenced(referenced_data(2, 6, 4), -1)
    variances = np.moveaxis([run.covs[..., i, i] for i in range(3)], 0, -1)
    np.testing.assert_allclose(run.deviations**2, variances, rtol=1e-14)


def test_a_motion_moves_the_vehicle_and_makes_it_uncertain_by_its_variance():
    made = motion(0.3, 0.25, 2)
    np.testing.assert_array_equal(made.noise, np.diag([0.25, 0, 0]))
    np.testing.assert_array_equal(made.transition, np.eye(3))
    np.testing.assert_array_equal(made.shift, [0.3, 0, 0])


@given(st.integers(1, 5), st.integers(1, 10), st.floats(-1e3, 1e3), st.integers(0, 2**31))
@settings(max_examples=25)
def test_anchor_and_external_sensor_of_equal_noise_are_one_system(n, steps, position, seed):
    data = referenced_data(n, steps, seed, runs=2)
    anchor = referenced(data, -1, position)
    watcher = referenced(data, 1, position, values=-data["values"])
    scale = 1 + abs(position)
    np.testing.assert_allclose(watcher.means, anchor.means, atol=1e-10 * scale)
    np.testing.assert_array_equal(watcher.covs, anchor.covs)
    flip = np.append(-1.0, np.ones(n))
    S = anchor.innovation_covs * flip[:, None] * flip
    np.testing.assert_allclose(watcher.innovation_covs, S, rtol=1e-14)
    np.testing.assert_allclose(watcher.gains, anchor.gains * flip, atol=1e-14)


@given(st.integers(1, 5), st.integers(1, 10), st.integers(0, 2**31))
@settings(max_examples=25)
def test_anchored_map_is_the_relative_map_of_the_filter_without_anchor(n, steps, seed):
    """Started by measuring the anchor, the filter knows what the plain one knows of it."""
    data = referenced_data(n, steps, seed, runs=2)
    rng = np.random.default_rng(seed)
    first, W0 = rng.normal(size=(2, 1)), 0.4
    anchored = run_referenced(
        Gaussian(-first, np.array([[W0]])),
        data["commands"],
        data["measurements"],
        Reference(-1, data["values"], data["R"]),
        motion_variance=data["V"],
        measurement_variance=data["W"],
    )
    posts = np.concatenate([first, data["values"]], axis=1)[..., None]
    noise = np.append(W0, data["R"])[:, None]
    plain = run_filter(
        start(3.0),
        data["commands"],
        np.concatenate([posts, data["measurements"]], axis=2),
        motion_variance=data["V"],
        measurement_variance=np.concatenate([noise, data["W"]], axis=1),
    )
    relative = np.insert(np.eye(n + 2)[[0, *range(2, n + 2)]], 0, 0.0, axis=0)[1:]
    relative[:, 1] = -1.0  # vehicle and landmarks, counted from the anchor
    np.testing.assert_allclose(plain.means @ relative.T, anchored.means, atol=1e-9)
    np.testing.assert_allclose(relative @ plain.covs @ relative.T, anchored.covs, atol=1e-9)


@given(st.integers(1, 8), st.integers(1, 12), st.integers(0, 2**31))
@settings(max_examples=25)
def test_a_reference_gives_every_term_of_the_information_full_rank(n, steps, seed):
    data = referenced_data(n, steps, seed)
    run = referenced(data, -1)
    H = Reference(-1, data["values"], data["R"]).matrix(n)
    for S in run.innovation_covs[0]:
        J = fisher_information(H, S[None])[-1]
        assert scale_free_rank(J) == n + 1
        assert np.linalg.det(J) == pytest.approx(1 / np.linalg.det(S), rel=1e-8)
        row = np.linalg.inv(S).sum(axis=0)  # sums over all measurements, the anchor's included
        np.testing.assert_allclose(J[0], np.append(row.sum(), -row[1:]), atol=1e-9 * J.max())


MEASUREMENTS, COMMANDS = np.zeros((2, 4, 3)), np.zeros(3)
NEGATIVE = np.array([0.1, -0.2, 0.1])


def run(**changes):
    arguments = {
        "start": start(),
        "commands": COMMANDS,
        "measurements": MEASUREMENTS,
        "motion_variance": 1.0,
        "measurement_variance": 1.0,
    }
    return run_filter(**(arguments | changes))


def watched(values, variance, **changes):
    noise = {"motion_variance": 1.0, "measurement_variance": 1.0} | changes
    return run_referenced(start(), COMMANDS, MEASUREMENTS, Reference(1, values, variance), **noise)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: sensor_matrix(0), "at least 1 landmark, got 0"),
        (lambda: Reference(0, np.zeros((1, 3)), 1.0), "sign must be -1 .* got 0"),
        (lambda: Reference(1, np.zeros(3), 1.0), r"values must be \(runs, steps\), got \(3,\)"),
        (lambda: Reference(1, np.full((1, 3), np.inf), 1.0), "values must be finite, got 3 of 3"),
        (lambda: Reference(1, np.zeros((1, 3)), -0.5), "variance must not be negative, got -0.5"),
        (lambda: Reference(1, np.zeros((1, 3)), 1.0, np.nan), "position must be finite"),
        (lambda: watched(np.zeros((2, 4)), 1.0), r"values \(2, 3\), got \(2, 4\)"),
        (lambda: watched(np.zeros((2, 3)), np.ones(4)), r"reference must broadcast to \(3,\)"),
        (lambda: watched(np.zeros((2, 3)), 0.0, measurement_variance=0.0), "singular"),
        (lambda: sensor_matrix(-2), "at least 1 landmark, got -2"),
        (lambda: motion(0.0, -1.0, 1), "motion_variance must not be negative, got -1"),
        (lambda: motion(np.nan, 1.0, 1), "command must be finite"),
        (lambda: run(measurements=np.zeros((2, 4, 0))), "at least 1 landmark, got 0"),
        (lambda: run(measurements=np.zeros((0, 4, 3))), "at least 1 run"),
        (lambda: run(measurements=np.zeros((2, 1, 3)), commands=np.zeros(0)), "2 measurements"),
        (
            lambda: run(measurements=np.zeros((4, 3))),
            r"measurements must be \(runs, steps \+ 1, n\), got \(4, 3\)",
        ),
        (
            lambda: run(measurements=np.full((2, 4, 3), np.nan)),
            "measurements must be finite, got 24 of 24",
        ),
        (
            lambda: run(commands=np.zeros(4)),
            r"commands must be \(3,\) for measurements \(2, 4, 3\)",
        ),
        (lambda: run(commands=np.array([0, np.inf, 0])), "commands must be finite"),
        (lambda: run(motion_variance=-0.5), "motion_variance must not be negative, got -0.5"),
        (lambda: run(motion_variance=NEGATIVE), "motion_variance must not be negative, got -0.2"),
        (lambda: run(motion_variance=np.nan), "motion_variance must be finite"),
        (lambda: run(motion_variance=np.ones(4)), r"motion_variance must broadcast to \(3,\)"),
        (lambda: run(motion_variance=np.ones((3, 3))), r"motion_variance must broadcast"),
        (lambda: run(measurement_variance=-1.0), "measurement_variance must not be negative"),
        (
            lambda: run(measurement_variance=np.ones((3, 3))),
            r"measurement_variance must broadcast to \(4, 3\)",
        ),
        (lambda: run(measurement_variance=0.0), "singular"),
        (lambda: run(start=Gaussian(np.zeros(2), np.eye(2))), "belief in 1 state, got 2"),
        (lambda: run(start=Gaussian(np.zeros((3, 1)), np.eye(1))), "one belief or 2"),
        (lambda: start(-1.0), "cov must be positive semi-definite"),
        (lambda: start(np.nan), "cov must be finite"),
        (lambda: first_measurement(start(), np.zeros(0), np.zeros(0)), "at least 1 landmark"),
        (
            lambda: first_measurement(start(), np.array([np.nan]), np.ones(1)),
            "measurement must be finite",
        ),
        (lambda: first_measurement(start(), np.zeros(2), NEGATIVE[:2]), "must not be negative"),
        (
            lambda: first_measurement(Gaussian(np.zeros(2), np.eye(2)), np.zeros(2), np.ones(2)),
            "belief in 1 state",
        ),
        (
            lambda: settled(1, start_variance=1, motion_variance=0, measurement_variance=1),
            "motion_variance must be positive and finite, got 0",
        ),
        (
            lambda: settled(0, start_variance=1, motion_variance=1, measurement_variance=1),
            "at least 1 landmark",
        ),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
