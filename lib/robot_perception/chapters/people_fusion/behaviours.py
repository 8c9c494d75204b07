"""Guide, follow, survey: the system steers the robot, and people answer to what it does.

What the paper names, and we use: the sonars compare their readings with the walls and cabinets of
the map, and hypotheses that never move are discarded unless the robot is busy with them. What we
add: a hypothesis whose distance is unknown, from the camera alone, is nobody to deal with. The
robot is told where on the map it starts; from then on it knows what its wheels report, for its
route, its sonars and its hypotheses.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from data_synth.people import make_people_office, make_person
from data_synth.people.signals import FisheyeImage, LaserScan, Sensing, SonarScan
from data_synth.people.world import STEP, Moment, Visit, World, walk
from data_synth.sonar import SonarRing
from data_synth.wheels import SMALL, roll
from robot_perception.chapters.people_fusion import committee
from robot_perception.chapters.people_fusion.rates import scaled
from robot_perception.chapters.people_sensors.sessions import PAPER, RIG, SENSORS, Senses, rig
from robot_perception.evaluation.intervals import bootstrap_mean, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import se2, wrap_angle
from robot_perception.people import behaviours as acts
from robot_perception.people.behaviours import MOVES, PHASES, STOP, Behaviours, Command, State
from robot_perception.people.detections import Detections
from robot_perception.people.tracker import PeopleTracker
from robot_perception.people.trajectories import StaticRules
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted
from robot_perception.walls.scores import distance_to_segments

Kind = Literal["guide", "follow", "survey"]
RULES = Behaviours(close=2.0, patience=2.0, memory=5.0, gap=0.8, speed=0.6)
"""Of the behaviours. A visitor of the world stands up to 1.6 m away; ours, chosen on ``CHOOSE``."""
BELIEVES = PeopleTracker(scaled(committee.RULES, patience=0.4), StaticRules(longest=3.0))
"""The rules of the committee, but who is no longer seen is forgotten sooner: a robot that asks back
within seconds cannot remember for eight. Chosen on ``CHOOSE``. Who stays in one place for 3 s, and
is not the one it is about, is furniture; ours."""
LEADS = 0.4
"""How fast a guide drives, so that who follows it stays in reach of the sonars, m/s; ours."""
STRAYS = 9.0  # when the visitor of a guide or a survey goes away, s; ours
DURATION = {"guide": 24.0, "follow": 20.0, "survey": 15.0}  # of a story, s; ours
PROMPT = 5.0  # a robot that asks back within that time has noticed, s; ours
LED = 0.5  # how fast the one who is followed walks, m/s; ours
COMES = 4.5  # from how far away the visitor comes, m; ours
WALLED = 0.3  # a sonar's reading so near to a wall of the map is the wall, m; ours
ARRIVED = 0.3  # a guide so near to the end of its route stops, m; ours
LOOK = 5  # every so many steps the hypotheses are written down
CHOOSE = tuple(range(5001, 5011))  # seeds of the stories that the rules were chosen on
SEEDS = tuple(range(6001, 6021))  # seeds of the stories that are scored
BACK_TO_ROBOT = 1.2  # where the one who is followed starts, m
SAID = ("", "come back", "welcome back", "take part", "first question", "thank you")
"""What the robot may say; mostly nothing."""


class TurnedRing(SonarRing):
    """The ring of the sessions turned by half a spacing: one sonar looks back, where visitors walk.

    Unturned, whoever walks straight behind the robot is in the gap between two cones.
    """

    @property
    def angles(self) -> Float[np.ndarray, " count"]:
        """Where the sonars look, rad."""
        return super().angles + np.pi / self.count


RING = TurnedRing()


@dataclass(frozen=True, eq=False, slots=True)
class Story:
    """What happened in k steps, with the h hypotheses that were written down at j of them.

    Of each step there are its time (s), where the robot was and where its wheels said it was (m and
    rad), where the person was (m), the phase of the behaviour in the order of ``PHASES``, which of
    ``SAID`` was said, the robot's speed (m/s), and whether what stood before it had stopped it. The
    hypotheses, so many a look, are about the robot; each has one of the roles of `acts`.
    """

    times: Float[np.ndarray, " k"]
    robot: Float[np.ndarray, "k 3"]
    reckoned: Float[np.ndarray, "k 3"]
    visitor: Float[np.ndarray, "k 2"]
    phase: Int[np.ndarray, " k"]
    said: Int[np.ndarray, " k"]
    speed: Float[np.ndarray, " k"]
    bumped: Bool[np.ndarray, " k"]
    looks: Int[np.ndarray, " j"]
    counts: Int[np.ndarray, " j"]
    mean: Float[np.ndarray, "h 2"]
    cov: Float[np.ndarray, "h 2 2"]
    weight: Float[np.ndarray, " h"]
    status: Int[np.ndarray, " h"]

    @property
    def apart(self) -> Float[np.ndarray, " k"]:
        """Distance of the person from the robot, m."""
        return np.linalg.norm(self.visitor - self.robot[:, :2], axis=-1)

    @property
    def asked(self) -> Bool[np.ndarray, " k"]:
        """When the robot asked back."""
        return self.said == SAID.index("come back")


@kept
def told(
    kind: Kind, seed: int, sensors: tuple[str, ...] = SENSORS, behaves: Behaviours = RULES
) -> Story:
    """Let the world run, with the detectors and the behaviour in it, and return the story.

    The seed is that of office, person and noise.
    """
    world, route = stage(kind, np.random.default_rng(seed))
    robot = _Robot(kind, seed, sensors, behaves, world)
    wheels = np.random.default_rng([seed, 2])
    command, rows, looks, now = STOP, [], [], world.now
    for k in range(round(DURATION[kind] / STEP)):
        before = now
        if kind == "follow" and command.speed > 0 and k % LOOK == 0:
            route = world.way(robot.pose[:2], robot.place())
        elif kind == "guide" and np.hypot(*(route[-1] - robot.pose[:2])) < ARRIVED:
            command = STOP
        now = world.advance(STEP, _velocity(robot.pose, command, route))
        rolled = roll(np.stack([before.robot, now.robot]), SMALL, rng=wheels).increments[0]
        command = robot.live(before, now, rolled)
        if command.say == "come back":
            world.ask(0)
        did = (PHASES.index(robot.state.phase), SAID.index(command.say), command.speed)
        rows.append((now.time, now.robot, robot.pose, now.positions[0], *did, world.bumped))
        if k % LOOK == 0:
            found = robot.tracked.hypotheses
            looks.append((k, len(found), found.mean, found.cov, found.weight, robot.roles()))
    at, counts, *found = zip(*looks, strict=True)
    return Story(
        *(np.array(column) for column in zip(*rows, strict=True)),
        *(np.array(at), np.array(counts)),
        *(np.concatenate(part) for part in found),
    )


class _Robot:
    """A robot's detectors, tracker and behaviour, fed with what its sensors and wheels report."""

    def __init__(
        self, kind: Kind, seed: int, sensors: tuple[str, ...], behaves: Behaviours, world: World
    ) -> None:
        self.behaves = replace(behaves, speed=LEADS) if kind == "guide" else behaves
        never = partial(self.behaves.survey, finished=False)
        self.act = never if kind == "survey" else getattr(self.behaves, kind)
        self.senses = Senses(np.random.default_rng([seed, 1]), RING)
        noise = np.random.default_rng([seed, 3])
        self.sensing = Sensing(world.office, world.people, rig(sensors, RING), rng=noise)
        self.map, _ = world.office.section(RIG.ring_height)
        self.pose, self.state = world.now.robot, State()
        self.tracked, self.still = BELIEVES.start(self.pose), np.zeros(0, dtype=bool)

    def live(self, before: Moment, now: Moment, rolled: Float[np.ndarray, "3"]) -> Command:
        """Take in what the sensors report between two moments, and return what to do."""
        start = self.pose
        for reading in self.sensing.due(before, now):
            share = (reading.time - before.time) / (now.time - before.time)
            self.pose = se2.compose(start, share * rolled)
            found = self.found(reading)
            self.tracked, info = BELIEVES.step(self.tracked, found, self.pose)
            self.still = info.static
        self.pose = se2.compose(start, rolled)
        persons = self.tracked.hypotheses.select(self.roles() >= MOVES)
        if persons.time == -np.inf:
            return STOP
        self.state, command = self.act(self.state, persons)
        return command

    def place(self) -> Float[np.ndarray, "2"]:
        """Return where on the map the one is whom it is about."""
        found = self.tracked.hypotheses
        return se2.act(self.pose, found.points[found.identity == self.state.person])[0]

    def roles(self) -> Int[np.ndarray, " n"]:
        """Return what each hypothesis is taken for."""
        found, person = self.tracked.hypotheses, BELIEVES.aggregation.person
        return acts.roles(found, self.still, self.state, person, committee.KNOWN)

    def found(self, reading: LaserScan | SonarScan | FisheyeImage) -> Detections:
        """Return what a detector makes of a reading; the sonars know the walls from the map."""

        def walled(points: np.ndarray) -> np.ndarray:
            on_map = se2.act(self.pose, points)
            return distance_to_segments(on_map, self.map).min(axis=-1) < WALLED

        return self.senses.detect(reading, float(self.pose[2]), walled)


