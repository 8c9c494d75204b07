"""Angles, and scans that go all the way round."""

import numpy as np
from jaxtyping import Float

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


OVERLAP = 1e-3
"""Angle by which a turn of single-precision beams may be longer than a turn, rad."""


def closes(angles: Float[np.ndarray, " n"]) -> bool:
    """Tell whether the last beam of a scan stands beside the first, as in a full turn.

    So it is where the gap between them is at most one and a half times the usual gap between beams.
    The last may point the same way as the first.

    Parameters
    ----------
    angles : (n,)
        Directions of the beams, rising, rad.

    Raises
    ------
    ValueError
        If the angles are not finite or do not rise over at most one turn.
    """
    angles = check_turn(angles)
    if len(angles) < 3:
        return False
    return bool(2 * np.pi - (angles[-1] - angles[0]) <= 1.5 * np.median(np.diff(angles)))


def check_turn(angles: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Return directions of beams; raise unless they are finite and rise over at most one turn."""
    angles = checks.array("angles", angles, ("n",))
    if (np.diff(angles) <= 0).any():
        raise ValueError("angles must be strictly increasing")
    if angles.size and angles[-1] - angles[0] > 2 * np.pi + OVERLAP:
        raise ValueError(f"angles span {angles[-1] - angles[0]:.3f} rad, more than one turn")
    return angles
