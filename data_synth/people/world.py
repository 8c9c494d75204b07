"""A world that runs: people with intentions, who keep clear of each other and of the robot.

Everybody walks with a bounded acceleration towards a point ahead on a shortest way through the
office, and among some velocities near the present one takes that which leads there without coming
near to anybody. Scripts are walked as written; the others keep clear of them.

All that a step hands to the next, and every best of several choices, is rounded to a grid:
:mod:`data_synth._grid` says why.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from data_synth._checks import array, generator, instance, number, whole
from data_synth._grid import direction, on_grid
from data_synth.people.bodies import Person
from data_synth.people.office import PeopleOffice

STEP = 0.05
"""The longest time step of a world, s; longer ones are taken in parts."""

_FASTEST, _HARDEST = 1.6, 3.0  # m/s and m/s²
_TURN = 3.5  # of a body, rad/s
_NECK = np.deg2rad(70.0)  # a face turns so far from the body
_APART, _KEEP = 0.75, 0.55  # between people, m: wished, and never less
_ROBOT_APART, _ROBOT_KEEP = 0.8, 0.5  # from the robot's middle
_WALLS, _TOUCH = 0.3, 0.2  # from what stands: wished, and never less
_AHEAD = np.array([0.25, 0.5, 0.8, 1.2])  # when a velocity is judged, s
_BODY = 0.25  # radius of the robot, m
_ROUND = 0.35  # half the time over which scripts are smoothed, s
_COARSE = 2  # cells of the office's raster along a cell of the ways
_FOLLOW = 1.3  # where a visitor likes to be, m from the robot
_REACTION = 0.8  # of somebody who is called, s
_ARRIVED = 0.25  # at the end of a way, m
_PASSAGE = 0.7  # a robot with less room than that beside it stands in a door, m
_FIDGETS = 0.01  # probability of turning at a step while standing


@dataclass(frozen=True, eq=False, slots=True)
class Walk:
    """A script: where somebody is at which time.

    Parameters
    ----------
    waypoints : (n, 2)
        Places, m.
    times : (n,)
        When they are passed, rising, s. The person is there from the first time to the last.
    facing
        Where the body turns while it stands: ``"ahead"``, ``"robot"`` or a direction, rad.
    """

    waypoints: np.ndarray
    times: np.ndarray
    facing: str | float = "ahead"

    def position(self, time: float) -> np.ndarray:
        """Return the place (2,) at a time: the mean of the straight legs over 0.7 s around it."""
        ends = np.array([-_ROUND, _ROUND]) + number("time", time)
        pieces = np.clip(np.r_[ends[0], self.times, ends[1]], *ends)  # where the legs join
        middles = (pieces[1:] + pieces[:-1]) / 2
        at = np.stack([np.interp(middles, self.times, column) for column in self.waypoints.T], -1)
        return np.diff(pieces) @ at / (2 * _ROUND)


def walk(waypoints: np.ndarray, times: np.ndarray, *, facing: str | float = "ahead") -> Walk:
    """Return a script; legs are straight, their corners are rounded.

    Parameters
    ----------
    waypoints : (n, 2)
        Places, m; the same place twice is a stop.
    times : (n,)
        When they are passed, rising, s.
    facing
        Where the body turns while it stands: ``"ahead"``, ``"robot"`` or a direction, rad.

    Raises
    ------
    ValueError
        If the times do not rise, or a leg is faster than 1.6 m/s.
    """
    times = array("times", times, (None,))
    waypoints = array("waypoints (one for each of times)", waypoints, (len(times), 2))
    if len(times) < 2 or not (np.diff(times) > 0).all():
        raise ValueError(f"times must be two at least and rise, got {times}")
    speeds = np.hypot(*np.diff(waypoints, axis=0).T) / np.diff(times)
    if speeds.max() > _FASTEST + 1e-9:
        raise ValueError(f"waypoints ask for {speeds.max():.2f} m/s, more than {_FASTEST:g}")
    if isinstance(facing, str):
        if facing not in ("ahead", "robot"):
            raise ValueError(f"facing must be ahead, robot or a direction, got {facing!r:.40}")
    else:
        number("facing", facing)
    return Walk(waypoints, times, facing)


@dataclass(frozen=True, slots=True)
class Wander:
    """Walks about near the robot, stops, turns, and now and then leaves and comes back.

    Parameters
    ----------
    leaves
        Probability that the next goal is the way out.
    faces
        Probability that a person who stops looks at the robot; never with 0.
    reach
        How far from the robot the goals are, m.
    """

    leaves: float = 0.12
    faces: float = 0.5
    reach: float = 3.5

    def __post_init__(self) -> None:
        number("leaves", self.leaves, 0.0, 1.0)
        number("faces", self.faces, 0.0, 1.0)
        number("reach", self.reach, 1.0, 100.0)


@dataclass(frozen=True, slots=True)
class Visit:
    """Stays with the robot, follows it if it drives, strays, and may come back when asked.

    Parameters
    ----------
    strays
        When the visitor turns away, rising, s.
    to : (2,)
        Where to, m.
    returns
        Whether a call of the robot brings the visitor back.
    """

    strays: tuple[float, ...] = ()
    to: tuple[float, float] = (0.0, 0.0)
    returns: bool = True

    def __post_init__(self) -> None:
        strays = array("strays", self.strays, (None,))
        if (np.diff(strays) <= 0).any():
            raise ValueError(f"strays must rise, got {self.strays}")
        array("to", self.to, (2,))
        instance("returns", self.returns, bool)


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """Places of people at a time.

    Parameters
    ----------
    time
        s.
    robot : (3,)
        x, y and heading, m and rad.
    positions : (p, 2)
        Of the people, m; where they were last if they are away.
    headings, gazes : (p,)
        Of bodies and faces, rad.
    phases, swings : (p,)
        Of the gaits, rad, and how far the legs swing, m.
    present : (p,)
        Who is on the floor.
    """

    time: float
    robot: np.ndarray
    positions: np.ndarray
    headings: np.ndarray
    gazes: np.ndarray
    phases: np.ndarray
    swings: np.ndarray
    present: np.ndarray


def between(first: Moment, second: Moment, time: float) -> Moment:
    """Return the moment at a time between two moments; who is present is that of the nearer one."""
    instance("first", first, Moment)
    instance("second", second, Moment)
    number("time", time)
    span = second.time - first.time
    share = min(max((time - first.time) / span, 0.0), 1.0) if span > 0 else 1.0

    def turned(a, b):
        return direction(a + share * direction(b - a))

    def moved(a, b):
        return a + share * (b - a)

    robot = np.r_[moved(first.robot[:2], second.robot[:2]), turned(first.robot[2], second.robot[2])]
    return Moment(
        time,
        robot,
        moved(first.positions, second.positions),
        turned(first.headings, second.headings),
        turned(first.gazes, second.gazes),
        turned(first.phases, second.phases),
        moved(first.swings, second.swings),
        (first if share < 0.5 else second).present,
    )


@dataclass(eq=False)
class _State:
    """State of somebody's plan."""

    mode: str = "new"  # walks, stands, leaves or is away; astray or with the robot
    until: float = 0.0
    way: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    speed: float = 1.0
    facing: float | None = None  # a direction while standing; as it came if it is None
    watches: bool = False
    strays: int = 0
    asked: float = np.inf  # when the robot called, s


