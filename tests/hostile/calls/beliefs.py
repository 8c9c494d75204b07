"""Valid calls of `beliefs`."""

import numpy as np

from robot_perception import beliefs
from tests.hostile.sweep import call

CALLS = {
    beliefs.Gaussian: lambda: call(np.zeros(2), np.eye(2)),
    beliefs.ParticleSet: lambda: call(np.ones((3, 2)), np.zeros(3)),
    beliefs.ParticleSet.uniform: lambda: call(np.ones((3, 2))),
    beliefs.normalise: lambda: call(np.zeros(3)),
}
