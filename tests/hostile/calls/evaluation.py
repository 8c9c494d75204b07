"""Valid calls of `evaluation`."""

import numpy as np

from robot_perception.evaluation import consistency, spatial, trajectories
from robot_perception.geometry import se3
from tests.hostile.sweep import call

RNG = np.random.default_rng(0)
TRUTH = np.cumsum(RNG.uniform(0, 1, (6, 3)), axis=0)
PATH = TRUTH + 0.1
POSES = se3.exp(np.cumsum(RNG.uniform(0, 0.3, (6, 6)), axis=0))


CALLS = {
    consistency.normalised_squared: lambda: call(np.ones((4, 2)), np.eye(2)),
    consistency.average_bounds: lambda: call(2, 10, 0.95),
    consistency.coverage: lambda: call(np.ones((3, 4)), 2, 0.95, independent=3),
    trajectories.align: lambda: call(PATH, TRUTH),
    trajectories.absolute_error: lambda: call(PATH, TRUTH, aligned=True),
    trajectories.end_error: lambda: call(PATH, TRUTH),
    trajectories.relative_error: lambda: call(PATH, TRUTH, 2),
    trajectories.relative_error_over: lambda: call(PATH, TRUTH, 0.5),
    trajectories.pairs_over: lambda: call(TRUTH, 0.5),
    trajectories.relative_poses: lambda: call(PATH, np.array([[0, 1], [2, 5]])),
    trajectories.motion_errors: lambda: call(PATH, TRUTH),
    spatial.Similarity.act: lambda: call(spatial.align(PATH, TRUTH, True), PATH),
    spatial.Similarity.move: lambda: call(spatial.align(PATH, TRUTH, True), POSES),
    spatial.associate: lambda: call(np.arange(4.0), np.arange(3.0), 0.5),
    spatial.align_poses: lambda: call(POSES, POSES, "sim3"),
    spatial.align: lambda: call(PATH, TRUTH, True),
    spatial.absolute_error: lambda: call(PATH, TRUTH),
    spatial.relative_error: lambda: call(POSES, POSES, 2),
    spatial.relative_error_over: lambda: call(POSES, POSES, 0.2),
}