class World:
    """An office that runs, with a robot that somebody steers.

    Parameters
    ----------
    office
        Where it is.
    people
        Who is there.
    acts
        What each of them does: a :class:`Walk`, :class:`Wander` or :class:`Visit`.
    robot : (3,)
        Where the robot starts: x, y, heading, m and rad.
    rng
        Source of all that people decide.
    starts : (p, 2)
        Where those without a script start, m; near the robot if left out.

    Raises
    ------
    ValueError
        If there are not as many acts as people, or the robot stands where it cannot.
    """

    def __init__(
        self,
        office: PeopleOffice,
        people: Sequence[Person],
        acts: Sequence[Walk | Wander | Visit],
        robot: np.ndarray,
        *,
        rng: np.random.Generator,
        starts: np.ndarray | None = None,
    ) -> None:
        self.office = instance("office", office, PeopleOffice)
        for name, values, kinds in (
            ("people", people, (Person,)),
            ("acts", acts, (Walk, Wander, Visit)),
        ):
            if not isinstance(values, Sequence) or isinstance(values, str):
                raise TypeError(f"{name} must be a sequence, got {values!r:.60}")
            for value in values:
                if not isinstance(value, kinds):
                    words = " or ".join(kind.__name__ for kind in kinds)
                    raise TypeError(f"{name} must be of {words}, got {value!r:.60}")
        if len(people) != len(acts):
            raise ValueError(f"acts must be {len(people)}, one for each of people, got {len(acts)}")
        robot = array("robot", robot, (3,))
        if office.free(robot[None, :2])[0] < _BODY:
            raise ValueError(f"robot must stand free, not at {robot[:2]}")
        robot = np.r_[on_grid(robot[:2]), direction(robot[2])]
        self.people, self.acts = tuple(people), tuple(acts)
        self.rng = generator(rng)
        self._ways = _Ways(office)
        count = len(people)
        self._velocities, self._robot_velocity = np.zeros((count, 2)), np.zeros(2)
        self._states = [_State(speed=person.pace) for person in people]
        present = np.array([not isinstance(act, Walk) for act in acts], dtype=bool)
        places = np.zeros((count, 2))
        self.now = Moment(
            0.0, robot, places, np.zeros(count), *np.zeros((3, count)), np.zeros(count, dtype=bool)
        )
        for k, act in enumerate(acts):
            if isinstance(act, Walk):
                places[k] = act.position(0.0)
                present[k] = act.times[0] <= 0.0
            elif starts is None:
                others = np.r_[places[:k], robot[None, :2]]
                places[k] = self._goal(robot[:2], robot[:2], 3.0, others)
        if starts is not None:
            starts = array("starts", starts, (count, 2))
            loose = np.array([not isinstance(act, Walk) for act in acts], dtype=bool)
            places[loose] = starts[loose]
        places = on_grid(places)
        headings = direction(np.arctan2(*(robot[:2] - places).T[::-1]))
        phases = direction(self.rng.uniform(0, 2 * np.pi, count))
        self.now = Moment(
            *(0.0, robot, places, headings, headings, phases, np.zeros(count), present)
        )
        self.before = self.now
        self.bumped = False

    def way(self, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Return places (n, 2) along a short way between two, clear of what stands, m.

        Parameters
        ----------
        start, goal : (2,)
            From where to where, m.
        """
        return self._ways.way(array("start", start, (2,)), array("goal", goal, (2,)))

    def ask(self, person: int) -> None:
        """Call a visitor back."""
        self._states[whole("person", person, 0, len(self.people) - 1)].asked = self.now.time

    def advance(self, dt: float, robot_velocity: tuple[float, float] = (0.0, 0.0)) -> Moment:
        """Let time pass, and return the moment at its end.

        Parameters
        ----------
        dt
            How long, s.
        robot_velocity
            Ahead and turning, m/s and rad/s. A robot that would run into something stays where it
            is, and ``bumped`` says so.
        """
        dt = number("dt", dt, 0.0, 1.0, above=0.0)
        ahead, turning = array("robot_velocity", robot_velocity, (2,))
        if abs(ahead) > 3.0 or abs(turning) > 10.0:
            raise ValueError(f"robot_velocity must be at most 3 m/s and 10 rad/s, got {ahead:g}")
        self.bumped, self.before = False, self.now
        parts = int(np.ceil(dt / STEP - 1e-9))
        for _ in range(parts):
            self._step(dt / parts, ahead, turning)
        return self.now

    def _step(self, dt: float, ahead: float, turning: float) -> None:
        old = self.now
        time = old.time + dt
        robot = self._drive(old, dt, ahead, turning)
        positions, present = old.positions.copy(), old.present.copy()
        headings, gazes = old.headings.copy(), old.gazes.copy()
        for k, act in enumerate(self.acts):
            if isinstance(act, Walk):
                place = on_grid(act.position(time))
                self._velocities[k] = on_grid((place - positions[k]) / dt)
                positions[k] = place
                present[k] = act.times[0] <= time <= act.times[-1]
                if not old.present[k]:
                    self._velocities[k] = 0.0
        for k in self.rng.permutation(len(self.acts)):
            act, state = self.acts[k], self._states[k]
            facing, watches = state.facing, state.watches
            if isinstance(act, Walk):
                watches = act.facing == "robot"
                facing = None if isinstance(act.facing, str) else act.facing
            else:
                if isinstance(act, Wander):
                    self._wander(k, act, time, positions, present, robot)
                else:
                    self._visit(k, act, time, positions, robot)
                steered = self._steer(k, positions, present, robot, dt)
                self._velocities[k] = steered if present[k] else 0.0
                positions[k] = on_grid(positions[k] + self._velocities[k] * dt)
            self._turn(k, headings, gazes, positions[k], robot, dt, facing, watches)
        speeds = on_grid(np.hypot(*self._velocities.T))
        phases = old.phases + 2 * np.pi * speeds / (0.75 + 0.65 * speeds) * dt
        wanted = np.where(speeds > 0.15, 0.05 + 0.15 * speeds, 0.015)
        swings = old.swings + (wanted - old.swings) * min(1.0, 4 * dt)
        self._robot_velocity = on_grid((robot[:2] - old.robot[:2]) / dt)
        self.now = Moment(
            *(time, robot, positions, headings, gazes, direction(phases), on_grid(swings), present)
        )

    def _drive(self, old: Moment, dt: float, ahead: float, turning: float) -> np.ndarray:
        """The robot's next pose; it does not move into what stands there or into people."""
        x, y, heading = old.robot
        middle = heading + turning * dt / 2
        chord = ahead * dt * np.sinc(turning * dt / (2 * np.pi))
        place = on_grid([x + chord * np.cos(middle), y + chord * np.sin(middle)])
        there = old.positions[old.present]
        before, after = np.hypot(*(there - [x, y]).T), np.hypot(*(there - place).T)
        hits = (after < _ROBOT_KEEP) & (after < before)
        if self.office.free(place[None])[0] < _BODY or hits.any():
            self.bumped = self.bumped or ahead != 0
            place = np.array([x, y])
        return np.array([*place, direction(heading + turning * dt)])

    def _goal(
        self, place: np.ndarray, around: np.ndarray, reach: float, others: np.ndarray
    ) -> np.ndarray:
        """A free place some way from the robot, in its room, and away from others; nobody wants to
        pass a robot that stands in a door.
        """
        office = self.office
        blocked = office.free(around[None])[0] < _PASSAGE
        x0, y0, x1, y1 = office.rooms[office.room_of(place if blocked else around)]
        low = np.maximum([x0, y0], around - reach)
        high = np.minimum([x1, y1], around + reach)
        places = self.rng.uniform(low, high, (200, 2))
        gaps = np.hypot(*(places[:, None] - np.r_[others, around[None]]).transpose(2, 0, 1))
        good = (office.free(places) > _WALLS + 0.1) & (gaps > 0.95).all(axis=1)
        good &= np.hypot(*(places - around).T) < reach
        if not good.any():
            good = office.free(places) > _WALLS
        return places[good.argmax()]

    def _wander(
        self,
        k: int,
        act: Wander,
        time: float,
        positions: np.ndarray,
        present: np.ndarray,
        robot: np.ndarray,
    ) -> None:
        """Choose what comes next: stop at the end of a way, vanish at the way out, set off."""
        state, others = self._states[k], np.delete(positions, k, axis=0)
        if state.mode in ("walks", "leaves"):
            arrived = np.hypot(*(state.way[-1] - positions[k])) < _ARRIVED
            if not arrived and time < state.until:
                return
            if arrived and state.mode == "leaves":
                present[k] = False
                state.mode, state.until = "away", time + self.rng.uniform(3.0, 10.0)
                return
            state.mode, state.until = "stands", time + self.rng.uniform(1.5, 7.0)
            state.watches = bool(self.rng.random() < act.faces)
            state.facing = None if state.watches else float(self.rng.uniform(-np.pi, np.pi))
            state.way = positions[k][None].copy()
            return
        if time < state.until:
            if state.mode == "stands" and not state.watches and self.rng.random() < _FIDGETS:
                state.facing = float(self.rng.uniform(-np.pi, np.pi))
            return
        leaves = False
        if state.mode == "away":
            near = np.hypot(*(others[np.delete(present, k)] - positions[k]).T) < 1.0
            if near.any():
                return
            present[k] = True
        elif state.mode == "stands":
            leaves = bool(self.rng.random() < act.leaves)
        goal = self._out(robot)
        if not leaves:
            goal = self._goal(positions[k], robot[:2], act.reach, others)
        state.mode, state.way = "leaves" if leaves else "walks", self._ways.way(positions[k], goal)
        state.watches, state.facing = False, None
        pace = self.people[k].pace * self.rng.uniform(0.6, 1.25)
        state.speed = float(np.clip(pace, 0.35, _FASTEST))
        long = on_grid(np.hypot(*np.diff(state.way, axis=0).T).sum())
        state.until = time + 4.0 + 2.0 * long / state.speed

    def _out(self, robot: np.ndarray) -> np.ndarray:
        """Way out: past the door of the robot's room, else the end of the corridor."""
        office, room = self.office, self.office.room_of(robot[:2])
        if room < len(office.doors):
            door = office.doors[room, 0]
            sides = door + np.array([[3.0, 0.0], [-3.0, 0.0]])
            sides[:, 1] = office.exits[0, 1]
            inside = np.abs(sides[:, 0] - office.exits[:, 0].mean()) < 8.5
            return self.rng.permutation(sides[inside])[0]
        return office.exits[np.hypot(*(office.exits - robot[:2]).T).argmin()]

    def _visit(
        self, k: int, act: Visit, time: float, positions: np.ndarray, robot: np.ndarray
    ) -> None:
        """Stay near the robot, or go away until called."""
        state = self._states[k]
        if state.strays < len(act.strays) and time >= act.strays[state.strays]:
            state.mode, state.strays, state.asked = "astray", state.strays + 1, np.inf
            state.way = self._ways.way(positions[k], np.array(act.to))
            state.watches, state.speed = False, self.people[k].pace
        if state.mode == "astray" and not (act.returns and time >= state.asked + _REACTION):
            return
        state.mode, state.watches = "with", True
        away = np.hypot(*(robot[:2] - positions[k]))
        if away <= _FOLLOW + 0.3:
            state.way = positions[k][None].copy()
        elif time >= state.until or len(state.way) < 2:
            state.way = self._ways.way(positions[k], self._beside(positions[k], robot))
            state.until = time + 0.6
        state.speed = float(np.clip(0.9 * (away - _FOLLOW) + 0.3, 0.35, 1.3))

    def _beside(self, place: np.ndarray, robot: np.ndarray) -> np.ndarray:
        """A free place at the distance a visitor likes, on the near side of the robot if it can."""
        gap = place - robot[:2]
        turn = np.arctan2(gap[1], gap[0]) + np.deg2rad([0, 40, -40, 80, -80, 130, -130, 180])
        spots = robot[:2] + _FOLLOW * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        free = self.office.free(spots) > _WALLS
        return spots[free.argmax()] if free.any() else robot[:2]

    def _steer(
        self, k: int, positions: np.ndarray, present: np.ndarray, robot: np.ndarray, dt: float
    ) -> np.ndarray:
        """The velocity among some near the present one that suits best."""
        place, velocity, state = positions[k], self._velocities[k], self._states[k]
        wish = np.zeros(2)
        if len(state.way) and np.hypot(*(state.way[-1] - place)) > _ARRIVED:
            wish = _pursue(state.way, place, state.speed)
        others = np.flatnonzero(present & (np.arange(len(present)) != k))
        places = np.r_[positions[others], robot[None, :2]]
        moving = np.r_[self._velocities[others], self._robot_velocity[None]]
        wanted = np.r_[np.full(len(others), _APART), _ROBOT_APART]
        least = np.r_[np.full(len(others), _KEEP), _ROBOT_KEEP]
        speed, ahead = np.hypot(*wish), np.arctan2(wish[1], wish[0])
        turns = ahead + np.deg2rad([0, 20, -20, 45, -45, 75, -75, 110, -110])
        some = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        shares = speed * np.array([1.0, 0.65, 0.35])[:, None, None]
        trial = np.r_[(shares * some).reshape(-1, 2), np.zeros((1, 2))]
        change = trial - velocity
        size = np.maximum(np.hypot(*change.T), 1e-12)
        trial = on_grid(velocity + change * np.minimum(1.0, _HARDEST * dt / size)[:, None])
        cost = np.hypot(*(trial - wish).T)
        then = place + trial[:, None] * _AHEAD[:, None]  # (trials, times, 2)
        room = self.office.free(then.reshape(-1, 2)).reshape(then.shape[:2])
        cost = cost + (np.maximum(_WALLS - room, 0) * [20, 8, 3, 1.5]).sum(axis=1)
        they = places + moving * _AHEAD[:, None, None]  # (times, others, 2)
        gaps = np.linalg.norm(then[:, :, None] - they, axis=-1)
        near = np.maximum(wanted - gaps, 0) * np.array([12, 8, 4, 2])[:, None]
        cost = cost + near.sum(axis=(1, 2))
        best = trial[on_grid(cost).argmin()]
        after = place + best * dt
        now, next_ = np.hypot(*(places - place).T), np.hypot(*(places - after).T)
        clash = ((next_ < least) & (next_ < now)).any()
        free = self.office.free(np.stack([place, after]))
        if clash or (free[1] < _TOUCH and free[1] < free[0]):
            return np.zeros(2)
        return best

    def _turn(
        self,
        k: int,
        headings: np.ndarray,
        gazes: np.ndarray,
        place: np.ndarray,
        robot: np.ndarray,
        dt: float,
        wish: float | None,
        watches: bool,
    ) -> None:
        """Turn body and face: along the way, or while standing to where they look."""
        speed = np.hypot(*self._velocities[k])
        to_robot = np.arctan2(*(robot[:2] - place)[::-1])
        if speed > 0.2:
            wish = np.arctan2(self._velocities[k, 1], self._velocities[k, 0])
        elif wish is None:
            wish = to_robot if watches else headings[k]
        off = direction(wish - headings[k])
        most = _TURN * dt
        turn = np.clip(0.2 * off if abs(off) < most else off, -most, most)
        headings[k] = direction(headings[k] + turn)
        look = direction((to_robot if watches else headings[k]) - headings[k])
        look = np.clip(look, -_NECK, _NECK)
        turn = np.clip(direction(headings[k] + look - gazes[k]), -1.5 * most, 1.5 * most)
        gazes[k] = direction(gazes[k] + turn)


def _pursue(way: np.ndarray, place: np.ndarray, speed: float) -> np.ndarray:
    """Velocity towards a point ahead on a way, slower near its end."""
    away = np.hypot(*(way - place).T)
    nearest = int(on_grid(away).argmin())
    ahead = min(nearest + 6, len(way) - 1)
    gap = way[ahead] - place
    left = np.hypot(*(way[-1] - place))
    size = np.hypot(*gap)
    if size < 1e-9:
        return np.zeros(2)
    return gap / size * min(speed, 0.3 + 1.2 * left)


class _Ways:
    """Shortest ways on the free cells of an office, some way from what stands there."""

    def __init__(self, office: PeopleOffice) -> None:
        room = office.clearance[::_COARSE, ::_COARSE]
        self.cell = office.cell * _COARSE
        self.corner = office.corner + office.cell / 2
        self.cells = np.argwhere(room > _WALLS)
        number_of = np.full(room.shape, -1)
        number_of[tuple(self.cells.T)] = np.arange(len(self.cells))
        starts, ends, costs = [], [], []
        price = 1 + 0.8 * (_WALLS / room[tuple(self.cells.T)]) ** 2
        for step in ((0, 1), (1, 0), (1, 1), (1, -1)):
            there = self.cells + step
            inside = (there < room.shape).all(axis=1) & (there >= 0).all(axis=1)
            other = np.where(inside, number_of[tuple(np.where(inside[:, None], there, 0).T)], -1)
            fits = np.flatnonzero(other >= 0)
            starts.append(fits)
            ends.append(other[fits])
            costs.append(np.hypot(*step) * (price[fits] + price[other[fits]]) / 2)
        count = len(self.cells)
        edges = (np.concatenate(starts), np.concatenate(ends))
        costs = on_grid(np.concatenate(costs))
        self.graph = coo_array((costs, edges), shape=(count, count)).tocsr()

    def way(self, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Places (n, 2) from near the start to the goal."""
        first, last = self._cell(start), self._cell(goal)
        _, before = dijkstra(self.graph, directed=False, indices=last, return_predecessors=True)
        chain = [first]
        while chain[-1] != last and before[chain[-1]] >= 0:
            chain.append(before[chain[-1]])
        way = self.cells[chain][:, ::-1] * self.cell + self.corner
        return np.concatenate([way, np.asarray(goal, dtype=float)[None]])

    def _cell(self, place: np.ndarray) -> int:
        at = (np.asarray(place) - self.corner) / self.cell
        return int(((self.cells[:, ::-1] - at) ** 2).sum(axis=1).argmin())
