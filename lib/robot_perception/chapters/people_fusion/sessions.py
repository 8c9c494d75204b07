"""From rendered signals to detections: what every study of the chapter starts from.

A session is rendered once, the three detectors run on its signals, and what they report is kept on
the reader's computer with the truth beside it. Seeds of sessions that the skin colours are learnt
on, that the parameters are chosen on, and that are scored never meet.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from data_synth.fisheye import Fisheye
from data_synth.people import (
    LASER_ANGLES,
    SONAR_ANGLES,
    FisheyeImage,
    LaserScan,
    Person,
    Rig,
    Session,
    SonarScan,
    Truth,
    Wander,
    make_people_office,
    make_session,
    readings,
    truth,
)
from data_synth.people.world import Moment
from robot_perception.beliefs import Gaussian
from robot_perception.geometry import se2, wrap_angle
from robot_perception.people import legs, sonar
from robot_perception.people.detections import SENSORS, Detections
from robot_perception.people.skin import SkinModel, SkinState, SkinTracker
from robot_perception.teaching.results import kept

RIG = Rig()
TRUTH = Rig(camera=Fisheye(size=8))
"""For what the sensors could know; the pixels of faces, which take long, are not asked for."""
NO_IMAGES = Rig(rates=(*RIG.rates[:2], 0.001), delays=(*RIG.delays[:2], 60.0))
LEARN = (9001, 9002, 9003)
"""Seeds of the sessions that the colours of skin are learnt on."""
CHOOSE = (8001, 8002, 8003, 8004)
"""Seeds of the sessions that the parameters are chosen on."""
TEST = tuple(range(7001, 7011))
"""Seeds of the sessions that are scored."""
JUDGED = (4, 2, 3)
"""Of so many readings of laser, sonars and camera one is compared with the truth: 2.5 a second."""
TURNED = 0.8
"""Cosine from which on a face looks at the robot, or away from it."""


@dataclass(frozen=True, slots=True)
class Config:
    """One session.

    Paper: an office room, the robot standing in its middle, up to three people, no duration.
    Ours: the office, the people and what they do.

    Parameters
    ----------
    seed
        Of office, people, and noise.
    duration
        s.
    people
        How many.
    robot
        ``"stands"`` or ``"drives"``.
    lights_out
        When all lamps go out, s.
    faces
        Probability that somebody who stops looks at the robot.
    furnished
        Whether there are chairs, baskets, wood and cork, which can be taken for people.
    images
        Whether the camera takes part; else it takes one picture, after a minute.
    """

    seed: int
    duration: float = 180.0
    people: int = 3
    robot: str = "stands"
    lights_out: float = np.inf
    faces: float = 0.5
    furnished: bool = True
    images: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """What the detectors reported in a session of n readings and p people, and the truth.

    Parameters
    ----------
    times, sensors : (n,)
        When each reading was taken, s, and by which sensor, in the order of ``SENSORS``.
    poses, reckoned : (n, 3)
        Where the robot was then, and where its wheels say it was, m and rad.
    counts : (n,)
        Detections in each reading.
    means, covs : (d, 2), (d, 2, 2)
        The detections, reading after reading: distance and direction, m and rad.
    judged : (j,)
        The readings at which the truth is known.
    polar : (j, p, 2)
        Where the people were, from the robot.
    present, clear : (j, p)
        Who was on the floor, and whose head nothing hid that stands.
    beams, cones : (j, p)
        Beams of the laser and sonars that met the legs.
    side, gaze : (j, p)
        Sine of the direction that the body is turned off the robot, and cosine of the face's.
    swing : (j, p)
        How far the legs swing, m.
    skirt : (p,)
        Who wore a long skirt.
    tone : (p,)
        Of the skin, from 0 (light) to 1 (dark).
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
    tone: Float[np.ndarray, "p"]

    @property
    def places(self) -> Float[np.ndarray, "j p 2"]:
        """Where the people were in the frame of the robot: ahead and to the left, m."""
        r, phi = np.moveaxis(self.polar, -1, 0)
        return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1)

    def found(self, reading: int) -> Detections:
        """Return what one reading detected."""
        return self._all()[reading]

    def _all(self) -> tuple[Detections, ...]:
        return _detections(self)


@cache
def _detections(recording: Recording) -> tuple[Detections, ...]:
    """Return all readings of a recording as the aggregation takes them."""
    ends = np.concatenate([[0], recording.counts.cumsum()])
    return tuple(
        Detections(
            float(recording.times[k]),
            SENSORS[recording.sensors[k]],
            Gaussian(recording.means[a:b], recording.covs[a:b]),
        )
        for k, (a, b) in enumerate(itertools.pairwise(ends))
    )


@kept
def skin_model() -> SkinModel:
    """Return the colours of skin as learnt in other offices, on other people.

    They are the colours of faces against all else; hair is among all else.
    """
    pixels = [_pixels(seed, 60.0) for seed in LEARN]
    skin, other = (np.concatenate(column) for column in zip(*pixels, strict=True))
    return SkinModel.fit(skin, other)


