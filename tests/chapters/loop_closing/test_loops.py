"""What the studies of the loop share: the anchor, and the account of a run."""

import numpy as np
import pytest

from robot_perception.chapters.loop_closing import loops
from robot_perception.chapters.loop_closing.loops import Drive
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.observations import Observations
from robot_perception.slam import planar


def test_the_anchor_is_the_nearest_of_the_first_landmarks():
    sightings = [
        Observations(np.array([], int), np.empty((0, 2)), np.empty((0, 2, 2))),
        Observations(
            np.array([-1, 7, 4]), np.array([[1.0, 0], [5, 0], [2, 1]]), np.zeros((3, 2, 2))
        ),
    ]
    assert loops.first_observed(sightings) == 4


def test_wrong_associations_are_counted_against_who_a_landmark_was_at_first():
    names = [np.array([3, 5]), np.array([3, 5]), np.array([5, 3])]
    used = (np.array([0, 1]), np.array([0, 1]), np.array([0, 2]))
    landmarks = np.arange(12.0).reshape(6, 2)
    start = planar.MapBelief(
        np.r_[0, 0, 0, landmarks[3], landmarks[5], landmarks[3]], np.eye(9), np.array([0, 1, 2])
    )
    history = planar.History(
        start=np.zeros(3),
        times=np.full(3, np.nan),
        poses=np.tile([0.0, 0.0, 2 * np.pi - 0.1], (3, 1)),
        pose_covs=np.broadcast_to(np.eye(3), (3, 3, 3)),
        nis=np.zeros(3),
        dof=np.zeros(3, int),
        sizes=np.array([2, 2, 3]),
        used=used,
        belief=start,
        frozen={},
        counts=planar.run_filter(
            planar.MapBelief.start(np.zeros(3), np.eye(3)),
            [planar.Step(None)],
            planar.Settings(planar.CartesianSensor(np.eye(2))),
        ).counts,
        kept={},
        points={},
    )
    seen = [Observations(n, np.zeros((2, 2)), np.zeros((2, 2, 2))) for n in names]
    drive = Drive(landmarks, np.zeros((3, 3)), seen, np.zeros(3), {}, {})
    runs = loops.stack([loops.account(history, drive)])
    np.testing.assert_allclose(runs.errors, np.tile([0, 0, -0.1], (1, 3, 1)), atol=1e-12)
    assert runs.false.tolist() == [1]  # landmark 0 was the third, then the fifth is taken for it
    assert runs.twice.tolist() == [1]  # the third came into the map again, as 2
    np.testing.assert_allclose(runs.map_error, 0, atol=1e-12)
    assert runs.states[0] == pytest.approx((49 + 49 + 81) / 3)
    np.testing.assert_allclose(runs.stated, [[np.sqrt(2), 1]])


def test_errors_of_runs_are_reduced_over_runs_or_over_steps():
    errors = np.random.default_rng(0).normal(size=(4, 5, 3))
    nees = np.random.default_rng(1).chisquare(3, size=(4, 5))
    rest = np.zeros(4, int), np.zeros(4, int), np.zeros(4), np.zeros(4), np.zeros(4)
    runs = loops.Runs(errors, nees, *rest, np.zeros(4, int), np.zeros((4, 2)))
    for k in range(5):
        squared = [e[k] @ e[k] - e[k, 2] ** 2 for e in errors]
        assert runs.rms[k] ** 2 == pytest.approx(np.mean(squared))
        heading = np.rad2deg(errors[:, k, 2])
        assert runs.rms_heading[k] ** 2 == pytest.approx(np.mean(heading**2))
        np.testing.assert_allclose(runs.heading(k), np.abs(heading))
        np.testing.assert_allclose(runs.distance(k) ** 2, squared)
    for one, path in zip(errors, runs.path_error, strict=True):
        assert path**2 == pytest.approx(np.mean([e[:2] @ e[:2] for e in one]))
    np.testing.assert_allclose(runs.mean_nees, [values.mean() for values in nees])
    assert (runs.coverage.low[0], runs.coverage.high[0]) == pytest.approx(average_bounds(3, 4))
