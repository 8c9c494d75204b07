r"""Scores of a segmentation against the tracked shape: three shares from 0 to 1, and a weight.

.. math::
    \rho = \mu_1 (1 - \Phi_{affine}) + \mu_2 (1 - \Phi_{area}) + \mu_3 (1 - \Phi_{quality}), \qquad
    \pi = e^{-\rho^2 / 2 \sigma^2}

Leading axes are batches, and those of areas, scores and weights broadcast.

References
----------
Andrade-Cetto, "Perception issues in mobile robotics", section 3.3. The paper gives neither the
weights μ nor σ nor the slope of :math:`\Phi_{quality}`.
"""

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.appearance._masks import Mask, check_mask

__all__ = [
    "affine_similarity",
    "area_congruence",
    "area_difference",
    "log_weight",
    "predicted_area",
    "quality",
    "rho",
    "weight",
]

Values = float | Float[np.ndarray, "..."]


def affine_similarity(boundary: Mask, outline: Float[np.ndarray, "*sets n 2"]) -> Values:
    r"""Return the share of an outline's points that lie on a boundary.

    .. math:: \Phi_{affine} = \frac{1}{N_r} \sum_i \nabla S(u_i, v_i)

    Parameters
    ----------
    boundary : (height, width)
        True on the edges of a segmentation.
    outline : (…, n, 2)
        Points (u, v), px, rounded to the nearest pixel. Those beyond the image are on no boundary.

    Raises
    ------
    TypeError
        If the boundary is no mask.
    ValueError
        If it is empty, there is no point, or one is not finite.
    """
    boundary = check_mask("boundary", boundary)
    points = checks.array("outline", outline, (..., "n", 2))
    if not points.size:
        raise ValueError(f"outline must have points, got {points.shape}")
    height, width = boundary.shape
    inside = ((points > -0.5) & (points < [width - 0.5, height - 0.5])).all(axis=-1)
    u, v = np.moveaxis(np.rint(np.where(inside[..., None], points, 0)).astype(int), -1, 0)
    return np.mean(boundary[v, u] & inside, axis=-1)[()]


def predicted_area(last: Values, before: Values, momentum: float = 1.0) -> Values:
    r"""Return the area expected next if it goes on changing, at least 0.

    .. math:: \tilde A_t = A_{t-1} + \mu (A_{t-1} - A_{t-2})

    Parameters
    ----------
    last, before : (…)
        Areas :math:`A_{t-1}` and :math:`A_{t-2}`, px².
    momentum
        μ; the paper names no value.

    Raises
    ------
    ValueError
        If an area is negative or not finite, or the momentum is not finite.
    """
    last, before = _areas(last=last, before=before)
    momentum = checks.number("momentum", momentum)
    if abs(momentum) > 1e6:
        raise ValueError(f"momentum must be at most a million, got {momentum:g}")
    return np.maximum(last + momentum * (last - before), 0.0)[()]


def area_difference(predicted: Values, found: Values) -> Values:
    r"""Return the :math:`\Phi_{area}` that the paper prints: 0 for a perfect match.

    .. math:: \Phi_{area} = \frac{|\tilde A - A|}{\max \{\tilde A, A\}}

    As :math:`\rho` takes the match to be the better the nearer it is to 1, this rewards an area
    that is wrong; `area_congruence` is 1 less it.

    Parameters
    ----------
    predicted, found : (…)
        Areas :math:`\tilde A` and A, px²; not both 0.

    Raises
    ------
    ValueError
        If an area is negative or not finite, or both are 0.
    """
    predicted, found = _areas(predicted=predicted, found=found)
    larger = np.maximum(predicted, found)
    if not (larger > 0).all():
        raise ValueError("predicted or found must be positive, got 0 for both")
    return (np.abs(predicted - found) / larger)[()]


def area_congruence(predicted: Values, found: Values) -> Values:
    r"""Return the :math:`\Phi_{area}` that works: 1 for a perfect match.

    .. math::
        \Phi_{area} = 1 - \frac{|\tilde A - A|}{\max \{\tilde A, A\}}
        = \frac{\min \{\tilde A, A\}}{\max \{\tilde A, A\}}

    Parameters
    ----------
    predicted, found : (…)
        Areas :math:`\tilde A` and A, px²; not both 0.

    Raises
    ------
    ValueError
        If an area is negative or not finite, or both are 0.
    """
    return 1.0 - area_difference(predicted, found)