class Senses:
    """The three detectors at work.

    Parameters
    ----------
    rng
        Source of the particles.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        camera = RIG.camera
        self.tracker = SkinTracker(
            camera.centre_px, camera.focal_px, (camera.size, camera.size), skin_model()
        )
        self.rng, self.state, self.last = rng, SkinState(), (0.0, 0.0)

    def detect(self, reading: LaserScan | SonarScan | FisheyeImage, heading: float) -> Detections:
        """Return where people seem to be.

        Parameters
        ----------
        reading
            Of one sensor.
        heading
            Of the robot, as its wheels report it, rad.
        """
        if isinstance(reading, LaserScan):
            return Detections(reading.time, "laser", legs.detect(reading.ranges, LASER_ANGLES))
        if isinstance(reading, SonarScan):
            found = sonar.detect(reading.ranges, SONAR_ANGLES, RIG.ring.radius)
            return Detections(reading.time, "sonar", found)
        before, old = self.last
        self.state = self.tracker.step(
            self.state,
            reading.image,
            rng=self.rng,
            elapsed=reading.time - before,
            turned=float(wrap_angle(heading - old)),
        )
        self.last = reading.time, heading
        return Detections(reading.time, "camera", self.tracker.detect(self.state))


@kept
def record(config: Config) -> Recording:
    """Render a session, run the detectors on it, and return what they report."""
    session, rng = staged(config)
    rig = RIG if config.images else NO_IMAGES
    senses = Senses(np.random.default_rng([config.seed, 1]))
    wheels = _reckoned(session)
    found, poses, reckoned, judged, truths, moments = [], [], [], [], [], []
    seen = [0] * len(SENSORS)
    for k, reading in enumerate(readings(session, rig, rng=rng)):
        moment = session.at(reading.time)
        poses.append(moment.robot)
        reckoned.append(np.array([np.interp(reading.time, session.times, c) for c in wheels.T]))
        found.append(senses.detect(reading, float(reckoned[-1][2])))
        sensor = SENSORS.index(found[-1].sensor)
        if seen[sensor] % JUDGED[sensor] == 0:
            judged.append(k)
            truths.append(truth(session.office, session.people, moment, TRUTH))
            moments.append(moment)
        seen[sensor] += 1
    return _recording(session.people, found, poses, reckoned, judged, truths, moments)


def staged(config: Config) -> tuple[Session, np.random.Generator]:
    """Return a session, and the source of the noise of its readings."""
    rng = np.random.default_rng(config.seed)
    session = make_session(
        make_people_office(rng=rng, distractors=config.furnished),
        rng=rng,
        duration=config.duration,
        people=config.people,
        robot=config.robot,
        act=Wander(faces=config.faces),
        lights_out=None if config.lights_out == np.inf else config.lights_out,
    )
    return session, rng


def _reckoned(session: Session) -> Float[np.ndarray, "t 3"]:
    """Return the path by the wheels alone, with a heading that never jumps."""
    path = [session.robot[0]]
    for increment in session.odometry.increments:
        path.append(se2.compose(path[-1], increment))
    reckoned = np.array(path)
    reckoned[:, 2] = np.unwrap(reckoned[:, 2])
    return reckoned


def _recording(
    who: Sequence[Person],
    found: Sequence[Detections],
    poses: Sequence[np.ndarray],
    reckoned: Sequence[np.ndarray],
    judged: Sequence[int],
    truths: Sequence[Truth],
    moments: Sequence[Moment],
) -> Recording:
    """Return all of it as arrays."""
    away = np.array([m.positions - m.robot[:2] for m in moments])
    to_robot = np.arctan2(-away[..., 1], -away[..., 0])
    headings, gazes, swings = (
        np.array([getattr(m, name) for m in moments]) for name in ("headings", "gazes", "swings")
    )
    columns = {
        name: np.array([getattr(t, name) for t in truths])
        for name in ("polar", "present", "clear", "beams", "cones")
    }
    return Recording(
        np.array([d.time for d in found]),
        np.array([SENSORS.index(d.sensor) for d in found]),
        np.array(poses),
        np.array(reckoned),
        np.array([len(d) for d in found]),
        np.concatenate([d.positions.mean for d in found]),
        np.concatenate([d.positions.cov for d in found]),
        np.array(judged),
        **columns,
        side=np.abs(np.sin(headings - to_robot)),
        gaze=np.cos(gazes - to_robot),
        swing=swings,
        skirt=np.array([person.skirt for person in who], dtype=bool),
        tone=np.array([person.tone for person in who], dtype=float),
    )


# Colours of skin ---------------------------------------------------------------------------------

_BAND = np.deg2rad([2.0, 50.0])
_NEAR = 3.5  # faces further away are too few pixels to learn from, m
_SAMPLES = 3000  # pixels of an image that show nobody


def _pixels(seed: int, duration: float) -> tuple[UInt8[np.ndarray, "n 3"], ...]:
    """Return pixels of faces, and of walls, furniture and the backs of heads."""
    rng = np.random.default_rng(seed)
    rig = Rig(rates=(0.001, 0.001, 1.0), delays=(60.0, 60.0, 0.5))
    office = make_people_office(rng=rng)
    session = make_session(office, rng=rng, duration=duration, people=4)
    camera = rig.camera
    rows, columns = np.mgrid[: camera.size, : camera.size]
    grid = np.stack([columns, rows], axis=-1).reshape(-1, 2).astype(float)
    phi, up = camera.bearing(grid), camera.elevation(grid)
    band = (up > _BAND[0]) & (up < _BAND[1])
    skin, other = [], []
    for reading in readings(session, rig, rng=rng):
        if not isinstance(reading, FisheyeImage):
            continue
        colours, nobody = reading.image.reshape(-1, 3), band.copy()
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
        high = np.arctan2(session.people[k].head - RIG.camera.height, away)
        inside = np.hypot(
            across * np.cos(up) * away / 0.05, (up - high + 0.02 / away) * away / 0.07
        )
        gaze = float(np.cos(moment.gazes[k] - to - np.pi))
        yield inside < 1, np.abs(across) < 0.45 / away, gaze, away
