"""Memory of the way on which the robot was led: one map in metres, one below the ceiling.

The two are of the same way, so that a place in one is a place in the other.
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
    """Notes that the robot takes on the way.

    Parameters
    ----------
    poses, ancestors
        Poses of all particles after each stereo pair, and which particle each comes from.
    since
        For each picture of the ceiling: how many pairs came before it, and how the robot has moved
        since the last one, m and rad.
    sightings
        Patterns in each picture of the ceiling.
    told
        Places that were named: after how many pictures of the ceiling, and where, m, ahead and to
        the left.
    scans
        For each scan: how many pairs came before it, the motion since, and its readings, m.
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
        Points with their looks, in the frame of the map, m.
    walls
        Straight walls in the same frame.
    poses : (n, 3)
        Of the robot in that frame at each picture of the ceiling, m and rad.
    sightings
        Patterns in each of these pictures.
    patterns, mosaic
        What they look like, and where they are relative to each other.
    onto : (3,)
        The motion that lays the mosaic's frame on the map's.
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
        """Return the picture of the way taken nearest to a pose, in about its direction.

        Parameters
        ----------
        pose : (3,)
            In the map, m and rad.
        turned
            How far the headings may differ, rad.
        """
        pose, turned = checks.vector("pose", pose, 3), checks.positive("turned", turned)
        away = np.hypot(*(self.poses[:, :2] - pose[:2]).T)
        off = np.abs(wrap_angle(self.poses[:, 2] - pose[2]))
        away = np.where(off <= turned, away, np.inf)
        return int(away.argmin()) if np.isfinite(away).any() else None

    def passes(self, place: str, within: float = 1.5) -> list[int]:
        """Return the pictures that were taken nearest to a place, one for each time it was passed.

        Raises
        ------
        ValueError
            If there is no such place.
        """
        checks.one_of("place", place, self.places)
        within = checks.positive("within", within)
        away = np.hypot(*(self.poses[:, :2] - self.places[place]).T)
        near = np.flatnonzero(away <= max(within, away.min() + 0.1))
        runs = np.split(near, np.flatnonzero(np.diff(near) > 10) + 1)
        return [int(run[away[run].argmin()]) for run in runs]

    def route(self, first: int, last: int, rules: KeyRules) -> list[KeyImage]:
        """Return key images of the way from one of its pictures to a later one.

        Raises
        ------
        NoCommonPattern
            If the pictures between have too few patterns in common.
        ValueError
            If the last is not later than the first.
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
    """Return what is kept of a lesson.

    Of all particles that with the largest weight at the end tells where the robot was. The mosaic
    is fitted to all that was seen together, and laid onto the map by the way.

    Parameters
    ----------
    lesson
        What was noted.
    maps, above, walls
        States of stereo SLAM, of the mosaic and of the walls at the end.

    Raises
    ------
    ValueError
        If there was no stereo pair, or no picture of the ceiling shows a pattern of the mosaic.
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
    """Return poses by how many poses of the way came before each, and the motion since."""
    return np.array([se2.compose(way[max(count - 1, 0)], step) for count, step in since])
