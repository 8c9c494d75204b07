r"""Rigid motions of the plane: poses (x, y, φ) in m and rad; leading axes are batches, broadcast.

A pose T stands for the motion :math:`p \mapsto R(\varphi)\, p + t`, which takes points of its own
frame to the frame in which it is given. Headings that come out are in [-π, π).
"""

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.geometry.angles import wrap_angle

Numbers = float | np.ndarray


def rotation(angle: float | Float[np.ndarray, "..."]) -> Float[np.ndarray, "... 2 2"]:
    r"""Return the rotation matrix of an angle in rad, or of each of many.

    .. math::
        R(\varphi) = \begin{bmatrix} \cos\varphi & -\sin\varphi \\ \sin\varphi & \cos\varphi
        \end{bmatrix}

    Raises
    ------
    ValueError
        If an angle is not finite.
    """
    angle = checks.array("angle", angle)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)


def compose(
    first: Float[np.ndarray, "... 3"], second: Float[np.ndarray, "... 3"]
) -> Float[np.ndarray, "... 3"]:
    r"""Return the pose reached by the first motion and then, in its frame, the second.

    .. math:: T_1 T_2 = (t_1 + R(\varphi_1)\, t_2,\; \varphi_1 + \varphi_2)

    Raises
    ------
    ValueError
        If a last axis is not 3, other axes do not broadcast, or a number is not finite.
    """
    first, second = _poses(first, second)
    x, y = _turned(first[..., 2], second[..., 0], second[..., 1])
    heading = wrap_angle(first[..., 2] + second[..., 2])
    return np.stack([first[..., 0] + x, first[..., 1] + y, heading], axis=-1)


def inverse(pose: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
    r"""Return the motion back.

    .. math:: T^{-1} = (-R(\varphi)^\top t,\; -\varphi)

    Raises
    ------
    ValueError
        If the last axis is not 3 or a number is not finite.
    """
    pose = checks.array("pose", pose, (..., 3))
    x, y = _turned(-pose[..., 2], -pose[..., 0], -pose[..., 1])
    return np.stack([x, y, wrap_angle(-pose[..., 2])], axis=-1)


def between(
    first: Float[np.ndarray, "... 3"], second: Float[np.ndarray, "... 3"]
) -> Float[np.ndarray, "... 3"]:
    r"""Return the second pose as seen from the first: the motion that leads from one to the other.

    .. math:: T_1^{-1} T_2 = (R(\varphi_1)^\top (t_2 - t_1),\; \varphi_2 - \varphi_1)

    Raises
    ------
    ValueError
        If a last axis is not 3, other axes do not broadcast, or a number is not finite.
    """
    first, second = _poses(first, second)
    x, y, turn = np.moveaxis(second - first, -1, 0)
    return np.stack([*_turned(-first[..., 2], x, y), wrap_angle(turn)], axis=-1)


def act(
    pose: Float[np.ndarray, "... 3"], points: Float[np.ndarray, "... n 2"]
) -> Float[np.ndarray, "... n 2"]:
    r"""Return points given in the frame of a pose in the frame in which the pose is given.

    .. math:: p_{world} = R(\varphi)\, p_{robot} + t

    Parameters
    ----------
    pose
        Position and heading, m and rad.
    points
        Points seen from that pose, m.

    Raises
    ------
    ValueError
        If the last axes are not 3 and 2, others do not broadcast, or a number is not finite.
    """
    pose = checks.array("pose", pose, (..., 3))
    points = checks.array("points", points, (..., "n", 2))
    checks.check_batches(pose=pose.shape[:-1], points=points.shape[:-2])
    turned = _turned(pose[..., 2, None], points[..., 0], points[..., 1])
    return np.stack(turned, axis=-1) + pose[..., None, :2]


def _turned(angle: Numbers, x: Numbers, y: Numbers) -> tuple[Numbers, Numbers]:
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * x - sin * y, sin * x + cos * y


def _poses(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    first, second = checks.array("first", first, (..., 3)), checks.array("second", second, (..., 3))
    checks.check_batches(first=first.shape[:-1], second=second.shape[:-1])
    return first, second
