"""Reports of the wheels, as a camera and as the filter take them."""

import numpy as np
from jaxtyping import Float

from data_synth import wheels
from robot_perception.geometry import se3
from robot_perception.slam.planar import Odometry


def moved(
    report: wheels.Odometry, T_robot_camera: Float[np.ndarray, "4 4"]
) -> Float[np.ndarray, "frames 4 4"]:
    """Return T_now_before of the camera at each frame, as the wheels report it."""
    increments = np.concatenate([np.zeros((1, 3)), report.increments])
    return se3.conjugated(se3.inverse(se3.from_se2(increments)), T_robot_camera)


def motions(report: wheels.Odometry) -> list[Odometry]:
    """Return what the wheels report as the filter takes it."""
    return [
        Odometry(increment, np.diag(sigma**2))
        for increment, sigma in zip(report.increments, report.deviations, strict=True)
    ]
