"""People on the floor, and what they do: a visitor is guided, a tutor comes, leads and points.

People are told once and shown three ways: their legs to laser and sonars, their bodies to a fisheye
(:mod:`data_synth.people.bodies`), their clothes, faces and hands to the camera that looks ahead
(:mod:`data_synth.companion.visits`), and arms that point (:mod:`data_synth.arms.bodies`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import minimize

from data_synth._checks import array, generator, instance, number, whole
from data_synth.arms import bodies as arms
from data_synth.companion.canvas import photograph
from data_synth.companion.hall import RobotCamera
from data_synth.companion.visits import Sight, Stance, Visitor, lay_people, make_visitor
from data_synth.day.building import Building
from data_synth.people.bodies import Person, make_person
from data_synth.people.stories import StepsAside, ask_aside
from data_synth.people.world import Moment, Visit, World, walk

__all__ = [
    "EAST",
    "WEST",
    "Act",
    "Someone",
    "clear_the_way",
    "guided_tour",
    "led_path",
    "make_someone",
    "pointing",
    "portrait",
    "tutor_comes",
]

EAST, WEST = 0.95, 1.45
"""Lanes of the corridor on which the robot drives, m."""
_FAST, _SLOW = 0.5, 0.12  # of who leads the robot: straight on and in a turn, m/s
_SWAY = 0.02  # of who leads it, m
_TALL = 1.6  # of all heads, m
_LIFT = 0.5  # that an arm takes, s
_ASIDE = 0.45  # y of whoever has stepped aside, m
_SHOULDER = 1.42  # above the floor, m
_REST = np.array([0.24, 0.05, 1.2, 0.25])
_STRAIGHT = (0.6, 0.06)  # about its axis, and elbow, of an arm that points, rad


@dataclass(frozen=True, eq=False, slots=True)
class Someone:
    """Somebody, as each sensor sees them.

    Parameters
    ----------
    person
        To laser, sonars and fisheye.
    visitor
        To the camera that looks ahead.
    body
        To the same camera, while arms point.
    """

    person: Person
    visitor: Visitor
    body: arms.Person

    def __post_init__(self) -> None:
        instance("person", self.person, Person)
        instance("visitor", self.visitor, Visitor)
        instance("body", self.body, arms.Person)


def make_someone(rng: np.random.Generator) -> Someone:
    """Return somebody drawn at random, with one skin, one shirt and one pair of trousers."""
    of_looks, of_legs, of_arms = generator(rng).spawn(3)
    visitor = make_visitor(of_looks)
    who, wears = visitor.identity, visitor.clothes

    def seen(light: Sequence[float]) -> tuple[int, int, int]:
        return tuple(round(255 * one ** (1 / 2.2)) for one in light)

    person = replace(
        make_person(rng=of_legs, skirt=False),
        head=_TALL,
        tone=min(who.tone / 5, 1.0),
        hair=seen(who.hair),
        shirt=seen(wears.shirt),
        trousers=seen(wears.trousers),
    )
    pattern = wears.pattern if wears.pattern in ("plain", "stripes", "checks") else "plain"
    outfit = replace(
        arms.make_outfit(of_arms), shirt=wears.shirt, other=wears.other, pattern=pattern
    )
    return Someone(person, visitor, arms.make_person(of_arms, who, outfit))


@dataclass(frozen=True, eq=False, slots=True)
class Act:
    """Some seconds of the day, with who is there and what they do.

    Parameters
    ----------
    building
        Where.
    people
        Who is there.
    world
        In which they walk and the robot drives.
    hands
        When somebody holds up a hand: by person, first and last time, s, and whether beside the
        body and not above the head.
    seconds
        How long it lasts at most, s.
    """

    building: Building
    people: tuple[Someone, ...]
    world: World = field(repr=False)
    hands: Mapping[int, tuple[tuple[float, float, bool], ...]]
    seconds: float

    def stances(self, moment: Moment) -> list[tuple[int, Stance]]:
        """Return who is there at a moment, and how they stand or walk."""
        found = []
        for k in np.flatnonzero(moment.present).tolist():
            x, y = (moment.positions[k] + _SHIFT).tolist()
            raised, beside = self._raised(k, moment.time)
            walks = bool(moment.swings[k] > 0.08)
            heading = float(moment.headings[k])
            found.append((k, Stance(x, y, heading, walks, 0.0 if walks else raised, beside)))
        return found

    def _raised(self, person: int, time: float) -> tuple[float, bool]:
        for first, last, beside in self.hands.get(person, ()):
            if first <= time <= last:
                return float(min((time - first) / _LIFT, (last - time) / _LIFT, 1.0)), beside
        return 0.0, False

    def look(self, camera: RobotCamera, moment: Moment, *, rng: np.random.Generator) -> Sight:
        """Return what the camera that looks ahead sees, with the truth of whom it shows.

        Parameters
        ----------
        camera
            On the robot's axis.
        moment
            When.
        rng
            Source of small turns of heads, and of noise.
        """
        instance("moment", moment, Moment)
        generator(rng)
        canvas = self.building.ahead(camera, moment.robot)
        places = moment.positions
        clear = self.building.in_sight(camera, moment.robot, places) if len(places) else []
        shown = [(k, stance) for k, stance in self.stances(moment) if clear[k]]
        pairs = [(self.people[k].visitor, stance) for k, stance in shown]
        pose = moment.robot + np.append(_SHIFT, 0.0)
        steps = float(moment.phases[shown[0][0]]) if shown else 0.0
        laid = lay_people(canvas, camera, pose, pairs, rng=rng, phase=steps)
        found = np.full((3, len(self.people), 4), np.nan)
        found[:, [k for k, _ in shown]] = laid
        return Sight(photograph(canvas, rng=rng), *found)

    def heads(self, moment: Moment) -> np.ndarray:
        """Return where heads are (n, 3) at a moment, m."""
        instance("moment", moment, Moment)
        places = moment.positions[moment.present]
        return np.column_stack([places, np.full(len(places), _TALL)])


_SHIFT = np.array([100.0, 100.0])  # stances have no negative place


def led_path(building: Building, *, rng: np.random.Generator, tick: float = 0.1) -> np.ndarray:
    """Return the path (n, 3) of a robot that is led along the corridor and back, a pose a tick.

    It begins and ends near the western end, goes east on one lane and back on the other.

    Parameters
    ----------
    building
        Where.
    rng
        Source of how a hand sways that leads it.
    tick
        From pose to pose, s.
    """
    west, east = instance("building", building, Building).office.exits[:, 0] + [1.2, -1.4]
    radius = (WEST - EAST) / 2
    long, turn = east - west, np.pi * radius
    at = [np.arange(0.0, long, _FAST * tick), np.arange(0.0, turn, _SLOW * tick)]
    angle = at[1] / radius
    pieces = [
        np.column_stack([west + at[0], np.full(len(at[0]), EAST), np.zeros(len(at[0]))]),
        np.column_stack(
            [east + radius * np.sin(angle), EAST + radius * (1 - np.cos(angle)), angle]
        ),
        np.column_stack([east - at[0], np.full(len(at[0]), WEST), np.full(len(at[0]), np.pi)]),
    ]
    path = np.concatenate(pieces)
    along = np.arange(len(path)) * _FAST * tick
    waves = 2 * np.pi / generator(rng).uniform(2.5, 6.0, 4)[:, None]
    heights = _SWAY * rng.standard_normal((4, 1))
    aside = (heights * np.sin(waves * along + rng.uniform(0, 2 * np.pi, (4, 1)))).sum(axis=0)
    path[:, 0] -= aside * np.sin(path[:, 2])
    path[:, 1] += aside * np.cos(path[:, 2])
    return path


def guided_tour(
    building: Building,
    people: Sequence[Someone],
    robot: np.ndarray,
    goal: float,
    *,
    rng: np.random.Generator,
) -> Act:
    """Return an act in which a robot guides the first person west, and two others are in the way.

    Parameters
    ----------
    building
        Where.
    people
        Visitor, and the two.
    robot : (3,)
        Where the robot is, m and rad.
    goal
        How far west, m.
    rng
        Source of all that people decide.
    """
    robot, goal = array("robot", robot, (3,)), number("goal", goal)
    x = (robot[0] + goal) / 2  # there the two talk, on the lane of the robot
    acts: list[Visit | StepsAside] = [Visit((), (float(robot[0]), 1.2))]
    for side in (1, -1):
        places = np.array([[x, WEST - 0.08 + 0.28 * side], [x + 0.4 * side, _ASIDE]])
        acts.append(StepsAside(places, np.array([0.0, 999.0]), "robot"))
    starts = [robot[:2] + np.array([1.2, 0.0]), *(act.waypoints[0] for act in acts[1:])]
    world = World(
        building.office,
        [one.person for one in people[:3]],
        acts,
        robot,
        rng=rng,
        starts=np.array(starts).clip(0.4, building.office.exits[1]),
    )
    return Act(building, tuple(people[:3]), world, {}, 90.0)


def clear_the_way(act: Act) -> None:
    """Ask those who stand in the way of an act to step aside."""
    ask_aside(act.world)


def tutor_comes(
    building: Building, people: Sequence[Someone], robot: np.ndarray, *, rng: np.random.Generator
) -> Act:
    """Return an act in which a stranger raises a hand, then a tutor who leads the robot east.

    Somebody passes between the two. At the end the tutor turns round and raises an open hand.

    Parameters
    ----------
    building
        Where.
    people
        Stranger, tutor, and who passes.
    robot : (3,)
        Where the robot stands and looks east, m and rad.
    rng
        Source of all that people decide.
    """
    x = float(array("robot", robot, (3,))[0])
    east = x + 9.0
    stranger = walk(
        np.array([[east, 1.2], [x + 2.1, 1.0], [x + 2.1, 1.0], [east, 1.2]]),
        np.array([0.0, 6.3, 10.5, 17.0]),
        facing="robot",
    )
    stops = x + 2.15 + 6.0
    tutor = walk(
        np.array([[east, 1.3], [x + 2.15, 1.2], [x + 2.15, 1.2], [stops, 1.2], [stops, 1.2]]),
        np.array([15.0, 21.5, 31.0, 42.0, 60.0]),
        facing="robot",
    )
    passer = walk(
        np.array([[x + 11.0, 1.95], [x + 5.2, 1.95], [x + 4.0, 0.45], [x + 1.0, 0.45]]),
        np.array([31.0, 36.5, 38.3, 41.0]),
    )
    chosen = people[:3]
    world = World(
        building.office,
        [one.person for one in chosen],
        [stranger, tutor, passer],
        robot,
        rng=rng,
    )
    hands = {0: ((7.0, 9.5, False),), 1: ((26.0, 29.5, False), (44.0, 47.0, False))}
    return Act(building, tuple(chosen), world, hands, 49.0)


def pointing(
    building: Building,
    who: Someone,
    place: np.ndarray,
    robot: np.ndarray,
    target: np.ndarray,
    camera: RobotCamera,
    *,
    rng: np.random.Generator,
    pictures: int = 45,
) -> list[np.ndarray]:
    """Return pictures of somebody who faces the robot and points at a place of the floor.

    Parameters
    ----------
    building, who
        Where, and whom they show.
    place : (2,)
        Where the person stands, m.
    robot : (3,)
        Pose of the robot, m and rad.
    target : (2,)
        Where the arm points, at half a person's height, m.
    camera
        On the robot's axis.
    rng
        Source of noise.
    pictures
        How many, fifteen a second.

    Raises
    ------
    ValueError
        If the person is not before the camera, or no arm reaches that way.
    """
    place, robot, target = (
        array(name, value, (size,))
        for name, value, size in (("place", place, 2), ("robot", robot, 3), ("target", target, 2))
    )
    instance("building", building, Building)
    instance("who", who, Someone)
    instance("camera", camera, RobotCamera)
    generator(rng)
    pictures = whole("pictures", pictures, 1, 10_000)
    cos, sin = np.cos(robot[2]), np.sin(robot[2])

    def before(point: np.ndarray, up: float) -> np.ndarray:  # right, down and ahead of the camera
        east, north = point - robot[:2]
        return np.array([sin * east - cos * north, camera.height - up, cos * east + sin * north])

    at = before(place, _SHOULDER)
    if not at[2] >= 1.0:
        raise ValueError(f"place must be 1 m before the camera at least, got {at[2]:.2f} m")
    if abs(at[0]) > 0.5 * at[2]:
        raise ValueError(f"place must be in view of the robot at {robot}, got {place}")
    stage = arms.Stage(focal=camera.focal, size=camera.size, away=at[2], high=-at[1], aside=at[0])
    pose, side = _aim(who.body, stage, before(target, 0.8))
    rest = np.tile(_REST, 2)
    raised = rest.copy()
    raised[slice(0, 4) if side < 0 else slice(4, 8)] = pose
    canvas, found = building.ahead(camera, robot), []
    for share in np.clip(np.arange(pictures) / (0.45 * pictures), 0, 1):
        smooth = share * share * (3 - 2 * share)
        painted, _ = stage.paint(who.body, rest + smooth * (raised - rest), canvas)
        found.append(photograph(painted, rng=rng))
    return found


def _aim(body: arms.Person, stage: arms.Stage, target: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the four angles of the arm that points at a place best, and its side."""
    side = 1 if target[0] > stage.middle[0] else -1

    def off(angles: np.ndarray) -> float:
        both = np.tile(_REST, 2)
        both[slice(0, 4) if side < 0 else slice(4, 8)] = [*angles, *_STRAIGHT]
        shoulder, _, _, tip = stage.joints(body, both)[0 if side < 0 else 1]
        arm, way = tip - shoulder, target - shoulder
        return -float(arm @ way / np.linalg.norm(arm) / np.linalg.norm(way))

    starts = [(a, b) for a in (0.4, 1.0, 1.6) for b in (0.1, 0.7)]
    bounds = [(0.15, 2.1), (-0.1, 1.2)]
    best = min((minimize(off, start, bounds=bounds) for start in starts), key=lambda one: one.fun)
    if best.fun > -np.cos(np.deg2rad(12.0)):
        raise ValueError(f"target must be where an arm reaches, got {target.round(2)}")
    return np.array([*best.x, *_STRAIGHT]), side


def portrait(
    building: Building, who: Someone, camera: RobotCamera, *, rng: np.random.Generator
) -> Sight:
    """Return a picture of somebody who stands before the robot in the corridor to be enrolled."""
    instance("building", building, Building)
    instance("who", who, Someone)
    west, east = building.office.exits[:, 0]
    x, y = generator(rng).uniform((west + 1, 0.8), (east - 4, 1.6))
    heading = rng.uniform(-0.2, 0.2)
    ahead, left = rng.uniform((1.8, -0.3), (2.5, 0.3))
    cos, sin = np.cos(heading), np.sin(heading)
    pose = np.array([x, y, heading])
    there = Stance(
        float(x + ahead * cos - left * sin + _SHIFT[0]),
        float(y + ahead * sin + left * cos + _SHIFT[1]),
    )
    light = float(rng.uniform(0.8, 1.2))
    canvas = building.ahead(camera, pose) * np.float32(light)
    shifted = pose + np.append(_SHIFT, 0.0)
    laid = lay_people(canvas, camera, shifted, [(who.visitor, there)], rng=rng, light=light)
    return Sight(photograph(canvas, rng=rng), *laid)
