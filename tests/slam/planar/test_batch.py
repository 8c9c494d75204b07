"""The filter against the batch optimum of the same data: SciPy's least squares, and gtsam."""

import gtsam
import numpy as np
import pytest
from gtsam.symbol_shorthand import L, X
from scipy.optimize import least_squares

from robot_perception.slam.planar import (
    CartesianSensor,
    Compass,
    Odometry,
    RangeBearing,
    Settings,
    Step,
    run_filter,
    smooth,
)
from tests.slam.planar.drives import R_POLAR, Q, R, drive, wrapped
from tests.unchecked import unchecked

STEPS, LANDMARKS = 40, 6


def residuals(world, x, polar, noise):
    """Return all whitened residuals of a drive, positions as complex numbers; x: poses, posts."""
    poses = np.vstack([world.poses[:1], x[: 3 * STEPS].reshape(-1, 3)])
    posts = x[3 * STEPS :: 2] + 1j * x[3 * STEPS + 1 :: 2]
    place, heading = poses[:, 0] + 1j * poses[:, 1], poses[:, 2]
    shift = np.diff(place) * np.exp(-1j * heading[:-1])
    moved = np.array([step.motion.increment for step in world.steps])
    moved = moved - np.stack([shift.real, shift.imag, np.diff(heading)], axis=-1)
    moved[:, 2] = wrapped(moved[:, 2])
    names = np.array([step.observations.ids for step in world.steps])
    seen = (posts[names] - place[1:, None]) * np.exp(-1j * heading[1:, None])
    parts = (np.abs(seen), np.angle(seen)) if polar else (seen.real, seen.imag)
    error = np.array([step.observations.values for step in world.steps]) - np.stack(parts, axis=-1)
    if polar:
        error[..., 1] = wrapped(error[..., 1])
    blur = np.sqrt(np.diag(R_POLAR if polar else R))
    return np.r_[(moved / np.sqrt(np.diag(Q))).ravel(), (error / blur).ravel()] / noise


def batch(world, polar, noise):
    """Return the optimum of last pose and landmarks, and its covariance."""
    guess = np.concatenate([world.poses[1:].ravel(), world.landmarks.ravel()])
    found = least_squares(lambda x: residuals(world, x, polar, noise), guess, method="lm")
    last = np.r_[3 * STEPS - 3 : 3 * STEPS, 3 * STEPS : guess.size]
    return found.x[last], np.linalg.inv(found.jac.T @ found.jac)[np.ix_(last, last)]


def smoothed(world, noise):
    """Return the same from gtsam, range and bearing."""
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.add(gtsam.NonlinearEqualityPose2(X(0), gtsam.Pose2(*world.poses[0])))
    odometry = gtsam.noiseModel.Diagonal.Sigmas(noise * np.sqrt(np.diag(Q)))
    noise_seen = gtsam.noiseModel.Diagonal.Sigmas(noise * np.sqrt(np.diag(R_POLAR))[::-1])
    for k, pose in enumerate(world.poses):
        values.insert(X(k), gtsam.Pose2(*pose))
    for name, post in enumerate(world.landmarks):
        values.insert(L(name), gtsam.Point2(*post))
    for k, step in enumerate(world.steps):
        moved = gtsam.Pose2(*step.motion.increment)
        graph.add(gtsam.BetweenFactorPose2(X(k), X(k + 1), moved, odometry))
        for name, (reach, bearing) in zip(
            step.observations.ids.tolist(), step.observations.values, strict=True
        ):
            direction = gtsam.Rot2(bearing)
            graph.add(gtsam.BearingRangeFactor2D(X(k + 1), L(name), direction, reach, noise_seen))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-14)
    best = gtsam.LevenbergMarquardtOptimizer(graph, values, parameters).optimize()
    pose = best.atPose2(X(STEPS))
    posts = [best.atPoint2(L(name)) for name in range(LANDMARKS)]
    body = gtsam.Marginals(graph, best).marginalCovariance(X(STEPS))
    turned = np.eye(3)
    turned[:2, :2] = pose.rotation().matrix()  # gtsam's errors are in the frame of the robot
    mean = np.concatenate([[pose.x(), pose.y(), pose.theta()], *posts])
    return mean, turned @ body @ turned.T


def filtered(world, polar, noise):
    """Return last pose and landmarks in the order of their numbers, and the covariance."""
    sensor = RangeBearing(noise**2 * R_POLAR) if polar else CartesianSensor(noise**2 * R)
    belief = run_filter(world.start, world.steps, Settings(sensor)).belief
    order = [0, 1, 2] + [belief.slot(name) + c for name in range(LANDMARKS) for c in (0, 1)]
    return belief.mean[order], belief.cov[np.ix_(order, order)]


def distance(a, b, cov):
    """Return the largest difference in standard deviations."""
    difference = a - b
    difference[2] = wrapped(difference[2])
    return np.abs(difference / np.sqrt(np.diag(cov))).max()


