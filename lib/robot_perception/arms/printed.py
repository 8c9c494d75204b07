r"""Silhouettes on edges as the paper prints them, to be tracked with in place of ours.

The printed likelihood of an outline is

.. math:: p(z^S \mid x) \propto \exp\Bigl( -\frac{D^2}{2 \sigma_s^2} \Bigr), \qquad
    D = \sum_j \min(I_{DT}(j),\; K \cdot I'_{DT}(j)) \qquad (2)

over the points of the outline that are visible. The text above eq. (2) speaks of "the sum of the
squared distances". `EdgeCue` takes the mean of the squares, and counts hidden points.

References
----------
Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion Robot", section V, "Shape
cues" and "Motion cues".
"""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from robot_perception.arms.likelihoods import (
    Bodies,
    EdgeCue,
    Logarithms,
    Look,
    square_of_sum,
    sum_of_squares,
)
from robot_perception.fields import NotNegative, Positive, checked, one_of

__all__ = ["FORMS", "SumCue"]

FORMS = MappingProxyType({"square of the sum": square_of_sum, "sum of the squares": sum_of_squares})
"""Forms of D²: that of eq. (2) as it is printed, and that of its text."""


@final
@dataclass(frozen=True, slots=True)
class SumCue:
    r"""Silhouettes on edges by eq. (2).

    .. math:: \log p = -\lambda_s \frac{D^2}{2 \sigma_s^2}

    A hidden point costs nothing. The distances are as far cut as those of the picture are: with
    ``EdgeRules(most=1000.0)`` they are not, and the paper cuts none.

    Parameters
    ----------
    sigma
        σ_s, px, of the sum; the paper gives no number.
    gain
        K; ``None`` for :math:`I_{DT}` alone.
    weight
        λ_s, by which the logarithm is multiplied.
    form
        What D² is, a name in `FORMS`.

    Raises
    ------
    ValueError
        If a number is not positive, or the form is unknown.

    References
    ----------
    Eq. (2), and section V, "Motion cues".
    """

    sigma: Positive = 60.0
    gain: Positive | None = None
    weight: NotNegative = 1.0
    form: Annotated[str, one_of(*FORMS)] = "square of the sum"
    __post_init__ = checked

    def __call__(self, seen: Look, bodies: Bodies) -> Logarithms:
        """Return the logarithm of a likelihood for each state."""
        distances = EdgeCue(gain=self.gain).distances(seen, bodies)
        return self.weight * FORMS[self.form](distances, bodies.contours.visible, self.sigma)
