"""Motion models: odometry increments, or speed and turn rate held for a while."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.fields import NotNegative, checked
from robot_perception.geometry import rotation
from robot_perception.slam.planar import kernels
from robot_perception.streams import Held


def checked_noise(name: str, value: np.ndarray, size: int) -> np.ndarray:
    """Return one small covariance as a new array, in a tenth of the time of `checks.covariance`."""
    array = checks.array(name, value, (size, size), finite=False).copy()
    if not kernels.is_covariance(array[None], 1e-9):
        raise ValueError(
            f"{name} must be finite, symmetric, positive semi-definite, got {array.tolist()}"
        )
    return array


@dataclass(frozen=True, eq=False, slots=True)
class Odometry:
    r"""A measured motion in the frame of the robot.

    .. math:: t' = t + R(\varphi)\,(d_x, d_y)^\top, \qquad \varphi' = \varphi + d_\varphi

    Parameters
    ----------
    increment : (3,)
        :math:`(d_x, d_y, d_\varphi)`, m, m, rad.
    noise : (3, 3)
        Covariance of the increment.

    Raises
    ------
    ValueError
        If a shape is wrong, a number not finite, or ``noise`` no covariance.
    """

    increment: Float[np.ndarray, "3"]
    noise: Float[np.ndarray, "3 3"]

    def __post_init__(self) -> None:
        object.__setattr__(self, "increment", checks.vector("increment", self.increment, 3))
        object.__setattr__(self, "noise", checked_noise("noise", self.noise, 3))

    @property
    def increment_cov(self) -> Float[np.ndarray, "3 3"]:
        """Covariance of the increment in the frame of the robot."""
        return self.noise

    def move(self, pose: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3"]:
        """Return the pose after the motion, heading in [-π, π)."""
        return _moved(pose, self.increment)

    def jacobians(
        self, pose: Float[np.ndarray, "3"]
    ) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3 3"]]:
        """Return the derivatives of :meth:`move` by the pose and by the increment."""
        return _jacobians(pose, self.increment)


@dataclass(frozen=True, eq=False, slots=True)
class Velocity:
    r"""Speed and turn rate, held for a while: the robot drives an arc.

    .. math::
        d = v T \Big(\frac{\sin a}{a}, \frac{1 - \cos a}{a}\Big), \qquad
        d_\varphi = a = \omega T

    and then as :class:`Odometry`.

    Parameters
    ----------
    speed
        v, m/s.
    turn_rate
        ω, rad/s.
    duration
        T, s, not negative.
    noise : (2, 2)
        Covariance of (v, ω), held as long as they are.

    Raises
    ------
    ValueError
        If a number is not finite, the duration negative, or ``noise`` no covariance.
    """

    speed: float
    turn_rate: float
    duration: NotNegative
    noise: Float[np.ndarray, "2 2"]
    increment: Float[np.ndarray, "3"] = field(init=False)
    increment_cov: Float[np.ndarray, "3 3"] = field(init=False)

    def __post_init__(self) -> None:
        checked(self)
        object.__setattr__(self, "noise", checked_noise("noise", self.noise, 2))
        increment, by_command = kernels.arc(self.speed, self.turn_rate, self.duration)
        object.__setattr__(self, "increment", increment)
        object.__setattr__(self, "increment_cov", by_command @ self.noise @ by_command.T)

    def move(self, pose: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3"]:
        """Return the pose after the motion, heading in [-π, π)."""
        return _moved(pose, self.increment)

    def jacobians(
        self, pose: Float[np.ndarray, "3"]
    ) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3 2"]]:
        """Return the derivatives of :meth:`move` by the pose and by (v, ω)."""
        F, G = _jacobians(pose, self.increment)
        _, by_command = kernels.arc(self.speed, self.turn_rate, self.duration)
        return F, G @ by_command


PlanarMotion = Odometry | Velocity
"""Motion of a robot in the plane since the step before."""


def dead_reckoning(
    start: Float[np.ndarray, "3"], motions: Iterable[PlanarMotion | None]
) -> Float[np.ndarray, "poses 3"]:
    """Return the poses by the motions alone, (k + 1, 3) with the start; ``None`` is no motion.

    Parameters
    ----------
    start : (3,)
        m, m, rad.
    motions
        One after the other.
    """
    poses = [checks.vector("start", start, 3)]
    for motion in checks.instances("motions", motions, Odometry, Velocity, type(None)):
        poses.append(poses[-1] if motion is None else motion.move(poses[-1]))
    return np.array(poses)


def compound(
    held: Held, density: Float[np.ndarray, "2"]
) -> tuple[Float[np.ndarray, "intervals 3"], Float[np.ndarray, "intervals 3 3"]]:
    r"""Return the motion over each interval and its covariance.

    Arcs are joined one to the other in the frame in which the interval began. The noise of (v, ω)
    is white: over a piece of length T its variance is the density over T. What piece j does to the
    end of the interval is

    .. math::
        \frac{\partial t_e}{\partial v_j} = R_j \frac{\partial d_j}{\partial v}, \qquad
        \frac{\partial t_e}{\partial \omega_j} = R_j \frac{\partial d_j}{\partial \omega}
        + T_j J (t_e - t_{j+1})

    so that the filter's result is the same as if it had taken the pieces one by one.

    Parameters
    ----------
    held
        Pieces of constant speed (m/s) and turn rate (rad/s).
    density : (2,)
        Variance per second of distance (m²/s) and of turn (rad²/s).

    Returns
    -------
    increments : (intervals, 3)
    covs : (intervals, 3, 3)

    Raises
    ------
    ValueError
        If the commands are not two numbers each, or the density is negative or not finite.
    """
    checks.instance("held", held, Held)
    if held.commands.shape[1] != 2:
        raise ValueError(f"commands held must be (pieces, 2), got {held.commands.shape}")
    density = checks.vector("density", density, 2)
    if density.min() < 0:
        raise ValueError(f"density must not be negative, got {density.tolist()}")
    speed, rate = held.commands.T
    duration = held.durations
    turn = rate * duration
    chord = (duration * np.sinc(turn / (2 * np.pi)))[:, None]
    by_speed = chord * np.stack([np.cos(turn / 2), np.sin(turn / 2)], axis=1)
    by_rate = (speed * duration**2)[:, None] * _arc_slope(turn)
    interval = held.intervals
    first = np.flatnonzero(np.diff(interval, prepend=-1))
    heading = _before(turn, first, interval)
    R = rotation(heading)
    part = (R @ (speed[:, None] * by_speed)[..., None])[..., 0]
    end = np.add.reduceat(part, first, axis=0)
    x, y = (end[interval] - _before(part, first, interval) - part).T  # t_e - t_{j+1}
    by_noise = np.zeros((len(turn), 3, 2))
    by_noise[:, :2, 0] = (R @ by_speed[..., None])[..., 0]
    by_noise[:, :2, 1] = (R @ by_rate[..., None])[..., 0] + duration[:, None] * np.stack([-y, x], 1)
    by_noise[:, 2, 1] = duration
    root = by_noise * np.sqrt(density / duration[:, None])[:, None, :]
    covs = np.add.reduceat(root @ root.mT, first, axis=0)
    return np.column_stack([end, np.add.reduceat(turn, first)]), (covs + covs.mT) / 2


def _arc_slope(turn: np.ndarray) -> np.ndarray:
    """Return the derivative of (sin a, 1 - cos a) / a; by its series where a is small."""
    small = np.abs(turn) < 1e-3
    a = np.where(small, 1.0, turn)
    x = (a * np.cos(a) - np.sin(a)) / a**2
    y = (a * np.sin(a) + np.cos(a) - 1) / a**2
    return np.stack([np.where(small, -turn / 3, x), np.where(small, 0.5 - turn**2 / 8, y)], axis=1)


def _before(values: np.ndarray, first: np.ndarray, interval: np.ndarray) -> np.ndarray:
    """Return for each piece the sum over the pieces of its interval that come before it."""
    so_far = np.cumsum(values, axis=0) - values
    return so_far - so_far[first][interval]


def _moved(pose: np.ndarray, increment: np.ndarray) -> np.ndarray:
    moved = checks.vector("pose", pose, 3)
    kernels.move(moved, increment)
    return moved


def _jacobians(pose: np.ndarray, increment: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    _, _, heading = checks.vector("pose", pose, 3)
    F, G = np.eye(3), np.eye(3)
    G[:2, :2] = rotation(heading)
    dx, dy = G[:2, :2] @ increment[:2]
    F[:2, 2] = -dy, dx  # J R d
    return F, G