def quality(euler: int | Int[np.ndarray, "..."], slope: float = 0.2) -> Values:
    r"""Return how free of holes a segmentation is: linear in its Euler number E, cut to [0, 1].

    .. math:: \Phi_{quality} = 1 - s (1 - E)

    Parameters
    ----------
    euler : (…)
        Euler number: 1 for one piece without a hole, 1 less for each hole.
    slope
        s, what a hole costs; our choice, as the paper says no more than that it is linear.

    Raises
    ------
    ValueError
        If a number is not whole, or the slope is not from 0 to 1.
    """
    found = checks.integers("euler", euler, (...,))
    slope = checks.share("slope", slope)
    return np.clip(1.0 - slope * (1.0 - found), 0.0, 1.0)[()]


def rho(
    affine: Values,
    area: Values,
    quality: Values,
    importance: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Values:
    r"""Return how bad a segmentation is: 0 if all three scores are 1.

    .. math::
        \rho = \mu_1 (1 - \Phi_{affine}) + \mu_2 (1 - \Phi_{area}) + \mu_3 (1 - \Phi_{quality})

    Parameters
    ----------
    affine, area, quality : (…)
        The scores, each from 0 to 1.
    importance
        :math:`\mu_1, \mu_2, \mu_3`, none negative.

    Raises
    ------
    ValueError
        If a score is not from 0 to 1, an importance is negative or not finite, or the shapes do not
        broadcast.
    """
    scores = {"affine": affine, "area": area, "quality": quality}
    scores = {name: checks.array(name, value) for name, value in scores.items()}
    for name, value in scores.items():
        if ((value < 0) | (value > 1)).any():
            raise ValueError(f"{name} must be from 0 to 1, got {checks.shown(value.tolist())}")
    checks.check_batches(**{name: value.shape for name, value in scores.items()})
    parts = checks.vector("importance", importance, 3)
    if (parts < 0).any() or parts.max() > 1e6:
        raise ValueError(f"importance must be from 0 to a million, got {parts.tolist()}")
    return sum(mu * (1.0 - value) for mu, value in zip(parts, scores.values(), strict=True))[()]


def log_weight(rho: Values, sigma: float) -> Values:
    r"""Return the logarithm of a weight, :math:`-\rho^2 / 2 \sigma^2`.

    Parameters
    ----------
    rho : (…)
        ρ, none negative.
    sigma
        σ: of this ρ the weight is :math:`e^{-1/2}`.

    Raises
    ------
    ValueError
        If a ρ is negative or not finite, or σ is not positive or too small for a finite result.
    """
    found = checks.array("rho", rho)
    if (found < 0).any():
        raise ValueError(f"rho must not be negative, got {found.min():g}")
    sigma = checks.positive("sigma", sigma)
    with np.errstate(over="ignore"):
        result = -0.5 * (found / sigma) ** 2
    if not np.isfinite(result).all():
        raise ValueError(f"rho must be within reach of sigma {sigma:g}, got {found.max():g}")
    return result[()]


def weight(rho: Values, sigma: float) -> Values:
    r"""Return the weight of a sample, :math:`\pi = e^{-\rho^2 / 2 \sigma^2}`; it may round to 0.

    Parameters
    ----------
    rho : (…)
        ρ, none negative.
    sigma
        σ: of this ρ the weight is :math:`e^{-1/2}`.

    Raises
    ------
    ValueError
        If a ρ is negative or not finite, or σ is not positive or too small for a finite result.
    """
    return np.exp(log_weight(rho, sigma))


def _areas(**areas: Values) -> list[Float[np.ndarray, "..."]]:
    found = {name: checks.array(name, value) for name, value in areas.items()}
    for name, value in found.items():
        if ((value < 0) | (value > 1e12)).any():
            raise ValueError(f"{name} must be an area, got {checks.shown(value.tolist())}")
    checks.check_batches(**{name: value.shape for name, value in found.items()})
    return list(found.values())
