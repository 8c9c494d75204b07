r"""Rigid motions of space: homogeneous matrices (…, 4, 4), m; leading axes are batches, broadcast.

A pose T stands for the motion :math:`p \mapsto R\, p + t`, which takes points of its own frame to
the frame in which it is given: ``T_world_camera`` takes points of the camera to the world.
"""

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from robot_perception import checks
from robot_perception.geometry import se2

TOLERANCE = 1e-5
"""Allowed deviation of an entry of RᵀR from that of 1: files of six digits stay within."""


def compose(
    first: Float[np.ndarray, "... 4 4"], second: Float[np.ndarray, "... 4 4"]
) -> Float[np.ndarray, "... 4 4"]:
    r"""Return the pose reached by the first motion and then, in its frame, the second.

    .. math:: T_1 T_2 = (R_1 R_2,\; t_1 + R_1 t_2)

    Raises
    ------
    ValueError
        If a matrix is no rigid motion or the leading axes do not broadcast.
    """
    first, second = _pair(first=first, second=second)
    return first @ second


def inverse(pose: Float[np.ndarray, "... 4 4"]) -> Float[np.ndarray, "... 4 4"]:
    r"""Return the motion back.

    .. math:: T^{-1} = (R^\top,\; -R^\top t)

    Raises
    ------
    ValueError
        If a matrix is no rigid motion.
    """
    return _back(checked("pose", pose))


def between(
    first: Float[np.ndarray, "... 4 4"], second: Float[np.ndarray, "... 4 4"]
) -> Float[np.ndarray, "... 4 4"]:
    r"""Return the second pose as seen from the first: the motion that leads from one to the other.

    .. math:: T_1^{-1} T_2 = (R_1^\top R_2,\; R_1^\top (t_2 - t_1))

    Raises
    ------
    ValueError
        If a matrix is no rigid motion or the leading axes do not broadcast.
    """
    first, second = _pair(first=first, second=second)
    R = first[..., :3, :3].mT
    shift = second[..., :3, 3:] - first[..., :3, 3:]
    return _matrix(R @ second[..., :3, :3], (R @ shift)[..., 0])


def conjugated(
    motion: Float[np.ndarray, "... 4 4"], mount: Float[np.ndarray, "... 4 4"]
) -> Float[np.ndarray, "... 4 4"]:
    r"""Return a motion of a body as what is fixed to it at a mount makes it, in its own frame.

    .. math:: M^{-1}\, T\, M

    A robot whose camera sits at ``T_robot_camera`` moves the camera so; the inverse of the mount
    leads back, from the camera's motion to the robot's.

    Parameters
    ----------
    motion : (…, 4, 4)
        T, for instance T_before_now or T_now_before of a robot, m.
    mount : (…, 4, 4)
        M, for instance T_robot_camera, m.

    Raises
    ------
    ValueError
        If a matrix is no rigid motion or the leading axes do not broadcast.
    """
    motion, mount = _pair(motion=motion, mount=mount)
    return between(mount, motion @ mount)


def act(
    pose: Float[np.ndarray, "... 4 4"], points: Float[np.ndarray, "... n 3"]
) -> Float[np.ndarray, "... n 3"]:
    r"""Return points given in the frame of a pose in the frame in which the pose is given.

    .. math:: p_{world} = R\, p_{camera} + t

    Parameters
    ----------
    pose : (…, 4, 4)
        For instance that of a camera in the world, m.
    points : (…, n, 3)
        Points seen from that pose, m.

    Raises
    ------
    ValueError
        If a matrix is no rigid motion, the shapes do not fit or a number is not finite.
    """
    pose = checked("pose", pose)
    points = checks.array("points", points, (..., "n", 3))
    checks.check_batches(pose=pose.shape[:-2], points=points.shape[:-2])
    return points @ pose[..., :3, :3].mT + pose[..., None, :3, 3]


def exp(twist: Float[np.ndarray, "... 6"]) -> Float[np.ndarray, "... 4 4"]:
    r"""Return where a constant velocity leads in unit time.

    .. math::
        T = \begin{bmatrix} e^{\hat\omega} & V v \\ 0 & 1 \end{bmatrix}, \qquad
        V = I + \frac{1 - \cos\theta}{\theta^2} \hat\omega
              + \frac{\theta - \sin\theta}{\theta^3} \hat\omega^2, \qquad
        \theta = \lVert \omega \rVert

    Parameters
    ----------
    twist : (…, 6)
        Velocity v, m, and then the rotation vector ω, rad; both in the moving frame.

    Raises
    ------
    ValueError
        If the last axis is not 6, or a number is not finite or beyond 1e100.
    """
    twist = checks.array("twist", twist, (..., 6))
    v, omega = twist[..., :3], twist[..., 3:].copy()  # SciPy writes to no array, but asks for it
    R = Rotation.from_rotvec(omega.reshape(-1, 3)).as_matrix().reshape(*omega.shape, 3)
    return _matrix(R, (_mean_rotation(omega) @ v[..., None])[..., 0])


