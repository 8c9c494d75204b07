"""Reports of a robot's sensors on people in an office, each at its own rate."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from data_synth._checks import array, generator, instance, number
from data_synth._grid import on_grid
from data_synth.fisheye import Bodies, Fisheye, expose, view
from data_synth.laser import Scanner, Sight, measure
from data_synth.outlines import cast_outlines
from data_synth.people.bodies import Person, figures, legs
from data_synth.people.office import PeopleOffice
from data_synth.people.world import Moment, between
from data_synth.sonar import SonarRing, ping

LASER_ANGLES = np.deg2rad(np.arange(-90.0, 91.0))
"""Directions of the beams of a scan, counter-clockwise from ahead, rad: (181,)."""

SONAR_ANGLES = SonarRing().angles
"""Directions of the sonars, rad: (16,)."""

_GREY = 0.30  # mean light that the exposure aims at
_GAINS = 0.4, 2.5  # what it may do
_ADAPTS = 0.15  # share of the way from image to image
_TALL = 1.3  # what stands higher hides a face, m


@dataclass(frozen=True, slots=True)
class Rig:
    """The sensors of a robot, all on its axis.

    Parameters
    ----------
    scanner, scan_height
        The laser, and its height, m.
    ring, ring_height
        The sonars, and their height, m.
    camera
        The fisheye camera.
    rates
        Of laser, sonars and camera, Hz.
    delays
        When each of them reads first, s.
    """

    scanner: Scanner = field(
        default_factory=lambda: Scanner(beams=181, range_sigma=0.015, max_range=8.0)
    )
    scan_height: float = 0.30
    ring: SonarRing = field(default_factory=SonarRing)
    ring_height: float = 0.20
    camera: Fisheye = field(default_factory=Fisheye)
    rates: tuple[float, float, float] = (10.0, 5.0, 7.5)
    delays: tuple[float, float, float] = (0.013, 0.057, 0.031)

    def __post_init__(self) -> None:
        instance("scanner", self.scanner, Scanner)
        number("scan_height", self.scan_height, 0.0, 2.0)
        instance("ring", self.ring, SonarRing)
        number("ring_height", self.ring_height, 0.0, 2.0)
        instance("camera", self.camera, Fisheye)
        rates, delays = array("rates", self.rates, (3,)), array("delays", self.delays, (3,))
        if not ((rates > 0) & (rates <= 1000)).all():
            raise ValueError(f"rates must be above 0 and at most 1000, got {self.rates}")
        if not ((delays >= 0) & (delays <= 60)).all():
            raise ValueError(f"delays must be from 0 to 60, got {self.delays}")


@dataclass(frozen=True, eq=False, slots=True)
class LaserScan:
    """Ranges (beams,) of a scan at a time (s), m; infinite where nothing came back."""

    time: float
    ranges: np.ndarray


@dataclass(frozen=True, eq=False, slots=True)
class SonarScan:
    """Ranges (sonars,) from the ring at a time (s), m; infinite where nothing came back."""

    time: float
    ranges: np.ndarray


@dataclass(frozen=True, eq=False, slots=True)
class FisheyeImage:
    """An image (size, size, 3) at a time (s): blue, green and red of 8 bits."""

    time: float
    image: np.ndarray


@dataclass(frozen=True, eq=False, slots=True)
class Truth:
    """True places of people, and what each sensor could know of them.

    Parameters
    ----------
    time
        s.
    polar : (p, 2)
        Distance and direction from the robot, counter-clockwise from ahead, m and rad.
    present : (p,)
        Who is on the floor.
    clear : (p,)
        Whether nothing that stands hides the head from the robot.
    beams : (p,)
        Beams of the laser that end on the legs.
    cones : (p,)
        Sonars in whose cone the legs are the first thing within the cut.
    face : (p,)
        Pixels of skin of the head.
    """

    time: float
    polar: np.ndarray
    present: np.ndarray
    clear: np.ndarray
    beams: np.ndarray
    cones: np.ndarray
    face: np.ndarray


class Sensing:
    """The sensors at work; it keeps what they remember, the exposure of the camera.

    Parameters
    ----------
    office, people
        Where, and who is there.
    rig
        The sensors.
    rng
        Source of their noise.
    lights_out : (n,)
        When the lamps of each room and of the corridor go out, s; never if left out.
    """

    def __init__(
        self,
        office: PeopleOffice,
        people: Sequence[Person],
        rig: Rig,
        *,
        rng: np.random.Generator,
        lights_out: np.ndarray | None = None,
    ) -> None:
        self.office, self.people = instance("office", office, PeopleOffice), _people(people)
        self.rig = instance("rig", rig, Rig)
        self._rngs = generator(rng).spawn(3)
        office.light(0.0, lights_out)
        self.lights_out = lights_out
        self._still = [_still(office, h) for h in (rig.scan_height, rig.ring_height)]
        self._gain: float | None = None

    def due(self, before: Moment, now: Moment) -> Iterator[LaserScan | SonarScan | FisheyeImage]:
        """Return in order the readings taken after a moment and not after another.

        Parameters
        ----------
        before, now
            The moments; in between people move evenly.
        """
        for name, moment in (("before", before), ("now", now)):
            if len(instance(name, moment, Moment).present) != len(self.people):
                raise ValueError(
                    f"{name} must have {len(self.people)} people, got {len(moment.present)}"
                )
        rates, delays = np.array(self.rig.rates), np.array(self.rig.delays)
        first = np.floor((before.time - delays) * rates + 1e-9).clip(-1) + 1
        last = np.floor((now.time - delays) * rates + 1e-9)
        times = sorted(
            (float(delay + number / rate), sensor)
            for sensor, (delay, rate) in enumerate(zip(delays, rates, strict=True))
            for number in np.arange(first[sensor], last[sensor] + 1)
        )
        look = self._scan, self._ping, self._image
        return (look[sensor](between(before, now, time)) for time, sensor in times)

    def _scan(self, moment: Moment) -> LaserScan:
        scanner = self.rig.scanner
        away, met = _sweep(scanner, moment, *self._still[0], self.people)
        return LaserScan(
            moment.time, measure(Sight(away, met), scanner, rng=self._rngs[0]).ranges[0]
        )

    def _ping(self, moment: Moment) -> SonarScan:
        faces, round_ = self._still[1]
        ellipses, _ = _legs(self.people, moment)
        all_ = np.concatenate([round_, ellipses])
        soft = np.arange(len(all_)) >= len(round_)
        ranges = ping(self.rig.ring, moment.robot, faces, all_, soft, rng=self._rngs[1])
        return SonarScan(moment.time, ranges)

    def _image(self, moment: Moment) -> FisheyeImage:
        light = self.office.light(moment.time, self.lights_out)
        body = _bodies(self.office, self.people, moment)
        seen = view(self.rig.camera, self.office.stage, moment.robot, body, light)
        wanted = float(np.clip(_GREY / max(seen.light.clip(0, 1).mean(), 1e-6), *_GAINS))
        gain = wanted if self._gain is None else self._gain
        self._gain = float(on_grid(gain + _ADAPTS * (wanted - gain)))
        return FisheyeImage(
            moment.time, expose(self.rig.camera, seen.light, gain, rng=self._rngs[2])
        )


def truth(office: PeopleOffice, people: Sequence[Person], moment: Moment, rig: Rig) -> Truth:
    """Return who is where at a moment, and what each sensor could know of it, free of noise.

    Parameters
    ----------
    office, people
        Where, and who is there.
    moment
        When.
    rig
        The sensors.
    """
    instance("office", office, PeopleOffice)
    array("rooms of office", office.rooms, (None, 4))
    people = _people(people)
    instance("rig", rig, Rig)
    if len(instance("moment", moment, Moment).present) != len(people):
        raise ValueError(f"moment must have {len(people)} people, got {len(moment.present)}")
    x, y, heading = moment.robot
    gap = moment.positions - [x, y]
    away, turn = np.hypot(*gap.T), np.arctan2(gap[:, 1], gap[:, 0])
    count = len(people)
    faces, round_ = _still(office, _TALL)
    free, _, _ = cast_outlines(np.tile([x, y], (count, 1)), turn, faces, round_)
    ring = rig.ring
    still = _still(office, rig.ring_height)
    off = np.linspace(-0.5, 0.5, 31) * ring.cone
    look = heading + ring.angles
    mounts = np.array([x, y]) + ring.radius * np.stack([np.cos(look), np.sin(look)], axis=-1)
    ellipses, whose = _legs(people, moment)
    reach, met, _ = cast_outlines(
        np.repeat(mounts, len(off), axis=0),
        (look[:, None] + off).ravel(),
        still[0],
        np.concatenate([still[1], ellipses]),
    )
    reach, met = reach.reshape(-1, len(off)), met.reshape(-1, len(off))
    nearest = met[np.arange(ring.count), reach.argmin(axis=1)] - len(still[0]) - len(still[1])
    nearest = np.where(reach.min(axis=1) < ring.cut, nearest, -1)
    still = _still(office, rig.scan_height)
    _, hit = _sweep(rig.scanner, moment, *still, people)
    beams = hit[0, :, 1] - len(still[0]) - len(still[1])
    light = np.ones((len(office.level), 3))
    body = _bodies(office, people, moment)
    seen = view(rig.camera, office.stage, moment.robot, body, light).faces
    return Truth(
        moment.time,
        np.stack([away, (turn - heading + np.pi) % (2 * np.pi) - np.pi], axis=-1),
        moment.present,
        moment.present & (free > away),
        np.bincount(whose[beams[beams >= 0]], minlength=count),
        np.bincount(whose[nearest[nearest >= 0]], minlength=count),
        np.pad(seen, (0, count - len(seen))),
    )


def _people(people: Sequence[Person]) -> tuple[Person, ...]:
    if not isinstance(people, Sequence) or isinstance(people, str):
        raise TypeError(f"people must be a sequence, got {people!r:.60}")
    return tuple(instance("people", person, Person) for person in people)


def _still(office: PeopleOffice, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Faces and ellipses of what stands still at a height."""
    faces, circles = office.section(height)
    return faces, np.column_stack([circles, circles[:, 2], np.zeros(len(circles))])


