"""Valid calls of `geometry`."""

import numpy as np

from robot_perception import geometry
from robot_perception.geometry import homographies, scan_matching, se3
from tests.hostile.sweep import call

POSE = np.array([1.0, 2.0, 3.0])
SPACE = se3.exp(np.linspace(0.1, 0.6, 6))
SCAN = np.stack([np.linspace(0, 3, 60), np.repeat([1.0, 2.0], 30)], axis=1)

CALLS = {
    geometry.wrap_angle: lambda: call(4.0),
    geometry.closes: lambda: call(np.linspace(-3.0, 3.0, 40)),
    geometry.rotation: lambda: call(0.5),
    geometry.compose: lambda: call(POSE, POSE),
    geometry.inverse: lambda: call(POSE),
    geometry.between: lambda: call(POSE, POSE),
    geometry.act: lambda: call(POSE, np.ones((4, 2))),
    homographies.condition_number: lambda: call(np.eye(3)),
    homographies.apply: lambda: call(
        np.array([[1.0, 0, 2], [0, 1, 3], [0, 1e-3, 1]]), np.ones((4, 2))
    ),
    scan_matching.match_scans: lambda: call(SCAN, SCAN, POSE / 100),
    scan_matching.follow_scans: lambda: call([SCAN, SCAN]),
    se3.compose: lambda: call(SPACE, SPACE),
    se3.inverse: lambda: call(SPACE),
    se3.between: lambda: call(SPACE, SPACE),
    se3.conjugated: lambda: call(SPACE, SPACE),
    se3.act: lambda: call(SPACE, np.ones((4, 3))),
    se3.exp: lambda: call(np.ones(6)),
    se3.log: lambda: call(SPACE),
    se3.from_se2: lambda: call(POSE, 1.0),
    se3.checked: lambda: call("pose", SPACE),
}
