"""MRCLAM: tracks at given times, commands, and what is known of the recording."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.datasets import Commands, read_mrclam
from robot_perception.datasets.tracks import Track
from robot_perception.geometry import wrap_angle
from tests.datasets.here import recording
from tests.unchecked import unchecked


def test_headings_take_the_short_way_and_nothing_is_extrapolated():
    track = Track(np.array([0.0, 1, 5]), np.array([[0.0, 0, 3.1], [2, 4, -3.1], [2, 4, -3.1]]))
    poses, covered = track.at(np.array([0.5, -0.1, 1.0, 3.0, 5.0, 5.1]), longest_gap=2.0)
    np.testing.assert_array_equal(covered, [True, False, True, False, True, False])
    np.testing.assert_allclose(poses[0], [1, 2, -np.pi])
    assert np.isnan(poses[[1, 3, 5]]).all()
    assert track.at(np.array([3.0]), longest_gap=4.0)[1].all()


@given(st.integers(0, 2**31))
def test_interpolation_agrees_with_numpy(seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 1, 20))
    poses = np.cumsum(rng.normal(size=(20, 3)), axis=0)
    wrapped = np.column_stack([poses[:, :2], wrap_angle(poses[:, 2])])
    asked = rng.uniform(times[0], times[-1], 30)
    found, covered = Track(times, wrapped).at(asked, longest_gap=2.0)
    assert covered.all()
    for column in range(2):
        expected = np.interp(asked, times, poses[:, column])
        np.testing.assert_allclose(found[:, column], expected, atol=1e-12)
    turns = np.interp(asked, times, np.unwrap(wrapped[:, 2]))
    np.testing.assert_allclose(wrap_angle(found[:, 2] - turns), 0, atol=1e-9)


def test_track_of_one_pose_covers_its_own_time():
    track = Track(np.array([2.0]), np.array([[1.0, 2, 3]]))
    poses, covered = track.at(np.array([1.0, 2.0, 3.0]), longest_gap=1.0)
    np.testing.assert_array_equal(covered, [False, True, False])
    np.testing.assert_allclose(poses[1], [1, 2, 3])


TRACK = Track(np.array([0.0, 1.0]), np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"poses": np.zeros((0, 3))}, r"poses must be \(2, 3\)"),
        ({"poses": np.zeros((2, 2))}, r"poses must be \(2, 3\)"),
        ({"poses": np.full((2, 3), np.nan)}, "poses must"),
        ({"times": np.arange(3.0)}, r"poses must be \(3, 3\)"),
        ({"times": np.array([1.0, np.inf])}, "times must"),
        ({"times": np.array([2.0, 1.0])}, "times must not fall, got 2 before 1"),
        ({"times": np.zeros(0), "poses": np.zeros((0, 3))}, "one at least, got none"),
        ({"covs": np.zeros((2, 3))}, "covs must be"),
    ],
)
def test_what_is_no_track_is_refused(changed, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        replace(TRACK, **changed)
    assert len(replace(TRACK, times=np.zeros(2)).times) == 2  # motion capture may tell twice


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"velocities": np.zeros((1, 2))}, r"velocities must be \(2, 2\)"),
        ({"velocities": np.zeros((2, 3))}, r"velocities must be \(2, 2\)"),
        ({"times": np.array([2.0, 1.0])}, "times must not fall"),
        ({"times": np.array([np.nan, 1.0])}, "times must"),
    ],
)
def test_what_are_no_commands_is_refused(changed, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        replace(Commands(np.zeros(2), np.zeros((2, 2))), **changed)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: TRACK.at(np.array([np.inf]), longest_gap=1.0), "times must be finite"),
        (lambda: TRACK.at(np.array([0.5]), longest_gap=0.0), "longest_gap must be positive, got 0"),
    ],
)
def test_bad_times_are_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()


# ---- the recording -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def utias():
    return read_mrclam(recording("utias_mrclam_6"))


def test_recording_holds_what_is_known_of_it(utias):
    counts = [len(robot.landmarks.times) for robot in utias.robots.values()]
    assert counts == [1534, 3239, 4348, 2023, 4239]
    unknown = {number: dict(robot.unknown) for number, robot in utias.robots.items()}
    assert unknown == {1: {43: 1}, 2: {}, 3: {34: 2}, 4: {50: 3}, 5: {}}
    assert len(utias.landmarks.ids) == 15
    assert sum(report.lines for report in utias.reports) == 606015


def test_bearings_agree_with_motion_capture(utias):
    """Wrong frames, barcodes or clocks would be metres off; the camera is good to a degree."""
    robot = utias.robots[3]
    poses, covered = robot.truth.at(robot.landmarks.times, longest_gap=0.2)
    assert covered.mean() > 0.99
    rows = np.searchsorted(utias.landmarks.ids, robot.landmarks.subjects)
    x, y = (utias.landmarks.positions[rows] - poses[:, :2])[covered].T
    bearing = wrap_angle(np.arctan2(y, x) - poses[covered, 2] - robot.landmarks.values[covered, 1])
    assert np.median(np.abs(bearing)) < np.deg2rad(1)
    assert np.median(np.abs(np.hypot(x, y) - robot.landmarks.values[covered, 0])) < 0.15
