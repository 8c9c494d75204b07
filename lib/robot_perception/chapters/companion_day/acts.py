"""Acts of a day: the world runs, its sensors report, and the truth decides.

What happens is a `Moment` after the other; how an act ended is an `Outcome`.
"""

from collections.abc import Callable, Iterator
from copy import copy, deepcopy
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from data_synth import stereo
from data_synth.companion.hall import RobotCamera
from data_synth.day.acts import (
    EAST,
    WEST,
    Someone,
    clear_the_way,
    guided_tour,
    led_path,
    make_someone,
    pointing,
    tutor_comes,
)
from data_synth.day.building import Building, make_building
from data_synth.people.signals import LaserScan, Rig, Sensing, SonarScan
from data_synth.people.staging import rig
from data_synth.people.stories import TurnedRing
from data_synth.people.world import World
from data_synth.wheels import SMALL, roll
from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.eigenfaces import Eigenfaces
from robot_perception.day.robot import DayInfo, DayRobot, DayState, Reading
from robot_perception.geometry import se2, wrap_angle
from robot_perception.slam.planar.motions import Odometry

TICK = 0.1
"""Length of a step of the world, s."""
ACTS = ("learn", "find", "hall", "guide", "tutor", "follow", "halt", "point", "go")
"""Acts of a day, in their order."""
PARTS = ("learn", "find", "hall", "guide", "attend", "point", "go")
"""Parts of a day; recognised, followed and stopped by the tutor is one of them."""
ASKED = {
    "stereo": ("find",),
    "ceiling": ("hall", "guide", "go"), "intersection": ("hall", "guide", "go"),
    "laser": ("guide",), "sonar": ("guide",), "skin": ("guide",),
    "faces": ("attend",), "arms": ("point",),
}  # fmt: skip
"""Parts of a day in which a system is asked."""
STRAINS = {"twin": ("attend",), "dark": ("attend", "point")}
"""Strains on a day, and the parts that they touch: a stranger in the tutor's clothes, dim light."""
DIM = 0.25  # of the light, where it fails
POST = 5.0  # where the robot waits for its tutor, m from the western end
CAMERA = RobotCamera()
PAIR = stereo.Rig()
RING = TurnedRing()
APART, TURNED = 0.16, 0.12  # from one stereo pair to the next, m or rad
KEEPS = 2.6  # from the tutor, m: nearer, a hand above his head is out of view


@dataclass(frozen=True, eq=False)
class Moment:
    """State of world and robot at the end of a step.

    Parameters
    ----------
    time
        Of the day, s.
    act
        Which of `ACTS`.
    robot : (3,)
        Where the robot truly is, m and rad.
    state, info
        What it knows, and what its last reading led to.
    people : (n, 2)
        Where people truly are, m.
    image
        What the camera shows that the task uses: a function that returns it.
    """

    time: float
    act: str
    robot: np.ndarray
    state: DayState
    info: DayInfo
    people: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    image: Callable[[], np.ndarray] | None = None


@dataclass(frozen=True)
class Outcome:
    """End of an act.

    Parameters
    ----------
    act
        Which of `ACTS`.
    right
        Whether its goal was reached, as the truth decides.
    why
        What the truth says of it.
    """

    act: str
    right: bool
    why: str


