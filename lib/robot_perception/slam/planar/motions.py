"""How the vehicle moves: odometry increments, or speed and turn rate held for a while."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from robot_perception.slam.planar import kernels


def turn(angle: float) -> Float[np.ndarray, "2 2"]:
    """Return the rotation matrix R of an angle, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def checked_vector(name: str, value: np.ndarray, size: int) -> np.ndarray:
    """Return ``size`` finite numbers as an array, or raise ``ValueError``."""
    array = np.array(value, dtype=float)
    if array.shape != (size,):
        raise ValueError(f"{name} must be ({size},), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {array.tolist()}")
    return array


def checked_noise(name: str, value: np.ndarray, size: int) -> np.ndarray:
    """Return a covariance of ``size`` entries as an array, or raise ``ValueError``."""
    array = np.array(value, dtype=float)
    if array.shape != (size, size):
        raise ValueError(f"{name} must be ({size}, {size}), got {array.shape}")
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
        object.__setattr__(self, "increment", checked_vector("increment", self.increment, 3))
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
    duration: float
    noise: Float[np.ndarray, "2 2"]
    increment: Float[np.ndarray, "3"] = field(init=False)
    increment_cov: Float[np.ndarray, "3 3"] = field(init=False)

    def __post_init__(self) -> None:
        given = np.array([self.speed, self.turn_rate, self.duration], dtype=float)
        speed, rate, duration = checked_vector("speed, turn_rate, duration", given, 3)
        if duration < 0:
            raise ValueError(f"duration must not be negative, got {duration}")
        object.__setattr__(self, "noise", checked_noise("noise", self.noise, 2))
        increment, by_command = kernels.arc(speed, rate, duration)
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


Motion = Odometry | Velocity


def _moved(pose: np.ndarray, increment: np.ndarray) -> np.ndarray:
    moved = checked_vector("pose", pose, 3)
    kernels.move(moved, increment)
    return moved


def _jacobians(pose: np.ndarray, increment: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    _, _, heading = checked_vector("pose", pose, 3)
    F, G = np.eye(3), np.eye(3)
    G[:2, :2] = turn(heading)
    dx, dy = G[:2, :2] @ increment[:2]
    F[:2, 2] = -dy, dx  # J R d
    return F, G
