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
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted

SIGNS = {
    "printed": shape_scores.area_difference,
    "turned round": shape_scores.area_congruence,
}

RULES = SnakeRules(reach=(30.0, 3.0))
"""The snake has to arrive at an outline that is 1.4 times as wide."""
IMPORTANCE, SIGMA = (1.0, 1.0, 1.0), 0.5
"""Weights of the scores, and σ; ours."""
RATIO = 2.0
"""How much too large the wrong segmentation is; ours."""


def exact_rho(ratio: Fraction, importance: Fraction, *, printed: bool) -> Fraction:
    """Return ρ exactly, with the two other scores at 1, for a ratio of found to predicted area."""
    difference = abs(1 - ratio) / max(Fraction(1), ratio)  # Φ as printed
    return importance * (1 - (difference if printed else 1 - difference))


def curve(ratios: np.ndarray, sign: str) -> Float[np.ndarray, " k"]:
    """Return the weights for ratios of found to predicted area, with the other scores at 1."""
    found = SIGNS[sign](1.0, ratios)
    return shape_scores.weight(shape_scores.rho(1.0, found, 1.0, IMPORTANCE), SIGMA)


def compared(
    cases: list[Case],
) -> tuple[Float[np.ndarray, "cases 2"], dict[str, Float[np.ndarray, "cases 2"]]]:
    """Return how well a snake fits the shell as it is and the same too large, and ρ by sign.

    The snake starts from the outline one frame before, and its area is the one predicted.
    """
    affine, areas, euler = np.empty((3, len(cases), 2))
    for row, case in enumerate(cases):
        middle = case.truth.mean(axis=0)
        for column, ratio in enumerate((1.0, RATIO)):
            outline = middle + np.sqrt(ratio) * (case.truth - middle)
            found = blob(filled(outline, case.blob.shape), case.start)
            edges = found.boundary()
            fit = affine_snake(case.start, edges, RULES)
            affine[row, column] = shape_scores.affine_similarity(edges, fit.outline)
            areas[row, column] = area(fit.outline)
            euler[row, column] = found.euler
    predicted = np.array([[area(case.start)] for case in cases])
    quality = shape_scores.quality(euler.astype(int))
    return affine, {
        name: shape_scores.rho(affine, sign(predicted, areas), quality, IMPORTANCE)
        for name, sign in SIGNS.items()
    }


def right_first(rho: Float[np.ndarray, "cases 2"]) -> Interval:
    """Return in which share of the cases the right segmentation gets the larger weight."""
    return proportion(int((rho[:, 0] < rho[:, 1]).sum()), len(rho))


@dataclass(frozen=True, slots=True)
class Shells:
    """The films whose shells are weighed, and the sign of a perfect match's score."""

    films: tuple[int, ...]
    printed: bool = True


def run(config: Shells, *, rng: np.random.Generator) -> tuple[Fraction, dict[str, Interval]]:
    """Return ρ of a perfect match over μ₂, and by sign how often a shell precedes a larger one."""
    films = snakes.Config(films=config.films, frames=(24,))
    _, rho = compared(snakes.gathered(films, rng=rng))
    perfect = exact_rho(Fraction(1), Fraction(1), printed=config.printed)
    return perfect, {sign: right_first(values) for sign, values in rho.items()}


FILMS = snakes.Config().films
shells = Study(run, full=Shells(FILMS), quick=Shells(FILMS[:2]), seed=72)


@shells.claim(
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
    sabotage=Change("1 less the printed expression", printed=False),
)
def phi_area(result: tuple[Fraction, dict[str, Interval]]) -> Finding:
    """Compare ρ of a perfect match with the paper's, and true shells with ones too large."""
    perfect, first = result
    double = exact_rho(Fraction(2), Fraction(1), printed=True)
    return Finding(
        exact(float(perfect)),
        {"twice the area, as printed": exact(float(double))}
        | {f"right shell first, {sign}": share for sign, share in first.items()},
        note="As printed it is 0 for a perfect match, where ρ rewards 1: a segmentation of twice "
        "the area gets the larger weight. 1 less the printed expression is what ρ wants.",
    )
