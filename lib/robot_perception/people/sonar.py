r"""People in one round of readings of a ring of sonars: every near object may be a person.

A cone of 15° cannot tell a leg from a wall. So each reading below two metres is a hypothesis of a
person. Neighbouring readings that may come from the same person are merged, and a map, if there is
one, rules out readings of what it knows.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.people._readings import check_readings
from robot_perception.people.detections import polar

Occupied = Callable[[Float[np.ndarray, "n 2"]], Bool[np.ndarray, " n"]]
"""Function of points in the robot's frame that tells which lie on something that the map knows."""


@dataclass(frozen=True, slots=True)
class SonarRules:
    """Rules for sonar readings. The paper gives the value of ``reach``; the others are our choice.

    Parameters
    ----------
    reach
        Readings from this distance on are left out, m from the sensor.
    widest
        Largest distance between two readings of one person, m. A wider group of neighbours is not
        merged: each of its readings remains a hypothesis.
    depth
        Distance from the surface that reflects the sound to the middle of the person, m.
    range_sigma
        Standard deviation of a person's distance, m.
    bearing_sigma
        Standard deviation of the direction, rad.

    Raises
    ------
    ValueError
        If a number is not positive, or ``depth`` is negative.

    References
    ----------
    Schaffernicht et al. 2005 (see `Detections`), sections 2.2 and 3.1.
    """

    reach: float = 2.0
    widest: float = 0.5
    depth: float = 0.1
    range_sigma: float = 0.2
    bearing_sigma: float = np.deg2rad(10.0)

    def __post_init__(self) -> None:
        for name in ("reach", "widest", "range_sigma", "bearing_sigma"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        object.__setattr__(self, "depth", checks.not_negative("depth", self.depth))


def detect(
    ranges: Float[np.ndarray, " n"],
    angles: Float[np.ndarray, " n"],
    ring_radius: float,
    rules: SonarRules = SonarRules(),
    occupied: Occupied | None = None,
) -> Gaussian:
    r"""Return the positions at which people may stand, from one round of readings.

    Parameters
    ----------
    ranges : (n,)
        Readings, m; infinite where nothing came back.
    angles : (n,)
        Direction of each sensor, in which it sits on the ring and looks, rad; rising over less than
        a turn.
    ring_radius
        Distance of the sensors from the middle of the robot, m.
    rules
        Rules for the readings.
    occupied
        Function of points (m, 2) in the frame of the robot, m, that tells which lie on something
        that the map knows. Readings there are left out, so a person close to a wall is missed.

    Returns
    -------
    Gaussian
        Positions :math:`(r, \varphi)` about the robot, m and rad: a batch with one entry for each
        hypothesis.

    Raises
    ------
    ValueError
        If the shapes disagree, there is no sensor, a reading is NaN or not positive, the angles do
        not rise or they span a turn, the radius is negative, or ``occupied`` returns another shape.

    References
    ----------
    Schaffernicht et al. 2005 (see `Detections`), sections 2.2 and 3.1.
    """
    ranges = checks.array("ranges", ranges, ("n",), finite=False)
    angles = checks.array("angles", angles, ranges.shape, f"ranges {ranges.shape}")
    check_readings("ranges", ranges)
    if (np.diff(angles) <= 0).any() or angles[-1] - angles[0] >= 2 * np.pi:
        raise ValueError("angles must rise over less than a turn")
    ring_radius = checks.not_negative("ring_radius", ring_radius)
    reach = checks.instance("rules", rules, SonarRules).reach
    near = ranges < reach
    r = np.where(near, ranges, reach) + ring_radius
    points = r[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    if occupied is not None:
        checks.instance("occupied", occupied, Callable)
        known = checks.instance("occupied(points)", occupied(points[near]), np.ndarray)
        checks.shaped("occupied(points)", known, (np.count_nonzero(near),))
        near[near] = ~known.astype(bool)
    centres = np.array([points[rows].mean(axis=0) for rows in _groups(near, points, rules.widest)])
    x, y = centres.reshape(-1, 2).T
    r = np.hypot(x, y) + rules.depth
    return polar(r, np.arctan2(y, x), rules.range_sigma, rules.bearing_sigma)


def _groups(near: np.ndarray, points: np.ndarray, widest: float) -> list[list[int]]:
    """Return the groups of near readings: chains of neighbours that lie close to each other.

    A chain whose ends are more than ``widest`` apart is split into single readings.
    """
    count = len(near)
    linked = near & np.roll(near, -1)  # to the next sensor; the last is next to the first
    linked &= np.hypot(*(np.roll(points, -1, axis=0) - points).T) <= widest
    starts = np.flatnonzero(near & ~np.roll(linked, 1))
    if not starts.size:  # no reading is near, or the chain goes all round
        return [[k] for k in np.flatnonzero(near).tolist()]
    groups = []
    for start in starts.tolist():
        chain = [start]
        while linked[chain[-1]]:
            chain.append((chain[-1] + 1) % count)
        ends = points[[chain[0], chain[-1]]]
        whole = np.hypot(*(ends[1] - ends[0])) <= widest
        groups += [chain] if whole else [[k] for k in chain]
    return groups
