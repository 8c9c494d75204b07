"""What ground truth says of sensors, on worlds whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.datasets.mrclam import Sightings, Track
from robot_perception.geometry import act
from robot_perception.observations import unnamed
from robot_perception.slam.planar import Odometry, dead_reckoning
from robot_perception.slam.planar.calibration import (
    WINDOW,
    Calibration,
    calibrate,
    calibrate_odometry,
    make_steps,
    name_landmarks,
    pooled,
)
from tests.slam.planar.logged import BIAS, DELAY, DRAG, LANDMARKS, SCALE, SIGMA, make_robot

PLACES = dict(zip(LANDMARKS.ids.tolist(), LANDMARKS.positions, strict=True))
SAME = 0.3


def log(robot):
    wheels, seen = robot.commands, robot.landmarks
    return wheels.times, wheels.velocities, seen.times, seen.subjects, seen.values


def calibrated(robot):
    delays = np.arange(0.0, 0.51, 0.05)
    return calibrate(*log(robot), places=PLACES, truth=robot.truth, delays=delays)


def test_calibration_finds_the_delay_scale_and_errors_that_were_put_in():
    robot = make_robot(np.random.default_rng(0), persistence=0.5)
    found = calibrated(robot)
    assert found.delay == pytest.approx(DELAY)
    np.testing.assert_allclose(found.scale, SCALE, rtol=0.01)
    assert found.drag == pytest.approx(DRAG, rel=0.05)
    np.testing.assert_allclose(found.bias, BIAS, atol=0.02)
    np.testing.assert_allclose(found.sigma, SIGMA, rtol=0.1)
    np.testing.assert_allclose(found.persistence, 0.5, atol=0.12)
    assert found.interval == pytest.approx(0.4)
    assert found.misread == 0


def test_calibration_leaves_out_what_motion_capture_did_not_see():
    robot = make_robot(np.random.default_rng(0))
    there = (robot.truth.times < 1100) | (robot.truth.times > 1160)
    holed = Track(robot.truth.times[there], robot.truth.poses[there])
    found = calibrated(replace(robot, truth=holed))
    assert found.delay == pytest.approx(DELAY)
    np.testing.assert_allclose(found.scale, SCALE, rtol=0.01)
    np.testing.assert_allclose(found.sigma, SIGMA, rtol=0.1)


def test_time_between_images_is_that_of_a_landmark_in_sight():
    """Law: a minute without an image makes no image later than the one before."""
    robot = make_robot(np.random.default_rng(0))
    times = robot.landmarks.times
    kept = (times < 1100) | (times > 1160)
    parts = (part[kept] for part in (times, robot.landmarks.subjects, robot.landmarks.values))
    robot = replace(robot, landmarks=Sightings(*parts))
    assert calibrated(robot).interval == pytest.approx(0.4)


def test_calibration_finds_the_wander_of_the_wheels_and_leaves_misread_barcodes_out():
    robot = make_robot(np.random.default_rng(1), seconds=1500.0, wander=(0.02, 0.05))
    values = robot.landmarks.values.copy()
    values[[3, 700], 1] += 1.0
    robot = replace(robot, landmarks=replace(robot.landmarks, values=values))
    found = calibrated(robot)
    np.testing.assert_allclose(np.sqrt(found.density), [0.02, 0.05], rtol=0.15)
    np.testing.assert_allclose(found.sigma, SIGMA, rtol=0.1)
    assert found.misread == 2


def test_inflation_is_the_variance_of_a_mean_of_lasting_errors():
    """Oracle: the exact variance of the mean of an autoregressive sequence."""
    interval, n = 0.3, 4000
    sensors = Calibration(
        0.0, np.ones(2), 0.0, np.ones(2), np.zeros(2), np.ones(2), np.array([0.6, 0.3]), interval, 0
    )
    for persistence, inflation in zip(sensors.persistence, sensors.inflation, strict=True):
        step = persistence ** (interval / WINDOW)
        lags = np.arange(1, n)
        exact = 1 + 2 * np.sum((1 - lags / n) * step**lags)
        assert inflation == pytest.approx(exact, rel=0.01)


def test_errors_that_do_not_average_out_have_no_inflation():
    lasting = np.array([0.5, 1.0])
    sensors = Calibration(
        0.0, np.ones(2), 0.0, np.ones(2), np.zeros(2), np.ones(2), lasting, 0.3, 0
    )
    with pytest.raises(ValueError, match=r"persistence must be below 1, got \[0\.5 1\. \]"):
        _ = sensors.inflation


def test_sensors_of_several_robots_are_pooled_without_their_biases():
    rngs = np.random.default_rng(3).spawn(2)
    one, other = (calibrated(make_robot(rng, seconds=120.0)) for rng in rngs)
    both = pooled([one, other])
    for name in ("delay", "scale", "drag", "density", "persistence", "interval"):
        mean = (getattr(one, name) + getattr(other, name)) / 2
        np.testing.assert_allclose(getattr(both, name), mean)
    np.testing.assert_allclose(both.sigma**2, (one.sigma**2 + other.sigma**2) / 2)
    np.testing.assert_array_equal(both.bias, 0.0)
    assert both.misread == one.misread + other.misread


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"delays": np.empty(0)}, "delays must hold one"),
        ({"observed": np.arange(12.0)[::-1]}, r"observed must not fall, got 10\.0 after 11\.0"),
        ({"places": {6: np.zeros(2)}}, r"places must have all names seen, none of"),
        ({"observed": -np.ones(12)}, "observed, names, values and places must give right"),
        ({"velocities": np.ones((200, 2)) * [1, 0]}, "velocities must turn"),
        ({"delays": np.array([1e4])}, "times must share 4 s of the truth after each of delays"),
    ],
)
def test_too_little_to_calibrate_from_is_said(changes, said):
    robot = make_robot(np.random.default_rng(0), seconds=10.0)
    wheels, seen = robot.commands, robot.landmarks
    given = {"times": wheels.times, "velocities": wheels.velocities, "observed": seen.times[:12]}
    given |= {"names": seen.subjects[:12], "values": seen.values[:12], "places": PLACES}
    given |= {"truth": robot.truth, "delays": np.zeros(1)} | changes
    with pytest.raises(ValueError, match=said):
        calibrate(**given)


def test_steps_by_the_right_calibration_lead_along_the_true_path():
    robot, none = make_robot(np.random.default_rng(2), seconds=30.0), np.zeros(2)
    sensors = Calibration(DELAY, SCALE, DRAG, none, none, none, none, 0.4, 0)
    steps, merged = make_steps(sensors, *log(robot))
    truth, _ = robot.truth.at(merged.times, longest_gap=1.0)
    driven = dead_reckoning(truth[0], (step.motion for step in steps))
    np.testing.assert_allclose(driven[:, :2], truth[:, :2], atol=2e-3)  # arcs for chords


def path(increments):
    return dead_reckoning(np.zeros(3), (Odometry(i, np.zeros((3, 3))) for i in increments))


def test_calibrated_wheels_lose_a_drift_per_metre_and_an_offset():
    rng = np.random.default_rng(0)
    true = np.column_stack([rng.uniform(0.3, 1, 500), np.zeros(500), rng.normal(0, 0.3, 500)])
    raw = true - np.column_stack([np.full((500, 2), [0.02, -0.01]), 0.05 * true[:, 0]])
    motions = calibrate_odometry(path(raw), path(true))
    np.testing.assert_allclose([m.increment for m in motions], true, atol=2e-3)


def test_calibration_is_least_squares_and_its_noise_the_variance_of_the_rest():
    """Oracle: `lstsq` on headings that turn by nearly half a circle and err."""
    rng = np.random.default_rng(1)
    raw = np.column_stack([rng.uniform(0.2, 2, 300), np.zeros(300), rng.choice([-3.1, 3.1], 300)])
    errors = rng.normal(0, [0.03, 0.02, 0.1], (300, 3))
    errors[:, 2] += 0.05 * raw[:, 0]
    motions = calibrate_odometry(path(raw), path(raw + errors))
    (drift,) = np.linalg.lstsq(raw[:, :1], errors[:, 2])[0]
    change = np.array([*errors[:, :2].mean(axis=0), 0]) + np.outer(raw[:, 0], [0, 0, drift])
    np.testing.assert_allclose([m.increment for m in motions], raw + change, rtol=1e-6)
    np.testing.assert_allclose(np.diag(motions[0].noise), (errors - change).var(axis=0), rtol=1e-6)


def marks(points):
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    return unnamed(points, np.tile(1e-4 * np.eye(2), (len(points), 1, 1)))


def test_corners_are_told_by_where_they_are_in_the_corrected_frame():
    poses = np.array([[0.0, 0, 0], [1, 0, np.pi / 2], [5, 5, 0]])
    seen = [marks([[2, 0], [3, 3]]), marks([[0.05, -1]]), marks([])]  # (2, 0) again, from (1, 0)
    assert [names.tolist() for names in name_landmarks(poses, seen, SAME)] == [[0, 1], [0], []]


def test_a_scan_sees_a_name_once_though_two_corners_are_near_one_another():
    names = name_landmarks(
        np.zeros((2, 3)), [marks([[2, 0], [2.1, 0]]), marks([[2.1, 0], [2, 0]])], SAME
    )
    assert [n.tolist() for n in names] == [[0, 1], [1, 0]]


def test_a_corner_is_where_the_mean_of_its_sightings_is():
    """Law: one far sighting to the right takes no name from one on the left."""
    ends = np.array([0.0, 0, 0.9, -0.7]) * SAME
    names = name_landmarks(np.zeros((4, 3)), [marks([[2 + end, 0]]) for end in ends], SAME)
    assert [n.tolist() for n in names] == [[0], [0], [0], [0]]


def test_moving_the_world_moves_the_told_names_not():
    """Names come from the poses given, wherever their frame lies."""
    rng = np.random.default_rng(1)
    poses = np.cumsum(rng.normal(size=(6, 3)), axis=0)
    spots = rng.uniform(-5, 5, (8, 2))
    seen = []
    for pose in poses:
        back = np.array([0, 0, -pose[2]])
        seen.append(marks(act(back, spots - pose[:2])))
    shift = np.array([3.0, -2.0, 0.7])
    moved = np.column_stack([act(shift, poses[:, :2]), poses[:, 2] + shift[2]])
    names = (name_landmarks(frame, seen, SAME) for frame in (poses, moved))
    for one, other in zip(*names, strict=True):
        np.testing.assert_array_equal(one, other)
