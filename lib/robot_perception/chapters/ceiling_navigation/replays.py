"""A learned path driven again, by what the camera sees: section 2.4.

The robot is led along a path once, builds its mosaic on the way and keeps key images. Then it is
put down near the beginning, and drives by pictures alone.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from data_synth.ceiling import CeilingCamera, Occluder, drive
from data_synth.wheels import SMALL
from robot_perception.ceiling.mosaic import NoCommonPattern
from robot_perception.ceiling.navigator import Navigator
from robot_perception.ceiling.visual_memory import (
    KeyImage,
    KeyRules,
    choose_key_images,
)
from robot_perception.chapters.ceiling_navigation import runs
from robot_perception.chapters.ceiling_navigation.upto_scale import SERVO
from robot_perception.chapters.ceiling_navigation.world import MOUNT, SCALE, Sightings
from robot_perception.geometry import se2
from robot_perception.teaching.results import kept

ASIDE = np.array([0.3, 0.3, 0.25])
"""How far from the beginning of the path a robot is put down at most, m, m and rad."""
CLOSE, END = 0.1, 0.1
"""A path is reproduced if its points are that near to the driven one on average, and so is the
end to the end, m."""


def apart(
    one: Float[np.ndarray, "n 3"], other: Float[np.ndarray, "m 3"]
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " m"]]:
    """Return how far each point of either path is from the other path, m."""
    gaps = np.hypot(*(one[:, None, :2] - other[None, :, :2]).transpose(2, 0, 1))
    return gaps.min(axis=1), gaps.min(axis=0)


@dataclass(frozen=True, slots=True)
class Lesson:
    """A path that is taught, and how its key images are chosen; all values are ours."""

    seed: int = runs.SCORING[0]
    plan: str = "varied"
    kind: str = "corner"
    most: float = 5.0
    step: float = 0.05
    turn: float = float(np.deg2rad(15.0))
    common: int = 2


@dataclass(frozen=True, slots=True)
class Trial:
    """How a path is driven again; all values are ours.

    ``factor`` is the assumed over the true scale; ``heads`` discs of 15 cm, 1 m above the camera,
    hide parts of the ceiling near the path; ``tilt`` has tilted the camera since the path was
    learned, rad, and ``plan`` made the ceiling another one. A picture comes every ``seconds``, and
    ``most`` of them at most.
    """

    factor: float = 1.0
    heads: int = 0
    tilt: float = 0.0
    plan: str = ""
    seconds: float = 0.1
    most: int = 400


@dataclass(frozen=True, eq=False)
class Replay:
    """A path driven again, picture by picture.

    Parameters
    ----------
    taught : (m, 3)
        The path, m and rad.
    driven : (n, 3)
        Where the robot was in truth, m and rad.
    estimated : (n, 3)
        Where it was in its mosaic, laid over the ceiling, m and rad.
    sightings
        Of each picture.
    key : (n,)
        Number of the key image that it steered for.
    keys
        Numbers of the pictures of the path that are key images.
    status
        ``"arrived"``, or ``"lost"``.
    """

    taught: Float[np.ndarray, "m 3"]
    driven: Float[np.ndarray, "n 3"]
    estimated: Float[np.ndarray, "n 3"]
    sightings: list[Sightings] = field(repr=False)
    key: np.ndarray
    keys: tuple[int, ...]
    status: str

    @property
    def off(self) -> float:
        """Mean distance of the taught path's points from the driven path, m."""
        return float(apart(self.taught, self.driven)[0].mean())

    @property
    def end(self) -> float:
        """Distance of the driven path's end from that of the taught one, m."""
        return float(np.hypot(*(self.driven[-1] - self.taught[-1])[:2]))

    @property
    def reproduced(self) -> bool:
        """Whether the robot came to the end and was near the path."""
        return self.status == "arrived" and self.off <= CLOSE and self.end <= END


def lesson(of: Lesson) -> tuple[runs.Run, tuple[int, ...]]:
    """Return the run along a taught path, and which of its pictures are key images."""
    run = runs.drive(of.seed, of.kind, of.step, of.most, plan=of.plan)
    for common in range(of.common, 0, -1):
        try:
            return run, choose_key_images(run.sightings, KeyRules(of.turn, common))
        except ValueError:  # where fewer patterns are in view, fewer must do
            if common == 1:
                raise
    raise AssertionError


@kept
def replay(of: Lesson, trial: Trial = Trial(), number: int = 0) -> Replay:
    """Return how a robot drives a learned path again, from a start of a number.

    The first start, 0, is where the path begins.
    """
    run, chosen = lesson(of)
    rng = np.random.default_rng([of.seed, 3, number])
    start = se2.compose(run.true[0], rng.uniform(-1, 1, 3) * ASIDE * (number > 0))
    below = CeilingCamera(
        runs.ceiling(of.seed, trial.plan or of.plan, runs.ROOM), replace(MOUNT, pitch=trial.tilt)
    )
    heads = in_the_way(run.true, trial.heads, rng=rng)
    keys = [KeyImage(run.sightings[k]) for k in chosen]
    navigator = Navigator(
        keys, run.patterns, run.mosaic, MOUNT.middle, trial.factor * SCALE, SERVO, runs.RULES
    )

    def look(pose: np.ndarray) -> np.ndarray:
        return below.image(pose, rng=rng, exposure=runs.NOISE, occluders=heads)

    try:
        state = navigator.start(look(start), rng=rng)
    except NoCommonPattern:
        return Replay(run.true, start[None], start[None], [{}], np.zeros(1, int), chosen, "lost")
    poses, found, seen, steered, status = [start], [], [], [], "lost"
    while len(poses) <= trial.most:
        state, info = navigator.step(state, look(poses[-1]), rng=rng)
        found.append(state.pose)
        seen.append(dict(info.sightings))
        steered.append(state.key)
        status = info.status
        if status != "driving":
            break
        poses.append(drive(poses[-1], *info.command, trial.seconds, SMALL, rng=rng))
    driven = np.array(poses[: len(found)])
    estimated = run.below(np.array(found))
    ended = "arrived" if status == "arrived" else "lost"
    return Replay(run.true, driven, estimated, seen, np.array(steered), chosen, ended)


def in_the_way(
    true: Float[np.ndarray, "n 3"], number: int, *, rng: np.random.Generator
) -> list[Occluder]:
    """Return discs at random places near a path."""
    at = true[rng.integers(0, len(true), number), :2] + rng.uniform(-0.8, 0.8, (number, 2))
    return [Occluder(float(x), float(y), 0.15, 1.0, 60.0) for x, y in at]
