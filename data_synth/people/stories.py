"""Stories for a robot that acts: it guides, asks people aside, follows, or asks questions.

A story is a `World` with the robot and its people in their places. The caller steers the robot by
`World.advance`, and passes its words on: `World.ask` calls a visitor back, `ask_aside` asks people
to clear the way.
"""

from dataclasses import dataclass, field

import numpy as np

from data_synth._checks import array, generator, instance, number
from data_synth.people.bodies import make_person
from data_synth.people.office import PeopleOffice, make_people_office
from data_synth.people.world import Visit, Walk, World, walk
from data_synth.sonar import SonarRing

KINDS = ("guide", "blocked", "follow", "survey")
"""Kinds of stories; `make_story` tells each."""

_SPACING = 0.1  # between points of a route, m
_TOWARD = 10  # the robot looks first to the point of the way so many points off
_ASIDE, _NEAR = 0.85, 0.25  # a person's distance from the route: beside it, and in the way, m
_ROOM = 0.2  # least distance of a person who has stepped aside from walls and furniture, m
_GROUP = 30  # people block a route so many points after its start, or further on
_REACTION, _STEPS = 0.8, 1.5  # from the request to the first step, and from there to the end, s
_WAITS = 2.0  # time that the person to be followed stands before walking, s


class TurnedRing(SonarRing):
    """A ring turned by half a spacing: one sonar looks straight back, where visitors walk."""

    __slots__ = ()

    @property
    def angles(self) -> np.ndarray:
        """Directions of the sonars, counter-clockwise from ahead, rad: (count,)."""
        return super().angles + np.pi / self.count


@dataclass(frozen=True, eq=False, slots=True)
class StepsAside(Walk):
    """A person who stands at one place until asked, and then walks to a second one.

    Parameters
    ----------
    waypoints : (2, 2)
        The first and the second place, m.
    times : (2,)
        When the person appears and when the person disappears, s.
    facing
        Where the body turns while it stands: ``"ahead"``, ``"robot"`` or a direction, rad.
    """

    _asked: list[float] = field(default_factory=list, init=False, repr=False)

    @property
    def asked(self) -> float:
        """Time of the first request, s; infinite while there was none."""
        return min(self._asked, default=np.inf)

    def ask(self, time: float) -> None:
        """Ask the person at a time, s; later requests change nothing."""
        self._asked.append(number("time", time))

    def position(self, time: float) -> np.ndarray:
        """Return the place (2,) at a time."""
        since = number("time", time) - self.asked - _REACTION
        share = np.clip(since / _STEPS, 0.0, 1.0)
        return (1 - share) * self.waypoints[0] + share * self.waypoints[1]


def ask_aside(world: World) -> None:
    """Ask everybody in a world whose act is `StepsAside` to step aside now.

    Parameters
    ----------
    world
        The world; its present time is the time of the request.
    """
    for act in instance("world", world, World).acts:
        if isinstance(act, StepsAside):
            act.ask(world.now.time)


