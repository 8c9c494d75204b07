"""Beliefs: what a robot knows about a state."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks


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
        mean = checks.array("mean", self.mean, (..., "n"))
        n = mean.shape[-1]
        cov = checks.covariance("cov", self.cov, (..., n, n), f"mean {mean.shape}")
        checks.check_batches(mean=mean.shape[:-1], cov=cov.shape[:-2])
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "cov", cov)
