"""The normalised correlation in other light, and the product of eq. (6) as printed: section 3.3."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.patterns import Decay, Pattern, PatternRules, correlations
from robot_perception.chapters.pattern_tracking.rivals import Task, condensation
from robot_perception.chapters.pattern_tracking.scene import (
    RULES,
    SCORED,
    SIGMAS,
    START,
    errors,
    scene,
    seen,
)
from robot_perception.evaluation.intervals import bootstrap_ratio, exact
from robot_perception.evaluation.sweep import sweep
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
    few
        Another N_p, smaller than N_m: with it the printed product can be run. Ours.
    moves
        Of each patch, by 0.7 σ along all coordinates in the root mean square.
    """

    seeds: tuple[int, ...] = SCORED
    particles: int = RULES.particles
    few: int = 60
    moves: int = 6


@dataclass(frozen=True, eq=False, slots=True)
class Products:
    """What the product up to N_p is, and does, beside that up to N_m.

    Parameters
    ----------
    few
        N_p of the errors.
    factors : (2, scenes)
        Of the printed product, and vectors of the pattern.
    off : (2, scenes)
        Mean error of a tracker of few particles with either product, σ.
    """

    few: int
    factors: Float[np.ndarray, "2 scenes"]
    off: Float[np.ndarray, "2 scenes"]


def both(config: Product, *, rng: np.random.Generator) -> Products:
    """Count the factors of both products, and run both where N_p vectors are there."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        return np.mean([track(seed, config.few, rng) for _ in range(config.moves)], axis=0)

    points = [len(scene(seed).pattern().places) for seed in config.seeds]
    printed = [config.particles or count for count in points]
    off = np.array(sweep(task, config.seeds, rng=rng)).T
    return Products(config.few, np.array([printed, points], dtype=float), off)


def first(pattern: Pattern, count: int) -> Pattern:
    """Return a pattern of the first vectors alone: those that a product up to there takes."""
    decay = Decay(pattern.decay.rate[:count], pattern.decay.power[:count])
    places, vectors = pattern.places[:count], pattern.vectors[:count]
    return replace(pattern, places=places, vectors=vectors, decay=decay)


def track(seed: int, few: int, rng: np.random.Generator) -> Float[np.ndarray, " 2"]:
    """Return the error of each product after three pictures of one move, by the same draws, σ."""
    one, place = scene(seed), START + 0.7 * SIGMAS * rng.standard_normal(4)
    images, draws = [seen(one.picture(place), rng) for _ in range(3)], int(rng.integers(2**32))
    pattern, rules, found = one.pattern(), replace(RULES, particles=few), []
    for product in (first(pattern, few), pattern):
        find = condensation(rules, pictures=3)
        pose = find(Task(product, images[0], tuple(images)), np.random.default_rng(draws))
        found.append(np.abs(errors(pose, place)).mean())
    return np.array(found)


factors = Study(both, full=Product(), quick=Product(SCORED[:10], moves=2), seed=32)


@factors.claim(
    "erratum-eq6",
    paper=PAPER,
    place="§3.3, eq. 6",
    basis="mathematics",
    statement="The likelihood of a particle is a product of as many factors as there are "
    "particles.",
    paper_value="∏ from j = 1 to N_p",
    method="Patterns of patches, 200 particles: factors of the printed product for each vector of "
    "the pattern, the largest and the smallest ratio over patterns. Both products are run where "
    "there are fewer particles than vectors: error after three pictures of a pattern that moved "
    "once, by the same draws; ratio of means over patches.",
    accepted=Accepted(1.0, 1.0, "a factor for each vector"),
    sabotage=Change("as many particles as the pattern has points", particles=0),
)
def product(found: Products) -> Finding:
    """Count factors and vectors, and compare what the products do."""
    printed, vectors = found.factors
    ratio = printed / vectors
    worst = float(ratio[np.argmax(np.abs(np.log(ratio)))])
    return Finding(
        exact(worst),
        {
            "factors as printed": exact(float(printed.max())),
            "vectors of a pattern, most": exact(float(vectors.max())),
            "vectors of a pattern, fewest": exact(float(vectors.min())),
            "few particles": exact(float(found.few)),
            "error of few particles, printed product over that up to N_m": bootstrap_ratio(
                *found.off
            ),
        },
        note="It must be N_m: a factor for each vector of the pattern.",
    )
