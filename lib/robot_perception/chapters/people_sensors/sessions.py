"""From rendered signals to detections: what every study of the chapter starts from.

A session is rendered once, the three detectors run on its signals, and what they report is kept on
the reader's computer with the truth beside it. Seeds of sessions that the skin colours are learnt
on, that the parameters are chosen on, and that are scored never meet.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from scipy.optimize import linear_sum_assignment

from data_synth.fisheye import Fisheye
from data_synth.people import (
    LASER_ANGLES,
    FisheyeImage,
    LaserScan,
    Rig,
    Session,
    SonarScan,
    make_people_office,
    make_person,
    make_session,
    readings,
    truth,
)
from data_synth.people.world import Moment, Wander
from data_synth.sonar import SonarRing
from robot_perception.beliefs import Gaussian
from robot_perception.evaluation.progress import progress
from robot_perception.geometry import se2, wrap_angle
from robot_perception.people import legs, sonar
from robot_perception.people.detections import Detections
from robot_perception.people.skin import SkinModel, SkinState, SkinTracker
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.results import kept

SENSORS = ("laser", "sonar", "camera")  # of the paper, in the order of the rig
RIG = Rig()
TRUTH = Rig(camera=Fisheye(size=8))
"""For what the sensors could know; the pixels of faces, which take long, are not asked for."""
_NEVER = 60.0, 0.001  # when a sensor reads that takes no part, s, and how often after that, Hz
LEARN = (9001, 9002, 9003)  # seeds of the sessions that the colours of skin are learnt on
CHOOSE = tuple(range(8001, 8009))  # seeds of the sessions that the parameters are chosen on
TEST = tuple(range(7201, 7241))  # seeds of the sessions that are scored
PEOPLE = 3
JUDGED = (4, 2, 3)
"""Of so many readings of laser, sonars and camera one is compared with the truth: 2.5 a second."""
FAR = 1e3  # dearer than all pairs in reach together, m
PAPER = "sensor-aggregation"
BODY = 0.3  # so far from the edge of the laser's half-plane both legs are inside, m; ours
TURNED = 0.8  # cosine from which on a face looks at the robot, or away from it


@dataclass(frozen=True, slots=True)
class Config:
    """One session: its seed, how long it takes (s), and what the robot does.

    Paper: an office room, the robot standing in its middle, up to three people, no duration. Ours:
    the office, three people and what they do. The robot ``"stands"`` or ``"drives"``; all lamps go
    out at a time (s) or never. What a sensor reports does not depend on which others take part.

    Of the room it is told whether there are table legs, wood and cork (``distractors``); of the
    people, whether one in ten wears a long ``skirt``, or nobody; with which probability somebody
    who stops ``faces`` the robot, and the next goal is the way out (``leaves``); and by which
    factor they walk slower or faster (``pace``).
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


FULL = tuple(Config(seed) for seed in TEST)  # the sessions that are scored
QUICK = FULL[:8]
"""Rooms differ more than minutes do: many short sessions, and in the quick size fewer of them."""


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """What the detectors reported in a session of n readings and p people, and the truth.

    Of each reading there are its time (s), its sensor in the order of ``SENSORS``, the robot's pose
    and where its wheels say it was (m and rad), and how many of the d detections are its: their
    means and covariances are of distance and direction (m and rad), reading after reading.

    The truth is known at the j readings ``judged``: where people were from the robot (m and rad),
    who was on the floor and whose head nothing hid that stands, how many beams of the laser and
    sonars met their legs, the sine by which the body is turned off the robot, the cosine by which
    the face is, and how far the legs swing (m). Who wears a long skirt does so all the time.
    """

    times: Float[np.ndarray, "n"]
    sensors: Int[np.ndarray, "n"]
    poses: Float[np.ndarray, "n 3"]
    reckoned: Float[np.ndarray, "n 3"]
    counts: Int[np.ndarray, "n"]
    means: Float[np.ndarray, "d 2"]
    covs: Float[np.ndarray, "d 2 2"]
    judged: Int[np.ndarray, "j"]
    polar: Float[np.ndarray, "j p 2"]
    present: Bool[np.ndarray, "j p"]
    clear: Bool[np.ndarray, "j p"]
    beams: Int[np.ndarray, "j p"]
    cones: Int[np.ndarray, "j p"]
    side: Float[np.ndarray, "j p"]
    gaze: Float[np.ndarray, "j p"]
    swing: Float[np.ndarray, "j p"]
    skirt: Bool[np.ndarray, "p"]

    @property
    def places(self) -> Float[np.ndarray, "j p 2"]:
        """Where the people were in the frame of the robot: ahead and to the left, m."""
        return points(self.polar)

    @property
    def judged_at(self) -> Float[np.ndarray, "j"]:
        """When the truth is known, s."""
        return self.times[self.judged]

    def found(self, reading: int) -> Detections:
        """Return what one reading detected."""
        return _detections(self)[reading]


