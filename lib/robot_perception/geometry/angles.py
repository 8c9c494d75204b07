"""Angles."""

import numpy as np

from robot_perception import checks


def wrap_angle(angle: float | np.ndarray) -> float | np.ndarray:
    """Return angles brought into the range from -π (included) to π, rad.

    An angle already there is returned as it is, to the last bit.

    Raises
    ------
    ValueError
        If an angle is not finite.
    """
    angle = checks.array("angle", angle)
    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    wrapped = np.where(wrapped < np.pi, wrapped, -np.pi)  # just below -π rounding gives π
    return np.where((angle >= -np.pi) & (angle < np.pi), angle, wrapped)[()]
