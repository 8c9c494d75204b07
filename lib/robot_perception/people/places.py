"""Places of people about a robot, and the assignment between two lists of places."""

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import linear_sum_assignment

from robot_perception import checks


def points(polar: Float[np.ndarray, "... 2"]) -> Float[np.ndarray, "... 2"]:
    r"""Return the places of distances and directions in the frame of the robot, ahead and left, m.

    .. math:: (x, y) = (r \cos\varphi,\ r \sin\varphi)

    Parameters
    ----------
    polar : (..., 2)
        Distances r, m, and directions φ counter-clockwise from ahead, rad.

    Raises
    ------
    ValueError
        If they are no pairs, or a number is not finite or beyond 1e100.
    """
    r, phi = np.moveaxis(checks.array("polar", polar, (..., 2)), -1, 0)
    return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1)


def pairs_within(
    apart: Float[np.ndarray, "n m"], reach: float
) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
    r"""Return pairs of a row and a column that are within reach, each row and column at most once.

    They are as many as can be, and of those the ones that are nearest together:

    .. math:: \max |P|, \quad \text{then} \quad \min \sum_{(i, j) \in P} d_{ij}, \qquad
              d_{ij} \le d_{\max} .

    Parameters
    ----------
    apart : (n, m)
        How far the columns are from the rows, :math:`d`, in any unit; infinite for never.
    reach
        :math:`d_{\max}`, in the same unit.

    Returns
    -------
    (k,), (k,)
        Rows and columns.

    Raises
    ------
    ValueError
        If a distance is negative or NaN, or the reach is not positive and finite.
    """
    apart = checks.array("apart", apart, ("n", "m"), finite=False)
    reach = checks.positive("reach", reach)
    if not (apart >= 0).all():
        raise ValueError(f"apart must not be negative or NaN, got {apart[~(apart >= 0)][0]:g}")
    dear = 2.0 * (min(apart.shape) + 1)  # dearer than all pairs in reach together
    cost = np.where(apart <= reach, np.minimum(apart, reach) / reach, dear)
    i, j = linear_sum_assignment(cost)
    near = apart[i, j] <= reach
    return i[near], j[near]
