"""The structured filter against whole matrices, the linear filter and filterpy."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.slam.planar import (
    CartesianSensor,
    Compass,
    MapBelief,
    Observations,
    Odometry,
    PositionFix,
    RangeBearing,
    Velocity,
    add_landmarks,
    correct,
    predict,
    textbook,
    update,
)
from robot_perception.slam.planar.workspace import Workspace
from tests.slam.planar.drives import Q, R, assert_close, belief_of
from tests.unchecked import unchecked

TILTED = np.array([[0.04, 0.01], [0.01, 0.02]])
SENSORS = [CartesianSensor(TILTED), RangeBearing(TILTED, range_bias=0.05)]
seeds = st.integers(0, 10**6)


def case(seed, sensor):
    """Return a random belief, observations of some landmarks and an anchor, the anchor, a point."""
    rng = np.random.default_rng(seed)
    belief = belief_of(rng, int(rng.integers(1, 12)))
    seen = rng.permutation(belief.ids)[: 1 + belief.ids.size // 2]
    anchors = {77: rng.uniform(-5, 5, 2)}
    ids = np.append(seen, 77)
    places = np.array([anchors[i] if i in anchors else belief.landmark(i).mean for i in ids])
    values = sensor.expect(belief.pose, places)[0] + 0.1 * rng.standard_normal((ids.size, 2))
    values[:, 0] = 0.06 + np.abs(values[:, 0])  # farther than the bias
    noises = rng.standard_normal((ids.size, 2, 2))
    noises = noises @ noises.mT if seed % 2 else None
    at = belief.mean + 0.1 * rng.standard_normal(belief.mean.size)
    return belief, Observations(ids, values, noises), anchors, at


def assert_same(ours, theirs, tolerance=1e-9):
    assert_close(ours.mean, theirs.mean, tolerance)
    assert_close(ours.cov, theirs.cov, tolerance)
    np.testing.assert_array_equal(ours.ids, theirs.ids)
    np.testing.assert_array_equal(ours.cov, ours.cov.T)


@pytest.mark.parametrize("sensor", SENSORS, ids=["cartesian", "polar"])
@given(seed=seeds, moved=st.booleans())
@settings(max_examples=40)
def test_update_is_the_textbooks(sensor, seed, moved):
    belief, observed, anchors, at = case(seed, sensor)
    at = at if moved else None
    ours, seen = update(belief, observed, sensor, anchors, at)
    theirs, expected = textbook.update(belief, observed, sensor, anchors, at)
    assert_same(ours, theirs)
    np.testing.assert_allclose(seen.innovation, expected.innovation, atol=1e-12)
    assert_close(seen.innovation_cov, expected.innovation_cov)
    np.testing.assert_allclose(seen.nis, expected.nis, rtol=1e-7)


@given(seed=seeds, moved=st.booleans())
@settings(max_examples=40)
def test_predict_is_the_textbooks(seed, moved):
    rng = np.random.default_rng(seed)
    belief = belief_of(rng, int(rng.integers(0, 12)))
    at, after = (belief.mean + 0.1 * rng.standard_normal(belief.mean.size) for _ in range(2))
    points = (at, after) if moved else (None, None)
    for motion in (
        Odometry(rng.standard_normal(3), Q),
        Velocity(rng.standard_normal(), rng.standard_normal(), 0.5, TILTED),
    ):
        assert_same(predict(belief, motion, *points), textbook.predict(belief, motion, *points))


@pytest.mark.parametrize("sensor", SENSORS, ids=["cartesian", "polar"])
@given(seed=seeds, moved=st.booleans())
@settings(max_examples=40)
def test_new_landmarks_are_the_textbooks(sensor, seed, moved):
    belief, observed, _, at = case(seed, sensor)
    observed = Observations(100 + np.arange(observed.ids.size), observed.values, observed.covs)
    at = at if moved else None
    ours = add_landmarks(belief, observed, sensor, at)
    theirs = textbook.add_landmarks(belief, observed, sensor, at)
    assert_same(ours, theirs)
    one_by_one = belief
    for i in range(observed.ids.size):
        noise = None if observed.covs is None else observed.covs[i : i + 1]
        single = Observations(observed.ids[i : i + 1], observed.values[i : i + 1], noise)
        one_by_one = add_landmarks(one_by_one, single, sensor, at)
    assert_same(ours, one_by_one)


@given(seeds)
@settings(max_examples=30)
def test_fixes_are_the_textbooks(seed):
    rng = np.random.default_rng(seed)
    belief = belief_of(rng, 4)
    for fix in (PositionFix(rng.standard_normal(2), TILTED), Compass(rng.uniform(-9, 9), 0.01)):
        ours, seen = correct(belief, fix)
        theirs, expected = textbook.correct(belief, fix)
        assert_same(ours, theirs)
        np.testing.assert_allclose(seen.nis, expected.nis, rtol=1e-9)
        assert -np.pi <= ours.pose[2] < np.pi


@given(seeds)
@settings(max_examples=20)
def test_a_linearised_step_is_the_linear_filter_and_filterpy(seed):
    """With the Jacobians frozen, the step is a Kalman filter's: two independent ones agree."""
    sensor = SENSORS[0]
    belief, observed, anchors, _ = case(2 * seed, sensor)
    motion = Odometry(np.array([0.3, -0.1, 0.2]), Q)
    moved = predict(belief, motion)
    ours, seen = update(moved, observed, sensor, anchors)
    n = belief.mean.size
    F, G = np.eye(n), np.zeros((n, 3))
    F[:3, :3], G[:3] = motion.jacobians(belief.pose)
    linear = kalman.predict(
        Gaussian(belief.mean, belief.cov),
        kalman.Motion(F, G @ Q @ G.T, moved.mean - F @ belief.mean),
    )
    slots = [None if i in anchors else moved.slot(i) for i in observed.ids.tolist()]
    places = np.array(
        [anchors[i] if i in anchors else moved.landmark(i).mean for i in observed.ids]
    )
    H = textbook.measurement_matrix(moved.mean, slots, places, sensor)
    noise = np.kron(np.eye(observed.ids.size), TILTED)
    offset = sensor.expect(moved.pose, places)[0].ravel() - H @ moved.mean
    linear, info = kalman.update(linear, observed.values.ravel() - offset, kalman.Sensor(H, noise))
    peer = ExtendedKalmanFilter(n, H.shape[0])
    peer.x, peer.P, peer.F, peer.Q = moved.mean[:, None].copy(), belief.cov.copy(), F, G @ Q @ G.T
    peer.P = F @ peer.P @ F.T + peer.Q
    peer.R = noise
    peer.update(observed.values.ravel()[:, None], lambda _: H, lambda x: H @ x + offset[:, None])
    for mean, cov in ((linear.mean, linear.cov), (peer.x[:, 0], peer.P)):
        mean = mean.copy()
        mean[2] = np.angle(np.exp(1j * mean[2]))
        assert_close(ours.mean, mean)
        assert_close(ours.cov, cov)
    np.testing.assert_allclose(seen.nis, info.normalised_innovation_squared, rtol=1e-7)


