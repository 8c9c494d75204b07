"""Every model against finite differences and complex numbers; its bad input."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.integrate import solve_ivp

from robot_perception.geometry import between, compose, wrap_angle
from robot_perception.slam.planar import (
    CartesianSensor,
    Compass,
    MapBelief,
    Odometry,
    PositionFix,
    RangeBearing,
    Settings,
    Velocity,
    compound,
    dead_reckoning,
    predict,
)
from robot_perception.streams import Held
from tests.slam.planar.drives import Q, R, wrapped
from tests.unchecked import unchecked

SENSORS = [CartesianSensor(R), RangeBearing(R), RangeBearing(R, range_bias=0.07)]
poses = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3.14, 3.14)).map(np.array)
offsets = st.tuples(st.floats(0.3, 30), st.floats(-3.1, 3.1))


def derivative(f, x, step=1e-6):
    """Return central differences of f, outputs first."""
    columns = []
    for i in range(x.size):
        e = step * np.eye(x.size)[i]
        columns.append((f(x + e) - f(x - e)) / (2 * step))
    return np.stack(columns, axis=-1)


@given(poses, arrays(float, 3, elements=st.floats(-2, 2)))
def test_odometry_moves_and_its_jacobians(pose, increment):
    motion = Odometry(increment, Q)
    moved = motion.move(pose)
    place = complex(*pose[:2]) + np.exp(1j * pose[2]) * complex(*increment[:2])
    np.testing.assert_allclose(moved[:2], [place.real, place.imag], atol=1e-12)
    assert abs(wrapped(moved[2] - pose[2] - increment[2])) < 1e-12
    assert -np.pi <= moved[2] < np.pi

    def unwrapped(p, d):  # the wrapped heading jumps
        z = complex(*p[:2]) + np.exp(1j * p[2]) * complex(*d[:2])
        return np.array([z.real, z.imag, p[2] + d[2]])

    F, G = motion.jacobians(pose)
    np.testing.assert_allclose(F, derivative(lambda p: unwrapped(p, increment), pose), atol=1e-7)
    np.testing.assert_allclose(G, derivative(lambda d: unwrapped(pose, d), increment), atol=1e-7)


@given(
    poses,
    st.floats(-2, 2),
    st.one_of(st.floats(-2, 2), st.floats(-1e-2, 1e-2)),
    st.floats(0.01, 2),
)
def test_velocity_moves_as_the_differential_equation(pose, speed, rate, duration):
    def flow(v, w, p=pose):
        return solve_ivp(
            lambda _, x: [v * np.cos(x[2]), v * np.sin(x[2]), w],
            (0, duration), p, rtol=1e-12, atol=1e-12, method="DOP853",
        ).y[:, -1]  # fmt: skip

    motion = Velocity(speed, rate, duration, np.array([[0.1, 0.05], [0.05, 0.2]]))
    difference = motion.move(pose) - flow(speed, rate)
    np.testing.assert_allclose(difference[:2], 0, atol=1e-9)
    assert abs(wrapped(difference[2])) < 1e-9
    F, G = motion.jacobians(pose)
    np.testing.assert_allclose(
        G, derivative(lambda u: flow(*u), np.array([speed, rate]), 1e-4), atol=1e-6
    )
    np.testing.assert_allclose(F, derivative(lambda p: flow(speed, rate, p), pose, 1e-4), atol=1e-6)
    # the increment it hands to the filter carries the same noise
    turned = np.eye(3)
    turned[:2, :2] = [[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]]
    np.testing.assert_allclose(
        turned @ motion.increment_cov @ turned.T, G @ motion.noise @ G.T, atol=1e-12
    )


@given(st.floats(-8, 0.5), st.sampled_from([-1.0, 1.0]))
def test_arcs_are_exact_for_turns_of_every_size(decade, sign):
    """Oracle: the quotients in 60 digits."""
    turn = sign * 10**decade
    with mpmath.workdps(60):
        a = mpmath.mpf(turn)
        along, across = mpmath.sin(a) / a, (1 - mpmath.cos(a)) / a
        slopes = (mpmath.cos(a) - along) / a, (mpmath.sin(a) - across) / a
    motion = Velocity(2.0, turn, 1.0, np.eye(2))
    np.testing.assert_allclose(
        motion.increment,
        np.array([2.0 * along, 2.0 * across, turn], dtype=float),
        rtol=0,
        atol=1e-10,
    )
    _, G = motion.jacobians(np.zeros(3))
    wanted = np.array([[along, 2.0 * slopes[0]], [across, 2.0 * slopes[1]], [0, 1]], dtype=float)
    np.testing.assert_allclose(G, wanted, rtol=0, atol=1e-9)


@pytest.mark.parametrize("rate", [1e-3, -1e-3])
def test_arc_series_meets_the_quotients(rate):
    before, after = (
        Velocity(2.0, r, 1.0, np.eye(2)) for r in (rate * (1 - 1e-9), rate * (1 + 1e-9))
    )
    np.testing.assert_allclose(before.increment, after.increment, rtol=0, atol=1e-11)
    np.testing.assert_allclose(before.increment_cov, after.increment_cov, rtol=0, atol=1e-8)


@pytest.mark.parametrize("sensor", SENSORS, ids=["cartesian", "polar", "biased"])
@given(pose=poses, offset=offsets)
def test_sensor_and_its_jacobians(sensor, pose, offset):
    reach, bearing = offset
    away = complex(*pose[:2]) + reach * np.exp(1j * (pose[2] + bearing))
    point = np.array([[away.real, away.imag]])
    expected, by_pose, by_point = sensor.expect(pose, point)
    if isinstance(sensor, CartesianSensor):
        by_hand = [reach * np.cos(bearing), reach * np.sin(bearing)]
    else:
        by_hand = [reach + sensor.range_bias, bearing]
    np.testing.assert_allclose(expected[0], by_hand, atol=1e-9)
    # differences of expected values run through the residual, so that bearings do not jump

    def seen(p, q):
        return sensor.residual(sensor.expect(p, q[None])[0], expected)[0]

    near, point = 1e-6 * (1 + 30 / reach), point[0]
    np.testing.assert_allclose(by_pose[0], derivative(lambda p: seen(p, point), pose), atol=near)
    np.testing.assert_allclose(by_point[0], derivative(lambda q: seen(pose, q), point), atol=near)


@pytest.mark.parametrize("sensor", SENSORS, ids=["cartesian", "polar", "biased"])
@given(pose=poses, offset=offsets)
def test_location_is_the_inverse_of_looking(sensor, pose, offset):
    reach, bearing = offset
    away = complex(*pose[:2]) + reach * np.exp(1j * (pose[2] + bearing))
    point = np.array([[away.real, away.imag]])
    values, _, _ = sensor.expect(pose, point)
    found = sensor.locate(pose, values)
    np.testing.assert_allclose(found, point, atol=1e-9)
    by_pose, by_value = sensor.locate_jacobians(pose, found, values)
    np.testing.assert_allclose(
        by_pose[0], derivative(lambda p: sensor.locate(p, values)[0], pose), atol=1e-6
    )
    np.testing.assert_allclose(
        by_value[0],
        derivative(lambda z: sensor.locate(pose, z[None])[0], values[0]),
        atol=1e-6,
    )


@given(poses)
def test_an_anchor_at_the_origin_has_the_jacobian_of_eq_25(pose):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    rotation, slope = np.array([[c, -s], [s, c]]), np.array([[-s, -c], [c, -s]])  # R and its dR/dφ
    h, by_pose, _ = CartesianSensor(R).expect(pose, np.zeros((1, 2)))
    np.testing.assert_allclose(h[0], -rotation.T @ pose[:2], atol=1e-12)  # eq. (24)
    printed = np.column_stack([-rotation.T, -slope.T @ pose[:2]])  # eq. (25)
    np.testing.assert_allclose(by_pose[0], printed, atol=1e-12)


@given(poses, st.floats(-20, 20))
def test_fixes(pose, value):
    compass = Compass(value, 0.1)
    assert abs(compass.residual(pose)[0]) <= np.pi
    assert abs(np.exp(1j * (pose[2] + compass.residual(pose)[0])) - np.exp(1j * value)) < 1e-9
    fix = PositionFix(np.array([value, 1.0]), np.eye(2))
    np.testing.assert_allclose(fix.residual(pose), [value - pose[0], 1 - pose[1]])
    for sensor in (compass, fix):
        expected = derivative(lambda p, s=sensor: -s.residual(p), pose)
        np.testing.assert_allclose(sensor.matrix(), expected, atol=1e-6)


def test_bearing_residuals_are_wrapped():
    sensor = RangeBearing(R)
    values, expected = np.array([[1.0, 3.1], [1.0, -3.1]]), np.array([[1.0, -3.1], [1.0, 3.1]])
    short = 2 * np.pi - 6.2
    np.testing.assert_allclose(sensor.residual(values, expected)[:, 1], [-short, short])


@given(st.integers(0, 2**31))
@settings(max_examples=40)
def test_joined_arcs_are_what_the_filter_makes_of_them_one_by_one(seed):
    """Law: one motion of many pieces gives the belief that its pieces give one after the other."""
    rng = np.random.default_rng(seed)
    pieces = int(rng.integers(1, 9))
    held = Held(
        np.stack([rng.normal(0.2, 0.2, pieces), rng.choice([0, 1e-5, 0.5, -1.3], pieces)], axis=1),
        rng.uniform(0.01, 1.5, pieces),
        np.cumsum(np.append(0, rng.integers(0, 2, pieces - 1))),
    )
    density = np.array([2e-3, 1e-3])
    root = rng.normal(size=(3, 3))
    one = many = MapBelief.start(rng.normal(size=3), 0.01 * root @ root.T)
    for increment, cov in zip(*compound(held, density), strict=True):
        one = predict(one, Odometry(increment, cov))
    for (speed, rate), duration in zip(held.commands, held.durations, strict=True):
        noise = np.diag(density) / duration
        many = predict(many, Velocity(float(speed), float(rate), float(duration), noise))
    np.testing.assert_allclose(one.mean[:2], many.mean[:2], atol=1e-9)
    assert wrap_angle(one.mean[2] - many.mean[2]) == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(one.cov, many.cov, rtol=1e-7, atol=1e-12)


def test_a_landmark_stands_where_its_name_says():
    root = np.random.default_rng(3).normal(size=(9, 9))
    belief = MapBelief(np.arange(9.0), root @ root.T, np.array([70, 0, 4]))
    for row, name in enumerate((70, 0, 4)):
        places = [3 + 2 * row, 4 + 2 * row]
        np.testing.assert_array_equal(belief.landmark(name).mean, places)
        np.testing.assert_array_equal(belief.landmark(name).cov, belief.cov[np.ix_(places, places)])
        np.testing.assert_array_equal(belief.landmark_covs[row], belief.landmark(name).cov)


ONE_ARC = Held(np.ones((1, 2)), np.ones(1), np.zeros(1, dtype=int))
NAN, TILTED = np.nan, np.array([[1.0, 0.5], [0.0, 1.0]])
BAD = [
    (lambda: Odometry(np.array([NAN, 0, 0]), Q), "increment must be finite"),
    (lambda: Odometry(np.zeros(2), Q), r"increment must be \(3,\)"),
    (lambda: Odometry(np.zeros(3), -Q), "noise must be finite, symmetric, positive"),
    (lambda: Odometry(np.zeros(3), Q[:2, :2]), r"noise must be \(3, 3\)"),
    (lambda: Odometry(np.zeros(3), np.inf * np.ones((3, 3))), "noise must be finite"),
    (lambda: Velocity(np.inf, 0.0, 1.0, R), "speed must be finite, got inf"),
    (lambda: Velocity(1.0, 0.0, -0.1, R), "duration must not be negative, got -0.1"),
    (lambda: Velocity(1.0, 0.0, 1.0, TILTED), "noise must be finite, symmetric"),
    (lambda: CartesianSensor(np.array([[1.0, 2.0], [2.0, 1.0]])), "positive semi-definite"),
    (lambda: RangeBearing(R, range_bias=NAN), "range_bias must be finite"),
    (lambda: RangeBearing(R).expect(np.zeros(3), np.zeros((1, 2))), "exactly at the robot"),
    (lambda: RangeBearing(R).check(np.array([[-0.5, 0.0]])), "not be negative, got -0.5"),
    (lambda: RangeBearing(R, 0.5).check(np.array([[0.2, 0.0]])), "exceed the bias, 0.5 m, got 0.2"),
    (lambda: RangeBearing(R, -0.5).check(np.array([[-0.1, 0.0]])), "not be negative, got -0.1"),
    (lambda: dead_reckoning(np.zeros(2), []), r"start must be \(3,\)"),
    (lambda: compound(ONE_ARC, np.array([-1.0, 0])), "density must not be negative, got"),
    (lambda: compound(Held(np.ones((1, 3)), np.ones(1), np.zeros(1, int)), np.ones(2)), "commands"),
    (lambda: PositionFix(np.array([NAN, 0.0]), R), "value must be finite"),
    (lambda: Compass(0.0, -1.0), "variance must not be negative, got -1.0"),
    (lambda: Compass(NAN, 1.0), "must be finite"),
    (lambda: MapBelief(np.zeros(4), np.eye(4), np.array([1])), "mean must be"),
    (lambda: MapBelief(np.zeros(5), np.eye(3), np.array([1])), r"cov must be \(5, 5\)"),
    (lambda: MapBelief(np.zeros(7), np.eye(7), np.array([1, 1])), "ids must differ"),
    (lambda: MapBelief(np.zeros(5), np.eye(5), np.array([-3])), "negative, got -3"),
    (lambda: MapBelief(np.zeros(5), np.eye(5), [1.9]), r"ids must be integers, got \[1.9\]"),
    (lambda: MapBelief(np.zeros(5), np.eye(5), [True]), r"ids must be integers, got \[True\]"),
    (lambda: MapBelief.start(np.zeros(3), np.triu(np.ones((3, 3)))), "cov must be symmetric"),
    (lambda: MapBelief.start(np.array([0, NAN, 0]), np.eye(3)), "pose must be finite"),
    (lambda: MapBelief.start(np.zeros(3), np.eye(3)).slot(7), "landmark_id must be .*, got 7"),
    (lambda: Settings(CartesianSensor(R), {-1: np.zeros(2)}), "at least 0 as identifier, got -1"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(make, message):
    with unchecked(), pytest.raises((TypeError, ValueError), match=message):
        make()


@given(st.integers(0, 10**6), st.integers(1, 4))
def test_the_compiled_covariance_check_agrees_with_eigenvalues(seed, d):
    from robot_perception.slam.planar.kernels import is_covariance

    rng = np.random.default_rng(seed)
    root = rng.standard_normal((d, d))
    lowest = rng.choice([rng.uniform(-1, 1), -3e-9, -0.3e-9])
    vectors = np.linalg.qr(root)[0]
    values = np.concatenate([[lowest], rng.uniform(1, 2, d - 1)])
    block = vectors @ np.diag(values) @ vectors.T
    block = (block + block.T) / 2
    holds = lowest >= -1e-9 * np.abs(block).max()
    assert is_covariance(block[None] * 10 ** rng.uniform(-8, 8), 1e-9) == holds
    whole = root @ root.T * 10 ** rng.uniform(-8, 8)
    assert is_covariance(whole[None], 1e-9)
    assert is_covariance(np.zeros((1, d, d)), 1e-9)
    if d > 1:  # symmetric to a share of the largest entry, wherever that stands
        whole[*rng.permutation(d)[:2]] += rng.choice([-1.0, 1.0]) * 0.5e-9 * np.abs(whole).max()
        assert is_covariance(np.stack([np.eye(d), whole]), 1e-9)
        whole[*rng.permutation(d)[:2]] += rng.choice([-1.0, 1.0]) * 2e-9 * np.abs(whole).max()
        assert not is_covariance(np.stack([np.eye(d), whole]), 1e-9)


@pytest.mark.parametrize("place", range(3))
def test_one_bad_landmark_of_many_is_found(place):
    points, values = np.ones((3, 2)), np.ones((3, 2))
    points[place], values[place, 0] = 0.0, 0.2
    with pytest.raises(ValueError, match="exactly at the robot"):
        RangeBearing(R).expect(np.zeros(3), points)
    with pytest.raises(ValueError, match=r"got 0\.2"):
        RangeBearing(R, 0.5).check(values)


def test_inputs_are_copied():
    cov = np.eye(3)
    belief = MapBelief.start(np.zeros(3), cov)
    cov[0, 0] = 9.0
    assert belief.pose_cov[0, 0] == 1.0


@given(st.integers(0, 10**6))
def test_dead_reckoning_composes_the_motions(seed):
    rng = np.random.default_rng(seed)
    start, increments = rng.standard_normal(3), rng.standard_normal((6, 3))
    motions = [Odometry(increment, Q) for increment in increments]
    poses = dead_reckoning(start, iter([*motions[:3], None, *motions[3:]]))
    expected = [start]
    for increment in [*increments[:3], np.zeros(3), *increments[3:]]:
        expected.append(compose(expected[-1], increment))
    np.testing.assert_allclose(between(np.array(expected), poses), 0, atol=1e-12)
    np.testing.assert_array_equal(dead_reckoning(start, []), [start])
