"""The batch optimum: path and map of a drive at once, relinearised until nothing moves."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy import sparse
from scipy.sparse.linalg import splu

from robot_perception import checks
from robot_perception.geometry import wrap_angle
from robot_perception.slam.planar.motions import Odometry
from robot_perception.slam.planar.runs import History, Step
from robot_perception.slam.planar.sensors import LandmarkSensor, checked_noises, checked_sensor

MOST = 60
"""Linearisations before the search is given up."""
NEAR = 1e-9
"""Relative decrease of the sum of squares at which it ends."""
STILL = 1e-10
"""Step, over the largest number of the state, at which it ends."""


@dataclass(frozen=True, eq=False, slots=True)
class Optimum:
    """The path and the map that fit all measurements of a drive best.

    Parameters
    ----------
    path : (k + 1, 3)
        The start and the pose after each step, m, m, rad.
    ids : (n,)
        Landmarks, as in the history from which the search began.
    landmarks : (n, 2)
        Their places, m.
    squares
        Sum of squares of all residuals over their covariances.
    dof
        Numbers measured less numbers estimated, what ``squares`` is expected to be.
    """

    path: Float[np.ndarray, "poses 3"]
    ids: Int[np.ndarray, " n"]
    landmarks: Float[np.ndarray, "n 2"]
    squares: float
    dof: int


def smooth(steps: Iterable[Step], guess: History, sensor: LandmarkSensor) -> Optimum:
    r"""Return the batch optimum of a drive: nonlinear least squares over path and map.

    .. math::
        \min \sum_k \| (\ominus x_{k-1}) \oplus x_k - d_k \|^2_{Q_k}
        + \sum_{k, i} \| z_{k, i} - h(x_k, p_i) \|^2_{R_{k, i}}

    A filter keeps the Jacobians of the past; here all measurements are linearised anew at every
    iteration (Levenberg–Marquardt, sparse normal equations), so that nothing is invented. The pose
    at the start is taken as exact.

    Parameters
    ----------
    steps
        Motions of :class:`Odometry`, and observations of named landmarks; no fixes.
    guess
        A run of the filter over these steps, from which the search begins.
    sensor
        The sensor of the landmarks.

    Raises
    ------
    ValueError
        If there is no step, the guess is of another drive, a step has a fix or no motion by
        odometry, an observation names no landmark of the guess, a covariance is singular, or the
        search does not end.
    TypeError
        If the guess, a step or the sensor is of another type.

    References
    ----------
    Dellaert and Kaess, "Factor graphs for robot perception", 2017.
    """
    steps = checks.instances("steps", steps, Step)
    problem = _Problem(steps, checks.instance("guess", guess, History), checked_sensor(sensor))
    state, damping = problem.start, 1e-6
    squares, matrix, slope = problem.linearise(state)
    for _ in range(MOST):
        scale = sparse.diags(damping * matrix.diagonal())
        with checks.computable("steps and guess", RuntimeError):
            step = splu((matrix + scale).tocsc(), permc_spec="MMD_AT_PLUS_A").solve(slope)
        still = np.abs(step).max() <= STILL * (1 + np.abs(state).max())
        found = problem.linearise(state - step)
        if found[0] <= squares:
            still |= squares - found[0] <= NEAR * squares
            state, (squares, matrix, slope), damping = state - step, found, damping / 10
        else:
            damping *= 10
        if still:
            return problem.optimum(state, squares)
    raise ValueError(f"the search did not end within {MOST} linearisations")


class _Problem:
    """Residuals and Jacobians of a drive; the state is the poses after the steps, then the map."""

    def __init__(self, steps: Sequence[Step], guess: History, sensor: LandmarkSensor) -> None:
        if not steps or len(steps) != len(guess.poses):
            poses = len(guess.poses)
            raise ValueError(f"steps and guess must be of one drive, got {len(steps)} and {poses}")
        self.sensor, self.first, self.ids = sensor, guess.start, guess.belief.ids
        self.count = len(steps)
        self.start = np.concatenate([guess.poses.ravel(), guess.belief.landmarks.ravel()])
        slots = {name: i for i, name in enumerate(self.ids.tolist())}
        increments, noises, self.seen, roots = [], [], [], []
        for k, step in enumerate(steps):
            if not isinstance(step.motion, Odometry) or step.fixes:
                raise ValueError(f"step {k} must have a motion by odometry and no fixes")
            increments.append(step.motion.increment)
            noises.append(step.motion.noise)
            if step.observations is None or not len(step.observations):
                continue
            names = step.observations.ids.tolist()
            strange = [name for name in names if name not in slots]
            if strange:
                raise ValueError(f"step {k}: no landmark of the guess: {strange}")
            covs = checked_noises(step.observations, sensor)
            roots.append(np.broadcast_to(covs, (len(names), 2, 2)))
            self.seen.append((k, [slots[name] for name in names], step.observations.values))
        self.increments = np.array(increments)
        self.weights = _whitening("noise of a motion", np.array(noises))
        self.seen_weights = _whitening(
            "noise of an observation", np.concatenate(roots) if roots else np.empty((0, 2, 2))
        )

    def linearise(self, state: np.ndarray) -> tuple[float, sparse.csc_matrix, np.ndarray]:
        """Return the sum of squares, its curvature JᵀJ, and half its slope Jᵀr."""
        k, m = self.count, len(self.seen_weights)
        poses = np.vstack([self.first, state[: 3 * k].reshape(-1, 3)])
        points = state[3 * k :].reshape(-1, 2)
        moved, by_before, by_after = _between(poses)
        moved = moved - self.increments
        moved[:, 2] = wrap_angle(moved[:, 2])
        motion = (self.weights @ moved[..., None])[..., 0]
        parts = [
            _blocks(self.weights[1:] @ by_before[1:], 3 * np.arange(1, k), 3 * np.arange(k - 1)),
            _blocks(self.weights @ by_after, 3 * np.arange(k), 3 * np.arange(k)),
        ]
        observed = np.empty(0)
        if m:
            errors, by_pose, by_point, owners, places = self._errors(poses[1:], points)
            rows = 3 * k + 2 * np.arange(m)
            observed = (self.seen_weights @ errors[..., None])[..., 0].ravel()
            parts += [
                _blocks(self.seen_weights @ by_pose, rows, 3 * owners),
                _blocks(self.seen_weights @ by_point, rows, 3 * k + 2 * places),
            ]
        residuals = np.concatenate([motion.ravel(), observed])
        values, rows, columns = (np.concatenate(part) for part in zip(*parts, strict=True))
        shape = (residuals.size, state.size)
        jacobian = sparse.csr_matrix((values, (rows, columns)), shape)
        return float(residuals @ residuals), jacobian.T @ jacobian, jacobian.T @ residuals

    def _errors(self, poses: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return expected minus measured values, their Jacobians, and whose they are."""
        errors, by_pose, by_point, owners, places = [], [], [], [], []
        for k, slots, values in self.seen:
            expected, pose_part, point_part = self.sensor.expect(poses[k], points[slots])
            errors.append(-self.sensor.residual(values, expected))
            by_pose.append(pose_part)
            by_point.append(point_part)
            owners += [k] * len(slots)
            places += slots
        joined = (np.concatenate(part) for part in (errors, by_pose, by_point))
        return *joined, np.array(owners), np.array(places)

    def optimum(self, state: np.ndarray, squares: float) -> Optimum:
        """Return the result."""
        path = np.vstack([self.first, state[: 3 * self.count].reshape(-1, 3)])
        path[:, 2] = wrap_angle(path[:, 2])
        dof = 3 * self.count + 2 * len(self.seen_weights) - state.size
        return Optimum(path, self.ids, state[3 * self.count :].reshape(-1, 2), squares, dof)


