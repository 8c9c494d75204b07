"""What the page shows: one ceiling, a loop and a corner below it, and the states of explorers."""

from dataclasses import dataclass
from functools import cache
from itertools import product

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from data_synth.ceiling import CeilingCamera
from robot_perception.ceiling.mosaic import paint
from robot_perception.ceiling.visual_memory import KeyImage, KeyRules, ServoRules
from robot_perception.chapters.ceiling_navigation import chaining, key_images, replays, runs
from robot_perception.chapters.ceiling_navigation.upto_scale import SERVO
from robot_perception.chapters.ceiling_navigation.world import (
    BORDER,
    CENTRE,
    MOUNT,
    SCALE,
    looking,
    seen,
)
from robot_perception.geometry import se2
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.tables import Table

SHOWN = runs.SCORING[0]
"""Seed of the ceiling of the page."""
PER_METRE = 40
"""Pixels of a plan for a metre, at most."""


@recorded("nav-loop")
def loop() -> runs.Run:
    """Return the run of the page: a mosaic on a loop."""
    return runs.drive(SHOWN)


@recorded("nav-comeback")
def comeback() -> replays.Replay:
    """Return the replay of the page: put down beside the path, with a wrong scale."""
    return replays.replay(replays.Lesson(seed=SHOWN), replays.Trial(factor=1.5), 1)


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """A picture of a piece of ceiling, columns along x, and its left, right, lower and upper end.

    The ends are in metres, as axes ask for them whose y runs downwards.
    """

    image: UInt8[np.ndarray, "rows columns"]
    extent: tuple[float, float, float, float]


@cache
def plan(margin: float = 2.0) -> Plan:
    """Return the ceiling above the corner of the film, as it is."""
    above, true = runs.ceiling(SHOWN, side=runs.ROOM), comeback().taught[:, :2]
    ends = above.texels(np.array([true.min(axis=0) - margin, true.max(axis=0) + margin]))
    (left, top), (right, bottom) = np.round(ends).astype(int)
    image = above.texture[top:bottom, left:right]
    share = PER_METRE * above.resolution
    small = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    (west, north), (east, south) = above.places(ends.round() - 0.5)
    return Plan(small, (float(west), float(east), float(south), float(north)))