def stage(kind: Kind, rng: np.random.Generator) -> tuple[World, Float[np.ndarray, "n 2"]]:
    """Return a world with a robot and one person in it, and the route of a guide.

    A guide waits in the corridor near the entrance, and its route leads to a room at the other end;
    a poller stands half-way; people come from 4.5 m away and leave the same way. Who is followed
    leads from the middle of a room to an end of the corridor. Only a guide has a route; it has a
    point every 0.1 m.
    """
    office = make_people_office(rng=rng)
    person, ends = make_person(rng=rng), office.exits[rng.permutation(2)]
    rooms = (office.rooms[:-1, :2] + office.rooms[:-1, 2:]) / 2
    room = rooms[rng.integers(len(rooms))]
    start, goal, at = ends[0], ends[1], round(COMES / 0.1)
    if kind == "guide":
        goal = rooms[np.abs(rooms[:, 0] - goal[0]).argsort()[rng.integers(2)]]
    elif kind == "follow":
        start, goal, at = room, ends[np.abs(ends[:, 0] - room[0]).argmax()], 0
    empty = World(office, (), (), np.array([*room, 0.0]), rng=rng)
    way = _even(empty.way(start, goal))
    if kind == "survey":
        at = len(way) // 2
    toward = way[at - 10] if kind == "survey" else way[at + 10]
    robot = np.array([*way[at], np.arctan2(*(toward - way[at])[::-1])])
    if kind == "follow":
        path = way[round(BACK_TO_ROBOT / 0.1) :]
        times = np.r_[0.0, 2.0 + 0.1 / LED * np.arange(len(path))]
        led = walk(np.concatenate([path[:1], path]), times)
        return World(office, (person,), (led,), robot, rng=rng), way[:0]
    leaves = Visit(strays=(STRAYS,), to=(float(start[0]), float(start[1])), returns=kind == "guide")
    comes = way[at - round(COMES / 0.1), None]
    world = World(office, (person,), (leaves,), robot, rng=rng, starts=comes)
    return world, way[at if kind == "guide" else len(way) :]