def _whitening(name: str, covs: np.ndarray) -> np.ndarray:
    """Return the inverse roots of covariances."""
    try:
        return np.linalg.inv(np.linalg.cholesky(covs))
    except np.linalg.LinAlgError:
        raise ValueError(f"the {name} is singular: no weight follows from it") from None


def _between(poses: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the motions from pose to pose, and their derivatives by the two."""
    before, after = poses[:-1], poses[1:]
    c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
    x, y, turn = (after - before).T
    moved = np.stack([c * x + s * y, c * y - s * x, turn], axis=1)
    by_after = np.zeros((len(moved), 3, 3))
    by_after[:, 0, 0] = by_after[:, 1, 1] = c
    by_after[:, 0, 1], by_after[:, 1, 0] = s, -s
    by_after[:, 2, 2] = 1.0
    by_before = -by_after
    by_before[:, 0, 2], by_before[:, 1, 2] = moved[:, 1], -moved[:, 0]
    return moved, by_before, by_after


def _blocks(
    blocks: np.ndarray, rows: np.ndarray, columns: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return values, rows and columns of small dense blocks that begin where they are told."""
    _, high, wide = blocks.shape
    i, j = np.mgrid[:high, :wide]
    return blocks.ravel(), (rows[:, None, None] + i).ravel(), (columns[:, None, None] + j).ravel()
