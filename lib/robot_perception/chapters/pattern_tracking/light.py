"""The normalised correlation in other light, and the product of eq. (6) as printed: section 3.3."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.patterns import PatternRules, correlations
from robot_perception.chapters.pattern_tracking.scene import RULES, SCORED, START, scene
from robot_perception.evaluation.intervals import exact
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition

PAPER = "ceiling-navigation"
PRINTED = PatternRules(centred=False)
"""Vectors are compared as printed: their means stay."""
CENTRED = PatternRules()


@dataclass(frozen=True, slots=True)
class Config:
    """Pictures of one place in another light.

    Parameters
    ----------
    seeds
        Of patch and ground.
    gain
        The light is multiplied by it; ours.
    offset
        Grey values that are added to it; ours.
    """

    seeds: tuple[int, ...] = SCORED
    gain: float = 0.6
    offset: float = 0.0


def change(seed: int, rules: PatternRules, gain: float, offset: float) -> float:
    """Return the largest change of a vector's correlation with its model at the true place."""
    one = scene(seed)
    grey = gain * one.picture(START).astype(np.float32) + np.float32(offset)
    C = correlations(grey[None], one.pattern(rules), START[None])
    return float(np.abs(1 - C).max())


def run(config: Config, *, rng: np.random.Generator) -> Float[np.ndarray, "4 scenes"]:
    """Return the changes: as printed, under the light; and under an offset, printed and centred."""
    return np.array(
        [
            [change(seed, PRINTED, config.gain, config.offset) for seed in config.seeds],
            [change(seed, PRINTED, 1.0, 40.0) for seed in config.seeds],
            [change(seed, CENTRED, config.gain, config.offset) for seed in config.seeds],
            [change(seed, CENTRED, 1.0, 40.0) for seed in config.seeds],
        ]
    )


lit = Study(run, full=Config(), quick=Config(SCORED[:10]), seed=31)
NONE = Accepted(0.0, 1e-4, "what is left is the rounding of 32 bits")


@lit.claim(
    "normalised-light",
    paper=PAPER,
    place="§3.3",
    basis="mathematics",
    statement="The normalised correlation of grey vectors does not change with the light.",
    paper_value="“robust to illumination changes thanks to normalization”",
    method="Patches on cluttered grounds in a light of 0.6 times the strength, grey values not "
    "rounded: the largest change of any vector's correlation, as printed, at its true place.",
    accepted=NONE,
    sabotage=Change("an offset of 40 grey values", gain=1.0, offset=40.0),
)
def light(found: Float[np.ndarray, "4 scenes"]) -> Finding:
    """Compare a gain and an offset, with means as printed and without."""
    gain, offset, centred, both = (exact(float(row.max())) for row in found)
    return Finding(
        gain,
        {
            "change under an offset of 40, as printed": offset,
            "change under the light, means removed": centred,
            "change under an offset of 40, means removed": both,
        },
        conditions=(Condition.judged("the light changes by a factor", NONE, outside=offset),),
        note="Where the means are removed first, it does not change under an offset either.",
    )


@dataclass(frozen=True, slots=True)
class Product:
    """Patterns and particles.

    Parameters
    ----------
    seeds
        Of patch and ground.
    particles
        N_p, section 4.1; 0 for as many as a pattern has points.
    """

    seeds: tuple[int, ...] = SCORED
    particles: int = RULES.particles


def terms(config: Product, *, rng: np.random.Generator) -> Float[np.ndarray, "2 scenes"]:
    """Return how many factors the printed product has, and how many vectors there are."""
    points = [len(scene(seed).pattern().places) for seed in config.seeds]
    return np.array([[config.particles or count for count in points], points], dtype=float)


factors = Study(terms, full=Product(), quick=Product(SCORED[:10]), seed=32)


@factors.claim(
    "erratum-eq6",
    paper=PAPER,
    place="§3.3, eq. 6",
    basis="mathematics",
    statement="The likelihood of a particle is a product of as many factors as there are "
    "particles.",
    paper_value="∏ from j = 1 to N_p",
    method="Patterns of patches, 200 particles: factors of the printed product for each vector of "
    "the pattern, the largest and the smallest ratio over patterns.",
    accepted=Accepted(1.0, 1.0, "a factor for each vector"),
    sabotage=Change("as many particles as the pattern has points", particles=0),
)
def product(found: Float[np.ndarray, "2 scenes"]) -> Finding:
    """Count factors and vectors."""
    ratio = found[0] / found[1]
    worst = float(ratio[np.argmax(np.abs(np.log(ratio)))])
    return Finding(
        exact(worst),
        {
            "factors as printed": exact(float(found[0].max())),
            "vectors of a pattern, most": exact(float(found[1].max())),
            "vectors of a pattern, fewest": exact(float(found[1].min())),
        },
        note="It must be N_m: a factor for each vector of the pattern.",
    )
