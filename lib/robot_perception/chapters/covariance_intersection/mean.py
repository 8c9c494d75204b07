"""Eq. (3) as it is printed, with an inverse of the mean."""

import numpy as np

from robot_perception.beliefs import Gaussian
from robot_perception.chapters.covariance_intersection import consistency
from robot_perception.chapters.covariance_intersection.consistency import PAPER, by_equation_4
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.verdicts import Accepted


@claim(
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
    seed=36,
)
def as_printed(size: Size, rng: np.random.Generator) -> Finding:
    """Fuse beliefs with themselves by the line as printed."""
    return Finding(
        _distance(size, rng, inverted=True),
        note="Without the exponent the line gives the mean, and a belief fused with itself stays "
        "where it is.",
    )


@as_printed.sabotage("the line without the exponent")
def as_meant(size: Size, rng: np.random.Generator) -> Finding:
    """Take the right side for the mean itself."""
    return Finding(_distance(size, rng, inverted=False))


def _distance(size: Size, rng: np.random.Generator, *, inverted: bool) -> Interval:
    config = consistency.Config(pairs=2000 if size is Size.FULL else 200)
    drawn, _ = consistency.pairs(config, rng=rng)
    belief = Gaussian(rng.uniform(0.5, 3.0, (config.pairs, 2)), drawn.cov)
    right = by_equation_4(belief, belief).mean
    off = (1 / right if inverted else right) - belief.mean
    squared = np.einsum("pi,pij,pj->p", off, np.linalg.inv(belief.cov), off)
    return exact(float(np.sqrt(squared.max())), "σ", "largest over beliefs")
