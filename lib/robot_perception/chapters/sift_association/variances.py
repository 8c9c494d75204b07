"""What a variance from few descriptors is worth: the law behind eq. (9)."""

import numpy as np

LENGTH = 128


def expected_distance(p: int) -> float:
    r"""Return the mean of L of the right class of p descriptors, were all normal and independent.

    .. math:: \frac{(d - \bar d)^2}{s^2} \sim \left(1 + \frac 1p\right) F_{1,\,\nu}, \quad
        \mathrm E\,L = 128 \left(1 + \frac 1p\right) \frac{\nu}{\nu - 2}, \quad \nu = p - 1

    It is infinite up to p = 3; with the variance known it would be 128 (1 + 1/p).
    """
    nu = p - 1
    return LENGTH * (1 + 1 / p) * nu / (nu - 2) if nu > 2 else np.inf


def variance_spread(p: int) -> float:
    r"""Return the relative standard deviation of a variance from p descriptors.

    .. math:: \sqrt{\operatorname{var} s^2} / \sigma^2 = \sqrt{2 / (p - 1)}
    """
    return float(np.sqrt(2 / (p - 1)))
