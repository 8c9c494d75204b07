r"""Where the robot is, from one pattern: eq. (2).

.. math:: {}^M T_C = {}^M T_i \left( {}^C T_i \right)^{-1}
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.mosaic import Mosaic, camera_pose, in_camera
from robot_perception.chapters.ceiling_navigation.world import (
    CENTRE,
    HALF,
    PAPER,
    SCALE,
    Sightings,
    looking,
    seen,
)
from robot_perception.evaluation.intervals import exact, root_mean_square, variance_ratio
from robot_perception.geometry import se2
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted

SIGMA_PX, SIGMA_HEADING = 1.0, 0.02
"""Of a noisy sighting, px and rad; ours."""
SIGMAS = np.array([SIGMA_PX, SIGMA_PX, SIGMA_HEADING, 0.0])
PATTERNS = 3
"""So many are seen together."""
NEAR, FAR = 0.5, 1.5
"""Distances of a pattern from the optical axis at which noise is compared, m."""

Rule = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, slots=True)
class Config:
    """Poses and patterns at random; the paper gives no numbers.

    ``pitch`` tilts a camera whose picture is not corrected, rad.
    """

    poses: int = 5000
    pitch: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Errors of the position of the robot, m.

    Distances from one exact sighting; then x and y from one noisy sighting, from three by least
    squares, and from one at the two distances.
    """

    exact: Float[np.ndarray, " poses"]
    one: Float[np.ndarray, "poses 2"]
    several: Float[np.ndarray, "poses 2"]
    near: Float[np.ndarray, "poses 2"]
    far: Float[np.ndarray, "poses 2"]


def run(config: Config, rule: Rule = camera_pose, *, rng: np.random.Generator) -> Result:
    """Compute poses of robots from what they see of patterns, without and with noise."""
    camera, rows = looking(pitch=config.pitch), []
    for _ in range(config.poses):
        pose = rng.uniform(-1, 1, 3) * [5, 5, np.pi]
        angle = rng.uniform(-np.pi, np.pi)
        ring = np.array([np.cos(angle), np.sin(angle)])
        ways = [*(rng.uniform(-1, 1, (PATTERNS, 2)) * HALF), NEAR * ring, FAR * ring]
        poses = se2.compose(pose, np.column_stack([ways, rng.uniform(-np.pi, np.pi, len(ways))]))
        there = {str(k): one for k, one in enumerate(poses)}
        found = seen(camera, pose, there)
        noisy = {n: s + SIGMAS * rng.standard_normal(4) for n, s in found.items()}
        first = [str(k) for k in range(PATTERNS)]
        together = Mosaic({n: there[n] for n in first}, SCALE, np.array(CENTRE))
        several = together.locate({n: noisy[n] for n in first}, sigma_heading=SIGMA_HEADING)[0]
        alone = [located(there, noisy, n, rule) for n in ("0", "3", "4")]
        both = np.array([located(there, found, "0", rule), several, *alone])
        rows.append((both - pose)[:, :2])
    errors = np.array(rows)
    sharp = np.hypot(errors[:, 0, 0], errors[:, 0, 1])
    return Result(sharp, errors[:, 2], errors[:, 1], errors[:, 3], errors[:, 4])


def located(
    there: dict[str, np.ndarray], found: Sightings, name: str, rule: Rule = camera_pose
) -> Float[np.ndarray, "3"]:
    """Return the pose of the robot from one pattern."""
    return rule(there[name], in_camera(found[name], centre=np.array(CENTRE), scale=SCALE))


def exchanged(config: Config, *, rng: np.random.Generator) -> Result:
    """Exchange the factors of eq. (2)."""
    return run(config, lambda known, sight: se2.compose(se2.inverse(sight), known), rng=rng)


def not_inverted(config: Config, *, rng: np.random.Generator) -> Result:
    """Leave the inverse out of eq. (2)."""
    return run(config, se2.compose, rng=rng)


def expected(distance: float) -> float:
    """Return the standard deviation of a position from one noisy pattern, m, both axes together.

    The pixels move the robot by Z/f each; a heading that is wrong swings it about the pattern.
    """
    return float(np.sqrt(2 * (SIGMA_PX * SCALE) ** 2 + (SIGMA_HEADING * distance) ** 2))


posing = Study(run, full=Config(), quick=Config(poses=400), seed=72)


@posing.claim(
    "pose-from-pattern",
    paper=PAPER,
    place="§2.2, eq. 2",
    basis="mathematics",
    statement="The pose of the robot follows from what it sees of one pattern of the mosaic.",
    paper_value="eq. 2",
    method="Robots and patterns at random places, exact sightings by a camera that shares no code "
    "with eq. 2: largest error of the position.",
    accepted=Accepted(0.0, 1e-9, "an identity leaves nothing but rounding"),
    sabotage=[
        Change("the factors of eq. 2 exchanged", exchanged),
        Change("the inverse of eq. 2 left out", not_inverted),
        Change("a camera tilted by 1° whose picture is not corrected", pitch=np.deg2rad(1.0)),
    ],
)
def pose(found: Result) -> Finding:
    """Compare the pose by eq. (2) with the true one."""

    def off(errors: np.ndarray):
        return root_mean_square(np.hypot(*errors.T), "m")

    return Finding(
        exact(float(found.exact.max()), "m", "largest over poses"),
        {
            "noisy sightings, one pattern": off(found.one),
            f"noisy sightings, {PATTERNS} patterns together": off(found.several),
            f"one pattern {NEAR:g} m from the axis": off(found.near),
            f"what the noise lets expect at {NEAR:g} m": exact(expected(NEAR), "m"),
            f"one pattern {FAR:g} m from the axis": off(found.far),
            f"what the noise lets expect at {FAR:g} m": exact(expected(FAR), "m"),
            "variance with one pattern over that with three": variance_ratio(
                found.one.ravel(), found.several.ravel()
            ),
        },
        note=f"With errors of {SIGMA_PX:g} px and {np.rad2deg(SIGMA_HEADING):.1f}° a pattern far "
        "from the axis says less, since its heading swings the robot round it; three patterns "
        "tell the heading by their places.",
    )
