"""Memory of a lesson: the way on which the robot was led, in two maps that share it.

The one is a map of landmarks and walls, in metres. The other is visual: the pictures of the ceiling
taken along the way, and the mosaic of their patterns. For each picture the pose in the metric map
is known, so that a place in one map is also a place in the other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.ceiling.mapping import MapState
from robot_perception.ceiling.mosaic import Mosaic, NoCommonPattern, adjust, pieces
from robot_perception.ceiling.patterns import Pattern
from robot_perception.ceiling.visual_memory import KeyImage, KeyRules, choose_key_images
from robot_perception.evaluation.trajectories import align
from robot_perception.geometry import se2
from robot_perception.geometry.angles import wrap_angle
from robot_perception.slam import rao_blackwellised
from robot_perception.slam.localisation import LandmarkMap
from robot_perception.slam.visual import VisualMaps
from robot_perception.walls.wall_map import WallMap

__all__ = ["Lesson", "Memory", "remember"]

Sightings = Mapping[str, Float[np.ndarray, " 4"]]


@dataclass(frozen=True, eq=False, slots=True)
class Lesson:
    """Notes that the robot takes while it is led.

    Parameters
    ----------
    poses, ancestors
        For each stereo pair: the poses of all particles after it, and the number of the particle
        that each was resampled from.
    since
        For each picture of the ceiling: how many stereo pairs came before it, and the robot's
        motion since the last of them, m and rad.
    sightings
        For each picture of the ceiling: poses (x, y, θ, s) of its patterns, by name.
    told
        For each place that the tutor named: how many pictures of the ceiling came before, and where
        the place is from the robot, ahead and to the left, m.
    scans
        For each laser scan: how many stereo pairs came before it, the robot's motion since the last
        of them, and the ranges, m.
    """

    poses: tuple[Float[np.ndarray, "M 3"], ...] = ()
    ancestors: tuple[np.ndarray, ...] = ()
    since: tuple[tuple[int, Float[np.ndarray, "3"]], ...] = ()
    sightings: tuple[Sightings, ...] = ()
    told: Mapping[str, tuple[int, Float[np.ndarray, "2"]]] = field(default_factory=dict)
    scans: tuple[tuple[int, Float[np.ndarray, "3"], Float[np.ndarray, " beams"]], ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Memory:
    """Memory of a lesson.

    Parameters
    ----------
    landmarks
        Landmarks with their descriptors; their frame is that of the map, m.
    walls
        Straight walls in the same frame.
    poses : (n, 3)
        Pose of the robot in that frame at each picture of the ceiling, m and rad.
    sightings
        For each of these pictures: poses (x, y, θ, s) of its patterns, by name.
    patterns, mosaic
        The patterns by name, and their poses relative to each other.
    onto : (3,)
        Rigid motion from the frame of the mosaic to that of the map, m and rad.
    places
        Named places in the map, m.
    """

    landmarks: LandmarkMap
    walls: WallMap
    poses: Float[np.ndarray, "n 3"]
    sightings: tuple[Sightings, ...]
    patterns: Mapping[str, Pattern]
    mosaic: Mosaic
    onto: Float[np.ndarray, "3"]
    places: Mapping[str, Float[np.ndarray, "2"]]

    def nearest(self, pose: Float[np.ndarray, "3"], turned: float) -> int | None:
        """Return the number of the picture nearest to a pose among those of a similar heading.

        It is ``None`` if no picture was taken with such a heading.

        Parameters
        ----------
        pose : (3,)
            Pose in the map, m and rad.
        turned
            Largest difference of headings, rad.
        """
        pose, turned = checks.vector("pose", pose, 3), checks.positive("turned", turned)
        away = np.hypot(*(self.poses[:, :2] - pose[:2]).T)
        off = np.abs(wrap_angle(self.poses[:, 2] - pose[2]))
        away = np.where(off <= turned, away, np.inf)
        return int(away.argmin()) if np.isfinite(away).any() else None

    def passes(self, place: str, within: float = 1.5) -> list[int]:
        """Return the numbers of the pictures nearest to a place, one for each time it was passed.

        Parameters
        ----------
        place
            Name of the place.
        within
            Distance at which a picture counts as taken at the place, m. If the way keeps farther
            off, its nearest pictures count.

        Raises
        ------
        ValueError
            If no place has this name.
        """
        checks.one_of("place", place, self.places)
        within = checks.positive("within", within)
        away = np.hypot(*(self.poses[:, :2] - self.places[place]).T)
        near = np.flatnonzero(away <= max(within, away.min() + 0.1))
        runs = np.split(near, np.flatnonzero(np.diff(near) > 10) + 1)
        return [int(run[away[run].argmin()]) for run in runs]

    def route(self, first: int, last: int, rules: KeyRules) -> list[KeyImage]:
        """Return key images along the way from one of its pictures to a later one.

        Parameters
        ----------
        first, last
            Numbers of the two pictures.
        rules
            Rules by which key images are chosen among the pictures.

        Raises
        ------
        NoCommonPattern
            If neighbouring pictures have too few patterns in common.
        ValueError
            If there are no such pictures, or the last is not later than the first.
        """
        first, last = checks.whole("first", first), checks.whole("last", last)
        checks.instance("rules", rules, KeyRules)
        if not 0 <= first < last < len(self.sightings):
            raise ValueError(f"last must come after first {first} on the way, got {last}")
        part = self.sightings[first : last + 1]
        try:
            return [KeyImage(part[k]) for k in choose_key_images(part, rules)]
        except ValueError as gap:
            raise NoCommonPattern(f"the way from {first} to {last} has a gap: {gap}") from gap


def remember(lesson: Lesson, maps: VisualMaps, above: MapState, walls: WallMap) -> Memory:
    """Return the memory of a lesson.

    The way is the path of the particle with the largest weight at the end. The mosaic is adjusted
    to all pairs of patterns that were seen together, and moved onto the map so that the robot's
    positions below it fit those of the way. A named place counts from the pose at the first picture
    of the ceiling after it was named.

    Parameters
    ----------
    lesson
        Notes of the lesson.
    maps, above, walls
        States of stereo SLAM, of the mosaic of the ceiling and of the walls at the end.

    Raises
    ------
    ValueError
        If there was no stereo pair or no picture of the ceiling, or no such picture shows a pattern
        of the mosaic.
    """
    checks.instance("lesson", lesson, Lesson)
    checks.instance("maps", maps, VisualMaps)
    checks.instance("above", above, MapState)
    checks.instance("walls", walls, WallMap)
    if not lesson.poses or not lesson.since:
        raise ValueError("lesson must have a pair and a picture of the ceiling, got none")
    paths = rao_blackwellised.paths(list(lesson.poses), list(lesson.ancestors))
    way = paths[:, maps.maps.best]
    poses = _at(way, lesson.since)
    part = pieces(above.mosaic, above.links)[0]
    mosaic = adjust(part, above.links, fixed=next(iter(part.poses)), loss="cauchy")[0]
    known = [k for k, seen in enumerate(lesson.sightings) if mosaic.poses.keys() & seen.keys()]
    if not known:
        raise ValueError("lesson must have a picture of a pattern of the mosaic, got none")
    below = np.array([mosaic.locate(lesson.sightings[k])[0] for k in known])
    places = {
        name: se2.act(poses[min(k, len(poses) - 1)], place[None])[0]
        for name, (k, place) in lesson.told.items()
    }
    return Memory(
        LandmarkMap.of(maps),
        walls,
        poses,
        lesson.sightings,
        above.patterns,
        mosaic,
        align(below, poses[known]),
        places,
    )


def _at(
    way: Float[np.ndarray, "k 3"], since: Sequence[tuple[int, Float[np.ndarray, "3"]]]
) -> Float[np.ndarray, "n 3"]:
    """Return the pose at each reading: that after the last stereo pair, and the motion since.

    A reading before the first pair counts from the pose after it.
    """
    return np.array([se2.compose(way[max(count - 1, 0)], step) for count, step in since])
