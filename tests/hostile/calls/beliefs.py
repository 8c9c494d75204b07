"""Valid calls of `beliefs`."""

import numpy as np

from robot_perception.beliefs import Gaussian
from tests.hostile.sweep import call

CALLS = {Gaussian: lambda: call(np.zeros(2), np.eye(2))}