def _even(way: np.ndarray) -> Float[np.ndarray, "n 2"]:
    """Return a way with a point every 0.1 m."""
    along = np.concatenate([[0.0], np.hypot(*np.diff(way, axis=0).T).cumsum()])
    at = np.arange(0.0, along[-1], 0.1)
    return np.stack([np.interp(at, along, column) for column in way.T], axis=-1)


def _velocity(
    pose: Float[np.ndarray, "3"], command: Command, way: np.ndarray
) -> tuple[float, float]:
    """Return how the robot moves: towards a point ahead on its way, slower while it turns."""
    x, y, heading = pose
    if not len(way) or command.speed == 0:
        return command.speed, command.turn_rate
    nearest = int(np.hypot(*(way - [x, y]).T).argmin())
    gap = way[min(nearest + 6, len(way) - 1)] - [x, y]
    off = float(wrap_angle(np.arctan2(gap[1], gap[0]) - heading))
    return command.speed * max(0.0, 1 - abs(off) / 0.6), float(np.clip(1.5 * off, -1, 1))


# The claims --------------------------------------------------------------------------------------

WITHOUT_CAMERA: tuple[str, ...] = ("laser", "sonar")
SLOW = replace(RULES, patience=30.0)
"""A robot that believes for half a minute that whoever is gone will be there."""


def delays(stories: Sequence[Story], limit: float) -> Float[np.ndarray, " n"]:
    """Return how long after the person was too far away the robot asked back, s; inf: never."""
    found = []
    for story in stories:
        gone = (story.times > STRAYS) & (story.apart > limit)
        later = story.times[story.asked & (story.times > STRAYS)]
        noticed = gone.any() and later.size
        start = story.times[gone.argmax()]
        found.append(max(float(later[0] - start), 0.0) if noticed else np.inf)
    return np.array(found)


def false_stops(stories: Sequence[Story]) -> Float[np.ndarray, " n"]:
    """Return how often each robot asked back somebody who had not gone yet."""
    return np.array([float((s.asked & (s.times <= STRAYS)).sum()) for s in stories])


def continued(stories: Sequence[Story]) -> Bool[np.ndarray, " n"]:
    """Return of each story in which the person came back whether the robot was busy then.

    They came back who were near after they were asked, a second before the end or earlier.
    """
    found = []
    for story in stories:
        after = (story.asked & (story.times > STRAYS)).cumsum() > 0
        back = after & (story.apart < RULES.close)
        if back.any() and story.times[-1] - story.times[back.argmax()] > 1.0:
            found.append(bool((back & (story.phase == PHASES.index("busy"))).any()))
    return np.array(found, dtype=bool)


@dataclass(frozen=True, slots=True)
class Config:
    """So many stories of a kind, once with each choice of the sensors; all is ours."""

    kind: Kind
    count: int
    sensors: tuple[tuple[str, ...], ...] = (SENSORS,)
    behaves: Behaviours = RULES


