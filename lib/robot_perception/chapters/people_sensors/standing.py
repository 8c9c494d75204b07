"""Somebody who stands where the reader puts them, and what the three sensors make of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np
from jaxtyping import Float

from data_synth.people import FisheyeImage, PeopleOffice, Person, make_people_office, make_person
from data_synth.people.signals import Sensing
from data_synth.people.world import Moment
from robot_perception.chapters.people_sensors import witnesses
from robot_perception.chapters.people_sensors.sessions import RIG, SENSORS, Senses, points
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import se2
from robot_perception.people.detections import Detections
from robot_perception.teaching.recorded import recorded

OFFICE, ROOM, OFF = 81, 5, (1.0, 0.3)
"""An office that is not learnt on, chosen on or scored: its seed, a room with much free floor, and
how far from the middle of the room the robot stands, m."""
DISTANCES = 0.8, 1.4, 2.0
DIRECTIONS = tuple(range(-160, 161, 40))
"""Where the person may stand, seen from the robot: m, and degrees from ahead to the left."""
HOW = {"facing the robot": 180, "sideways": 90, "turned away": 0, "in a long skirt": 180}
"""How: direction of body and face, degrees from that in which the robot sees the person.

The hair is long: from behind there is no skin to be seen.
"""
ENOUGH = 1.2
"""The camera has followed its candidates for so long before the sensors are asked, s."""


@dataclass(frozen=True, eq=False, slots=True)
class Stood:
    """A person at a distance and in a direction (m, degrees), and what each sensor detects.

    Scan and echoes are what came back from the laser and to the sonars, m, and infinite or NaN
    where nothing did.
    """

    distance: float
    direction: float
    how: str
    found: Mapping[str, Detections]
    scan: Float[np.ndarray, " beams"]
    echoes: Float[np.ndarray, " sonars"]

    @property
    def polar(self) -> Float[np.ndarray, "1 2"]:
        """Distance and direction, m and rad."""
        return np.array([[self.distance, np.deg2rad(self.direction)]])

    @property
    def heading(self) -> float:
        """Where the body turns to, from ahead of the robot to the left, rad."""
        return float(np.deg2rad(self.direction + HOW[self.how]))

    def sees(self, sensor: str) -> bool:
        """Return whether a sensor has a detection of the person."""
        found = self.found[sensor].positions.mean
        return len(witnesses.pairs(self.polar, found, sensor)[0]) == 1

    @property
    def false(self) -> int:
        """How many detections are not the person."""
        return sum(len(one) for one in self.found.values()) - sum(map(self.sees, SENSORS))

    @property
    def words(self) -> str:
        """Who finds the person."""
        *first, last = [*filter(self.sees, SENSORS)] or ["none of the three"]
        return "found by " + (f"{', '.join(first)} and {last}" if first else last)


def stood(distance: float, direction: float, how: str) -> Stood:
    """Return what the sensors make of somebody at a place."""
    return everywhere()[distance, direction, how]


@recorded("people-stand")
def everywhere() -> dict[tuple[float, float, str], Stood]:
    """Return what the sensors make of somebody at every place."""
    states = list(product(DISTANCES, DIRECTIONS, HOW))
    done = sweep(_stand, states, rng=np.random.default_rng(11), desc="places")
    return dict(zip(states, done, strict=True))


@cache
def _office() -> tuple[PeopleOffice, Person, Float[np.ndarray, "3"]]:
    """Return the office, who stands in it, and the pose of the robot."""
    rng = np.random.default_rng(OFFICE)
    office = make_people_office(rng=rng)
    low, high = np.split(office.rooms[ROOM], 2)
    person = replace(make_person(rng=rng), long_hair=True)
    return office, person, np.array([*(low + high) / 2 + OFF, 0.0])


def _stand(state: tuple[float, float, str], *, rng: np.random.Generator) -> Stood:
    office, person, robot = _office()
    asked = Stood(*state, {}, np.zeros(0), np.zeros(0))
    place, rest = se2.act(robot, points(asked.polar)), np.zeros(1)
    facing = np.array([asked.heading + robot[2]])
    start, end = (
        Moment(time, robot, place, facing, facing, rest, rest, np.array([True]))
        for time in (0.0, ENOUGH + 0.1)
    )
    once = replace(RIG, rates=(1.0, 1.0, RIG.rates[2]), delays=(ENOUGH, ENOUGH, RIG.delays[2]))
    dressed = replace(person, skirt=asked.how == "in a long skirt")
    sensing, senses = Sensing(office, [dressed], once, rng=rng), Senses(rng)
    readings = list(sensing.due(start, end))
    found = [senses.detect(reading, robot[2]) for reading in readings]
    ranges = [one.ranges for one in readings if not isinstance(one, FisheyeImage)]
    return replace(  # of the camera the last reading
        asked, found={one.sensor: one for one in found}, scan=ranges[0], echoes=ranges[1]
    )


def room() -> Float[np.ndarray, "f 2 2"]:
    """Return walls and furniture at the height of the laser, ahead and to the left, m."""
    office, _, robot = _office()
    faces, _ = office.section(RIG.scan_height)
    return se2.act(se2.inverse(robot), faces.reshape(-1, 2)).reshape(-1, 2, 2)
