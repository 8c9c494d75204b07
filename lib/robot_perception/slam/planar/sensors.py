"""Sensors of the vehicle: landmarks in its own frame, its position, its heading."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.geometry import act, rotation
from robot_perception.observations import Observations
from robot_perception.slam.planar import kernels
from robot_perception.slam.planar.motions import checked_noise


@runtime_checkable
class LandmarkSensor(Protocol):
    """Interface of a sensor of landmarks; k observations at once."""

    noise: np.ndarray

    def expect(self, pose: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return expected values (k, 2), Jacobians by pose (k, 2, 3), by landmark (k, 2, 2)."""

    def residual(self, values: np.ndarray, expected: np.ndarray) -> np.ndarray:
        """Return measured minus expected values (k, 2), angles wrapped."""

    def locate(self, pose: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the points (k, 2) seen, the inverse of the expected values."""

    def locate_jacobians(
        self, pose: np.ndarray, points: np.ndarray, values: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of the points by the pose (k, 2, 3), by the values (k, 2, 2)."""

    def check(self, values: np.ndarray) -> None:
        """Raise ``ValueError`` if a value is outside the sensor's range."""


@dataclass(frozen=True, eq=False, slots=True)
class CartesianSensor:
    r"""Landmarks as points in the frame of the robot.

    .. math::
        h = R(\varphi)^\top (p - t), \qquad
        \frac{\partial h}{\partial x} = \big[-R^\top \;\big|\; -J h \;\big|\; R^\top\big]

    An anchor (eqs 24 and 25) is measured by the same sensor; its place is known.

    Parameters
    ----------
    noise : (2, 2)
        Covariance of one observation, m², unless the observations bring their own.
    """

    noise: Float[np.ndarray, "2 2"]

    def __post_init__(self) -> None:
        object.__setattr__(self, "noise", checked_noise("noise", self.noise, 2))

    def expect(self, pose: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return expected values (k, 2), Jacobians by pose (k, 2, 3), by landmark (k, 2, 2)."""
        return kernels.cartesian(pose, points)

    def residual(self, values: np.ndarray, expected: np.ndarray) -> np.ndarray:
        """Return measured minus expected values, m."""
        return values - expected

    def locate(self, pose: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the points seen, in the frame of the world: :math:`p = t + R z`."""
        return act(pose, values)

    def locate_jacobians(
        self, pose: np.ndarray, points: np.ndarray, values: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of the points by the pose (k, 2, 3), by the values (k, 2, 2)."""
        return _by_pose(pose, points), np.tile(rotation(pose[2]), (len(points), 1, 1))

    def check(self, values: np.ndarray) -> None:
        """Accept every point."""


@dataclass(frozen=True, eq=False, slots=True)
class RangeBearing:
    r"""Landmarks by distance and direction.

    .. math:: h = \big(|p - t| + b,\; \operatorname{atan2}(p - t) - \varphi\big)

    Parameters
    ----------
    noise : (2, 2)
        Covariance of (range, bearing), m and rad, unless they bring their own.
    range_bias
        b, m: how much too long the sensor measures.

    Raises
    ------
    ValueError
        If ``noise`` is no covariance or the bias is not finite; when used, if a measured range does
        not exceed the bias, or a landmark lies exactly at the robot, where its bearing has no
        derivative.
    """

    noise: Float[np.ndarray, "2 2"]
    range_bias: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "noise", checked_noise("noise", self.noise, 2))
        object.__setattr__(self, "range_bias", checks.number("range_bias", self.range_bias))

    def expect(self, pose: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return expected values (k, 2), Jacobians by pose (k, 2, 3), by landmark (k, 2, 2)."""
        h, by_pose, by_point, regular = kernels.range_bearing(pose, points, self.range_bias)
        if not regular:
            raise ValueError(f"a landmark lies exactly at the robot, {pose[:2].tolist()}")
        return h, by_pose, by_point

    def residual(self, values: np.ndarray, expected: np.ndarray) -> np.ndarray:
        """Return measured minus expected values, m and rad; bearings in [-π, π)."""
        return kernels.bearing_residual(values, expected)

    def locate(self, pose: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the points seen, in the frame of the world."""
        direction = pose[2] + values[:, 1]
        ray = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
        return pose[:2] + (values[:, :1] - self.range_bias) * ray

    def locate_jacobians(
        self, pose: np.ndarray, points: np.ndarray, values: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of the points by the pose (k, 2, 3), by the values (k, 2, 2)."""
        direction, reach = pose[2] + values[:, 1], values[:, 0] - self.range_bias
        c, s = np.cos(direction), np.sin(direction)
        by_value = np.stack([c, -reach * s, s, reach * c], axis=-1).reshape(-1, 2, 2)
        return _by_pose(pose, points), by_value

    def check(self, values: np.ndarray) -> None:
        """Raise ``ValueError`` if a range is negative or, less the bias, not ahead of the robot."""
        shortest = values[:, 0].min(initial=np.inf)
        if shortest < 0:
            raise ValueError(f"ranges must not be negative, got {shortest}")
        if shortest <= self.range_bias:
            raise ValueError(f"ranges must exceed the bias, {self.range_bias} m, got {shortest}")


def _by_pose(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return [I | J (p - t)] for each point: it moves and turns with the robot."""
    by_pose = np.zeros((len(points), 2, 3))
    by_pose[:, 0, 0] = by_pose[:, 1, 1] = 1.0
    by_pose[:, 0, 2] = pose[1] - points[:, 1]
    by_pose[:, 1, 2] = points[:, 0] - pose[0]
    return by_pose


def checked_sensor(sensor: LandmarkSensor) -> LandmarkSensor:
    """Return a sensor of landmarks, or raise ``TypeError``; a class is none."""
    known = type(sensor) in (CartesianSensor, RangeBearing)
    return sensor if known else checks.instance("sensor", sensor, LandmarkSensor)


def checked_noises(seen: Observations, sensor: LandmarkSensor) -> np.ndarray:
    """Return the noises of observations, (m, 2, 2) or (1, 2, 2) where one holds for all.

    Raises
    ------
    ValueError
        If the observations are not of two numbers each, or outside the sensor's range.
    """
    if seen.values.shape[1] != 2:
        raise ValueError(f"values of observations must be (m, 2), got {seen.values.shape}")
    sensor.check(seen.values)
    return sensor.noise[None] if seen.covs is None else seen.covs


@dataclass(frozen=True, eq=False, slots=True)
class PositionFix:
    r"""A measured position, as from a camera on the wall or a satellite: :math:`h = t`, eq. (26).

    Parameters
    ----------
    value : (2,)
        m.
    noise : (2, 2)
        Its covariance, m².
    """

    value: Float[np.ndarray, "2"]
    noise: Float[np.ndarray, "2 2"]

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", checks.vector("value", self.value, 2))
        object.__setattr__(self, "noise", checked_noise("noise", self.noise, 2))

    def matrix(self) -> Float[np.ndarray, "2 3"]:
        """Return the Jacobian by the pose, eq. (27)."""
        return np.eye(2, 3)

    def residual(self, pose: Float[np.ndarray, "3"]) -> Float[np.ndarray, "2"]:
        """Return measured minus expected position, m."""
        return self.value - pose[:2]

    def covariance(self) -> Float[np.ndarray, "2 2"]:
        """Return the noise as a matrix."""
        return self.noise


@dataclass(frozen=True, eq=False, slots=True)
class Compass:
    r"""A measured heading: :math:`h = \varphi`.

    Parameters
    ----------
    value
        rad, any turn.
    variance
        rad², not negative.
    """

    value: float
    variance: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", checks.number("value", self.value))
        object.__setattr__(self, "variance", checks.not_negative("variance", self.variance))

    def matrix(self) -> Float[np.ndarray, "1 3"]:
        """Return the Jacobian by the pose."""
        return np.array([[0.0, 0.0, 1.0]])

    def residual(self, pose: Float[np.ndarray, "3"]) -> Float[np.ndarray, "1"]:
        """Return measured minus expected heading, rad, in [-π, π)."""
        return np.array([kernels.wrapped(self.value - pose[2])])

    def covariance(self) -> Float[np.ndarray, "1 1"]:
        """Return the noise as a matrix."""
        return np.array([[self.variance]])


Fix = PositionFix | Compass
