r"""Where a new pattern is: the quotient of two transformations in section 2.3.

The paper prints :math:`{}^0 L_i = {}^0 L_i^{(k)} / {}^I L_i^{(k)}`. For the numerator to be known
it must be :math:`{}^I L_0^{(k)}`, the pose of the reference in the picture. A quotient of matrices
can be read in two ways, and either way round; one of the four is right.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.mosaic import between_patterns
from robot_perception.chapters.ceiling_navigation.world import (
    CENTRE,
    HALF,
    PAPER,
    SCALE,
    looking,
    seen,
)
from robot_perception.evaluation.intervals import exact
from robot_perception.geometry import se2, wrap_angle
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted

PRINTED, UNDER, OVER, RIGHT = (
    "numerator times inverse",
    "inverse times numerator",
    "denominator times inverse",
    "inverse of the numerator first",
)
"""The four readings: A B⁻¹, B⁻¹ A, B A⁻¹ and A⁻¹ B, with A = ᴵL₀ and B = ᴵLᵢ."""
FORMULAS = {PRINTED: "A B⁻¹", UNDER: "B⁻¹ A", OVER: "B A⁻¹", RIGHT: "A⁻¹ B"}
READINGS = {
    PRINTED: lambda A, B: between_patterns(B, A, "inverse last"),
    UNDER: lambda A, B: between_patterns(B, A, "inverse first"),
    OVER: partial(between_patterns, order="inverse last"),
    RIGHT: partial(between_patterns, order="inverse first"),
}


@dataclass(frozen=True, slots=True)
class Config:
    """Pairs of patterns at random, each seen from several places; ours.

    ``read`` says how the quotient is read.
    """

    pairs: int = 200
    places: int = 10
    read: str = PRINTED


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """By reading: how far apart two places of the robot put a pattern, and by how much it is off.

    Both are the largest over the pairs, m.
    """

    config: Config
    apart: dict[str, float]
    off: dict[str, float]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Place patterns by all readings of the quotient, from several places each."""
    camera, centre = looking(), np.append(CENTRE, [0.0, 0.0])
    apart, off = dict.fromkeys(READINGS, 0.0), dict.fromkeys(READINGS, 0.0)
    for _ in range(config.pairs):
        pair = np.column_stack(
            [rng.uniform(-1, 1, (2, 2)) * HALF / 2, rng.uniform(-np.pi, np.pi, 2)]
        )
        there, true = {"0": pair[0], "i": pair[1]}, se2.between(pair[0], pair[1])
        places = rng.uniform(-1, 1, (config.places, 3)) * [*(HALF / 2), np.pi]
        views = [seen(camera, place, there) for place in places]
        for name, rule in READINGS.items():
            found = np.array([rule(view["0"] - centre, view["i"] - centre) for view in views])
            found[:, :2] *= SCALE
            between = np.hypot(*(found[:, None, :2] - found[:, :2]).transpose(2, 0, 1)).max()
            miss = np.hypot(np.hypot(*(found - true)[:, :2].T), wrap_angle(found - true)[:, 2])
            apart[name] = max(apart[name], float(between))
            off[name] = max(off[name], float(miss.max()))
    return Result(config, apart, off)


def placed(
    robot: Float[np.ndarray, "3"], pair: Float[np.ndarray, "2 3"], reading: str
) -> Float[np.ndarray, "3"]:
    """Return where a reading puts the second of two patterns that a robot sees, on the ceiling."""
    view = seen(looking(), robot, {"0": pair[0], "i": pair[1]})
    centre = np.append(CENTRE, [0.0, 0.0])
    way = READINGS[reading](view["0"] - centre, view["i"] - centre) * [SCALE, SCALE, 1.0]
    return se2.compose(pair[0], way)


chaining = Study(run, full=Config(), quick=Config(pairs=20), seed=73)


@chaining.claim(
    "erratum-mosaic",
    paper=PAPER,
    place="§2.3, before eq. 3",
    basis="mathematics",
    statement="The printed quotient, read from left to right as numerator times inverse of the "
    "denominator, does not depend on where the robot is.",
    paper_value="“time independent”",
    method="Pairs of patterns seen from ten places each, exactly: how far apart two places put the "
    "second pattern in the frame of the first, largest over the pairs. The numerator is taken as "
    "ᴵL₀, since as printed it is what is sought.",
    accepted=Accepted(0.0, 1e-9, "what does not depend on the robot is the same from all places"),
    sabotage=[
        Change("the inverse of the numerator first", read=RIGHT),
        Change("the inverse of the denominator first", read=UNDER),
    ],
)
def quotient(found: Result) -> Finding:
    """Read the quotient in the four ways that there are."""
    return Finding(
        exact(found.apart[found.config.read], "m", "largest over pairs and places"),
        {f"{FORMULAS[n]}: apart": exact(found.apart[n], "m") for n in READINGS}
        | {f"{FORMULAS[n]}: off the true pose": exact(found.off[n]) for n in READINGS},
        note="A motion of the robot multiplies both sightings from the left and cancels only where "
        "the inverse stands first. B⁻¹ A does not depend on the robot, either, but it is the pose "
        "of the reference from the new pattern. The pose that eq. 3 needs is A⁻¹ B.",
    )