@given(seeds)
@settings(max_examples=30)
def test_the_update_is_josephs_form_even_with_rows_of_the_gain_left_out(seed):
    """(I - KH) P (I - KH)ᵀ + K R Kᵀ; where landmarks are considered K is not the best gain."""
    rng = np.random.default_rng(seed)
    belief = belief_of(rng, 5)
    n, P = belief.mean.size, belief.cov
    work = Workspace(belief)
    slots = np.array([3, 7])
    by_pose, by_point = rng.standard_normal((2, 2, 3)), rng.standard_normal((2, 2, 2))
    if seed % 3:
        work.considered[:] = rng.random(n) < 0.5
    innovation = rng.standard_normal((2, 2))
    H = np.zeros((4, n))
    for i, slot in enumerate(slots):
        H[2 * i : 2 * i + 2, :3] = by_pose[i]
        H[2 * i : 2 * i + 2, slot : slot + 2] = by_point[i]
    noise = np.kron(np.eye(2), TILTED)
    S, squared = work.revise(by_pose, by_point, slots, innovation, TILTED[None])
    assert_close(S, H @ P @ H.T + noise, 1e-13)
    z = innovation.ravel()
    np.testing.assert_allclose(squared, z @ np.linalg.solve(S, z), rtol=1e-9)
    K = np.linalg.solve(S, H @ P).T
    K[work.considered] = 0
    rest = np.eye(n) - K @ H
    wanted = rest @ P @ rest.T + K @ noise @ K.T
    assert_close(work.release().cov, wanted)
    assert_close(work.mean[3:], (belief.mean + K @ z)[3:])


