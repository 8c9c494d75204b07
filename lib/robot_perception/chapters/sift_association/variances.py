r"""What a variance from few descriptors is worth: the law behind eq. (9).

Let an entry of a descriptor be normal with variance :math:`\sigma^2`, and the class made of p of
them. A new descriptor of the same landmark has

.. math:: \frac{(d - \bar d)^2}{s^2} \sim \left(1 + \frac 1p\right) F_{1,\,p-1},
    \qquad \mathrm E\, L = 128 \left(1 + \frac 1p\right) \frac{p - 1}{p - 3},

which is infinite up to p = 3; with the variance known it would be 128 (1 + 1/p).
"""

import numpy as np
from jaxtyping import Float

from robot_perception import checks

LENGTH = 128


def expected_distance(p: int, freedom: float = 0.0) -> float:
    r"""Return the mean of L of the right class, were all entries normal and independent.

    .. math:: \mathrm E\,L = 128 \left(1 + \frac 1p\right) \frac{\nu}{\nu - 2}, \quad
        \nu = p - 1 + \nu_0

    Parameters
    ----------
    p
        Descriptors in the class.
    freedom
        Degrees of freedom :math:`\nu_0` lent by a prior that happens to be right.

    Raises
    ------
    ValueError
        If p is less than 2.
    """
    nu = checks.whole("p", p, 2) - 1 + checks.not_negative("freedom", freedom)
    return LENGTH * (1 + 1 / p) * nu / (nu - 2) if nu > 2 else np.inf


def variance_spread(p: int) -> float:
    r"""Return the relative standard deviation of a variance from p descriptors.

    .. math:: \sqrt{\operatorname{var} s^2} / \sigma^2 = \sqrt{2 / (p - 1)}
    """
    return float(np.sqrt(2 / (checks.whole("p", p, 2) - 1)))


def right_share(
    p: int,
    gap: float,
    rivals: int,
    *,
    known: bool = False,
    runs: int = 400,
    rng: np.random.Generator,
) -> float:
    r"""Return how often the right class has the least L among equally noisy rivals.

    Every entry of every class has the same variance 1, so that a perfect estimate would make
    eq. (9) the same as eq. (8): what is lost is lost to the estimate of the variance.

    Parameters
    ----------
    p
        Descriptors in each class.
    gap
        Distance of the rivals' means, in standard deviations of an entry.
    rivals
        How many other classes.
    known
        Whether the variance is known rather than estimated.
    runs
        How many descriptors.
    rng
        Source of the descriptors.
    """
    won = 0
    for _ in range(runs):
        away = rng.standard_normal((rivals + 1, LENGTH))
        away *= gap / np.linalg.norm(away, axis=1, keepdims=True)
        away[0] = 0
        means = away + rng.standard_normal(away.shape) / np.sqrt(p)
        variances = np.ones_like(means) if known else rng.chisquare(p - 1, means.shape) / (p - 1)
        found = rng.standard_normal(LENGTH)
        won += int((((found - means) ** 2) / variances).sum(axis=1).argmin() == 0)
    return won / runs


def zero_share(stacks: Float[np.ndarray, "n p d"]) -> float:
    """Return the share of the entries that are the same number in all p descriptors."""
    return float((stacks == stacks[:, :1]).all(axis=1).mean())
