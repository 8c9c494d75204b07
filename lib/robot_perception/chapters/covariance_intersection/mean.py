"""Eq. (3) as it is printed, with an inverse of the mean."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.beliefs import Gaussian
from robot_perception.chapters.covariance_intersection.consistency import (
    PAPER,
    by_equation_4,
    pairs,
)
from robot_perception.evaluation.intervals import exact
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted


@dataclass(frozen=True, slots=True)
class Config:
    """How many beliefs there are, and whether the line is read with its exponent."""

    beliefs: int = 2000
    inverted: bool = True


def run(config: Config, *, rng: np.random.Generator) -> Float[np.ndarray, " beliefs"]:
    """Fuse beliefs with themselves; return how far their means move, in standard deviations."""
    drawn, _ = pairs(config.beliefs, rng=rng)
    belief = Gaussian(rng.uniform(0.5, 3.0, (config.beliefs, 2)), drawn.cov)
    right = by_equation_4(belief, belief).mean
    off = (1 / right if config.inverted else right) - belief.mean
    return np.sqrt(np.einsum("pi,pij,pj->p", off, np.linalg.inv(belief.cov), off))


twice = Study(run, full=Config(), quick=Config(200), seed=36)


@twice.claim(
    "erratum-eq3",
    paper=PAPER,
    place="§3.2, eq. 3",
    basis="mathematics",
    statement="The right side of the second line of eq. 3 is the inverse of the new mean.",
    paper_value="printed with the exponent −1",
    method="A belief fused with itself must give its mean back. The line is read entry by entry, "
    "as a vector has no other inverse: largest distance from that mean over random beliefs, in "
    "standard deviations.",
    accepted=Accepted(0.0, 1e-9, "twice the same opinion is that opinion, but for rounding"),
    sabotage=Change("the line without the exponent", inverted=False),
)
def as_printed(moved: Float[np.ndarray, " beliefs"]) -> Finding:
    """Look for the belief that moves farthest."""
    return Finding(
        exact(float(moved.max()), "σ", "largest over beliefs"),
        note="Without the exponent the line gives the mean, and a belief fused with itself stays "
        "where it is.",
    )
