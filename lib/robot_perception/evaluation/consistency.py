"""Is a filter as uncertain as it should be? Normalised errors and their χ² bounds."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.special import betaincinv

from robot_perception import checks
from robot_perception.gating import chi_squared_quantile


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
    error = checks.array("error", error, (..., "n"))
    n = error.shape[-1]
    if n == 0:
        raise ValueError(f"error must be (…, n) with n >= 1, got {error.shape}")
    cov = checks.covariance("cov", cov, (..., n, n), f"error {error.shape}")
    checks.check_batches(error=error.shape[:-1], cov=cov.shape[:-2])
    white = np.linalg.solve(_cholesky(cov), error[..., None])[..., 0]
    return np.asarray((white**2).sum(axis=-1))


def _cholesky(cov: np.ndarray) -> np.ndarray:
    """Return the Cholesky factors of covariances, or raise an error that names them."""
    try:
        return np.linalg.cholesky(cov)
    except np.linalg.LinAlgError:
        raise ValueError("cov must be positive definite, got a singular one") from None


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
        If a count is no whole number of at least 1 or the level is not between 0 and 1.
    """
    low, high = _bounds(checks.whole("dimension", dimension, 1), runs, level)
    return float(low), float(high)


@dataclass(frozen=True, eq=False, slots=True)
class Coverage:
    """Normalised squared errors of several runs beside what chance allows.

    Parameters
    ----------
    averages : (steps,)
        Average over the runs at each step.
    low, high : (steps,)
        χ² bounds of that average.
    averaged_share
        Share of the steps whose average lies within its bounds; the level if the filter is right.
    single_share
        Share of all single values that do not exceed the χ² quantile of the level.
    single_interval
        Binomial (Clopper-Pearson) 95 % interval of that share.
    """

    averages: Float[np.ndarray, " steps"]
    low: Float[np.ndarray, " steps"]
    high: Float[np.ndarray, " steps"]
    averaged_share: float
    single_share: float
    single_interval: tuple[float, float]


def coverage(
    values: Float[np.ndarray, "runs steps"],
    dimension: int | Int[np.ndarray, " steps"],
    level: float = 0.95,
    *,
    independent: int | None = None,
) -> Coverage:
    r"""Compare the NEES or NIS of runs with the χ² distribution a consistent filter gives them.

    The average of r independent runs at one step lies within
    :math:`\chi^2_{n r}((1 \mp \ell)/2) / r` with probability ℓ, a single value below
    :math:`\chi^2_n(\ell)` likewise.

    Parameters
    ----------
    values : (runs, steps)
        Normalised squared errors.
    dimension
        Their degrees of freedom n: one number, or one for each step.
    level
        The probability ℓ.
    independent
        How many of the values count as independent in the binomial interval. All do by default,
        which is right for a correct filter's NIS; the errors of one run hang together, so that for
        NEES the number of runs is the cautious choice.

    Raises
    ------
    ValueError
        If there is no value, one is negative or not finite, a count is no whole number of at least
        1 or does not fit, or the level is not between 0 and 1.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan 2001 (see `normalised_squared`), section 5.4.
    """
    values = checks.array("values", values, ("runs", "steps"))
    if not values.size:
        raise ValueError(f"values must be (runs, steps) and hold some, got {values.shape}")
    if values.min() < 0:
        raise ValueError(f"values are squares, got {values.min():.6g}")
    runs, steps = values.shape
    dimension = checks.integers("dimension", dimension, least=1)
    if dimension.shape not in {(), (steps,)}:
        raise ValueError(f"dimension must be one or {steps} numbers, got {dimension.shape}")
    count = values.size
    if independent is not None:
        count = checks.whole("independent", independent, 1, values.size)
    low, high = (np.broadcast_to(bound, steps) for bound in _bounds(dimension, runs, level))
    averages = values.mean(axis=0)
    share = float(np.mean(values <= chi_squared_quantile(level, dimension)))
    return Coverage(
        averages,
        low,
        high,
        averaged_share=float(np.mean((low <= averages) & (averages <= high))),
        single_share=share,
        single_interval=_share_interval(share, count),
    )


def _bounds(
    dimension: int | np.ndarray, runs: int, level: float
) -> tuple[float | np.ndarray, float | np.ndarray]:
    """Return the two quantiles of the average of χ² values, for one or many dimensions."""
    level = checks.level("level", level)
    freedom = np.asarray(dimension) * checks.whole("runs", runs, 1)
    return tuple(
        chi_squared_quantile(p, freedom) / runs for p in ((1 - level) / 2, (1 + level) / 2)
    )


def _share_interval(share: float, count: int) -> tuple[float, float]:
    """Return the Clopper-Pearson 95 % interval of a share of a count, which may be no integer."""
    hits = share * count
    low = betaincinv(hits, count - hits + 1, 0.025) if hits > 0 else 0.0
    high = betaincinv(hits + 1, count - hits, 0.975) if hits < count else 1.0
    return float(low), float(high)
