"""Angles and planar rigid motions."""

import numpy as np
from jaxtyping import Float


def wrap_angle(angle: float | np.ndarray) -> float | np.ndarray:
    """Return angles brought into the range from -π (included) to π, rad."""
    return (np.asarray(angle, dtype=float) + np.pi) % (2 * np.pi) - np.pi


def transform(
    pose: Float[np.ndarray, "... 3"], points: Float[np.ndarray, "... n 2"]
) -> Float[np.ndarray, "... n 2"]:
    r"""Return points given in the frame of a pose in the frame of the world.

    .. math:: p_{world} = R(\varphi)\, p_{robot} + t

    Parameters
    ----------
    pose
        Position and heading (x, y, φ), m and rad.
    points
        Points seen from that pose, m; leading axes broadcast.

    Raises
    ------
    ValueError
        If the last axes are not 3 and 2.
    """
    pose, points = np.asarray(pose, dtype=float), np.asarray(points, dtype=float)
    if pose.shape[-1:] != (3,) or points.shape[-1:] != (2,):
        raise ValueError(f"need poses (…, 3) and points (…, n, 2): {pose.shape}, {points.shape}")
    cos, sin = np.cos(pose[..., 2, None]), np.sin(pose[..., 2, None])
    x, y = points[..., 0], points[..., 1]
    turned = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    return turned + pose[..., None, :2]