def make_story(
    kind: str,
    *,
    rng: np.random.Generator,
    comes: float = 4.5,
    strays: float = 9.0,
    gap: float = 1.2,
    pace: float = 0.5,
    beside: bool = False,
) -> tuple[World, np.ndarray]:
    """Return a world with a robot and people in it, and the robot's route (k, 2), m.

    The kinds of stories are

    * ``"guide"``: the robot stands in the corridor. A visitor comes to it, and turns away after a
      time; a call brings the visitor back. The route leads to a room at the other end.
    * ``"blocked"``: the same, but the visitor stays, and two people stand in the way.
    * ``"follow"``: a person stands ahead of the robot in a room, and then walks to an end of the
      corridor. The route is empty.
    * ``"survey"``: the robot stands half-way along the corridor. A visitor comes to it, turns away
      after a time and does not come back. The route is empty.

    Points of a route are 0.1 m apart.

    Parameters
    ----------
    kind
        One of `KINDS`.
    rng
        Source of the office, of the people and of all that they decide.
    comes
        Length of the visitor's first way to the robot, m.
    strays
        Time at which the visitor turns away, s; not used for ``"blocked"`` and ``"follow"``.
    gap
        Distance of the person to be followed ahead of the robot, m.
    pace
        Speed of that person, m/s.
    beside
        Whether the two people of ``"blocked"`` stand beside the way from the beginning.

    Raises
    ------
    ValueError
        If there is no such kind of story, or the office has no room for it.
    """
    if not isinstance(kind, str) or kind not in KINDS:
        raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {kind!r:.40}")
    generator(rng)
    back = round(number("comes", comes, 1.0, 20.0) / _SPACING)
    number("strays", strays, 0.0, 3600.0)
    first = round(number("gap", gap, 0.8, 3.0) / _SPACING)
    number("pace", pace, 0.1, 1.6)
    instance("beside", beside, bool)
    office = make_people_office(rng=rng)
    person, ends = make_person(rng=rng), office.exits[rng.permutation(2)]
    rooms = (office.rooms[:-1, :2] + office.rooms[:-1, 2:]) / 2
    room = rooms[rng.integers(len(rooms))]
    start, goal, at = ends[0], ends[1], back
    if kind in ("guide", "blocked"):
        goal = rooms[np.abs(rooms[:, 0] - goal[0]).argsort()[rng.integers(2)]]
    elif kind == "follow":
        start, goal, at = room, ends[np.abs(ends[:, 0] - room[0]).argmax()], 0
    way = _even(World(office, (), (), np.array([*room, 0.0]), rng=rng).way(start, goal))
    at = len(way) // 2 if kind == "survey" else at
    if at + _TOWARD >= len(way) or (kind == "survey" and at < max(back, _TOWARD)):
        long = len(way) * _SPACING
        raise ValueError(f"comes must leave room on a way of {long:.1f} m, got {comes}")
    toward = way[at - _TOWARD] if kind == "survey" else way[at + _TOWARD]
    robot = np.array([*way[at], np.arctan2(*(toward - way[at])[::-1])])
    if kind == "follow":
        path = way[first:]
        times = np.r_[0.0, _WAITS + _SPACING / pace * np.arange(len(path))]
        led = walk(np.concatenate([path[:1], path]), times)
        return World(office, (person,), (led,), robot, rng=rng), way[:0]
    visit = Visit(
        () if kind == "blocked" else (strays,),
        (float(start[0]), float(start[1])),
        returns=kind != "survey",
    )
    here, route = way[at - back, None], way[len(way) if kind == "survey" else at :]
    if kind != "blocked":
        return World(office, (person,), (visit,), robot, rng=rng, starts=here), route
    two = _in_the_way(office, route, beside)
    people = person, make_person(rng=rng), make_person(rng=rng)
    starts = np.concatenate([here, *(one.waypoints[:1] for one in two)])
    return World(office, people, (visit, *two), robot, rng=rng, starts=starts), route


def meeting_place(office: PeopleOffice, route: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first place of a route where two people can block it and step aside.

    There a person has room on either side of the route.

    Parameters
    ----------
    office
        The office.
    route : (k, 2)
        Points 0.1 m apart, m; the first 3 m are left out.

    Returns
    -------
    place, across : (2,)
        The place, m, and the unit vector across the route, to its left.

    Raises
    ------
    ValueError
        If no place has room on both sides.
    """
    instance("office", office, PeopleOffice)
    route = array("route", route, (None, 2))
    for at, then in zip(route[_GROUP:], route[_GROUP + 5 :], strict=False):
        long = np.hypot(*(then - at))
        if long == 0:
            continue
        across = np.array([[0.0, -1.0], [1.0, 0.0]]) @ (then - at) / long
        if office.free(at + np.array([[_ASIDE], [-_ASIDE]]) * across).min() > _ROOM:
            return at, across
    raise ValueError("route must have a place with room for two on both sides, got none")


def _in_the_way(
    office: PeopleOffice, route: np.ndarray, beside: bool
) -> tuple[StepsAside, StepsAside]:
    """Return two people who stand in the way, or beside it, and face each other across it."""
    at, across = meeting_place(office, route)
    near = _ASIDE if beside else _NEAR
    left, right = (
        StepsAside(
            at + side * across * [[near], [_ASIDE]],
            np.array([0.0, 99.0]),
            float(np.arctan2(*(-side * across)[::-1])),
        )
        for side in (1, -1)
    )
    return left, right


def _even(way: np.ndarray) -> np.ndarray:
    """Return points along a way, one every 0.1 m of its length."""
    along = np.concatenate([[0.0], np.hypot(*np.diff(way, axis=0).T).cumsum()])
    at = np.arange(0.0, along[-1], _SPACING)
    return np.stack([np.interp(at, along, column) for column in way.T], axis=-1)
