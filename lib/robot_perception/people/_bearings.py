"""Directions of people whose distance is not known."""

import numpy as np
from jaxtyping import Float

from robot_perception.beliefs import Gaussian
from robot_perception.people.detections import polar

DISTANCE, RANGE_SIGMA = 2.0, 2.0
"""Mean and standard deviation of the distance of somebody who may stand anywhere near, m."""


def bearings(
    phi: Float[np.ndarray, " n"],
    phi_sigma: Float[np.ndarray, " n"],
    distance: float,
    range_sigma: float,
) -> Gaussian:
    r"""Return positions :math:`(r, \varphi)` in some directions, with one distance for all."""
    return polar(np.full(len(phi), distance), phi, range_sigma, phi_sigma)
