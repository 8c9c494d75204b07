"""Sessions as studies stage them: who is there, what they do, and which sensors of the robot work.

A session follows from its `Config` alone: the same numbers are the same office, the same people and
the same noise. What a sensor reports does not depend on which others take part.
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
"""Rig for what the sensors could know; the pixels of faces, which take long, are not asked for."""

_NEVER = 60.0, 0.001  # when a sensor reads that takes no part, s, and how often after that, Hz


@dataclass(frozen=True, slots=True)
class Config:
    """One session: all that it follows from.

    Paper: an office room, the robot standing in its middle, up to three people, no duration. Ours:
    the office, three people and what they do.

    Parameters
    ----------
    seed
        Of office, people, what they do, and noise.
    duration
        How long it takes, s.
    robot
        ``"stands"`` in the middle of a room, or ``"drives"`` from room to room.
    lights_out
        When all lamps go out, s; never if left out.
    sensors
        Which of `SENSORS` take part.
    distractors
        Whether there are table legs, chair legs, baskets, wood and cork.
    skirts
        Whether one in ten people wears a long skirt, or nobody.
    faces
        Probability that somebody who stops looks at the robot.
    leaves
        Probability that the next goal of somebody is the way out.
    pace
        Factor by which people walk slower or faster.
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
        """Number of readings that its sensors take."""
        used = rig(self.sensors)
        pairs = zip(used.delays, used.rates, strict=True)
        lasting = ((self.duration - delay, rate) for delay, rate in pairs)
        return sum(int(time * rate) + 1 for time, rate in lasting if time > 0)


def rig(sensors: Sequence[str], ring: SonarRing = RIG.ring) -> Rig:
    """Return a robot with some sensors at work; those left out are silent for a minute at first.

    Parameters
    ----------
    sensors
        Which of `SENSORS`.
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
    """Return a session, and the source of the noise of its readings.

    Parameters
    ----------
    config
        The session.
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
    """Return what is known of the p people at j times, by name.

    That is ``polar`` (j, p, 2), distance and direction from the robot, m and rad; who is
    ``present``, and whose head is ``clear`` of what stands; how many ``beams`` of the laser and
    ``cones`` of the sonars meet the legs; the sine by which the body is turned off the robot
    (``side``), the cosine by which the face is turned to it (``gaze``), and how far the legs
    ``swing``, m; all of (j, p).

    Parameters
    ----------
    session
        The session.
    times : (j,)
        One at least, s.
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
    """Tell which of `SENSORS` take no part."""
    is_list = isinstance(sensors, Sequence) and not isinstance(sensors, str)
    if not is_list or not all(isinstance(name, str) and name in SENSORS for name in sensors):
        raise ValueError(f"sensors must be of {', '.join(SENSORS)}, got {sensors!r:.60}")
    return [name not in sensors for name in SENSORS]
