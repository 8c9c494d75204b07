"""Valid calls of `geometry`."""

import numpy as np

from robot_perception import geometry
from tests.hostile.sweep import call

POSE = np.array([1.0, 2.0, 3.0])

CALLS = {
    geometry.wrap_angle: lambda: call(4.0),
    geometry.rotation: lambda: call(0.5),
    geometry.compose: lambda: call(POSE, POSE),
    geometry.inverse: lambda: call(POSE),
    geometry.between: lambda: call(POSE, POSE),
    geometry.act: lambda: call(POSE, np.ones((4, 2))),
}
