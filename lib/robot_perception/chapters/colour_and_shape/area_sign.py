r"""What the sign of :math:`\Phi_{area}` does: as printed it is 0 for a perfect match.

With the two other scores at 1 and areas :math:`\tilde A` and :math:`a \tilde A`,

.. math::
    \rho_{printed} = \mu_2 \frac{\min(1, a)}{\max(1, a)}, \qquad
    \rho = \mu_2 \left(1 - \frac{\min(1, a)}{\max(1, a)}\right)

so that the printed one is greatest, and the weight least, where the area is right.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Float

from robot_perception.appearance import shape_scores
from robot_perception.appearance.affine_snake import SnakeRules, affine_snake, area
from robot_perception.appearance.segmentation import blob, filled
from robot_perception.chapters.colour_and_shape.snakes import Case

SIGNS = {
    "printed": shape_scores.area_difference,
    "turned round": shape_scores.area_congruence,
}

RULES = SnakeRules(reach=(30.0, 3.0))
"""The snake has to arrive at an outline that is 1.4 times as wide."""


@dataclass(frozen=True, slots=True)
class Config:
    """Weights of the scores, σ, how much too large the wrong segmentation is; all ours."""

    importance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    sigma: float = 0.5
    ratio: float = 2.0
    rules: SnakeRules = RULES


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """ρ and weight by sign, of the right segmentation and of the one that is too large.

    Parameters
    ----------
    config
        What was run.
    affine : (cases, 2)
        How well a snake fits either segmentation.
    rho, weights
        By sign, (cases, 2): the right segmentation first.
    """

    config: Config
    affine: Float[np.ndarray, "cases 2"]
    rho: dict[str, Float[np.ndarray, "cases 2"]]
    weights: dict[str, Float[np.ndarray, "cases 2"]]

    def right_first(self, sign: str) -> int:
        """Return in how many cases the right segmentation gets the larger weight."""
        return int((self.rho[sign][:, 0] < self.rho[sign][:, 1]).sum())


def exact_rho(ratio: Fraction, importance: Fraction, *, printed: bool) -> Fraction:
    """Return ρ exactly, with the two other scores at 1, for a ratio of found to predicted area."""
    difference = abs(1 - ratio) / max(Fraction(1), ratio)  # Φ as printed
    return importance * (1 - (difference if printed else 1 - difference))


def curve(ratios: np.ndarray, config: Config, sign: str) -> Float[np.ndarray, " k"]:
    """Return the weights for ratios of found to predicted area, with the other scores at 1."""
    found = SIGNS[sign](1.0, ratios)
    return shape_scores.weight(shape_scores.rho(1.0, found, 1.0, config.importance), config.sigma)


def run(config: Config, cases: list[Case]) -> Result:
    """Score, in each case, the shell as it is and the same too large, each with a snake fitted.

    The snake starts from the outline one frame before, and its area is the one predicted.
    """
    affine, areas, euler = np.empty((3, len(cases), 2))
    for row, case in enumerate(cases):
        middle = case.truth.mean(axis=0)
        for column, ratio in enumerate((1.0, config.ratio)):
            outline = middle + np.sqrt(ratio) * (case.truth - middle)
            found = blob(filled(outline, case.blob.shape), case.start)
            edges = found.boundary()
            fit = affine_snake(case.start, edges, config.rules)
            affine[row, column] = shape_scores.affine_similarity(edges, fit.outline)
            areas[row, column] = area(fit.outline)
            euler[row, column] = found.euler
    predicted = np.array([[area(case.start)] for case in cases])
    quality = shape_scores.quality(euler.astype(int))
    rho = {
        name: shape_scores.rho(affine, sign(predicted, areas), quality, config.importance)
        for name, sign in SIGNS.items()
    }
    weights = {name: shape_scores.weight(values, config.sigma) for name, values in rho.items()}
    return Result(config, affine, rho, weights)
