"""Scene that notebook, drawings and recordings share: a pattern's place and its walk."""

import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.tracker import TrackerRules

MIDDLE = (160.0, 120.0)
START = np.array([*MIDDLE, 0.0, 1.0])
"""Place of the patch in the first picture: the middle, as it was learnt."""
WINDOW = (64, 64)
"""Size of the pattern, px; ours."""
COORDINATES = ("x", "y", "θ", "s")
SIGMAS = np.array([5.0, 5.0, np.deg2rad(3.0), 0.1])
"""Deviations of the random walk, section 4.1: px, px, rad and 1."""
RULES = TrackerRules(sigmas=tuple(SIGMAS.tolist()))
"""200 particles, as in section 4.1; the paper leaves the spread of eq. (6) and the threshold of a
bad vector open, and both were chosen on patches that are not scored."""


def errors(
    estimate: Float[np.ndarray, "... 4"], truth: Float[np.ndarray, "... 4"]
) -> Float[np.ndarray, "... 4"]:
    """Return estimate minus truth in units of σ, angles taken round the circle."""
    away = np.asarray(estimate) - truth
    away[..., 2] = np.angle(np.exp(1j * away[..., 2]))
    return away / SIGMAS