@pytest.mark.parametrize(("noise", "considered"), [(1.0, ()), (0.0, (0, 1, 2))])
@pytest.mark.slow
def test_a_million_updates_leave_a_covariance(noise, considered):
    """Rounding does not add up: round and round a few landmarks, with and without motion noise."""
    million_updates(10**6, noise, considered)


@pytest.mark.parametrize("considered", [(), (0, 1, 2)])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_thousands_of_updates_leave_a_covariance(noise, considered):
    million_updates(5000, noise, considered)


def million_updates(count, noise, considered):
    n, rng = 6, np.random.default_rng(1)
    places = rng.uniform(-5, 5, 2 * n)
    prior = np.diag(np.r_[1.0, 1.0, 0.1, np.ones(2 * n)])
    work = Workspace(MapBelief(np.r_[np.zeros(3), places], prior, np.arange(n)))
    for name in considered:
        work.consider(name)
    motion = Odometry(np.array([0.05, 0.0, 0.02]), 1e-4 * noise * np.eye(3))
    for k in range(count):
        work.predict(motion)
        slots, points = work.targets(range(k % n, min(k % n + 3, n)), {})
        _, by_pose, by_point = CART.expect(work.mean[:3], points)
        work.revise(by_pose, by_point, slots, np.zeros_like(points), R[None])
        if (k + 1) % (count // 10) == 0:
            P = work.snapshot().cov
            deviations = np.sqrt(np.diag(P))
            assert np.linalg.eigvalsh(P / np.outer(deviations, deviations))[0] > 0
            np.testing.assert_array_equal(P, P.T)


def test_a_landmark_shares_the_error_of_the_pose_that_saw_it():
    """Two landmarks seen from one uncertain pose: their difference knows nothing of the pose."""
    belief = MapBelief.start(np.array([2.0, 1.0, 0.5]), np.diag([4.0, 4.0, 0.0]))
    seen = Observations(np.array([1, 2]), np.array([[3.0, 0.0], [0.0, 3.0]]))
    after = add_landmarks(belief, seen, CartesianSensor(R))
    difference = np.zeros((2, 7))
    difference[:, 3:5], difference[:, 5:7] = -np.eye(2), np.eye(2)
    np.testing.assert_allclose(difference @ after.cov @ difference.T, 2 * R, atol=1e-12)
    np.testing.assert_allclose(after.cov[3:5, :2], 4 * np.eye(2), atol=1e-12)


def test_heading_error_spreads_sideways():
    """Driving 10 m with a heading error moves the error across the drive: F P Fᵀ, not Fᵀ P F."""
    belief = MapBelief.start(np.array([0.0, 0.0, np.pi / 2]), np.diag([0.0, 0.0, 0.01]))
    after = predict(belief, Odometry(np.array([10.0, 0.0, 0.0]), np.zeros((3, 3))))
    expected = [[1.0, 0.0, -0.1], [0.0, 0.0, 0.0], [-0.1, 0.0, 0.01]]
    np.testing.assert_allclose(after.cov, expected, atol=1e-12)


@pytest.mark.parametrize("heading", [3.1, -3.1])
def test_nothing_happens_at_the_seam_of_the_angles(heading):
    """A step across ±π gives the same as the same step elsewhere, turned."""
    results = []
    for shift in (0.0, heading):
        c, s = np.cos(shift), np.sin(shift)
        turned = np.array([[c, -s], [s, c]])
        belief = MapBelief.start(np.array([0.0, 0.0, shift]), np.diag([0.01, 0.01, 0.04]))
        belief = predict(belief, Odometry(np.array([0.0, 0.0, 0.2 * np.sign(heading)]), Q))
        belief, _ = correct(belief, Compass(shift + 0.25 * np.sign(heading), 0.01))
        anchor = {5: turned @ [-4.0, 0.3]}  # behind the robot: its bearing is at the seam as well
        observed = Observations(np.array([5]), np.array([[4.0, -3.12]]))
        belief, seen = update(belief, observed, RangeBearing(R), anchor)
        results.append((turned.T @ belief.pose[:2], belief.pose[2] - shift, seen.innovation))
    for a, b in zip(*results, strict=True):
        difference = np.atleast_1d(a - b)
        np.testing.assert_allclose(np.angle(np.exp(1j * difference)), 0, atol=1e-9)


def test_an_empty_scan_changes_nothing():
    belief = belief_of(np.random.default_rng(0), 3)
    none = Observations(np.empty(0, dtype=int), np.empty((0, 2)))
    after, seen = update(belief, none, CartesianSensor(R))
    assert_same(after, belief)
    assert seen.innovation.size == 0
    assert_same(add_landmarks(belief, none, CartesianSensor(R)), belief)


def test_beliefs_are_not_written_to():
    sensor = SENSORS[0]
    belief, observed, anchors, _ = case(3, sensor)
    mean, cov = belief.mean.copy(), belief.cov.copy()
    predict(belief, Odometry(np.ones(3), Q))
    update(belief, observed, sensor, anchors)
    correct(belief, Compass(1.0, 0.1))
    add_landmarks(belief, Observations(np.array([99]), np.ones((1, 2))), sensor)
    np.testing.assert_array_equal(belief.mean, mean)
    np.testing.assert_array_equal(belief.cov, cov)


def lost_symmetry(place=(0, 4), value=1.0):
    belief = belief_of(np.random.default_rng(0), 3)
    belief.cov[place] += value
    return belief


ONE = Observations(np.array([8]), np.ones((1, 2)))
CART = CartesianSensor(R)
EXACT = MapBelief.start(np.zeros(3), np.zeros((3, 3)))
BAD = [
    (lambda: update(EXACT, ONE, CART), r"no landmark of the map and no anchor: \[8\]"),
    (lambda: update(EXACT, Observations(np.array([-1]), np.ones((1, 2))), CART), r"\[-1\]"),
    (lambda: update(EXACT, ONE, CART, {8: np.ones(3)}), r"anchor 8 must be \(2,\)"),
    (lambda: update(EXACT, ONE, CART, {8: np.array([np.nan, 0])}), "anchor 8 must be finite"),
    (lambda: update(EXACT, ONE, CART, {-1: np.ones(2)}), "anchor needs .* at least 0 .* got -1"),
    (lambda: update(EXACT, ONE, CART, {1.7: np.ones(2)}), "anchor needs an integer .* got 1.7"),
    (lambda: update(EXACT, ONE, CART, {True: np.ones(2)}), "anchor needs an integer .* got True"),
    (lambda: update(EXACT, ONE, RangeBearing(R, 1.5), {8: np.ones(2)}), "1.5 m, got 1.0"),
    (lambda: add_landmarks(EXACT, ONE, RangeBearing(R, 1.0)), "the bias, 1.0 m, got 1.0"),
    (lambda: update(EXACT, ONE, CART, {8: np.ones(2)}, np.zeros(5)), r"at must be \(3,\)"),
    (lambda: update(EXACT, ONE, CartesianSensor(0 * R), {8: np.ones(2)}), "is singular"),
    (lambda: update(EXACT, ONE, RangeBearing(R), {8: np.zeros(2)}), "exactly at the robot"),
    (lambda: add_landmarks(add_landmarks(EXACT, ONE, CART), ONE, CART), r"in the map: \[8\]"),
    (lambda: add_landmarks(EXACT, Observations(np.array([-1]), np.ones((1, 2))), CART), "got -1"),
    (lambda: predict(EXACT, Odometry(np.ones(3), Q), np.array([0, np.inf, 0])), "at must be fin"),
    (lambda: predict(EXACT, Odometry(np.ones(3), Q), 1.0), r"at must be \(states,\), got \(\)"),
    (lambda: predict(EXACT, (0.1, 0, 0)), r"motion must be an Odometry .* got \(0.1, 0, 0\)"),
    (lambda: correct(EXACT, Compass), "fix must be a PositionFix or a Compass, got <class"),
    (lambda: correct(EXACT, PositionFix(np.zeros(2), 0 * R)), "is singular"),
    (lambda: predict(lost_symmetry(), Odometry(np.ones(3), Q)), "1 pairs of entries are not"),
    (lambda: update(lost_symmetry(), ONE, CART, {8: np.ones(2)}), "finite and symmetric"),
    (lambda: correct(lost_symmetry((2, 2), np.nan), Compass(0, 1)), "finite and symmetric"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(make, message):
    with unchecked(), pytest.raises((TypeError, ValueError), match=message):
        make()


def test_an_identifier_in_the_map_cannot_be_an_anchor_too():
    belief = add_landmarks(EXACT, ONE, CART)
    with pytest.raises(ValueError, match=r"in the map and an anchor: \[8\]"):
        update(belief, ONE, CART, {8: np.ones(2)})
