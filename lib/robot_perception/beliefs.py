"""Beliefs: what a robot knows about a state, as a normal distribution or as weighted samples."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks

FAR = 1e8
"""A logarithm is so far from 0 that a sum with another one loses more than eight digits."""


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


@dataclass(frozen=True, eq=False, slots=True)
class ParticleSet:
    r"""A belief as weighted samples, or a batch of such sets.

    .. math:: p(x) \approx \sum_{i=1}^{M} \omega_i \, \delta(x - x_i), \qquad \sum_i \omega_i = 1

    The weights are kept as logarithms, because products of many likelihoods soon leave the range
    of floating point; they are brought to sum 1 here.

    Parameters
    ----------
    states : (…, M, n)
        The samples :math:`x_i`, in the units of the state.
    log_weights : (…, M)
        Logarithms of the weights :math:`\omega_i`, but for a constant; -inf is a weight of 0.
        Leading axes broadcast against those of ``states``.

    Raises
    ------
    ValueError
        If the shapes disagree, there is no particle, a state is not finite, a logarithm is NaN or
        infinite, or all weights of a set are 0.
    """

    states: Float[np.ndarray, "*batch m n"]
    log_weights: Float[np.ndarray, "*sets m"]

    def __post_init__(self) -> None:
        states = checks.array("states", self.states, (..., "m", "n"))
        m, beside = states.shape[-2], f"states {states.shape}"
        if m == 0:
            raise ValueError(f"states must hold at least one particle, got {states.shape}")
        log_weights = checks.array("log_weights", self.log_weights, (..., m), beside, finite=False)
        checks.check_batches(states=states.shape[:-2], log_weights=log_weights.shape[:-1])
        object.__setattr__(self, "states", states)
        object.__setattr__(self, "log_weights", normalise(log_weights)[0])

    @classmethod
    def uniform(cls, states: Float[np.ndarray, "*batch m n"]) -> "ParticleSet":
        """Return samples of one weight, in the units of the state."""
        states = checks.array("states", states, (..., "m", "n"))
        return cls(states, np.zeros(states.shape[-2]))

    @property
    def weights(self) -> Float[np.ndarray, "*sets m"]:
        """Weights, which sum to 1."""
        return np.exp(self.log_weights)

    @property
    def mean(self) -> Float[np.ndarray, "*batch n"]:
        r"""Mean :math:`\sum_i \omega_i x_i`; means of angles are the caller's."""
        return (self.weights[..., None, :] @ self.states)[..., 0, :]

    @property
    def cov(self) -> Float[np.ndarray, "*batch n n"]:
        r"""Covariance :math:`\sum_i \omega_i (x_i - \mu)(x_i - \mu)^\top`."""
        scaled = np.sqrt(self.weights)[..., None] * (self.states - self.mean[..., None, :])
        return scaled.mT @ scaled


def normalise(
    log_weights: Float[np.ndarray, "*sets m"],
) -> tuple[Float[np.ndarray, "*sets m"], Float[np.ndarray, "*sets"]]:
    r"""Return weights brought to sum 1, and their sum before; all as logarithms, without overflow.

    .. math:: \log \sum_i e^{\ell_i} = \ell_{\max} + \log \sum_i e^{\ell_i - \ell_{\max}}

    Parameters
    ----------
    log_weights : (…, M)
        :math:`\ell_i`; -inf is a weight of 0.

    Returns
    -------
    (…, M)
        :math:`\ell_i - \log \sum_j e^{\ell_j}`; far from 0 as
        :math:`(\ell_i - \ell_{\max}) - \log \sum_j e^{\ell_j - \ell_{\max}}`.
    (…,)
        The logarithms of the sums.

    Raises
    ------
    ValueError
        If there is no weight, a logarithm is NaN or infinite, or all weights of a set are 0.
    """
    log_weights = checks.array("log_weights", log_weights, (..., "m"), finite=False)
    if log_weights.shape[-1] == 0:
        raise ValueError(f"log_weights must hold at least one weight, got {log_weights.shape}")
    highest = log_weights.max(axis=-1, keepdims=True)
    if not np.isfinite(highest).all():
        bad = np.count_nonzero(np.isnan(log_weights) | (log_weights == np.inf))
        if bad:
            size = log_weights.size
            raise ValueError(f"log_weights must be finite or -inf, got {bad} of {size} otherwise")
        empty = np.count_nonzero(highest == -np.inf)
        raise ValueError(f"log_weights must not all be -inf, got {empty} of {highest.size} sets so")
    below = log_weights - highest
    more = np.log(np.exp(below).sum(axis=-1, keepdims=True))
    log_sums = highest + more
    # far from 0 the sum is rounded by more than ``more``; nearer, recorded results stay bit by bit
    found = np.where(np.abs(highest) > FAR, below - more, log_weights - log_sums)
    return found, log_sums[..., 0]