def rig(sensors: tuple[str, ...], ring: SonarRing = RIG.ring) -> Rig:
    """Return the robot's sensors; those left out are silent for a minute, which spares images."""
    silent, (never, rarely) = [name not in sensors for name in SENSORS], _NEVER
    delays, rates = np.where(silent, never, RIG.delays), np.where(silent, rarely, RIG.rates)
    return replace(RIG, ring=ring, delays=tuple(delays), rates=tuple(rates))


def points(polar: Float[np.ndarray, "... 2"]) -> Float[np.ndarray, "... 2"]:
    """Return places of distances and directions (m, rad), ahead and to the left, m."""
    r, phi = np.moveaxis(polar, -1, 0)
    return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1)


def own(apart: Float[np.ndarray, "n m"], reach: float) -> tuple[Int[np.ndarray, " k"], ...]:
    """Return rows and columns of pairs within reach, as many as can be, each at most once."""
    pairs = linear_sum_assignment(np.where(apart <= reach, apart, FAR))
    return tuple(np.array(pairs)[:, apart[pairs] <= reach])


@cache
def _detections(recording: Recording) -> tuple[Detections, ...]:
    """Return all readings of a recording as the aggregation takes them."""
    ends = np.concatenate([[0], recording.counts.cumsum()])
    rows = zip(recording.times, recording.sensors, itertools.pairwise(ends), strict=True)
    return tuple(
        Detections(
            float(time), SENSORS[sensor], Gaussian(recording.means[a:b], recording.covs[a:b])
        )
        for time, sensor, (a, b) in rows
    )


@recorded("people-skin")
def skin_model() -> SkinModel:
    """Return the colours of skin as learnt in other offices, on other people.

    They are the colours of faces against all else; hair is among all else.
    """
    pixels = [_pixels(seed, 60.0) for seed in LEARN]
    skin, other = (np.concatenate(column) for column in zip(*pixels, strict=True))
    return SkinModel.fit(skin, other)