@pytest.mark.parametrize("polar", [False, True])
def test_the_filter_nears_the_batch_optimum_as_the_noise_shrinks(polar):
    """Only linearisation parts the two: the gap, in standard deviations, falls with the noise."""
    gaps, cov_gaps = [], []
    for noise in (1.0, 0.1, 0.01):
        rng = np.random.default_rng(12)
        world = drive(rng, steps=STEPS, landmarks=LANDMARKS, noise=noise, polar=polar)
        best, best_cov = batch(world, polar, noise)
        ours, cov = filtered(world, polar, noise)
        gaps.append(distance(ours, best, best_cov))
        scale = np.sqrt(np.diag(best_cov))
        cov_gaps.append(np.abs((cov - best_cov) / np.outer(scale, scale)).max())
    assert gaps[1] < 0.3 * gaps[0]
    assert gaps[2] < 0.3 * gaps[1]
    assert gaps[2] < 0.01
    assert cov_gaps[2] < 0.01
    assert cov_gaps[2] < 0.3 * cov_gaps[1]


def test_the_filter_nears_gtsams_optimum():
    noise = 0.01
    rng = np.random.default_rng(13)
    world = drive(rng, steps=STEPS, landmarks=LANDMARKS, noise=noise, polar=True)
    best, pose_cov = smoothed(world, noise)
    ours, cov = filtered(world, True, noise)
    assert distance(ours, best, cov) < 0.01
    np.testing.assert_allclose(cov[:3, :3], pose_cov, rtol=0, atol=0.01 * np.diag(pose_cov).max())


def run(world, polar, noise):
    """Return a run of the filter, and its sensor."""
    sensor = RangeBearing(noise**2 * R_POLAR) if polar else CartesianSensor(noise**2 * R)
    return run_filter(world.start, world.steps, Settings(sensor)), sensor


@pytest.mark.parametrize("polar", [False, True])
def test_the_batch_optimum_is_scipys(polar):
    """Oracle: dense least squares of residuals written from positions, at full noise."""
    world = drive(np.random.default_rng(14), steps=STEPS, landmarks=LANDMARKS, polar=polar)
    history, sensor = run(world, polar, 1.0)
    ours = smooth(world.steps, history, sensor)
    best, cov = batch(world, polar, 1.0)
    places = [ours.landmarks[history.belief.slot(n) // 2 - 1] for n in range(LANDMARKS)]
    assert distance(np.concatenate([ours.path[-1], *places]), best, cov) < 1e-3
    x = np.concatenate([ours.path[1:].ravel(), *places])
    left = residuals(world, x, polar, 1.0)
    assert ours.squares == pytest.approx(left @ left, rel=1e-9)
    assert ours.dof == left.size - x.size
    assert ours.squares < np.sum(residuals(world, guess(world), polar, 1.0) ** 2)


def guess(world):
    return np.concatenate([world.poses[1:].ravel(), world.landmarks.ravel()])


def test_without_noise_the_batch_optimum_is_the_truth_wherever_the_search_begins():
    """The guess is a run over the same steps with noise added to the motions."""
    world = drive(np.random.default_rng(15), steps=STEPS, landmarks=LANDMARKS, noise=1e-6)
    rng, bent = np.random.default_rng(16), []
    for step in world.steps:
        wrong = step.motion.increment + np.sqrt(np.diag(Q)) * rng.standard_normal(3)
        bent.append(Step(Odometry(wrong, Q), step.observations))
    sensor = CartesianSensor(R)
    history = run_filter(world.start, bent, Settings(sensor))
    assert np.abs(history.poses - world.poses[1:])[:, :2].max() > 0.01
    found = smooth([Step(Odometry(s.motion.increment, Q), s.observations) for s in world.steps],
                   history, sensor)  # fmt: skip
    np.testing.assert_allclose(found.path[:, :2], world.poses[:, :2], atol=1e-5)
    np.testing.assert_allclose(found.landmarks, world.landmarks[found.ids], atol=1e-5)


def test_a_drive_that_cannot_be_smoothed_is_named():
    world = drive(np.random.default_rng(17), steps=4, landmarks=LANDMARKS)
    history, sensor = run(world, False, 1.0)
    first = world.steps[0]
    exact = CartesianSensor(0 * R)
    unknown = first.observations.named(first.observations.ids + 1000)
    for steps, using, words in (
        (world.steps[:2], sensor, "of one drive, got 2 and 4"),
        ([Step(None), *world.steps[1:]], sensor, "step 0 must have a motion"),
        ([Step(first.motion, None, (Compass(0.0, 1.0),)), *world.steps[1:]], sensor, "no fixes"),
        ([Step(first.motion, unknown), *world.steps[1:]], sensor, "no landmark of the guess"),
        (world.steps, exact, "noise of an observation is singular"),
    ):
        with unchecked(), pytest.raises(ValueError, match=words):
            smooth(steps, history, using)
