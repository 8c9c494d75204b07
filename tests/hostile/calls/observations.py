"""Valid calls of `observations`."""

import numpy as np

from robot_perception.observations import Observations, unnamed
from tests.hostile.sweep import call

SEEN = Observations(np.array([3, -1]), np.ones((2, 2)))
COVS = np.stack([np.eye(2), np.eye(2)])

CALLS = {
    Observations: lambda: call(np.array([3, -1]), np.ones((2, 2)), COVS),
    Observations.named: lambda: call(SEEN, np.array([5, 6])),
    Observations.anonymous: lambda: call(SEEN),
    unnamed: lambda: call(np.ones((2, 2)), COVS),
}