class Senses:
    """The three detectors at work, with the ring of sonars that there is; ``rng`` of the particles.

    What the map knows can be told of to `detect`: which of the points that the sonars hear, ahead
    and to the left of the robot (m), are walls.
    """

    def __init__(self, rng: np.random.Generator, ring: SonarRing = RIG.ring) -> None:
        self.rng, self.ring = rng, ring
        self.state, self.last = SkinState(), (0.0, 0.0)

    def detect(
        self,
        reading: LaserScan | SonarScan | FisheyeImage,
        heading: float,
        walls: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> Detections:
        """Return where people seem to be, by one reading and the heading that the wheels report."""
        if isinstance(reading, LaserScan):
            return Detections(reading.time, "laser", legs.detect(reading.ranges, LASER_ANGLES))
        if isinstance(reading, SonarScan):
            ring = self.ring
            found = sonar.detect(reading.ranges, ring.angles, ring.radius, occupied=walls)
            return Detections(reading.time, "sonar", found)
        before, old = self.last
        self.state, _ = _tracker().step(
            self.state,
            reading.image,
            rng=self.rng,
            elapsed=reading.time - before,
            turned=float(wrap_angle(heading - old)),
        )
        self.last = reading.time, heading
        return Detections(reading.time, "camera", _tracker().detect(self.state))


@cache
def _tracker() -> SkinTracker:
    camera = RIG.camera
    return SkinTracker(camera.centre_px, camera.focal_px, (camera.size,) * 2, skin_model())


@kept
def record(config: Config) -> Recording:
    """Render a session, run the detectors on it, and return what they report."""
    session, rng = staged(config)
    senses, wheels = Senses(np.random.default_rng([config.seed, 1])), _reckoned(session)
    found, reckoned, judged = [], [], []
    seen = [0] * len(SENSORS)
    every = readings(session, rig(config.sensors), rng=rng)
    for k, reading in enumerate(progress(every, "detections", _count(config))):
        reckoned.append([np.interp(reading.time, session.times, column) for column in wheels.T])
        found.append(senses.detect(reading, reckoned[-1][2]))
        sensor = SENSORS.index(found[-1].sensor)
        if seen[sensor] % JUDGED[sensor] == 0:
            judged.append(k)
        seen[sensor] += 1
    positions = [one.positions for one in found]
    return Recording(
        times=np.array([one.time for one in found]),
        sensors=np.array([SENSORS.index(one.sensor) for one in found]),
        poses=np.array([session.at(one.time).robot for one in found]),
        reckoned=np.array(reckoned),
        counts=np.array([len(one) for one in found]),
        means=np.concatenate([one.mean for one in positions]),
        covs=np.concatenate([one.cov for one in positions]),
        judged=np.array(judged),
        **_truths(session, [session.at(found[k].time) for k in judged]),
        skirt=np.array([person.skirt for person in session.people], dtype=bool),
    )


def _count(config: Config) -> int:
    """Return how many readings there are in a session."""
    used = rig(config.sensors)
    times = [config.duration - delay for delay in used.delays]
    return sum(
        int(time * rate) + 1 for time, rate in zip(times, used.rates, strict=True) if time > 0
    )


def staged(config: Config) -> tuple[Session, np.random.Generator]:
    """Return a session, and the source of the noise of its readings."""
    rng = np.random.default_rng(config.seed)
    office = make_people_office(rng=rng, distractors=config.distractors)
    skirt = None if config.skirts else False
    people = [make_person(rng=rng, skirt=skirt) for _ in range(PEOPLE)]
    people = [replace(person, pace=config.pace * person.pace) for person in people]
    how = {name: getattr(config, name) for name in ("duration", "robot", "lights_out")}
    act = Wander(leaves=config.leaves, faces=config.faces)
    return make_session(office, rng=rng, people=people, act=act, **how), rng


def _reckoned(session: Session) -> Float[np.ndarray, "t 3"]:
    """Return the path by the wheels alone, with a heading that never jumps."""
    reckoned = np.array(
        list(
            itertools.accumulate(session.odometry.increments, se2.compose, initial=session.robot[0])
        )
    )
    reckoned[:, 2] = np.unwrap(reckoned[:, 2])
    return reckoned


def _truths(session: Session, moments: Sequence[Moment]) -> dict[str, np.ndarray]:
    """Return what is known of people at some moments, as in `Recording`."""

    def columns(rows: Sequence[object], *names: str) -> dict[str, np.ndarray]:
        return {name: np.array([getattr(row, name) for row in rows]) for name in names}

    truths = [truth(session.office, session.people, moment, TRUTH) for moment in moments]
    seen = columns(moments, "positions", "robot", "headings", "gazes", "swings")
    to_robot = seen["robot"][:, None, :2] - seen["positions"]
    to_robot = np.arctan2(to_robot[..., 1], to_robot[..., 0])
    return columns(truths, "polar", "present", "clear", "beams", "cones") | {
        "side": np.abs(np.sin(seen["headings"] - to_robot)),
        "gaze": np.cos(seen["gazes"] - to_robot),
        "swing": seen["swings"],
    }


# Colours of skin ---------------------------------------------------------------------------------

_BAND = np.deg2rad([2.0, 50.0])  # of heights above the horizon, rad
_NEAR = 3.5  # faces further away are too few pixels to learn from, m
_SAMPLES = 3000  # pixels of an image that show nobody


def _pixels(seed: int, duration: float) -> tuple[UInt8[np.ndarray, "n 3"], ...]:
    """Return pixels of faces, and of walls, furniture and the backs of heads."""
    rng = np.random.default_rng(seed)
    rig = Rig(rates=(0.001, 0.001, 1.0), delays=(60.0, 60.0, 0.5))
    session = make_session(make_people_office(rng=rng), rng=rng, duration=duration, people=4)
    rows, columns = np.mgrid[: RIG.camera.size, : RIG.camera.size]
    grid = np.stack([columns, rows], axis=-1).reshape(-1, 2).astype(float)
    phi, up = RIG.camera.bearing(grid), RIG.camera.elevation(grid)
    skin, other = [], []
    for reading in readings(session, rig, rng=rng):
        if not isinstance(reading, FisheyeImage):
            continue
        colours, nobody = reading.image.reshape(-1, 3), (up > _BAND[0]) & (up < _BAND[1])
        for inside, beside, gaze, away in _heads(session, session.at(reading.time), phi, up):
            nobody &= ~beside
            if away < _NEAR and abs(gaze) > TURNED:
                (skin if gaze > 0 else other).append(colours[inside])
        some = np.flatnonzero(nobody)
        other.append(colours[rng.choice(some, min(_SAMPLES, len(some)), replace=False)])
    return np.concatenate(skin), np.concatenate(other)


def _heads(
    session: Session, moment: Moment, phi: np.ndarray, up: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, float, float]]:
    """Yield of each person the pixels of the head, those of the figure, gaze and distance."""
    for k in np.flatnonzero(moment.present):
        gap = moment.positions[k] - moment.robot[:2]
        away, to = float(np.hypot(*gap)), float(np.arctan2(gap[1], gap[0]))
        across = wrap_angle(phi - wrap_angle(to - moment.robot[2]))
        above = up - np.arctan2(session.people[k].head - RIG.camera.height, away) + 0.02 / away
        inside = np.hypot(across * np.cos(up) * away / 0.05, above * away / 0.07)
        gaze = float(np.cos(moment.gazes[k] - to - np.pi))
        yield inside < 1, np.abs(across) < 0.45 / away, gaze, away