def _legs(people: Sequence[Person], moment: Moment) -> tuple[np.ndarray, np.ndarray]:
    """Ellipses (n, 5) of all legs, and whose they are (n,)."""
    found = [
        legs(
            people[k],
            moment.positions[k],
            *(v[k] for v in (moment.headings, moment.phases)),
            moment.swings[k],
        )
        for k in np.flatnonzero(moment.present)
    ]
    whose = np.repeat(np.flatnonzero(moment.present), [len(pair) for pair in found])
    return np.concatenate([np.zeros((0, 5)), *found]), whose


def _sweep(scanner, moment, faces, round_, people) -> tuple[np.ndarray, np.ndarray]:
    """Hits of the rims and the middle of each beam: distances and indices (1, beams, 3)."""
    ellipses, _ = _legs(people, moment)
    x, y, heading = moment.robot
    turns = heading + scanner.angles[:, None] + scanner.spot * np.array([-1.0, 0.0, 1.0])
    origins = np.tile([x, y], (turns.size, 1))
    away, met, _ = cast_outlines(origins, turns.ravel(), faces, np.concatenate([round_, ellipses]))
    return away.reshape(1, -1, 3), met.reshape(1, -1, 3)


def _bodies(office: PeopleOffice, people: Sequence[Person], moment: Moment) -> Bodies:
    return figures(
        *(people, moment.positions, moment.headings, moment.gazes, moment.phases, moment.swings),
        *(moment.present, office.stage.light_at(moment.positions)),
    )
