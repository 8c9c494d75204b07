"""Poses that no body can take: how many particles they cost, and what they do to the estimate."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.arm_likelihoods.scene import SCORED
from robot_perception.chapters.arm_tracking.tracking import FRAMES, tracked
from robot_perception.evaluation.intervals import bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
WITH, WITHOUT = "all cues", "no collisions"


@dataclass(frozen=True, slots=True)
class Config:
    """Films of people who gesture before a bare wall.

    Parameters
    ----------
    seeds
        Of the films.
    scene
        Name of a scene.
    frames
        Of each film.
    bounded
        The way that is compared with no test for collisions.
    """

    seeds: tuple[int, ...] = SCORED[:40]
    scene: str = "gesturing, plain"
    frames: int = FRAMES
    bounded: str = WITH


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What the test for collisions saves, and what it does.

    Parameters
    ----------
    config
        What was run.
    saved : (films, 2)
        Share of the particles that are not measured, with the test and without it: beyond the
        joints' limits there are some in both.
    angle, held : (films, 2)
        Mean error of the angles, degrees, and share of the arms that is held.
    """

    config: Config
    saved: Float[np.ndarray, "films 2"]
    angle: Float[np.ndarray, "films 2"]
    held: Float[np.ndarray, "films 2"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Track each film with the test and without it."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        runs = [tracked(seed, config.scene, way, frames=config.frames)
                for way in (config.bounded, WITHOUT)]  # fmt: skip
        return np.array([(one.saved[1:].mean(), one.angle, one.held.mean()) for one in runs])

    parts = np.array(sweep(task, config.seeds, rng=rng, desc="films"))
    return Result(config, *np.moveaxis(parts, -1, 0))


collisions = Study(run, full=Config(), quick=Config(SCORED[:3], frames=40), seed=2)


@collisions.claim(
    "collisions",
    paper=PAPER,
    place="§V, eq. of p_coll, Fig. 11",
    basis="substitute",
    statement="A test for collisions avoids measuring hypotheses that cannot be.",
    paper_value="“it avoids wasting time in performing the measuring step for unacceptable "
    "hypothesis”",
    method="Films of people who gesture before a bare wall, all cues, auxiliary filter. Share of "
    "the particles that is not measured with the test less that without it, where the limits of "
    "the joints alone count; bootstrap over films.",
    accepted=Accepted(0.02, 1.0, "one particle in fifty at least", Origin.CHOICE),
    sabotage=Change("no test for collisions", bounded=WITHOUT),
)
def collisions_avoided(result: Result) -> Finding:
    """Tell what is saved, and what the test does to the estimate."""
    return Finding(
        bootstrap_mean(result.saved[:, 0] - result.saved[:, 1]),
        {
            "not measured, with the limits": bootstrap_mean(result.saved[:, 0]),
            "error of the angles, with over without": bootstrap_ratio(*result.angle.T),
            "arms held, with less without": bootstrap_mean(result.held[:, 0] - result.held[:, 1]),
        },
    )