Stories = list[list[Story]]


def stories(config: Config, *, rng: np.random.Generator) -> Stories:
    """Return the stories by sensors; each has a seed of its own, and nothing else is drawn."""
    seeds = SEEDS[: config.count]
    jobs = [(seed, who) for who in config.sensors for seed in seeds]
    done = iter(sweep(partial(_told, config), jobs, rng=rng, desc="stories"))
    return [[next(done) for _ in seeds] for _ in config.sensors]


def _told(config: Config, job: tuple[int, tuple[str, ...]], *, rng: np.random.Generator) -> Story:
    return told(config.kind, *job, config.behaves)


PATIENT = Change(
    "a robot that waits for half a minute before it believes its sensors", count=2, behaves=SLOW
)


def _noticed(some: Sequence[Story], limit: float) -> Finding:
    took = delays(some, limit)
    evidence = {"asked back before anybody left, a story": bootstrap_mean(false_stops(some))}
    if np.isfinite(took).sum() > 1:
        evidence["delay"] = bootstrap_mean(took[np.isfinite(took)], "s")
    return Finding(proportion(int((took <= PROMPT).sum()), took.size), evidence)


def prompt(config: Config, *, rng: np.random.Generator) -> Stories:
    """Let the robots of those whose visitor leaves sensor range ask then, by the truth."""
    back, told = SAID.index("come back"), stories(config, rng=rng)
    gone = [[(one, (one.times > STRAYS) & (one.apart > RULES.reach)) for one in x] for x in told]
    return [
        [replace(one, said=np.where(left, back, one.said)) for one, left in some if left.any()]
        for some in gone
    ]


TOUR = Study(stories, full=Config("guide", 20), quick=Config("guide", 4), seed=68)


@TOUR.claim(
    "guide-asks-back",
    paper=PAPER,
    place="§4.2",
    basis="substitute",
    statement="A guide whose visitor leaves sensor range stops and asks them to return.",
    paper_value="described; no number",
    method="Stories in the closed loop: share of the visitors who stray that are asked back "
    "within 5 s of being 3 m away.",
    accepted=Accepted(0.75, 1.0, "three stories of four", "our choice"),
    sabotage=Change(
        "a robot that asks whenever its visitor is so far away",
        prompt,
        count=20,
        sensors=(WITHOUT_CAMERA,),
    ),
)
def guide_asks_back(told: Stories) -> Finding:
    """Count the stories in which the robot asks back."""
    (some,) = told
    found, after = _noticed(some, RULES.reach), continued(some)
    if not after.size:
        return found
    share = proportion(int(after.sum()), after.size)
    return replace(found, evidence=found.evidence | {"continued, of those who came back": share})


WALK = Study(
    stories,
    full=Config("follow", 20, (WITHOUT_CAMERA, SENSORS)),
    quick=Config("follow", 12, (WITHOUT_CAMERA,)),
    seed=69,
)


@WALK.claim(
    "follow-turned-back",
    paper=PAPER,
    place="§4.2",
    basis="substitute",
    statement="The robot follows a person whose back is turned, on laser and sonars alone.",
    paper_value="“successfully follows the user”; no number",
    method="Stories in the closed loop, the camera's readings left out: share of the stories "
    "at whose end the robot is within 3 m of the person it follows through the office.",
    accepted=Accepted(0.75, 1.0, "three stories of four", "our choice"),
    sabotage=Change(
        "the camera alone, which loses a face that turns away", count=2, sensors=(("camera",),)
    ),
)
def follow_turned_back(told: Stories) -> Finding:
    """Count the stories in which the robot is still there."""
    apart = [np.array([story.apart[-1] for story in some]) for some in told]
    near = [proportion(int((end < RULES.reach).sum()), end.size) for end in apart]
    evidence = {
        "distance at the end": bootstrap_mean(apart[0], "m"),
        "asked back, a story": bootstrap_mean(np.array([float(s.asked.sum()) for s in told[0]])),
    }
    if len(near) > 1:
        evidence["with the camera as well"] = near[1]
    return Finding(near[0], evidence)


ROUND = Study(stories, full=Config("survey", 20), quick=Config("survey", 12), seed=70)


@ROUND.claim(
    "survey-breaks-off",
    paper=PAPER,
    place="§4.1",
    basis="substitute",
    statement="A visitor who leaves before the survey is finished is noticed.",
    paper_value="“used to detect break offs”; no number",
    method="Stories in the closed loop: share of the visitors who leave that are asked back "
    "within 5 s of being 2 m away.",
    accepted=Accepted(0.75, 1.0, "three stories of four", "our choice"),
    sabotage=PATIENT,
)
def survey_breaks_off(told: Stories) -> Finding:
    """Count the stories in which the robot notices."""
    return _noticed(told[0], RULES.close)
