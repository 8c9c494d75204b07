"""Drives below rendered ceilings: a mosaic that grows on the way, and what of it is wrong.

The estimator gets pictures only. Where it stood in truth is kept beside it, and compared after.
"""

from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from jaxtyping import Bool, Float

from data_synth.ceiling import Ceiling, CeilingCamera, Exposure, make_ceiling, taught_path
from robot_perception.ceiling.mapping import Mapper, MapRules
from robot_perception.ceiling.mosaic import Links, Mosaic, adjust, in_camera
from robot_perception.ceiling.patterns import Pattern
from robot_perception.chapters.ceiling_navigation.world import CENTRE, MOUNT, SCALE, Sightings
from robot_perception.geometry import se2, wrap_angle
from robot_perception.teaching.results import kept

NOISE = Exposure(noise=2.0)
"""Of a cheap camera, grey values; ours."""
SIDE, ROOM = 17.0, 11.0
"""Of a ceiling above a loop, and above a shorter path, m."""
CHOOSING, SCORING = tuple(range(100, 116)), tuple(range(300, 320))
"""Seeds of the ceilings on which numbers were chosen, and of those that are scored."""


RULES = MapRules(closing="chain")
"""As in the paper: the mosaic stays as it was chained."""


@cache
def ceiling(seed: int, kind: str = "varied", side: float = SIDE) -> Ceiling:
    """Return a ceiling."""
    return make_ceiling(kind, rng=np.random.default_rng(seed), side=side)


def path(kind: str, step: float, seed: int | None = None, most: float = np.inf):
    """Return a taught path below the middle of a ceiling, (n, 3): its middle ``most`` metres.

    The seed is that of the teacher's hand; without one it is perfect.
    """
    rng = None if seed is None else np.random.default_rng([seed, 1])
    poses = taught_path(kind, step=step, rng=rng)
    if most < np.inf:
        keep = int(most / step) // 2
        middle = len(poses) // 2
        poses = poses[middle - keep : middle + keep + 1]
    low, high = poses[:, :2].min(axis=0), poses[:, :2].max(axis=0)
    return poses - np.append((low + high) / 2, 0.0)


@dataclass(frozen=True, eq=False)
class Run:
    """A mosaic, and the robot in it, picture by picture.

    Parameters
    ----------
    mosaic, patterns
        At the end.
    sightings
        Of each picture.
    poses : (n, 3)
        Of the robot when the picture came, in the mosaic.
    closed : (n,)
        Pictures in which a loop was closed.
    links
        Ways between patterns that were seen together.
    true : (n, 3)
        Of the robot below the ceiling, m and rad.
    born
        True poses of the patterns below the ceiling, m and rad.
    """

    mosaic: Mosaic
    patterns: dict[str, Pattern] = field(repr=False)
    sightings: list[Sightings] = field(repr=False)
    poses: Float[np.ndarray, "n 3"]
    closed: Bool[np.ndarray, " n"]
    links: Links = field(repr=False)
    true: Float[np.ndarray, "n 3"]
    born: dict[str, Float[np.ndarray, "3"]] = field(repr=False)

    @property
    def frame(self) -> Float[np.ndarray, "3"]:
        """Pose of the mosaic below the ceiling: that of the first pattern when it was made."""
        return next(iter(self.born.values()))

    def below(self, poses: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
        """Return poses in the mosaic as poses below the ceiling, in metres and rad."""
        return se2.compose(self.frame, poses)

    def located(self, mosaic: Mosaic) -> Float[np.ndarray, "n 3"]:
        """Return poses of the robot below the ceiling as a mosaic tells them of its sightings."""
        found, last = [], self.poses[0]
        for sightings in self.sightings:
            known = mosaic.poses.keys() & sightings.keys()
            last = mosaic.locate(sightings)[0] if known else last
            found.append(last)
        return self.below(np.array(found))

    @cached_property
    def adjusted(self) -> Mosaic:
        """The mosaic fitted to all that was seen together."""
        return adjust(self.mosaic, self.links, fixed=next(iter(self.born)), loss="cauchy")[0]

    def off(self, poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
        """Return how far poses are from where the robot was, m."""
        return np.hypot(*(poses - self.true)[:, :2].T)

    def turned(self, poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
        """Return by how much headings are wrong, rad."""
        return np.abs(wrap_angle(poses - self.true)[:, 2])

    def patterns_off(self, mosaic: Mosaic) -> Float[np.ndarray, " patterns"]:
        """Return how far the patterns of a mosaic of the run are from where they are, m."""
        names = [name for name in self.born if name in mosaic.poses]
        there = self.below(np.array([mosaic.poses[name] for name in names]))
        return np.hypot(*(there - np.array([self.born[name] for name in names]))[:, :2].T)

    @property
    def way(self) -> float:
        """How far the robot drove, m."""
        return float(np.hypot(*np.diff(self.true[:, :2], axis=0).T).sum())


def mapped(
    camera: CeilingCamera,
    true: Float[np.ndarray, "n 3"],
    scale: float = SCALE,
    rules: MapRules = RULES,
    *,
    rng: np.random.Generator,
) -> Run:
    """Return the run of a robot that builds a mosaic on a path, with Z/f as it believes it."""
    mapper = Mapper(scale, MOUNT.middle, rules)
    state = mapper.start()
    seen, poses, closed, born = [], [], [], {}
    for pose in true:
        image = camera.image(pose, rng=rng, exposure=NOISE)
        state, info = mapper.step(state, image, rng=rng)
        for name in info.new:
            there = in_camera(info.sightings[name], centre=np.array(CENTRE), scale=SCALE)
            born[name] = se2.compose(pose, there)
        seen.append(dict(info.sightings))
        poses.append(state.pose)
        closed.append(info.closed)
    patterns = {name: state.patterns[name] for name in born}
    return Run(
        state.mosaic, patterns, seen, np.array(poses), np.array(closed), state.links, true, born
    )


@kept
def drive(
    seed: int,
    kind: str = "loop",
    step: float = 0.06,
    most: float = np.inf,
    factor: float = 1.0,
    plan: str = "varied",
) -> Run:
    """Return the run below a ceiling, along a path that a hand taught.

    The seed is that of ceiling, hand and noise; ``factor`` is the assumed over the true scale.
    """
    side = SIDE if kind == "loop" else ROOM
    below = CeilingCamera(ceiling(seed, plan, side), MOUNT)
    true = path(kind, step, seed, most)
    return mapped(below, true, factor * SCALE, rng=np.random.default_rng([seed, 2]))
