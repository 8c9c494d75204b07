"""Homographies: what two pictures of one plane, or from one place, have to do with each other."""

import numpy as np
from jaxtyping import Float

from robot_perception import checks

SCALINGS = 3


def apply(
    homography: Float[np.ndarray, "... 3 3"], points: Float[np.ndarray, "... n 2"]
) -> Float[np.ndarray, "... n 2"]:
    r"""Return where a homography takes points.

    .. math:: \lambda \begin{bmatrix} p' \\ 1 \end{bmatrix} = H \begin{bmatrix} p \\ 1 \end{bmatrix}

    Parameters
    ----------
    homography : (…, 3, 3)
        H; its scale does not matter.
    points : (…, n, 2)
        Points, for instance pixels.

    Returns
    -------
    (…, n, 2)
        In the units of the other picture.

    Raises
    ------
    ValueError
        If the shapes do not fit, a number is not finite, a matrix is singular, or a point goes to
        infinity.
    """
    H = checks.array("homography", homography, (..., 3, 3))
    points = checks.array("points", points, (..., "n", 2))
    checks.check_batches(homography=H.shape[:-2], points=points.shape[:-2])
    condition = condition_number(H).max(initial=0.0)
    if condition > 1 / np.finfo(float).eps:
        raise ValueError(f"homography must not be singular, its condition is {condition:.3g}")
    images = points @ H[..., :2].mT + H[..., None, :, 2]
    scale = images[..., 2:]
    size = np.abs(points) @ np.abs(H[..., 2:, :2]).mT + np.abs(H[..., 2:, 2:])
    lost = np.count_nonzero(np.abs(scale) <= 8 * np.finfo(float).eps * size)
    if lost:
        raise ValueError(f"points must not go to infinity, got {lost} of {scale.size} that do")
    return images[..., :2] / scale


def condition_number(
    homography: Float[np.ndarray, "... 3 3"],
) -> Float[np.ndarray, "..."] | float:
    """Return how near homographies are to singular ones, in whatever units their points are.

    Where a matrix is badly conditioned in its own units, rows and columns are scaled until the
    largest entry of each is 1: millimetres in the coordinates of a map make no matrix singular.

    Parameters
    ----------
    homography : (…, 3, 3)
        Matrices.

    Returns
    -------
    (…)
        The quotients of largest and smallest singular values, infinite for singular ones.

    Raises
    ------
    ValueError
        If the shape is another, or a number is not finite.
    """
    H = checks.array("homography", homography, (..., 3, 3))
    found = np.linalg.cond(H)
    scaled = H
    for _ in range(SCALINGS):
        for axis in (-1, -2):
            largest = np.abs(scaled).max(axis=axis, keepdims=True)
            scaled = scaled / np.where(largest > 0, largest, 1.0)
    return np.minimum(found, np.linalg.cond(scaled))
