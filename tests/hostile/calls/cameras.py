"""Valid calls of `cameras`."""

import numpy as np

from robot_perception import cameras
from tests.hostile.sweep import call

CAMERA = cameras.Pinhole((300.0, 310.0), (160.0, 120.0), (320, 240), (-0.2, 0.05, 1e-3, 0.0))
RIG = cameras.StereoRig(cameras.Pinhole((300.0, 300.0), (160.0, 120.0), (320, 240)), 0.1)
POINTS = np.array([[0.1, 0.2, 1.0], [-0.1, 0.0, 2.0]])
SEEN = np.array([[100.0, 20.0, 90.0], [150.0, 130.0, 149.0]])

CALLS = {
    cameras.level_mount: lambda: call(np.ones(3)),
    cameras.Pinhole: lambda: call((300.0, 310.0), (160.0, 120.0), (320, 240), (-0.2, 0.05, 0, 0)),
    cameras.Pinhole.project: lambda: call(CAMERA, POINTS),
    cameras.Pinhole.sees: lambda: call(CAMERA, POINTS),
    cameras.Pinhole.rays: lambda: call(CAMERA, SEEN[:, :2]),
    cameras.StereoRig: lambda: call(RIG.camera, 0.1),
    cameras.StereoRig.project: lambda: call(RIG, POINTS),
    cameras.StereoRig.triangulate: lambda: call(RIG, SEEN, 0.3),
}
