"""Valid calls of `gating`."""

import numpy as np

from robot_perception import gating
from tests.hostile.sweep import call

PAIRS = np.array([[0, 0], [0, 1], [1, 1]])

CALLS = {
    gating.chi_squared_quantile: lambda: call(0.9, 2),
    gating.gate: lambda: call(0.9, 2),
    gating.nearest_neighbours: lambda: call(np.array([[1.0, 2.0], [0.5, np.inf]]), 9.0),
    gating.joint_compatibility: lambda: call(
        PAIRS, 0.1 * np.ones((3, 2)), np.eye(6), np.array([9.0, 13.0, 17.0])
    ),
}
