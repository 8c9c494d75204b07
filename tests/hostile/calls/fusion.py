"""Valid calls of `fusion`."""

import numpy as np

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from tests.hostile.sweep import Call, call

A = Gaussian(np.array([1.0, 3.0]), np.diag([0.1, 0.4]))
B = Gaussian(np.array([1.2, -3.0]), np.diag([0.5, 0.2]))
PART = 0.05 * np.eye(2)


def weighed() -> Call:
    return call(A, B, 0.3, angles=(1,))


CALLS = {
    fusion.intersection_by_inverses: lambda: call(A, B, 0.3),
    fusion.covariance_intersection: weighed,
    fusion.inverse_covariance_intersection: weighed,
    fusion.kalman_fusion: lambda: call(A, B, angles=(1,)),
    fusion.split_covariance_intersection: lambda: call(A, B, PART, PART, 0.3, angles=(1,)),
    fusion.omega_determinants: lambda: call(A, B),
    fusion.omega_least_determinant: lambda: call(A, B),
    fusion.omega_least_trace: lambda: call(A, B),
}
