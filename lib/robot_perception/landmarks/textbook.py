"""The same as in a textbook: one pair of descriptors at a time.

`Euclidean`, `Mahalanobis` and `match_stereo` give the same and are what everything else uses.
"""

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.landmarks.features import Features
from robot_perception.landmarks.stereo import StereoRules, check_both


def euclidean(d: Float[np.ndarray, " n"], mean: Float[np.ndarray, " n"]) -> float:
    r"""Return the squared Euclidean distance between two descriptors.

    .. math:: E = (d_i - d_j) (d_i - d_j)^\top

    Parameters
    ----------
    d, mean : (n,)
        The descriptors.

    Raises
    ------
    ValueError
        If the shapes disagree or a number is not finite.

    References
    ----------
    Gil et al. (2006), eq. (8).
    """
    d = checks.array("d", d, ("n",))
    mean = checks.array("mean", mean, d.shape, f"d {d.shape}")
    apart = d - mean
    return float(apart @ apart)


def mahalanobis(
    d: Float[np.ndarray, " n"], mean: Float[np.ndarray, " n"], variances: Float[np.ndarray, " n"]
) -> float:
    r"""Return the squared Mahalanobis distance from a descriptor to a class.

    .. math:: L = (d - \bar d_i) S_i^{-1} (d - \bar d_i)^\top

    Parameters
    ----------
    d : (n,)
        The descriptor.
    mean, variances : (n,)
        Mean and diagonal of the covariance of the class.

    Raises
    ------
    ValueError
        If the shapes disagree, a number is not finite or a variance not positive.

    References
    ----------
    Gil et al. (2006), eq. (9).
    """
    d = checks.array("d", d, ("n",))
    mean = checks.array("mean", mean, d.shape, f"d {d.shape}")
    variances = checks.array("variances", variances, d.shape, f"d {d.shape}")
    if variances.size and not variances.min() > 0:
        raise ValueError(f"variances must be positive, got {variances.min()}")
    apart = d - mean
    return float(np.sum(apart**2 / variances))


def match_stereo(left: Features, right: Features, rules: StereoRules) -> Int[np.ndarray, "pairs 2"]:
    """Return which features of a rectified pair are the same point, by all distances at once.

    Parameters
    ----------
    left, right
        Features of the two pictures.
    rules
        Rows, threshold and disparities.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If the descriptors of ``right`` are not of the same length as those of ``left``.

    References
    ----------
    Gil et al. (2006), §3.1.
    """
    check_both(left=left, right=right)
    least, most = checks.instance("rules", rules, StereoRules).disparities
    if not len(left) or not len(right):
        return np.empty((0, 2), dtype=int)
    disparity, offset = np.moveaxis(left.pixels[:, None] - right.pixels, -1, 0)
    apart = left.descriptors[:, None].astype(float) - right.descriptors
    distances = np.sqrt((apart**2).sum(axis=-1))
    distances[(np.abs(offset) > rules.rows) | (distances > rules.threshold)] = np.inf
    distances[(disparity < least) | (disparity > most)] = np.inf
    nearest, back = distances.argmin(axis=1), distances.argmin(axis=0)
    rows = np.arange(len(left))
    good = np.isfinite(distances[rows, nearest]) & (back[nearest] == rows)
    return np.stack([rows[good], nearest[good]], axis=1)
