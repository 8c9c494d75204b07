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
from robot_perception.chapters.colour_and_shape import snakes
from robot_perception.chapters.colour_and_shape.snakes import PAPER, Case
from robot_perception.evaluation.intervals import Interval, exact, proportion
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.verdicts import Accepted

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


@claim(
    "erratum-phi-area",
    paper=PAPER,
    place="§3.3, measure and weight",
    basis="mathematics",
    statement="With the printed Φ_area, ρ is 0 where the area is the predicted one.",
    paper_value="Φ_area = |Ã − A| / max {Ã, A}, and ρ adds μ₂ (1 − Φ_area)",
    method="Exact fractions: ρ over μ₂ of a segmentation whose two other scores are 1 and whose "
    "area is the predicted one. Beside it rendered shells, each as it is and with twice its area, "
    "a snake fitted to either: which of the two gets the larger weight.",
    accepted=Accepted(0.0, 0.0, "a perfect match lacks nothing, and its weight is 1"),
    seed=72,
)
def phi_area(size: Size, rng: np.random.Generator) -> Finding:
    """Compute ρ of a perfect match, and weigh true shells against ones that are too large."""
    films = snakes.Config().films if size is Size.FULL else snakes.Config().films[:2]
    cases = snakes.gathered(snakes.Config(films=films, frames=(24,)), rng=rng)
    found = run(Config(), cases)
    shares = {
        f"right shell first, {sign}": proportion(found.right_first(sign), len(cases))
        for sign in SIGNS
    }
    double = exact_rho(Fraction(2), Fraction(1), printed=True)
    return Finding(
        _perfect(printed=True),
        {"twice the area, as printed": exact(float(double)), **shares},
        note="As printed it is 0 for a perfect match, where ρ rewards 1: a segmentation of twice "
        "the area gets the larger weight. 1 less the printed expression is what ρ wants.",
    )


@phi_area.sabotage("1 less the printed expression")
def turned_round(size: Size, rng: np.random.Generator) -> Finding:
    """Turn the sign round."""
    return Finding(_perfect(printed=False))


def _perfect(*, printed: bool) -> Interval:
    return exact(float(exact_rho(Fraction(1), Fraction(1), printed=printed)))
