"""Sessions as studies stage them: the people, what they do, and which sensors of the robot work.

A session follows from its `Config` alone: equal values give the same office, the same people and
the same noise. The noise of a sensor does not depend on which other sensors take part.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from data_synth._checks import array, instance, number, whole
from data_synth.fisheye import Fisheye
from data_synth.people.bodies import make_person
from data_synth.people.office import make_people_office
from data_synth.people.session import Session, make_session
from data_synth.people.signals import Rig, truth
from data_synth.people.world import STEP, Wander
from data_synth.sonar import SonarRing

SENSORS = ("laser", "sonar", "camera")
"""Sensors of the paper's robot, in the order of a rig."""

PEOPLE = 3
"""Number of people in a session."""

RIG = Rig()
"""The paper's robot with all its sensors at work."""

_TRUTH = Rig(camera=Fisheye(size=8))
"""Rig with which the truth is computed; its camera is tiny, as no pixel of it is needed."""

_NEVER = 60.0, 0.001  # first reading, s, and rate, Hz, of a sensor that takes no part


@dataclass(frozen=True, slots=True)
class Config:
    """Settings of a session; everything in it follows from them.

    The paper has an office room, the robot in its middle and up to three people, and names no
    duration. The plan of the office, the number of people and their motion are our choice.

    Parameters
    ----------
    seed
        Seed of the office, the people, their decisions and the noise.
    duration
        Length of the session, s.
    robot
        ``"stands"`` in the middle of a room, or ``"drives"`` from room to room.
    lights_out
        Time at which all lamps go out, s; never if not given.
    sensors
        The sensors that take part, names of `SENSORS`.
    distractors
        Whether the office holds what detectors confuse with people: table legs, chair legs and
        baskets like legs; wood and cork like skin.
    skirts
        Whether each person wears a long skirt with a probability of one in ten; else nobody does.
    faces
        Probability that a person who stops looks at the robot.
    leaves
        Probability that a person's next goal is the way out.
    pace
        Factor of everybody's walking speed.
    """

    seed: int
    duration: float = 40.0
    robot: str = "stands"
    lights_out: float | None = None
    sensors: tuple[str, ...] = SENSORS
    distractors: bool = True
    skirts: bool = True
    faces: float = 0.5
    leaves: float = 0.12
    pace: float = 1.0

    def __post_init__(self) -> None:
        whole("seed", self.seed, 0, 2**62)
        number("duration", self.duration, 2 * STEP, 3600.0)
        if not isinstance(self.robot, str) or self.robot not in ("stands", "drives"):
            raise ValueError(f"robot must be stands or drives, got {self.robot!r:.40}")
        if self.lights_out is not None:
            number("lights_out", self.lights_out)
        _silent(self.sensors)
        instance("distractors", self.distractors, bool)
        instance("skirts", self.skirts, bool)
        number("faces", self.faces, 0.0, 1.0)
        number("leaves", self.leaves, 0.0, 1.0)
        number("pace", self.pace, 0.1, 2.0)

    @property
    def readings(self) -> int:
        """Number of readings that all sensors take together during the session."""
        used = rig(self.sensors)
        pairs = zip(used.delays, used.rates, strict=True)
        lasting = ((self.duration - delay, rate) for delay, rate in pairs)
        return sum(int(time * rate) + 1 for time, rate in lasting if time > 0)


def rig(sensors: Sequence[str], ring: SonarRing = RIG.ring) -> Rig:
    """Return the paper's robot with some of its sensors at work.

    A rig has no switch: a sensor that is left out reads first after a minute, and then once in a
    thousand seconds. A session longer than a minute therefore holds a reading of it.

    Parameters
    ----------
    sensors
        The sensors that take part, names of `SENSORS`.
    ring
        The sonars.

    Raises
    ------
    ValueError
        If there is no such sensor.
    """
    silent, (never, rarely) = _silent(sensors), _NEVER
    delays, rates = np.where(silent, never, RIG.delays), np.where(silent, rarely, RIG.rates)
    return replace(RIG, ring=ring, delays=tuple(delays), rates=tuple(rates))


def staged(config: Config) -> tuple[Session, np.random.Generator]:
    """Return the session of some settings, and the source of the noise of its readings.

    Parameters
    ----------
    config
        The settings.
    """
    instance("config", config, Config)
    rng = np.random.default_rng(config.seed)
    office = make_people_office(rng=rng, distractors=config.distractors)
    skirt = None if config.skirts else False
    people = [make_person(rng=rng, skirt=skirt) for _ in range(PEOPLE)]
    people = [replace(person, pace=config.pace * person.pace) for person in people]
    how = {name: getattr(config, name) for name in ("duration", "robot", "lights_out")}
    act = Wander(leaves=config.leaves, faces=config.faces)
    return make_session(office, rng=rng, people=people, act=act, **how), rng


def truths(session: Session, times: Sequence[float]) -> dict[str, np.ndarray]:
    """Return the truth about p people at j times.

    Parameters
    ----------
    session
        The session.
    times : (j,)
        Times within the session, at least one, s.

    Returns
    -------
    dict
        Arrays (j, p) by name, except for ``polar``:

        * ``polar`` (j, p, 2): distance and direction from the robot, m and rad;
        * ``present``: whether the person is on the floor;
        * ``clear``: whether nothing stands between the person's head and the camera;
        * ``beams``, ``cones``: how many beams of the laser and cones of the sonars meet the legs;
        * ``side``: absolute sine of the angle between body and robot, 0 for a body that faces the
          robot or turns its back on it, 1 for one seen from the side;
        * ``gaze``: cosine of the angle between face and robot, 1 for a face that looks at it;
        * ``swing``: how far the legs swing, m.

    Raises
    ------
    ValueError
        If there is no time, or one lies outside the session.
    """
    instance("session", session, Session)
    times, end = array("times", times, (None,)), float(session.times[-1])
    if not len(times) or times.min() < 0 or times.max() > end:
        raise ValueError(f"times must be one at least, from 0 to {end:g} s, got {times}")
    moments = [session.at(time) for time in times.tolist()]
    known = [truth(session.office, session.people, moment, _TRUTH) for moment in moments]

    def column(rows: Sequence[object], name: str) -> np.ndarray:
        return np.array([getattr(row, name) for row in rows])

    to_robot = column(moments, "robot")[:, None, :2] - column(moments, "positions")
    to_robot = np.arctan2(to_robot[..., 1], to_robot[..., 0])
    names = "polar", "present", "clear", "beams", "cones"
    return {name: column(known, name) for name in names} | {
        "side": np.abs(np.sin(column(moments, "headings") - to_robot)),
        "gaze": np.cos(column(moments, "gazes") - to_robot),
        "swing": column(moments, "swings"),
    }


def _silent(sensors: Sequence[str]) -> list[bool]:
    """Tell for each of `SENSORS` whether it takes no part."""
    is_list = isinstance(sensors, Sequence) and not isinstance(sensors, str)
    if not is_list or not all(isinstance(name, str) and name in SENSORS for name in sensors):
        raise ValueError(f"sensors must be of {', '.join(SENSORS)}, got {sensors!r:.60}")
    return [name not in sensors for name in SENSORS]
