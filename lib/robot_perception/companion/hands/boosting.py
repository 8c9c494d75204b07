r"""AdaBoost with stumps: a strong classifier from features that are each little better than chance.

A stump asks whether a feature f is below a threshold: :math:`h(x) = 1` if
:math:`p f(x) < p \theta`, else 0. In each round the stump with the least weighted error
:math:`\epsilon_t` is taken, and the samples that it gets right count less in the next:

.. math::
    \beta_t = \frac{\epsilon_t}{1 - \epsilon_t}, \qquad
    w_i \leftarrow w_i \beta_t^{[h_t(x_i) = y_i]}, \qquad
    H(x) = \sum_t \log \tfrac{1}{\beta_t} \, h_t(x)
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, final, no_type_check

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.fields import at_least, checked, not_empty
from robot_perception.kernels import kernel

__all__ = ["Boosted", "best_stump", "boost"]


def _signs(name: str, value: np.ndarray) -> np.ndarray:
    """Return an array of 1 and -1."""
    if not ((value == 1) | (value == -1)).all():
        raise ValueError(f"{name} must be 1 or -1, got {checks.shown(value.tolist())}")
    return value


@final
@dataclass(frozen=True, eq=False, slots=True)
class Boosted:
    """Stumps and their votes.

    Parameters
    ----------
    features : (k,)
        Which feature each stump asks.
    thresholds : (k,)
        θ.
    polarities : (k,)
        1 if a value below the threshold speaks for a hand, -1 if one above does.
    votes : (k,)
        :math:`\\log 1/\\beta`.
    """

    features: Annotated[Int[np.ndarray, " k"], at_least(0), not_empty]
    thresholds: Float[np.ndarray, " k"]
    polarities: Annotated[Int[np.ndarray, " k"], _signs]
    votes: Float[np.ndarray, " k"]
    __post_init__ = checked

    def scores(self, values: Float[np.ndarray, "n m"]) -> Float[np.ndarray, " m"]:
        """Return H of samples, given the values (n, m) of all features."""
        values = checks.array("values", values, ("n", "m"))
        if self.features.max() >= len(values):
            raise ValueError(f"values must be of {self.features.max() + 1} features or more")
        chosen = values[self.features] * self.polarities[:, None]
        says = chosen < (self.polarities * self.thresholds)[:, None]
        return (self.votes[:, None] * says).sum(axis=0)


def best_stump(
    values: Float[np.ndarray, "n m"],
    order: Int[np.ndarray, "n m"],
    labels: Bool[np.ndarray, " m"],
    weights: Float[np.ndarray, " m"],
) -> tuple[int, float, int, float]:
    """Return the stump with the least weighted error.

    Parameters
    ----------
    values : (n, m)
        Of n features on m samples.
    order : (n, m)
        The samples of each feature by rising value.
    labels : (m,)
        Whether a sample is a hand.
    weights : (m,)
        Positive, of sum 1.

    Returns
    -------
    (int, float, int, float)
        Feature, threshold, polarity and error.
    """
    values = checks.array("values", values, ("n", "m"))
    if not values.size:
        raise ValueError("values must not be empty")
    order = checks.integers("order", order, values.shape, 0)
    weights = checks.array("weights", weights, (values.shape[1],))
    if not isinstance(labels, np.ndarray) or labels.dtype != bool:
        raise TypeError(f"labels must be an array of booleans, got {checks.shown(labels)}")
    checks.shaped("labels", labels, (values.shape[1],))
    if order.size and order.max() >= values.shape[1]:
        raise ValueError(f"order must be of {values.shape[1]} samples, got {order.max()}")
    return _stump(values, order, labels, weights)


def boost(
    values: Float[np.ndarray, "n m"],
    labels: Bool[np.ndarray, " m"],
    enough: Callable[[Boosted], bool],
    *,
    most: int = 60,
) -> Boosted:
    """Return stumps until they are enough.

    Parameters
    ----------
    values : (n, m)
        Of n features on m samples.
    labels : (m,)
        Whether a sample is a hand; both kinds are needed.
    enough
        Function of what was boosted so far that says whether to stop.
    most
        How many stumps there may be.

    Raises
    ------
    ValueError
        If a kind of samples is missing, or shapes do not fit.

    References
    ----------
    Viola and Jones, "Rapid object detection using a boosted cascade of simple features", CVPR 2001,
    table 1.
    """
    values = checks.array("values", values, ("n", "m"))
    if not values.size:
        raise ValueError("values must not be empty")
    labels = np.asarray(labels)
    if labels.dtype != bool:
        raise TypeError(f"labels must be an array of booleans, got {checks.shown(labels)}")
    checks.shaped("labels", labels, (values.shape[1],))
    if labels.all() or not labels.any():
        raise ValueError(f"labels must be of both kinds, got {labels.sum()} of {len(labels)} true")
    checks.instance("enough", enough, Callable)
    most = checks.whole("most", most, 1, 10_000)
    order = values.argsort(axis=1, kind="stable").astype(np.int32)
    weights = np.where(labels, 0.5 / labels.sum(), 0.5 / (~labels).sum())
    chosen: list[tuple[int, float, int, float]] = []
    while True:
        feature, threshold, polarity, error = _stump(values, order, labels, weights)
        beta = max(error, 1e-9) / (1 - min(error, 1 - 1e-9))
        chosen.append((feature, threshold, polarity, -np.log(beta)))
        parts = zip(*chosen, strict=True)
        features, thresholds, polarities, votes = (np.array(part) for part in parts)
        found = Boosted(features, thresholds, polarities, votes)
        if len(chosen) >= most or enough(found):
            return found
        says = polarity * values[feature] < polarity * threshold
        weights = weights * np.where(says == labels, beta, 1.0)
        weights = weights / weights.sum()


@no_type_check
@kernel()
def _stump(values, order, labels, weights):  # pragma: no cover - compiled
    """Go through the thresholds between neighbouring values of each feature."""
    all_true = 0.0
    for i in range(len(labels)):
        if labels[i]:
            all_true += weights[i]
    all_false = weights.sum() - all_true
    best = 2.0
    at, threshold, polarity = 0, 0.0, 1
    for k in range(len(values)):
        true = false = 0.0
        for i in range(order.shape[1]):
            sample = order[k, i]
            if labels[sample]:
                true += weights[sample]
            else:
                false += weights[sample]
            here = values[k, sample]
            last = i + 1 == order.shape[1]
            after = here + 1.0 if last else values[k, order[k, i + 1]]
            if after <= here:
                continue
            below = false + all_true - true  # what is below is taken for a hand
            above = true + all_false - false
            if below < best:
                best, at, threshold, polarity = below, k, (here + after) / 2, 1
            if above < best:
                best, at, threshold, polarity = above, k, (here + after) / 2, -1
    return at, threshold, polarity, best
