"""Poses that no body can take: how many particles they cost, and what they do to the estimate."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception.arms.body_model import Measures
from robot_perception.arms.likelihoods import Bodies, CollisionCue, Cue, LimitCue, Look
from robot_perception.arms.tracker import BOUNDS, ArmTracker, First
from robot_perception.chapters.arm_likelihoods.scene import SCORED
from robot_perception.chapters.arm_tracking.tracking import CAMERA, FRAMES, film, follow, tracked
from robot_perception.evaluation.intervals import bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
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
    wide
        By which the trunk of the model is widened where the saved particles are counted.
    """

    seeds: tuple[int, ...] = SCORED[:40]
    scene: str = "gesturing, plain"
    frames: int = FRAMES
    bounded: str = WITH
    wide: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What the test for collisions saves, and what it does.

    Parameters
    ----------
    config
        What was run.
    saved : (films,)
        Share of the particles that only the test saves: in collision, within the joints' limits.
    bounded : (films,)
        Share of the particles that is not measured in all.
    angle, held : (films, 2)
        Mean error of the angles, degrees, and share of the arms that is held.
    """

    config: Config
    saved: Float[np.ndarray, " films"]
    bounded: Float[np.ndarray, " films"]
    angle: Float[np.ndarray, "films 2"]
    held: Float[np.ndarray, "films 2"]


@kept
def saved(seed: int, scene: str, frames: int, wide: float = 1.0) -> float:
    """Return the share of the particles that only the test for collisions saves."""
    shares: list[float] = []

    def counting(first: First) -> Cue:
        collision, limit = CollisionCue(), LimitCue()

        def cue(seen: Look, bodies: Bodies) -> Float[np.ndarray, " m"]:
            logs = collision(seen, bodies)
            shares.append(float(((logs < 0) & (limit(seen, bodies) == 0)).mean()))
            return logs

        return cue

    bounds = {**BOUNDS, "collisions": counting}
    across, deep = Measures().trunk
    measures = replace(Measures(), trunk=(wide * across, deep))
    follow(ArmTracker(CAMERA, measures, bounds=bounds), film(seed, scene, frames), seed)
    return float(np.mean(shares))


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Track each film with the test and without it."""

    def task(seed: int, rng: np.random.Generator) -> tuple[float, float, list, list]:
        runs = [tracked(seed, config.scene, way, frames=config.frames)
                for way in (config.bounded, WITHOUT)]  # fmt: skip
        only = saved(seed, config.scene, config.frames, config.wide)
        whole = float(runs[0].saved[1:].mean())
        return only, whole, [one.angle for one in runs], [one.held.mean() for one in runs]

    parts = sweep(task, config.seeds, rng=rng, desc="films")
    return Result(config, *(np.array(part, dtype=float) for part in zip(*parts, strict=True)))


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
    "the particles that is in collision and within the limits of the joints, so that only the test "
    "saves it; bootstrap over films.",
    accepted=Accepted(0.02, 1.0, "one particle in fifty at least", Origin.CHOICE),
    sabotage=Change(
        "arms that hang beside a wider trunk",
        config=Config(SCORED[:6], "pointing, plain", 24, wide=1.5),
    ),
)
def collisions_avoided(result: Result) -> Finding:
    """Tell what is saved, and what the test does to the estimate."""
    return Finding(
        bootstrap_mean(result.saved),
        {
            "not measured, with the limits": bootstrap_mean(result.bounded),
            "error of the angles, with over without": bootstrap_ratio(*result.angle.T),
            "arms held, with less without": bootstrap_mean(result.held[:, 0] - result.held[:, 1]),
        },
    )