def log(pose: Float[np.ndarray, "... 4 4"]) -> Float[np.ndarray, "... 6"]:
    r"""Return the twist that leads to a pose, the inverse of `exp`.

    Parameters
    ----------
    pose : (…, 4, 4)
        A rigid motion.

    Returns
    -------
    (…, 6)
        Velocity v, m, and rotation vector ω, rad, of a length up to π.

    Raises
    ------
    ValueError
        If a matrix is no rigid motion.
    """
    pose = checked("pose", pose)
    R, t = pose[..., :3, :3], pose[..., :3, 3:]
    omega = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec().reshape(R.shape[:-1])
    v = np.linalg.solve(_mean_rotation(omega), t)[..., 0]
    return np.concatenate([v, omega], axis=-1)


def from_se2(pose: Float[np.ndarray, "... 3"], height: float = 0.0) -> Float[np.ndarray, "... 4 4"]:
    """Return a pose (x, y, φ) of the plane as one of space, in which z points up.

    Parameters
    ----------
    pose : (…, 3)
        Position and heading, m and rad.
    height
        Of the plane, the z of the pose, m.

    Raises
    ------
    ValueError
        If the last axis is not 3 or a number is not finite.
    """
    pose = checks.array("pose", pose, (..., 3))
    T = np.zeros((*pose.shape[:-1], 4, 4))
    T[..., :2, :2] = se2.rotation(pose[..., 2])
    T[..., :2, 3] = pose[..., :2]
    T[..., 2, 3] = checks.number("height", height)
    T[..., 2, 2] = T[..., 3, 3] = 1
    return T


def checked(name: str, pose: Float[np.ndarray, "... 4 4"]) -> Float[np.ndarray, "... 4 4"]:
    """Return rigid motions as an array.

    Parameters
    ----------
    name
        What a message calls them.
    pose : (…, 4, 4)
        Homogeneous matrices; six digits are enough.

    Raises
    ------
    ValueError
        If a matrix is not (4, 4), not finite, its last row is not (0, 0, 0, 1), or its first three
        rows and columns are no rotation.
    """
    checks.instance("name", name, str)
    T = checks.array(name, pose, (..., 4, 4))
    if (T[..., 3, :] != [0, 0, 0, 1]).any():
        raise ValueError(f"{name} must have the last row (0, 0, 0, 1)")
    R = T[..., :3, :3]
    far = np.abs(R.mT @ R - np.eye(3)).max(initial=0.0)
    if far > TOLERANCE or (np.linalg.det(R) < 0).any():
        what = f"RᵀR differs from 1 by {far:.3g}" if far > TOLERANCE else "there is a reflection"
        raise ValueError(f"{name} must hold rotations, but {what}")
    return T


def _pair(**motions: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return two motions, checked, whose leading axes fit."""
    found = {name: checked(name, T) for name, T in motions.items()}
    checks.check_batches(**{name: T.shape[:-2] for name, T in found.items()})
    return tuple(found.values())


def _back(pose: np.ndarray) -> np.ndarray:
    R = pose[..., :3, :3].mT
    return _matrix(R, -(R @ pose[..., :3, 3:])[..., 0])


def _matrix(R: np.ndarray, t: np.ndarray) -> np.ndarray:
    T = np.zeros((*R.shape[:-2], 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, t, 1
    return T


def _mean_rotation(omega: np.ndarray) -> np.ndarray:
    """Return V: the mean of the rotations by s ω over s from 0 to 1."""
    x, y, z = np.moveaxis(omega, -1, 0)
    hat = np.zeros((*omega.shape, 3))
    hat[..., 0, 1], hat[..., 0, 2], hat[..., 1, 2] = -z, y, -x
    hat -= hat.mT
    theta = np.linalg.norm(omega, axis=-1)[..., None, None]
    small = theta < 1e-4  # where the cube would underflow long before the quotient matters
    safe = np.where(small, 1.0, theta)
    third = np.where(small, 1 / 6, (safe - np.sin(safe)) / safe**3)
    return np.eye(3) + np.sinc(theta / (2 * np.pi)) ** 2 / 2 * hat + third * hat @ hat
