r"""A robot for a day: it learns a floor, finds itself, guides, recognises, follows, and is sent.

One loop takes readings of all sensors and returns what the robot knows and does,
``DayRobot.step(state, reading, *, rng) -> (state, info)``. The task says which systems are asked:

=========== ====================================================================== =============
task        system, and what it hands over                                         paper
=========== ====================================================================== =============
``learn``   stereo SLAM, walls, mosaic of the ceiling: `Memory`                    001, 000, 003
``find``    Monte Carlo localisation in the map: a pose, and a way from there      001
``ceiling`` key images below the ceiling: the pose where the way ends              003
``guide``   legs, echoes and skin, a committee: who is there, who is in the way    002
``turn``    wheels alone
``attend``  face, link, hand and tracker: whom to follow, and when to stop         004
``watch``   two arms: the place at which one points                                004
``return``  key images again                                                       003
=========== ====================================================================== =============

Where wheels and another system tell the pose, covariance intersection (002) joins the two, since
their errors may have anything in common.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks, landmarks
from robot_perception.arms.tracker import ArmState, ArmTracker
from robot_perception.beliefs import Gaussian
from robot_perception.cameras import StereoRig
from robot_perception.ceiling.mapping import Mapper, MapState
from robot_perception.ceiling.mosaic import NoCommonPattern
from robot_perception.ceiling.navigator import Navigator, ReplayInfo, ReplayState
from robot_perception.ceiling.visual_memory import KeyRules, ServoRules
from robot_perception.companion.robot import CompanionRobot
from robot_perception.companion.robot import RobotState as CompanionState
from robot_perception.day.memory import Lesson, Memory, remember
from robot_perception.fields import Positive, checked, from_to
from robot_perception.fusion import covariance_intersection
from robot_perception.geometry import se2, se3
from robot_perception.geometry.angles import wrap_angle
from robot_perception.landmarks.metrics import euclidean_mean
from robot_perception.observations import unnamed
from robot_perception.people import legs, sonar
from robot_perception.people.behaviours import STOP
from robot_perception.people.detections import Detections
from robot_perception.people.robot import RobotState as PeopleState
from robot_perception.people.robot import ServiceRobot, velocity
from robot_perception.people.skin import SkinState, SkinTracker
from robot_perception.slam.localisation import LocaliserRules, MapLocaliser, Whereabouts
from robot_perception.slam.planar.motions import Odometry
from robot_perception.slam.visual import VisualMaps, VisualSlam
from robot_perception.walls.mapper import WallMapper
from robot_perception.walls.scores import distance_to_segments
from robot_perception.walls.wall_map import WallMap

__all__ = [
    "SYSTEMS",
    "TASKS",
    "DayInfo",
    "DayRobot",
    "DayState",
    "Reading",
    "clear_of",
    "pointed_at",
]

Task = Literal["learn", "find", "ceiling", "guide", "turn", "attend", "watch", "return", "wait"]
TASKS = ("learn", "find", "ceiling", "guide", "turn", "attend", "watch", "return", "wait")
SENSORS = ("wheels", "pair", "overhead", "ahead", "laser", "sonar", "fisheye", "teacher")
SYSTEMS = ("stereo", "ceiling", "laser", "sonar", "skin", "faces", "arms", "intersection")
"""Systems that can be left out; the wheels stand in for those that tell where the robot is."""
_BESIDE = np.diag([0.06, 0.06, 0.03]) ** 2  # of a pose by the ceiling, m and rad
_NEAR = 1.25, np.deg2rad(45.0)  # of a pattern to where it should be as a way begins, m and rad
_ECHO = 0.3  # an echo so near to a wall of the map is nobody's, m
_SPACING = 0.1  # of the points of a way, m
_ALIKE = np.deg2rad(50.0)  # headings of one direction along the corridor


@dataclass(frozen=True, eq=False, slots=True)
class Reading:
    """Reading of a sensor.

    Parameters
    ----------
    time
        s.
    sensor
        ``"wheels"``, ``"pair"``, ``"overhead"``, ``"ahead"``, ``"laser"``, ``"sonar"``,
        ``"fisheye"`` or ``"teacher"``.
    value
        An `Odometry` since the last one; left and right grey picture; a grey picture; a picture in
        red, green, blue; ranges, m; ranges, m; a picture in blue, green, red; or the name of a
        place with where it is, ahead and to the left, m, ``"switch off"`` when the lesson is over.

    Raises
    ------
    ValueError
        If there is no such sensor, or a range is NaN.
    """

    time: float
    sensor: str
    value: Any

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", checks.number("time", self.time))
        checks.one_of("sensor", self.sensor, SENSORS)
        value = checks.instance("value", self.value, Odometry, tuple, np.ndarray, str)
        if isinstance(value, np.ndarray) and value.dtype.kind == "f" and np.isnan(value).any():
            raise ValueError(f"value must hold no NaN, got {np.isnan(value).sum()}")


@dataclass(frozen=True, eq=False, slots=True)
class DayInfo:
    """Answer of the robot to a reading.

    Parameters
    ----------
    command
        Speed, m/s, and turn rate, rad/s.
    say
        What the robot says; nothing mostly.
    told
        What the system that was asked made of the reading, by name.
    """

    command: tuple[float, float] = (0.0, 0.0)
    say: str = ""
    told: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class DayState:
    """State of the robot.

    Parameters
    ----------
    task
        What it does.
    time
        Of the last reading, s.
    pose
        Where it takes itself to be in its map, m and rad.
    moved
        What the wheels report since the last stereo pair.
    lesson, maps, sight, walls, above
        While it is led: notes, and the states of SLAM, tracks, walls and mosaic.
    memory
        What it has kept of that.
    whereabouts, sure
        While it looks for itself: the localiser's state, and in how many pairs in a row it was
        located.
    navigator, replay, end
        While it drives below the ceiling: along what, how far, and the picture of the way where
        that ends.
    people, skin
        Who is there, and what the fisheye follows, with time and heading of its last picture.
    companion
        The interaction with the tutor.
    arms, pictures
        Of the tutor, and in how many pictures they were tracked.
    command
        What it does until it says otherwise: speed, m/s, and turn rate, rad/s.
    target
        The place to which it was sent.
    halted
        In how many pictures the tutor has been there since the following was ended.
    scan
        The last one while it guides, m.
    heading, then
        While it turns: to which heading, rad, and what it does after that.
    """

    task: Task = "learn"
    time: float = -np.inf
    pose: Gaussian = field(default_factory=lambda: Gaussian(np.zeros(3), 1e-6 * np.eye(3)))
    moved: Odometry = field(default_factory=lambda: Odometry(np.zeros(3), np.zeros((3, 3))))
    lesson: Lesson = field(default_factory=Lesson)
    maps: VisualMaps | None = None
    sight: landmarks.Sighting | None = None
    walls: WallMap | None = None
    above: MapState | None = None
    memory: Memory | None = None
    whereabouts: Whereabouts | None = None
    sure: int = 0
    navigator: Navigator | None = None
    replay: ReplayState | None = None
    end: int | None = None
    people: PeopleState | None = None
    skin: tuple[SkinState, float, float] | None = None
    companion: CompanionState | None = None
    arms: ArmState | None = None
    pictures: int = 0
    command: tuple[float, float] = (0.0, 0.0)
    target: str = ""
    halted: int = 0
    scan: Float[np.ndarray, " beams"] | None = None
    heading: float = 0.0
    then: Task = "wait"


@dataclass(frozen=True, eq=False, slots=True)
class DayRobot:
    """A robot with the systems of the five papers.

    Parameters
    ----------
    cameras, mount
        The stereo pair, and where its left camera is on the robot.
    angles
        Directions of the beams of the laser, rad.
    ring, radius
        Directions of the sonars, rad, and the radius of their ring, m.
    mapper
        Of the mosaic; it brings the ceiling's camera with it.
    guide
        Behaviour among people.
    skin
        What follows the colour of skin in the fisheye's pictures.
    companion
        Interaction with a tutor.
    arms
        Tracker of arms before the camera that looks ahead.
    slam
        Stereo SLAM; by default with the mount's.
    localiser
        Rules of the localisation.
    keys, servo
        Rules of key images and of the control law.
    errands
        Where ``ceiling`` and ``guide`` lead: names of places.
    certain
        In so many pairs in a row the robot must be located.
    looks
        In so many pictures arms are tracked before it is told where one points.
    ahead
        So many pictures of the way farther on it looks for the ceiling again after it was lost.
    without
        Systems that are left out, of `SYSTEMS`.

    Raises
    ------
    ValueError
        If there is no such system.
    """

    cameras: StereoRig
    mount: Float[np.ndarray, "4 4"]
    angles: Float[np.ndarray, " beams"]
    ring: Float[np.ndarray, " sonars"]
    radius: Positive
    mapper: Mapper
    guide: ServiceRobot
    skin: SkinTracker
    companion: CompanionRobot
    arms: ArmTracker
    slam: VisualSlam | None = None
    localiser: LocaliserRules = field(default_factory=LocaliserRules)
    keys: KeyRules = field(default_factory=lambda: KeyRules(common=2))
    servo: ServoRules = field(
        default_factory=lambda: ServoRules(
            gain_distance=1.0, gain_bearing=2.5, gain_heading=-0.8, fastest=0.5
        )
    )
    errands: Mapping[str, str] = field(default_factory=lambda: {"ceiling": "hall", "guide": "post"})
    certain: Annotated[int, from_to(1)] = 3
    looks: Annotated[int, from_to(2)] = 40
    ahead: Annotated[int, from_to(0)] = 10
    without: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        checked(self)
        for name in self.without:
            checks.one_of("without", name, SYSTEMS)
        if self.slam is None:
            object.__setattr__(self, "slam", VisualSlam(self.mount))

    def start(self) -> DayState:
        """Return what is known before the first reading: nothing."""
        maps = self.slam.start(np.zeros(3))
        walls = WallMapper(self.angles).start()
        return DayState(maps=maps, walls=walls, above=self.mapper.start())

    def carried(self, state: DayState, *, rng: np.random.Generator) -> DayState:
        """Return the state after the robot was switched off, carried, and switched on again.

        Raises
        ------
        ValueError
            If it has learned nothing yet.
        """
        checks.generator("rng", rng)
        if checks.instance("state", state, DayState).memory is None:
            raise ValueError("state must have a memory, got none")
        begun = MapLocaliser(state.memory.landmarks, self.mount, self.localiser).start(rng=rng)
        return replace(
            state, task="find", whereabouts=begun, sure=0, moved=_none(), command=(0.3, 0.0)
        )

    def put(
        self, state: DayState, task: Task, pose: Float[np.ndarray, "3"], place: str = ""
    ) -> tuple[DayState, DayInfo]:
        """Return the state after somebody has put the robot at a pose, and told it where that is.

        Parameters
        ----------
        state
            Before it, with a memory.
        task
            What it is to do there: ``"ceiling"``, ``"guide"``, ``"attend"``, ``"watch"`` or
            ``"return"``.
        pose : (3,)
            In its map, m and rad.
        place
            Where ``"ceiling"`` and ``"return"`` lead, and where ``"guide"`` begins: a name.

        Raises
        ------
        ValueError
            If it has learned nothing yet, or the task begins elsewhere.
        """
        if checks.instance("state", state, DayState).memory is None:
            raise ValueError("state must have a memory, got none")
        checks.one_of("task", task, ("ceiling", "guide", "attend", "watch", "return"))
        mean = checks.vector("pose", pose, 3)
        clean = DayState(task, state.time, Gaussian(mean, _BESIDE), memory=state.memory)
        if task in ("ceiling", "return"):
            return self._sent(clean, task, place)
        if task == "guide":
            end = min(state.memory.passes(place), key=lambda k: self._away(clean, k))
            return self._guiding(replace(clean, end=end)), DayInfo()
        return replace(clean, companion=self.companion.start()), DayInfo()

    @staticmethod
    def _away(state: DayState, picture: int) -> float:
        """Return how far from the robot a picture of the way was taken, m."""
        return float(np.hypot(*(state.memory.poses[picture] - state.pose.mean)[:2]))

    def step(
        self, state: DayState, reading: Reading, *, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Return the state after a reading, and what the robot does.

        A reading that the task does not ask for changes nothing but the time.

        Parameters
        ----------
        state
            Before it.
        reading
            Of one sensor.
        rng
            Source of particles.

        Raises
        ------
        ValueError
            If the reading is older than the state, or as the system that is asked.
        """
        checks.instance("state", state, DayState)
        if checks.instance("reading", reading, Reading).time < state.time:
            raise ValueError(f"reading must not be older than {state.time} s, got {reading.time}")
        checks.generator("rng", rng)
        state = replace(state, time=reading.time)
        if reading.sensor == "wheels":
            return self._rolled(state, reading.value)
        asked = {
            "learn": self._learn,
            "find": self._find,
            "ceiling": self._below,
            "return": self._below,
            "guide": self._among,
            "attend": self._attend,
            "watch": self._watch,
        }.get(state.task)
        if asked is None:
            return state, DayInfo(state.command)
        return asked(state, reading, rng)

    def _rolled(self, state: DayState, motion: Odometry) -> tuple[DayState, DayInfo]:
        """Return the pose moved by the wheels; it turns, or follows a way, by them alone."""
        F, G = motion.jacobians(state.pose.mean)
        cov = F @ state.pose.cov @ F.T + G @ motion.noise @ G.T
        pose = Gaussian(motion.move(state.pose.mean), (cov + cov.T) / 2)
        state = replace(state, pose=pose, moved=_chained(state.moved, motion))
        if state.task == "turn":
            return self._turned(state)
        if state.task == "guide":
            return self._guided(state)
        if state.task in ("ceiling", "return") and "ceiling" in self.without:
            return self._pursued(state)
        return state, DayInfo(state.command)

    # Learn ---------------------------------------------------------------------------------------

    def _learn(
        self, state: DayState, reading: Reading, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Note what a reading shows on the way on which the robot is led."""
        lesson, since = state.lesson, (len(state.lesson.poses), state.moved.increment)
        if reading.sensor == "pair":
            return self._mapped(state, reading.value, rng)
        if reading.sensor == "overhead":
            above, info = self.mapper.step(state.above, reading.value, rng=rng)
            lesson = replace(
                lesson,
                since=(*lesson.since, since),
                sightings=(*lesson.sightings, dict(info.sightings)),
            )
            return replace(state, above=above, lesson=lesson), DayInfo()
        if reading.sensor == "laser":
            lesson = replace(lesson, scans=(*lesson.scans, (*since, reading.value)))
            return replace(state, lesson=lesson), DayInfo()
        if reading.sensor != "teacher":
            return state, DayInfo()
        if reading.value == "switch off":
            return self._kept(state)
        name, place = reading.value
        at = len(lesson.since), checks.vector("place", place, 2)
        return replace(state, lesson=replace(lesson, told={**lesson.told, name: at})), DayInfo()

    def _mapped(
        self, state: DayState, pair: tuple[np.ndarray, np.ndarray], rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Take a stereo pair to the map."""
        T = se3.conjugated(se3.inverse(se3.from_se2(state.moved.increment)), self.mount)
        sight = landmarks.sight(state.sight, *pair, self.cameras, T)
        motion = state.moved if state.lesson.poses else None
        maps, info = self.slam.step(
            state.maps, motion, sight.observations, sight.descriptors, costs=euclidean_mean, rng=rng
        )
        lesson = replace(
            state.lesson,
            poses=(*state.lesson.poses, maps.maps.poses),
            ancestors=(*state.lesson.ancestors, info.resampling.ancestors),
        )
        best = maps.maps.poses[maps.maps.best]
        pose = Gaussian(best, state.pose.cov)
        after = replace(state, maps=maps, sight=sight, lesson=lesson, moved=_none(), pose=pose)
        return after, DayInfo(told={"pose": best})

    def _kept(self, state: DayState) -> tuple[DayState, DayInfo]:
        """Return the state with what is kept of the lesson."""
        memory = remember(state.lesson, state.maps, state.above, state.walls)
        mapper, walls, way = WallMapper(self.angles), state.walls, memory.poses
        counts = [count for count, _ in state.lesson.since]
        for count, step, ranges in state.lesson.scans:
            k = min(int(np.searchsorted(counts, count)), len(way) - 1)
            own = se2.compose(way[k], se2.between(state.lesson.since[k][1], step))
            walls, _ = mapper.step(walls, ranges, own)
        memory = replace(memory, walls=walls)
        return DayState("wait", state.time, state.pose, memory=memory), DayInfo(say="learned")

    # Find ----------------------------------------------------------------------------------------

    def _find(
        self, state: DayState, reading: Reading, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Look for the robot in its map; once it is found, drive to the first errand."""
        if "stereo" in self.without:  # it takes itself to be where the lesson began
            begin = Gaussian(state.memory.poses[0], np.diag([1.0, 1.0, 0.3]))
            return self._sent(replace(state, pose=begin), "ceiling", self.errands["ceiling"])
        if reading.sensor != "pair":
            return state, DayInfo(state.command)
        found = landmarks.observe(*reading.value, self.cameras)
        points, looks = found.points, found.features.descriptors
        localiser = MapLocaliser(state.memory.landmarks, self.mount, self.localiser)
        seen = unnamed(points.mean, points.cov)
        motion = state.moved if np.any(state.moved.increment) else None
        whereabouts, _ = localiser.step(
            state.whereabouts, motion, seen, looks.astype(float), costs=euclidean_mean, rng=rng
        )
        sure = state.sure + 1 if whereabouts.located else 0
        first = whereabouts.clusters[0]
        pose = Gaussian(first.pose, first.cov)
        after = replace(state, whereabouts=whereabouts, sure=sure, moved=_none(), pose=pose)
        if sure < self.certain:
            return after, DayInfo(state.command, told={"pose": first.pose})
        return self._sent(after, "ceiling", self.errands["ceiling"])

    # Below the ceiling ---------------------------------------------------------------------------

    def _sent(self, state: DayState, task: Task, place: str) -> tuple[DayState, DayInfo]:
        """Return the state in which the robot is on its way to a place that it has been shown."""
        memory, ways = state.memory, []
        for turned in (0.0, np.pi):
            here = memory.nearest(state.pose.mean + np.array([0.0, 0.0, turned]), _ALIKE)
            if here is not None:
                ways += [(end - here, here, end) for end in memory.passes(place) if end > here]
        if not ways:
            return replace(state, task="wait", command=(0.0, 0.0)), DayInfo(say="no way there")
        nearest = min(ways)[1:]  # by the wheels, where no way has key images
        here, end, navigator = self._way(memory, sorted(ways)) or (*nearest, None)
        sent = replace(state, task=task, navigator=navigator, replay=None, end=end, target=place)
        ahead = float(memory.poses[here, 2])
        if abs(wrap_angle(ahead - state.pose.mean[2])) > _ALIKE:  # it turns first, by its wheels
            return replace(sent, task="turn", heading=ahead, then=task), DayInfo(say=f"to {place}")
        return replace(sent, command=(0.0, 0.0)), DayInfo(say=f"to {place}")

    def _way(
        self, memory: Memory, ways: Sequence[tuple[int, int, int]]
    ) -> tuple[int, int, Navigator] | None:
        """Return the first way that has key images: its ends, and what drives it; or nothing."""
        narrow = replace(self.keys, common=1)  # across a bare stretch of the ceiling
        for rules, (_, here, end) in product((self.keys, narrow), ways):
            try:
                route = memory.route(here, end, rules)
            except NoCommonPattern:
                continue
            navigator = Navigator(
                route,
                memory.patterns,
                memory.mosaic,
                self.mapper.centre,
                self.mapper.scale,
                self.servo,
                self.mapper.rules,
                correction=self.mapper.correction,
            )
            return here, end, navigator
        return None

    def _overhead(
        self, state: DayState, image: np.ndarray, rng: np.random.Generator
    ) -> tuple[DayState, ReplayInfo | None]:
        """Return the state with its pose by the ceiling, too, and what was seen, if anything.

        As a way begins patterns are looked for near where they should be by the pose, not anywhere:
        one pattern may look like another.
        """
        replay, navigator = state.replay, state.navigator
        if navigator is None:
            return state, None
        if replay is None:
            there = se2.compose(se2.inverse(state.memory.onto), state.pose.mean)
            rules = replace(navigator.rules, search=_NEAR[0] / self.mapper.scale, turn=_NEAR[1])
            begun = replace(navigator, rules=rules)
            replay, first = begun.step(ReplayState({}, there), image, rng=rng)
            if not first.sightings:
                return state, None
        replay, info = navigator.step(replay, image, rng=rng)
        state = replace(state, replay=replay)
        if info.sightings:
            fix = Gaussian(se2.compose(state.memory.onto, replay.pose), _BESIDE)
            state = replace(state, pose=self._joined(state.pose, fix))
        return state, info

    def _below(
        self, state: DayState, reading: Reading, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Drive from key image to key image, and by the wheels where none of them is seen."""
        if reading.sensor != "overhead" or "ceiling" in self.without:
            return state, DayInfo(state.command)
        state, info = self._overhead(state, reading.value, rng)
        if info is None or info.status == "lost":
            return self._pursued(self._along(state, 0, state.end))
        state = replace(state, command=info.command)
        if info.status == "driving":
            return state, DayInfo(info.command, told={"key": state.replay.key})
        return self._arrived(state)

    def _joined(self, pose: Gaussian, fix: Gaussian) -> Gaussian:
        """Return the pose by the wheels and by another system together."""
        if "intersection" in self.without:
            return fix
        areas = np.linalg.det(pose.cov), np.linalg.det(fix.cov)
        omega = areas[0] / (areas[0] + areas[1])  # eq. (4) of 002: more of the surer one
        return covariance_intersection(pose, fix, omega, angles=(2,))

    def _arrived(self, state: DayState) -> tuple[DayState, DayInfo]:
        """Return the state at the end of a way."""
        after: Task = "guide" if state.task == "ceiling" else "wait"
        state = replace(state, task=after, command=(0.0, 0.0))
        return self._guiding(state) if after == "guide" else state, DayInfo(say="here")

    def _pursued(self, state: DayState) -> tuple[DayState, DayInfo]:
        """Follow the way by the pose alone."""
        here = state.memory.nearest(state.pose.mean, _ALIKE)
        way = state.memory.poses[min(here or 0, state.end) : state.end + 1, :2]
        if np.hypot(*(way[-1] - state.pose.mean[:2])) < 0.2:
            return self._arrived(state)
        command = velocity(replace(STOP, speed=0.4), state.pose.mean, way)
        return replace(state, command=command), DayInfo(command)

    # Among people --------------------------------------------------------------------------------

    def route(self, state: DayState) -> Float[np.ndarray, "k 2"]:
        """Return the way of a guide in the map, m, its points some 0.1 m apart.

        Raises
        ------
        ValueError
            If it has learned nothing, or has not come to where the way begins.
        """
        checks.instance("state", state, DayState)
        if state.memory is None or state.end is None:
            raise ValueError("state must have a memory and an end, got none")
        first, last = self._tour(state)
        way = state.memory.poses[first : last + 1, :2]
        gone = np.r_[0.0, np.hypot(*np.diff(way, axis=0).T).cumsum()]
        return way[np.searchsorted(gone, np.arange(0.0, gone[-1] + 1e-9, _SPACING))]

    def _tour(self, state: DayState) -> tuple[int, int]:
        """Return the first and the last picture of the way of a guide."""
        memory = state.memory
        first = memory.nearest(memory.poses[state.end], 0.1)
        return first, max(memory.passes(self.errands["guide"]))

    def _guiding(self, state: DayState) -> DayState:
        """Return the state in which the robot guides a visitor from where it is."""
        return self._below_way(replace(state, people=self.guide.start(state.pose.mean)))

    def _below_way(self, state: DayState) -> DayState:
        """Return the state in which the ceiling of the rest of the guide's way is looked for."""
        return self._along(state, *self._tour(state))

    def _along(self, state: DayState, first: int, last: int) -> DayState:
        """Return the state in which the ceiling of the rest of a way is looked for."""
        here = state.memory.nearest(state.pose.mean, _ALIKE)
        here = first if here is None else min(max(here + self.ahead, first), last - 1)
        found = self._way(state.memory, [(last - here, here, last)])
        return replace(state, navigator=None if found is None else found[2], replay=None)

    def _among(
        self, state: DayState, reading: Reading, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Take what a sensor says of people to the committee."""
        pose, found, skin = state.pose.mean, None, state.skin
        if reading.sensor == "overhead" and "ceiling" not in self.without:
            state, info = self._overhead(state, reading.value, rng)
            if info is None or info.status == "lost":
                state = self._below_way(state)
            return state, DayInfo(state.command)
        if reading.sensor == "laser" and "laser" not in self.without:
            state = replace(state, scan=reading.value)
            found = Detections(reading.time, "laser", legs.detect(reading.value, self.angles))
        elif reading.sensor == "sonar" and "sonar" not in self.without:
            walls = partial(_on_walls, state.memory.walls, pose)
            echoes = sonar.detect(reading.value, self.ring, self.radius, occupied=walls)
            found = Detections(reading.time, "sonar", echoes)
        elif reading.sensor == "fisheye" and "skin" not in self.without:
            clouds, before, heading = skin or (self.skin.start(), reading.time - 0.1, pose[2])
            turned = float(wrap_angle(pose[2] - heading))
            how = {"elapsed": reading.time - before, "turned": turned, "rng": rng}
            clouds, _ = self.skin.step(clouds, reading.value, **how)
            skin = clouds, reading.time, float(pose[2])
            found = Detections(reading.time, "camera", self.skin.detect(clouds))
        if found is None:
            return state, DayInfo(state.command)
        people, _ = self.guide.step(state.people, found, pose)
        return replace(state, people=people, skin=skin), DayInfo(state.command)

    def _guided(self, state: DayState) -> tuple[DayState, DayInfo]:
        """Drive a visitor along the way, and ask who is in it to step aside."""
        route, pose = self.route(state), state.pose.mean
        people, command = self.guide.act(state.people, pose, route)
        state = replace(state, people=people)
        if np.hypot(*(route[-1] - pose[:2])) < 0.3:
            ahead = float(state.memory.poses[0, 2])
            turning = replace(state, task="turn", heading=ahead, then="attend")
            return replace(turning, command=(0.0, 0.0)), DayInfo(say="here")
        driven = velocity(command, pose, route)
        if state.scan is not None:
            driven = clear_of(driven, state.scan, self.angles)
        return replace(state, command=driven), DayInfo(driven, command.say)

    def _turned(self, state: DayState) -> tuple[DayState, DayInfo]:
        """Turn by the wheels: to face who comes, or into the way to a place."""
        off = float(wrap_angle(state.heading - state.pose.mean[2]))
        if abs(off) > np.deg2rad(4.0):
            command = 0.0, float(np.clip(1.5 * off, -0.8, 0.8))
            return replace(state, command=command), DayInfo(command)
        state = replace(state, task=state.then, command=(0.0, 0.0))
        if state.task == "attend":
            state = replace(state, companion=self.companion.start())
        return state, DayInfo()

    # With a tutor --------------------------------------------------------------------------------

    def _attend(
        self, state: DayState, reading: Reading, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Wait for the tutor, follow, and stop."""
        if reading.sensor != "ahead":
            return state, DayInfo(state.command)
        companion, info = self.companion.step(state.companion, reading.value, rng=rng)
        stands = companion.name == "halt" or (state.halted and companion.name != "follow")
        halted = state.halted + 1 if stands else 0
        state = replace(state, companion=companion, command=info.command, halted=halted)
        if halted >= 10:
            state = replace(state, task="watch", command=(0.0, 0.0))
        return state, DayInfo(state.command, told={"state": companion.name, "info": info})

    def _watch(
        self, state: DayState, reading: Reading, rng: np.random.Generator
    ) -> tuple[DayState, DayInfo]:
        """Follow the arms of the tutor, and go where one points."""
        if reading.sensor != "ahead":
            return state, DayInfo()
        if "arms" in self.without:
            doors = _doors(state.memory)
            away = [np.hypot(*(doors[name] - state.pose.mean[:2])) for name in doors]
            return self._sent(state, "return", list(doors)[int(np.argmin(away))])
        if state.arms is None:
            box = state.companion.link.face.box if state.companion.link else None
            try:
                arms = self.arms.start(reading.value, rng=rng)
            except ValueError:
                if box is None:
                    return state, DayInfo(say="nobody")
                arms = self.arms.start(reading.value, rng=rng, face=box)
            return replace(state, arms=arms, pictures=1), DayInfo()
        arms, info = self.arms.step(state.arms, reading.value, rng=rng)
        state = replace(state, arms=arms, pictures=state.pictures + 1)
        if state.pictures < self.looks:
            return state, DayInfo(told={"joints": info.joints})
        place = pointed_at(info.joints, state.pose.mean, _doors(state.memory))
        return self._sent(state, "return", place)


def clear_of(
    command: tuple[float, float],
    ranges: Float[np.ndarray, " beams"],
    angles: Float[np.ndarray, " beams"],
    *,
    wide: float = 0.8,
    far: float = 0.9,
) -> tuple[float, float]:
    r"""Return a command that turns away from what stands in the way; all of it is ours.

    .. math:: \omega' = \omega - \operatorname{sign}(y)\,
        \left(1 - \frac{|y|}{w/2}\right) \left(1 - \frac{x}{d}\right) \cdot 2 \,\mathrm{rad/s}

    with (x, y) the nearest point ahead of the robot within half the width w and the distance d; it
    drives at half its speed there.

    Parameters
    ----------
    command
        Speed, m/s, and turn rate, rad/s.
    ranges, angles : (beams,)
        Of a scan, m and rad; infinite where nothing came back.
    wide, far
        w and d, m.

    Raises
    ------
    ValueError
        If there is not a range for each beam, or a number is not positive.
    """
    speed, turn = checks.vector("command", command, 2).tolist()
    angles = checks.array("angles", angles, ("beams",))
    ranges = checks.array("ranges", ranges, (len(angles),), finite=False)
    half, far = checks.positive("wide", wide) / 2, checks.positive("far", far)
    with np.errstate(invalid="ignore"):
        x, y = ranges * np.cos(angles), ranges * np.sin(angles)
        near = np.flatnonzero((x > 0) & (x < far) & (np.abs(y) < half))
    if speed <= 0 or not near.size:
        return speed, turn
    k = near[x[near].argmin()]
    away = 2.0 * (1 - abs(y[k]) / half) * (1 - x[k] / far)
    return speed / 2, turn - float(np.copysign(away, y[k]))


def pointed_at(
    joints: Float[np.ndarray, "2 4 3"],
    pose: Float[np.ndarray, "3"],
    places: Mapping[str, Float[np.ndarray, "2"]],
) -> str:
    r"""Return the place at which the arm points that is farther from the body.

    .. math:: \arg\min_p \angle(w - s,\; p - s)

    with shoulder s and wrist w in the plane of the floor.

    Parameters
    ----------
    joints : (2, 4, 3)
        Shoulder, elbow, wrist and fingertips of both arms before the camera: to the right, down and
        ahead, m.
    pose : (3,)
        Of the robot in the map, m and rad; the camera is on its axis and looks ahead.
    places
        In the map, m.

    Raises
    ------
    ValueError
        If there is no place.
    """
    joints = checks.array("joints", joints, (2, 4, 3))
    if not places:
        raise ValueError("places must be one at least, got none")
    floor = np.stack([joints[..., 2], -joints[..., 0]], axis=-1)  # ahead and to the left
    reach = np.hypot(*(floor[:, 2] - floor[:, 0]).T)
    shoulder, _, wrist, _ = se2.act(checks.vector("pose", pose, 3), floor[int(reach.argmax())])
    way = np.arctan2(*(wrist - shoulder)[::-1])

    def off(name: str) -> float:
        gap = places[name] - shoulder
        return abs(float(wrap_angle(np.arctan2(gap[1], gap[0]) - way)))

    return min(places, key=off)


def _on_walls(
    walls: WallMap, pose: Float[np.ndarray, "3"], points: Float[np.ndarray, "n 2"]
) -> Bool[np.ndarray, " n"]:
    """Tell which points ahead and to the left of the robot (n, 2), m, lie on walls of its map."""
    if not len(walls.ends):
        return np.zeros(len(points), dtype=bool)
    return distance_to_segments(se2.act(pose, points), walls.ends).min(axis=-1) < _ECHO


def _doors(memory: Memory) -> dict[str, np.ndarray]:
    """Return the places that are doors."""
    return {name: at for name, at in memory.places.items() if name.startswith("door")}


def _none() -> Odometry:
    return Odometry(np.zeros(3), np.zeros((3, 3)))


def _chained(first: Odometry, then: Odometry) -> Odometry:
    """Return two motions as one."""
    F, G = then.jacobians(first.increment)
    noise = F @ first.noise @ F.T + G @ then.noise @ G.T
    return Odometry(se2.compose(first.increment, then.increment), (noise + noise.T) / 2)
