"""Beliefs: what a robot knows about a state."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


def check_finite(name: str, value: np.ndarray) -> None:
    """Raise ``ValueError`` naming ``name`` if an entry of ``value`` is NaN or infinite."""
    bad = np.count_nonzero(~np.isfinite(value))
    if bad:
        raise ValueError(
            f"{name} must be finite, got {bad} of {np.size(value)} entries that are not"
        )


def check_covariance(name: str, cov: np.ndarray, *, tolerance: float = 1e-9) -> None:
    """Raise ``ValueError`` unless every ``(…, n, n)`` matrix is symmetric positive semi-definite.

    The tolerance is relative to the largest entry of each matrix.
    """
    if cov.ndim < 2 or cov.shape[-1] != cov.shape[-2]:
        raise ValueError(f"{name} must be (…, n, n), got {cov.shape}")
    check_finite(name, cov)
    if cov.shape[-1] == 0:
        return
    scale = np.maximum(np.abs(cov).max(axis=(-2, -1)), np.finfo(float).tiny)
    asymmetry = (np.abs(cov - cov.mT).max(axis=(-2, -1)) / scale).max(initial=0.0)
    if asymmetry > tolerance:
        raise ValueError(f"{name} must be symmetric, relative asymmetry is {asymmetry:.3g}")
    lowest = (np.linalg.eigvalsh(cov)[..., 0] / scale).min(initial=0.0)
    if lowest < -tolerance:
        raise ValueError(
            f"{name} must be positive semi-definite, smallest relative eigenvalue is {lowest:.3g}"
        )


@dataclass(frozen=True, eq=False, slots=True)
class Gaussian:
    r"""Normal distribution :math:`\mathcal N(\mu, P)`, or a batch of them.

    Parameters
    ----------
    mean : (…, n)
        Means, in the units of the state.
    cov : (…, n, n)
        Covariances; leading axes broadcast against those of ``mean`` (one covariance may serve a
        whole batch of means).

    Raises
    ------
    ValueError
        If the shapes disagree, an entry is not finite, or a covariance is not symmetric positive
        semi-definite.
    """

    mean: Float[np.ndarray, "*batch n"]
    cov: Float[np.ndarray, "*covs n n"]

    def __post_init__(self) -> None:
        mean, cov = np.asarray(self.mean, dtype=float), np.asarray(self.cov, dtype=float)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "cov", cov)
        if mean.ndim < 1:
            raise ValueError(f"mean must be (…, n), got {mean.shape}")
        n = mean.shape[-1]
        if cov.shape[-2:] != (n, n):
            raise ValueError(f"cov must be (…, {n}, {n}) for mean {mean.shape}, got {cov.shape}")
        np.broadcast_shapes(mean.shape[:-1], cov.shape[:-2])
        check_finite("mean", mean)
        check_covariance("cov", cov)
