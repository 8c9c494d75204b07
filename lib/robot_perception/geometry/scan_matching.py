r"""Motion of a scanner between two scans of a room, from the scans alone.

Iterated closest points: each point of the later scan is compared with the line through the points
of the earlier one about its nearest, and the motion that brings them together by least squares
follows; what lies far off, such as somebody who walks, counts for little.

Where a room looks the same from several places, as a long corridor does, it does not tell them
apart: the component along it stays what was guessed.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.geometry import se2

NEIGHBOURS = 6  # points that a line is laid through
FIRST, LAST, SHRINKS = 0.5, 0.1, 0.9  # distances of points that belong together, m
STEPS, ENOUGH = 30, 1e-5  # of the iteration; m and rad
LEAST = 30  # points that belong together
SPREAD = 0.01  # m, least distance that counts as far off
WEAK = 1e-6  # by so much the guess holds what the scans leave open


class ScanMatch(NamedTuple):
    """A motion that brings two scans together.

    Parameters
    ----------
    motion : (3,)
        Pose of the scanner at the later scan as seen from that at the earlier one, m and rad.
    residual
        Median distance of points from their lines, m.
    share
        Of the later scan's points that have a partner.
    """

    motion: Float[np.ndarray, "3"]
    residual: float
    share: float


def match_scans(
    before: Float[np.ndarray, "n 2"],
    now: Float[np.ndarray, "m 2"],
    guess: Float[np.ndarray, "3"] | None = None,
) -> ScanMatch | None:
    r"""Return the motion of a scanner between two scans; nothing if too little is alike.

    .. math:: \min_T \sum_i w_i \left( n_i^\top (T p_i - q_i) \right)^2

    where :math:`q_i` is the nearest point to :math:`T p_i` and :math:`n_i` is normal to the line
    there; the weight :math:`w` of a residual r falls as :math:`1 / (1 + r^2 / s^2)`.

    Parameters
    ----------
    before, now : (n, 2), (m, 2)
        Points of both scans, each in the frame of its scanner, m.
    guess : (3,)
        The motion, m and rad; none if not given. It must be right to some tenths of a metre and of
        a radian.

    Raises
    ------
    ValueError
        If a shape is another, or a number is not finite.

    References
    ----------
    Chen and Medioni, "Object modelling by registration of multiple range images", Image and Vision
    Computing 10(3), 1992; Censi, "An ICP variant using a point-to-line metric", ICRA 2008.
    """
    from scipy.spatial import cKDTree

    before, now = checks.array("before", before, ("n", 2)), checks.array("now", now, ("m", 2))
    pose = np.zeros(3) if guess is None else checks.array("guess", guess, (3,)).copy()
    if min(len(before), len(now)) < LEAST:
        return None
    tree, reach = cKDTree(before), FIRST
    around = before[tree.query(before, NEIGHBOURS)[1]]
    apart = around - around.mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(apart.mT @ apart)[1][:, :, 0]
    for _ in range(STEPS):
        moved = se2.act(pose, now)
        distance, nearest = tree.query(moved, distance_upper_bound=reach)
        near = np.isfinite(distance)
        if near.sum() < LEAST:
            return None
        nearest, (x, y) = nearest[near], (moved[near] - pose[:2]).T
        n = normals[nearest]
        residuals = ((before[nearest] - moved[near]) * n).sum(axis=1)
        middle = float(np.median(np.abs(residuals)))
        weights = 1 / (1 + (residuals / max(1.5 * middle, SPREAD)) ** 2)
        J = np.stack([n[:, 0], n[:, 1], n[:, 1] * x - n[:, 0] * y], axis=-1)
        A = (J * weights[:, None]).T @ J
        step = np.linalg.solve(A + WEAK * np.trace(A) * np.eye(3), J.T @ (weights * residuals))
        pose += step
        if np.abs(step).max() < ENOUGH:
            break
        reach = max(SHRINKS * reach, LAST)
    return ScanMatch(pose, middle, float(near.mean()))


def follow_scans(scans: Iterable[Float[np.ndarray, "n 2"]]) -> Float[np.ndarray, "scans 3"]:
    """Return the pose of a scanner at each scan, m and rad, from its first one.

    A scan that tells no motion is taken to go on as the one before.

    Parameters
    ----------
    scans
        Points (n, 2) of each, in the frame of the scanner, m.

    Raises
    ------
    TypeError
        If the scans cannot be gone through.
    ValueError
        As `match_scans`.
    """
    poses, motion, before = [], np.zeros(3), None
    for k, scan in enumerate(checks.iterable("scans", scans)):
        now = checks.array(f"scan {k + 1} of scans", scan, ("n", 2))
        found = None if before is None else match_scans(before, now, motion)
        motion = motion if found is None else found.motion
        poses.append(se2.compose(poses[-1], motion) if poses else np.zeros(3))
        before = now
    return np.array(poses).reshape(-1, 3)