class Day:
    """A building, its people, and a robot on one day.

    Parameters
    ----------
    seed
        Of all of it.
    enrol
        Function of building, people and a generator that returns the faces that the robot knows.
    assemble
        Function of building, faces and systems to leave out that returns the robot.
    without
        Systems that the robot lacks, of `robot_perception.day.robot.SYSTEMS`.
    strain
        What makes the day harder: one of `STRAINS`, or nothing.
    """

    def __init__(
        self,
        seed: int,
        enrol: Callable[[Building, list[Someone], np.random.Generator], Eigenfaces],
        assemble: Callable[[Building, Eigenfaces, frozenset[str]], DayRobot],
        without: frozenset[str] = frozenset(),
        strain: str = "",
    ) -> None:
        streams = np.random.default_rng(seed).spawn(6)
        make, looks, self.ways, self.noise, self.slip, self.chance = streams
        self.building: Building = make_building(rng=make)
        self.people = [make_someone(looks) for _ in range(6)]
        self.known, self.assemble = enrol(self.building, self.people[3:], looks), assemble
        self.robot = assemble(self.building, self.known, without)
        self.strain = strain
        self.state, self.time, self.place = self.robot.start(), 0.0, np.zeros(3)
        self.onto = np.zeros(3)  # lays the robot's map on the floor
        self.tutor, self.wish = np.zeros(2), ""
        self.outcomes: list[Outcome] = []

    def branch(self, without: frozenset[str] = frozenset(), strain: str = "") -> "Day":
        """Return a day that goes on from here with a robot that lacks systems, or harder."""
        other = copy(self)
        for name in ("ways", "noise", "slip", "chance", "outcomes"):
            setattr(other, name, deepcopy(getattr(self, name)))
        other.robot, other.strain = self.assemble(self.building, self.known, without), strain
        return other

    # Parts ---------------------------------------------------------------------------------------

    def tell(self, sensor: str, value: Any) -> DayInfo:
        """Give the robot a reading; return what it led to."""
        reading = Reading(self.time, sensor, value)
        self.state, info = self.robot.step(self.state, reading, rng=self.chance)
        return info

    def rolled(self, there: np.ndarray) -> DayInfo:
        """Bring the robot to its next pose; the wheels report the way."""
        report = roll(np.stack([self.place, there]), SMALL, rng=self.slip)
        self.place, self.time = there, self.time + TICK
        noise = np.diag(report.deviations[0] ** 2)
        return self.tell("wheels", Odometry(report.increments[0], noise))

    def pair(self) -> tuple[np.ndarray, np.ndarray]:
        """Return what the stereo pair sees now."""
        seen = self.building.pair(PAIR, self.place, rng=self.noise)
        return seen.left, seen.right

    def overhead(self, heads: np.ndarray | None = None) -> np.ndarray:
        """Return what the camera below the ceiling sees now."""
        heads = np.zeros((0, 3)) if heads is None else heads
        return self.building.overhead(self.place, heads, rng=self.noise)

    def seen(self, image: np.ndarray) -> np.ndarray:
        """Return a picture of the camera that looks ahead in the light of the day."""
        return (image * DIM).astype(np.uint8) if self.strain == "dark" else image

    def believed(self) -> np.ndarray:
        """Return where the robot takes itself to be on the floor, m and rad."""
        return se2.compose(self.onto, self.state.pose.mean)

    def off(self) -> tuple[float, float]:
        """Return how far that is from the truth, m and rad."""
        gap = self.believed() - self.place
        return float(np.hypot(*gap[:2])), float(abs(wrap_angle(gap[2])))

    def moment(self, act: str, info: DayInfo, **more: Any) -> Moment:
        """Return what is now."""
        return Moment(self.time, act, self.place, self.state, info, **more)

    def ended(self, act: str, right: bool, why: str) -> bool:
        """Note how an act ended, and return whether its goal was reached."""
        self.outcomes.append(Outcome(act, bool(right), why))
        return bool(right)

    def truly(self, pictures: list[int]) -> np.ndarray:
        """Return where pictures of the way were taken by the robot's own map, on the floor, m."""
        return se2.compose(self.onto, self.state.memory.poses[pictures])[:, :2]

    # Acts ----------------------------------------------------------------------------------------

    def run(self, *, helped: bool = False) -> Iterator[Moment]:
        """Yield the day, step by step.

        Parameters
        ----------
        helped
            Whether somebody puts the robot where the next act begins after an act whose goal was
            not reached, and tells it where it is. Without help the day ends there.
        """
        for part in PARTS:
            if not helped and self.outcomes and not self.outcomes[-1].right:
                return
            yield from self.part(part)

    def part(self, part: str) -> Iterator[Moment]:
        """Yield a part of the day; where the last act failed, somebody helps before it begins."""
        if self.outcomes and not self.outcomes[-1].right:
            self.help(part)
        yield from getattr(self, part)()

    def help(self, part: str) -> None:
        """Put the robot where a part of the day begins, and tell it where that is."""
        if part == "find":  # nobody tells it there
            return
        hall = np.array([self.building.office.exits[1, 0] - 1.4, (EAST + WEST) / 2, np.pi / 2])
        self.place = {
            "guide": hall,
            "attend": np.array([POST, WEST, 0.0]),
            "point": np.array([self.tutor[0] - KEEPS, WEST, 0.0]),
        }.get(part, self.place)
        task, place = {
            "hall": ("ceiling", "hall"),
            "guide": ("guide", "hall"),
            "attend": ("attend", ""),
            "point": ("watch", ""),
            "go": ("return", self.wish),
        }[part]
        told = se2.between(self.onto, self.place)
        self.state, _ = self.robot.put(self.state, task, told, place)

    def learn(self) -> Iterator[Moment]:
        """Lead the robot along the corridor and back, and tell it the names of places."""
        path = led_path(self.building, rng=self.ways, tick=TICK)
        self.place, self.onto = path[0], path[0]
        scans = Sensing(self.building.office, [], rig(("laser",), RING), rng=self.noise)
        turn = int(np.argmax(path[:, 2] > 0.1))
        post = turn + int(np.abs(path[turn:, 0] - POST).argmin())
        doors = self.building.office.doors[:, 0]
        shown = {int(np.hypot(*(path[:turn, :2] - door).T).argmin()): k
                 for k, door in enumerate(doors)}  # fmt: skip
        gone, last = np.inf, np.inf
        world = World(self.building.office, (), (), path[0], rng=self.ways)
        before = replace(world.now, robot=path[0])
        for k, pose in enumerate(path):
            info = self.rolled(pose) if k else DayInfo()
            gone += np.hypot(*(pose - path[max(k - 1, 0)])[:2])
            if gone >= APART or abs(wrap_angle(pose[2] - last)) >= TURNED:
                info, gone, last = self.tell("pair", self.pair()), 0.0, pose[2]
            self.tell("overhead", self.overhead())
            now = replace(world.now, time=k * TICK, robot=pose)
            for scan in scans.due(before, now):
                if k % 5 == 0 and isinstance(scan, LaserScan):
                    self.tell("laser", scan.ranges)
            before = now
            if k in shown:
                there = se2.act(se2.inverse(pose), doors[shown[k]][None])[0]
                self.tell("teacher", (f"door {shown[k]}", there))
            for at, name in ((turn, "hall"), (post, "post")):
                if k == at:
                    self.tell("teacher", (name, np.zeros(2)))
            yield self.moment("learn", info, image=partial(_left, self.building, pose))
        self.tell("teacher", "switch off")
        way = se2.compose(self.onto, self.state.memory.poses)
        error = float(np.sqrt(np.mean(np.sum((way - path)[:, :2] ** 2, axis=1))))
        self.ended("learn", error < 1.0, f"the way is off by {error:.2f} m")

    def find(self) -> Iterator[Moment]:
        """Set the robot down somewhere on the way; it drives on until it is sure where it is."""
        x = float(self.ways.uniform(2.0, 6.0))
        self.place = np.array([x, EAST + self.ways.uniform(-0.15, 0.15), self.ways.normal(0, 0.05)])
        self.state = self.robot.carried(self.state, rng=self.chance)
        world = World(self.building.office, (), (), self.place, rng=self.ways)
        gone = np.inf
        for _ in range(300):
            info = DayInfo(self.state.command)
            if gone >= 3 * APART:
                info, gone = self.tell("pair", self.pair()), 0.0
                yield self.moment("find", info, image=partial(_left, self.building, self.place))
            if self.state.task != "find":
                break
            before = self.place
            self.rolled(world.advance(TICK, self.state.command).robot)
            gone += np.hypot(*(self.place - before)[:2])
        off, turned = self.off()
        right = self.state.task == "ceiling" and off < 1.0 and turned < np.deg2rad(15)
        lost = " and knows no way" if self.state.task == "wait" else ""
        self.ended("find", right, f"it takes itself to be {off:.2f} m from where it is{lost}")

    def hall(self) -> Iterator[Moment]:
        """Let the robot drive below the ceiling to the hall."""
        yield from self._below("hall", "hall")

    def go(self) -> Iterator[Moment]:
        """Let the robot drive to the door to which it was sent."""
        yield from self._below("go", self.wish)

    def _below(self, act: str, goal: str) -> Iterator[Moment]:
        """Let the robot drive below the ceiling to a place that it has been shown."""
        world = World(self.building.office, (), (), self.place, rng=self.ways)
        for _ in range(900):
            image = self.overhead()
            info = self.tell("overhead", image)
            yield self.moment(act, info, image=partial(np.asarray, image))
            if self.state.task not in ("ceiling", "return", "turn"):
                break
            self.rolled(world.advance(TICK, self.state.command).robot)
        end = self.truly(self.state.memory.passes(goal))
        off = float(np.hypot(*(end - self.place[:2]).T).min())
        here = self.state.task in ("guide", "wait") and off < 0.6
        said = f" and says: {info.say}" if info.say else ""
        self.ended(act, here, f"it stands {off:.2f} m from where it was shown {goal}{said}")

    def guide(self) -> Iterator[Moment]:
        """Let the robot guide a visitor west; two people stand in the way until they are asked."""
        act = guided_tour(self.building, self.people, self.place, POST, rng=self.ways)
        sensing = Sensing(self.building.office, act.world.people, Rig(ring=RING), rng=self.noise)
        asked, bumped, shown = False, False, None
        start = self.time
        while self.time - start < act.seconds and self.state.task in ("guide", "turn"):
            before = act.world.now
            now = act.world.advance(TICK, self.state.command)
            info = self.rolled(now.robot)
            asked |= info.say == "clear the path"
            bumped |= act.world.bumped
            if info.say == "clear the path":
                clear_the_way(act)
            elif info.say == "come back":
                act.world.ask(0)
            for reading in sensing.due(before, now):
                name = {LaserScan: "laser", SonarScan: "sonar"}.get(type(reading), "fisheye")
                value = reading.image if name == "fisheye" else reading.ranges
                self.tell(name, value)
                if name == "fisheye":
                    self.tell("overhead", self.overhead(act.heads(now)))
                    shown = partial(np.asarray, reading.image[..., ::-1])
            yield self.moment("guide", info, people=now.positions, image=shown)
        off = float(abs(self.place[0] - POST))
        right = asked and not bumped and off < 0.8 and self.state.task == "attend"
        said = "asked" if asked else "did not ask"
        hurt = "ran into something" if bumped else "ran into nothing"
        why = f"it {said}, {hurt}, and stands {off:.2f} m from its post"
        self.ended("guide", right, why)

    def attend(self) -> Iterator[Moment]:
        """Let a stranger and the tutor come; the tutor leads the robot and stops it."""
        stranger, tutor, passer = self.people[0], self.people[3], self.people[1]
        if self.strain == "twin":
            dressed = replace(stranger.visitor, clothes=tutor.visitor.clothes)
            stranger = replace(stranger, visitor=dressed)
        company = [stranger, tutor, passer]
        act = tutor_comes(self.building, company, self.place, rng=self.ways)
        start, names, held, nearest = self.time, {}, [], []
        while self.time - start < act.seconds and self.state.task == "attend":
            now = act.world.advance(TICK, self.state.command)
            self.rolled(now.robot)
            seen = act.look(CAMERA, now, rng=self.noise)
            image = self.seen(seen.image)
            info = self.tell("ahead", image)
            clock, name = self.time - start, self.state.companion.name
            names[round(clock, 1)] = name
            if 25.0 < clock < 26.0:
                link = self.state.companion.link
                held.append(link is not None and same(link.face.box, seen.faces[1]))
            if 40.0 < clock < 42.0:
                person = self.state.companion.person
                nearest.append(person is not None and same(person.box, seen.boxes[1]))
            yield self.moment(
                "tutor" if clock < 26 else "follow" if clock < 44 else "halt",
                info,
                people=now.positions,
                image=partial(np.asarray, image),
            )
        self.tutor = now.positions[1]
        fooled = any(names[t] in ("follow", "gesture") for t in names if t < 20)
        known = not fooled and np.mean(held or [False]) > 0.5
        why = "it follows a stranger" if fooled else f"on the face in {np.mean(held or [0]):.0%}"
        if not self.ended("tutor", known, why):
            return
        on = float(np.mean(nearest or [0.0]))
        if not self.ended("follow", on > 0.5, f"on the tutor in {on:.0%} of the last pictures"):
            return
        self.ended("halt", self.state.task == "watch", f"at the end it is in {names[max(names)]}")

    def point(self) -> Iterator[Moment]:
        """Let the tutor point at a door, and the robot choose it."""
        doors = self.building.office.doors[:, 0]
        gap = doors[:, 0] - self.tutor[0]
        near = np.flatnonzero((gap < 0.6) & (gap > -6.0)).tolist()
        first = int(self.ways.choice(near))
        self.wish, images = f"door {first}", []
        for which in (first, *(k for k in near if k != first)):
            try:
                images = pointing(
                    self.building,
                    self.people[3],
                    self.tutor,
                    self.place,
                    doors[which],
                    CAMERA,
                    rng=self.noise,
                )
            except ValueError:  # no arm points there, or the robot looks elsewhere
                continue
            self.wish = f"door {which}"
            break
        for image in map(self.seen, images):
            self.time += 1 / 15
            info = self.tell("ahead", image)
            yield self.moment(
                "point", info, people=self.tutor[None], image=partial(np.asarray, image)
            )
            if self.state.task != "watch":
                break
        target = self.state.target
        right = bool(images) and target == self.wish
        self.ended("point", right, f"it goes to {target or 'no door'}, sent to {self.wish}")


def _left(building: Building, pose: np.ndarray) -> np.ndarray:
    """Return what the left eye sees, without noise."""
    return stereo.ideal_image(building.scene, PAIR, pose).clip(0, 255).astype(np.uint8)


def same(box: np.ndarray, truth: np.ndarray) -> bool:
    """Tell whether a box is at what it should be at."""
    return bool(np.isfinite(truth).all() and overlap(box[None], truth[None])[0, 0] >= 0.4)
