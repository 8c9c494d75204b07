"""Is a filter as uncertain as it should be? Normalised errors and their χ² bounds."""

import numpy as np
from jaxtyping import Float
from scipy import stats

from robot_perception.beliefs import check_covariance, check_finite


def normalised_squared(
    error: Float[np.ndarray, "... n"], cov: Float[np.ndarray, "... n n"]
) -> np.ndarray:
    r"""Return the squared length of an error in units of its covariance.

    .. math:: \epsilon = e^\top P^{-1} e

    With the estimation error and its covariance this is the NEES, with the innovation and its
    covariance the NIS. It is χ² with n degrees of freedom if the covariance is right.

    Parameters
    ----------
    error : (…, n)
        Estimate minus truth, or innovation.
    cov : (…, n, n)
        Its covariance; leading axes broadcast.

    Returns
    -------
    (…,)

    Raises
    ------
    ValueError
        If the shapes disagree, an entry is not finite, or a covariance is not positive definite.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation",
    2001, section 5.4.
    """
    error, cov = np.asarray(error, dtype=float), np.asarray(cov, dtype=float)
    n = error.shape[-1] if error.ndim else 0
    if n == 0 or cov.shape[-2:] != (n, n):
        raise ValueError(
            f"need errors (…, n) and covariances (…, n, n), got {error.shape}, {cov.shape}"
        )
    check_finite("error", error)
    check_covariance("cov", cov)
    try:
        factor = np.linalg.cholesky(cov)
    except np.linalg.LinAlgError:
        raise ValueError("cov must be positive definite, got a singular one") from None
    white = np.linalg.solve(factor, error[..., None])[..., 0]
    return np.asarray((white**2).sum(axis=-1))


def average_bounds(dimension: int, runs: int, level: float = 0.95) -> tuple[float, float]:
    r"""Return the range in which the average of normalised squared errors lies by chance.

    .. math:: \chi^2_{n r}\big((1 \mp \ell)/2\big) / r

    Parameters
    ----------
    dimension
        Degrees of freedom of one value, n.
    runs
        Number of independent values averaged, r.
    level
        Probability of the range.

    Returns
    -------
    low, high : float

    Raises
    ------
    ValueError
        If a count is below one or the level is not between 0 and 1.
    """
    if dimension < 1 or runs < 1:
        raise ValueError(f"dimension and runs must be at least 1, got {dimension}, {runs}")
    if not 0 < level < 1:
        raise ValueError(f"level must be between 0 and 1, got {level}")
    low, high = stats.chi2.ppf([(1 - level) / 2, (1 + level) / 2], dimension * runs) / runs
    return float(low), float(high)
