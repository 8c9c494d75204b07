"""Sensors: landmarks, anchors, the position, the heading; each a row block of one H."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.fields import checked
from robot_perception.slam.planar.sensors import CartesianSensor, LandmarkSensor, RangeBearing

Seen = tuple[np.ndarray, np.ndarray]

CARTESIAN = CartesianSensor(np.eye(2))
RANGE_BEARING = RangeBearing(np.eye(2))
"""Sensor of points. Observability asks what is seen, not how well: the noises do not matter."""


@runtime_checkable
class StateSensor(Protocol):
    """Something that measures the state."""

    def see(self, state: np.ndarray) -> Seen:
        """Return the measurement (m,) and its Jacobian (m, 3 + 2n)."""


@dataclass(frozen=True, slots=True)
class Landmarks:
    """All landmarks of the state, seen from the robot.

    Parameters
    ----------
    sensor
        How they are seen, for instance ``CARTESIAN`` or ``RANGE_BEARING``.
    """

    sensor: LandmarkSensor = CARTESIAN
    __post_init__ = checked

    def see(self, state: np.ndarray) -> Seen:
        """Return the measurement (2n,) and its Jacobian (2n, 3 + 2n)."""
        z, by_pose, by_point = self.sensor.expect(state[:3], state[3:].reshape(-1, 2))
        H = np.zeros((z.size, state.size))
        H[:, :3] = by_pose.reshape(-1, 3)
        for i, block in enumerate(by_point):
            H[2 * i : 2 * i + 2, 3 + 2 * i : 5 + 2 * i] = block
        return z.ravel(), H


def _number_or_symbol(name: str, value: Any) -> Any:
    if not hasattr(value, "free_symbols"):
        checks.number(f"{name} of an anchor", value)
    return value


@dataclass(frozen=True, slots=True)
class Anchor:
    """One point at a known place, seen from the robot; it is no part of the state.

    Parameters
    ----------
    x, y
        The place, m; symbols in the symbolic analyses.
    sensor
        How it is seen, for instance ``CARTESIAN`` or ``RANGE_BEARING``.
    """

    x: Annotated[Any, _number_or_symbol]
    y: Annotated[Any, _number_or_symbol]
    sensor: LandmarkSensor = CARTESIAN
    __post_init__ = checked

    def see(self, state: np.ndarray) -> Seen:
        """Return the measurement (2,) and its Jacobian (2, 3 + 2n), eqs (24) and (25)."""
        try:
            place = np.array([[float(self.x), float(self.y)]])
        except TypeError:
            raise TypeError(
                f"sensors see an anchor at a place in numbers, got {self.x}, {self.y}"
            ) from None
        z, by_pose, _ = self.sensor.expect(state[:3], place)
        return z[0], np.hstack([by_pose[0], np.zeros((2, state.size - 3))])


@dataclass(frozen=True, slots=True)
class Position:
    """A fixed sensor that measures where the robot is."""

    def see(self, state: np.ndarray) -> Seen:
        """Return the measurement (2,) and its Jacobian (2, 3 + 2n), eqs (26) and (27)."""
        return state[:2].copy(), np.eye(2, state.size)


@dataclass(frozen=True, slots=True)
class Heading:
    """A compass: a sensor of the heading."""

    def see(self, state: np.ndarray) -> Seen:
        """Return the measurement (1,) and its Jacobian (1, 3 + 2n)."""
        return state[2:3].copy(), np.eye(1, state.size, 2)


def see(
    sensors: Sequence[StateSensor], state: Float[np.ndarray, "states"]
) -> tuple[Float[np.ndarray, "m"], Float[np.ndarray, "m states"]]:
    """Return what all sensors measure, and the Jacobian H.

    Parameters
    ----------
    sensors
        At least one.
    state : (3 + 2n,)
        m, m, rad, then m.

    Raises
    ------
    ValueError
        If there is no sensor, the state is of another shape or not finite, or an anchor is not
        finite.
    """
    state = checked_state(state)
    sensors = checks.instances("sensors", sensors, StateSensor)
    if not sensors:
        raise ValueError("sensors are empty: there is no sensor")
    values, jacobians = zip(*(sensor.see(state) for sensor in sensors), strict=True)
    return np.concatenate(values), np.vstack(jacobians)


def checked_state(state: np.ndarray) -> np.ndarray:
    """Return a state (3 + 2n,) of finite numbers, or raise ``ValueError``."""
    state = checks.array("state", state)
    if state.ndim != 1 or state.size < 3 or state.size % 2 == 0:
        raise ValueError(f"state must be (3 + 2n,), got {state.shape}")
    return state