@recorded("nav-composed")
def composed(every: int = 8) -> Plan:
    """Return the picture that the chained mosaic makes of what the camera saw on the loop.

    One picture in so many is laid where the robot located itself. No truth enters but the place of
    the first pattern.
    """
    run, eye = loop(), CeilingCamera(runs.ceiling(SHOWN), MOUNT)
    images = (eye.image(pose) for pose in run.true[::every])
    poses = run.located(run.mosaic)[::every]
    greys, shown, corner = paint(images, poses, centre=np.array(CENTRE), scale=SCALE)
    greys = np.where(shown, greys, 255).astype(np.uint8)
    west, north = corner - SCALE / 2
    south, east = np.array(greys.shape) * SCALE + [north, west]
    image = cv2.resize(greys, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return Plan(image, (float(west), float(east), float(south), float(north)))


# Servoing ----------------------------------------------------------------------------------------

FACTORS = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
BEARINGS = (1.8, 2.5, 4.0)
ASIDES = (0.0, 0.3, 0.6)
PATH = "slalom"
THERE = key_images.patterns(1.0, rng=np.random.default_rng(9))
"""Patterns above the path of the explorer."""


@cache
def route(kind: str = PATH, way: str = key_images.TWO) -> tuple[KeyImage, ...]:
    """Return the key images of a path below these patterns."""
    images = [seen(looking(), pose, THERE, BORDER) for pose in key_images.taught(kind)]
    picked = key_images.chosen(images, way, KeyRules().turn)
    return tuple(KeyImage(images[k]) for k in picked)


@dataclass(frozen=True, eq=False, slots=True)
class Driven:
    """How a robot drives a path again by exact sightings: a state of the explorer.

    ``factor`` is the assumed over the true scale, ``bearing`` k_α, 1/s; the robot starts ``aside``
    of the path, m.
    """

    factor: float
    bearing: float
    aside: float
    path: Float[np.ndarray, "n 3"]
    status: str

    @property
    def limit(self) -> float:
        """The factor up to which the loop is stable, k_α / k_ρ."""
        return self.bearing / SERVO.gain_distance

    @property
    def off(self) -> float:
        """Mean distance of the taught path from the driven one, m."""
        return float(replays.apart(key_images.taught(PATH), self.path)[0].mean())

    @property
    def wagging(self) -> float:
        """How much the robot turns to and fro, rad for a metre."""
        turned = np.abs(np.diff(np.unwrap(self.path[:, 2]))).sum()
        return float(turned / np.hypot(*np.diff(self.path[:, :2], axis=0).T).sum())

    def words(self) -> str:
        """Return what the state shows."""
        loop_ = "stable" if self.factor < self.limit else "unstable"
        return (
            f"A slalom driven again from {self.aside:g} m beside it with a scale assumed "
            f"{self.factor:g} times the true one and k_α = {self.bearing:g}, near a key image "
            f"{loop_}: the robot has {self.status}, {100 * self.off:.0f} cm off the path on "
            f"average, and turns by {self.wagging:.1f} rad for a metre."
        )


@recorded("nav-driven", product(FACTORS, BEARINGS, ASIDES))
def driven(factor: float, bearing: float, aside: float) -> Driven:
    """Return a state of the explorer of servoing."""
    rules = ServoRules(
        SERVO.gain_distance, bearing, SERVO.gain_heading, fastest=SERVO.fastest,
        fastest_turn=SERVO.fastest_turn,
    )  # fmt: skip
    start = se2.compose(key_images.taught(PATH)[0], np.array([0.0, aside, 0.0]))
    path, status = key_images.replayed(THERE, route(), start, rules, factor=factor)
    return Driven(factor, bearing, aside, path, status)


# The quotient ------------------------------------------------------------------------------------

PAIR = np.array([[0.0, 0.0, 0.4], [1.2, 0.6, -0.7]])
"""The reference, and the new pattern, below the ceiling, m and rad."""
XS, YS = (-0.6, -0.2, 0.2, 0.6, 1.0, 1.4), (-0.4, 0.0, 0.4, 0.8)
TURNS = (-90.0, 0.0, 45.0, 180.0)


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Where two readings put the new pattern, m and rad: a state of the explorer."""

    robot: Float[np.ndarray, "3"]
    poses: dict[str, Float[np.ndarray, "3"]]

    def off(self, reading: str) -> float:
        """Return how far a reading puts the pattern from where it is, m."""
        return float(np.hypot(*(self.poses[reading] - PAIR[1])[:2]))

    def words(self) -> str:
        """Return what the state shows."""
        x, y, turn = self.robot
        return (
            f"A robot at ({x:g}, {y:g}) m, turned by {np.rad2deg(turn):.0f}°, sees the reference "
            f"and a new pattern. A⁻¹ B puts the new one where it is; B A⁻¹ puts it "
            f"{self.off(chaining.OVER):.2f} m away."
        )


def placed(x: float, y: float, turn: float) -> Placed:
    """Return a state of the explorer of the quotient."""
    robot = np.array([x, y, np.deg2rad(turn)])
    names = (chaining.RIGHT, chaining.OVER)
    return Placed(robot, {n: chaining.placed(robot, PAIR, n) for n in names})


# Key images --------------------------------------------------------------------------------------


@recorded("nav-conditions")
def by_conditions(kind: str = "circle") -> dict[str, tuple[np.ndarray, np.ndarray, str]]:
    """Return what is driven by key images of each kind: places of these, path, and how it ends."""
    found = {}
    true = key_images.taught(kind)
    images = [seen(looking(), pose, THERE, BORDER) for pose in true]
    for way in (key_images.TWO, key_images.NO_COMMON, key_images.NO_TURN):
        picked = key_images.chosen(images, way, KeyRules().turn)
        route_ = [KeyImage(images[k]) for k in picked]
        path, status = key_images.replayed(THERE, route_, true[0])
        found[way] = true[list(picked)], path, status
    return found


def setup_table() -> Table:
    """Return the paper's values, ours, and which of them matters."""
    rules = KeyRules()
    rows = {
        "camera": (
            "“low cost”",
            f"{MOUNT.size[0]} × {MOUNT.size[1]} px, {MOUNT.height:g} m below, 2 grey values noise",
            "no",
        ),
        "patterns": ("made as the robot moves", f"as few as {runs.RULES.enough} tracked", "yes"),
        "particles": ("200", f"{runs.RULES.tracker.particles}", "a little"),
        "threshold of turning": ("“a defined threshold”", f"{np.rad2deg(rules.turn):.0f}°", "yes"),
        "visual servoing": (
            "named only",
            f"k = {SERVO.gain_distance:g}, {SERVO.gain_bearing:g}, {SERVO.gain_heading:g} per s",
            "yes",
        ),
        "wheels": ("–", "slip, are not read", "no"),
    }
    return Table(rows, {"paper": "in its words", "ours": "", "matters": ""})
