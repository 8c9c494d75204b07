"""Sessions: minutes in an office with people round a robot, recorded with their truth."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from data_synth._checks import array, generator, instance, number, reals, whole
from data_synth._grid import direction, on_grid
from data_synth.people.bodies import Person, make_person
from data_synth.people.office import PeopleOffice
from data_synth.people.signals import FisheyeImage, LaserScan, Rig, Sensing, SonarScan
from data_synth.people.world import STEP, Moment, Wander, World, between
from data_synth.wheels import SMALL, Odometry, roll

_CRUISE, _SPIN = 0.4, 0.8  # of the robot, m/s and rad/s
_NEAR = 0.9  # the robot stops for people nearer than that in front of it, m
_WAITS = 2.0, 6.0  # between two drives, s
_PATIENCE = 5.0  # before it drives elsewhere, s


@dataclass(frozen=True, eq=False, slots=True)
class Session:
    """True positions of people, on a grid of times.

    Parameters
    ----------
    office, people
        Where, and who was there.
    times : (t,)
        Equally spaced, from 0, s.
    robot : (t, 3)
        x, y and heading, m and rad.
    positions : (t, p, 2)
        Of the people, m; where they were last while they are away.
    headings, gazes : (t, p)
        Of bodies and faces, rad.
    phases, swings : (t, p)
        Of the gaits, rad and m.
    present : (t, p)
        Who was on the floor.
    odometry
        What the wheels reported, step by step.
    lights_out : (n,)
        When the lamps of each room and of the corridor went out, s; infinite for never.
    """

    office: PeopleOffice
    people: tuple[Person, ...]
    times: np.ndarray
    robot: np.ndarray
    positions: np.ndarray
    headings: np.ndarray
    gazes: np.ndarray
    phases: np.ndarray
    swings: np.ndarray
    present: np.ndarray
    odometry: Odometry
    lights_out: np.ndarray

    def at(self, time: float) -> Moment:
        """Return the moment at a time, between those of the grid."""
        number("time", time, 0.0, float(self.times[-1]))
        k = min(int(np.searchsorted(self.times, time, side="right")), len(self.times) - 1)
        return between(self._moment(k - 1), self._moment(k), time)

    def _moment(self, k: int) -> Moment:
        return Moment(
            *(float(self.times[k]), self.robot[k], self.positions[k], self.headings[k]),
            *(self.gazes[k], self.phases[k], self.swings[k], self.present[k]),
        )


def make_session(
    office: PeopleOffice,
    *,
    rng: np.random.Generator,
    duration: float = 180.0,
    people: int | Sequence[Person] = 3,
    robot: str = "stands",
    act: Wander | None = None,
    lights_out: float | None = None,
) -> Session:
    """Return a session of people who walk about a robot, stop, turn, leave and come back.

    Parameters
    ----------
    office
        Where.
    rng
        Source of randomness.
    duration
        s.
    people
        How many, drawn at random, or who.
    robot
        ``"stands"`` in the middle of a room, or ``"drives"`` from room to room.
    act
        What people do; as :class:`Wander` does if left out.
    lights_out
        When all lamps go out, s; never if left out. Daylight stays.

    Raises
    ------
    ValueError
        If a number is out of range, or the robot does neither.
    """
    instance("office", office, PeopleOffice)
    array("rooms of office", office.rooms, (None, 4))
    generator(rng)
    number("duration", duration, 2 * STEP, 3600.0)
    if isinstance(people, Sequence) and not isinstance(people, str):
        crowd = tuple(instance("people", person, Person) for person in people)
    else:
        crowd = tuple(make_person(rng=rng) for _ in range(whole("people", people, 0, 20)))
    if not isinstance(robot, str) or robot not in ("stands", "drives"):
        raise ValueError(f"robot must be stands or drives, got {robot!r:.40}")
    act = Wander() if act is None else instance("act", act, Wander)
    out = np.full(len(office.level) - 1, np.inf)
    if lights_out is not None:
        out[:] = number("lights_out", lights_out)
    room = office.rooms[rng.integers(len(office.rooms) - 1)]
    start = np.array([*((room[:2] + room[2:]) / 2), rng.uniform(-np.pi, np.pi)])
    world = World(office, crowd, [act] * len(crowd), start, rng=rng)
    driver = _Driver(world, rng) if robot == "drives" else None
    moments = [world.now]
    for _ in range(round(duration / STEP)):
        moments.append(world.advance(STEP, driver.velocity() if driver else (0.0, 0.0)))
    return record(world, moments, lights_out=out, rng=rng)


def record(
    world: World,
    moments: Sequence[Moment],
    *,
    rng: np.random.Generator,
    lights_out: np.ndarray | None = None,
) -> Session:
    """Return the moments of a world as a session.

    Parameters
    ----------
    world
        The world.
    moments
        Two at least, one after the other.
    rng
        Source of the noise of the wheels.
    lights_out : (n,)
        When the lamps of each room and of the corridor went out, s; never if left out.
    """
    instance("world", world, World)
    generator(rng)
    if not isinstance(moments, Sequence) or len(moments) < 2:
        raise ValueError(f"moments must be two at least, got {moments!r:.60}")
    for moment in moments:
        instance("moments", moment, Moment)
    out = (
        np.full(len(world.office.level) - 1, np.inf)
        if lights_out is None
        else reals("lights_out", lights_out)
    )
    world.office.light(0.0, out)
    columns = {
        name: np.array([getattr(moment, name) for moment in moments])
        for name in Moment.__dataclass_fields__
    }
    if not (np.diff(columns["time"]) > 0).all():
        raise ValueError("moments must follow each other in time")
    odometry = roll(columns["robot"], SMALL, rng=rng)
    return Session(
        *(world.office, world.people, columns.pop("time")),
        **columns,
        odometry=odometry,
        lights_out=out,
    )


def readings(
    session: Session, rig: Rig, *, rng: np.random.Generator
) -> Iterator[LaserScan | SonarScan | FisheyeImage]:
    """Yield what the sensors reported during a session, in the order of time.

    Parameters
    ----------
    session
        The session.
    rig
        The sensors.
    rng
        Source of their noise.
    """
    instance("session", session, Session)
    sensing = Sensing(session.office, session.people, rig, rng=rng, lights_out=session.lights_out)
    return (
        reading
        for k in range(1, len(session.times))
        for reading in sensing.due(session._moment(k - 1), session._moment(k))
    )


class _Driver:
    """Drives a robot from room to room, and stops for people."""

    def __init__(self, world: World, rng: np.random.Generator) -> None:
        self.world, self.rng = world, rng
        self.way = np.zeros((0, 2))
        self.wait = rng.uniform(*_WAITS)
        self.moved = 0.0  # when it last did, s

    def velocity(self) -> tuple[float, float]:
        """Ahead and turning, m/s and rad/s."""
        now = self.world.now
        place, heading = now.robot[:2], now.robot[2]
        if not len(self.way) or np.hypot(*(self.way[-1] - place)) < 0.2:
            if len(self.way):
                self.way, self.wait = np.zeros((0, 2)), now.time + self.rng.uniform(*_WAITS)
            if now.time < self.wait:
                return 0.0, 0.0
            rooms = self.world.office.rooms
            room = rooms[self.rng.integers(len(rooms))]
            goal = (room[:2] + room[2:]) / 2 + self.rng.uniform(-0.5, 0.5, 2)
            self.way, self.moved = self.world.way(place, goal), now.time
        nearest = int(on_grid(np.hypot(*(self.way - place).T)).argmin())
        next_ = min(nearest + (1 if self.world.bumped else 4), len(self.way) - 1)
        gap = self.way[next_] - place
        off = direction(np.arctan2(gap[1], gap[0]) - heading)
        ahead = _CRUISE * max(0.0, 1 - abs(off) / 0.6)
        there = now.positions[now.present] - place
        front = there @ [np.cos(heading), np.sin(heading)]
        if ((np.hypot(*there.T) < _NEAR) & (front > 0.2)).any():
            ahead = 0.0
        if ahead > 0 and not self.world.bumped:
            self.moved = now.time
        if now.time > self.moved + _PATIENCE:
            self.way = np.zeros((0, 2))
        return ahead, float(np.clip(1.5 * off, -_SPIN, _SPIN))
