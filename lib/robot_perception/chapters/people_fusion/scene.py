"""A short session for the page, and what the sensors reported at some of its moments."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float, Int, UInt8

from data_synth.people import (
    FisheyeImage,
    LaserScan,
    SonarScan,
    readings,
)
from robot_perception.chapters.people_fusion import committee, sessions
from robot_perception.chapters.people_fusion.sessions import RIG, Config, Recording
from robot_perception.geometry import se2
from robot_perception.people.aggregation import AggregationRules, Hypotheses, step
from robot_perception.people.detections import SENSORS, Detections, Sensor
from robot_perception.people.trajectories import Stays, watch
from robot_perception.teaching.results import kept

CONFIG = Config(43, duration=30.0)
"""The session of the page; none of those that are learnt on, chosen on, or scored."""
MOMENTS = tuple(np.arange(2.46, 30.0, 2.4).round(2).tolist())
"""Of the timeline, s: all sensors have just reported, and the truth is known."""
_KINDS = (LaserScan, SonarScan, FisheyeImage)


@dataclass(frozen=True, eq=False, slots=True)
class Signals:
    """What the sensors reported last at k moments, and the room, all from where the robot stands.

    Parameters
    ----------
    scans : (k, 181)
        Readings of the laser, m; 0 where nothing came back.
    echoes : (k, 16)
        Readings of the sonars, m; 0 where nothing came back.
    pictures : (k, height, width, 3)
        Blue, green and red.
    readings : (k, 3)
        Which readings of the session these are.
    headings : (k, p)
        Where the people's bodies point, rad.
    heads : (p,)
        Heights of their heads, m.
    faces : (f, 2, 2)
        Walls and furniture at the height of the laser, m ahead and to the left.
    tops : (t, 2, 2)
        The same at the height of tables.
    posts : (c, 3)
        Round things: place and radius, m.
    """

    scans: Float[np.ndarray, "k beams"]
    echoes: Float[np.ndarray, "k sonars"]
    pictures: UInt8[np.ndarray, "k height width 3"]
    readings: Int[np.ndarray, "k 3"]
    headings: Float[np.ndarray, "k p"]
    heads: Float[np.ndarray, " p"]
    faces: Float[np.ndarray, "f 2 2"]
    tops: Float[np.ndarray, "t 2 2"]
    posts: Float[np.ndarray, "c 3"]


@kept
def signals() -> Signals:
    """Return the signals of the session of the page: the same noise, the same readings."""
    session, rng = sessions.staged(CONFIG)
    pose = session.robot[0]
    last: dict[type, tuple[int, np.ndarray]] = {}
    rows, moments = [], iter(MOMENTS)
    moment = next(moments)
    for k, reading in enumerate(readings(session, RIG, rng=rng)):
        if reading.time > moment:
            rows.append(tuple(last[kind] for kind in _KINDS))
            moment = next(moments, None)
            if moment is None:
                break
        signal = reading.image if isinstance(reading, FisheyeImage) else reading.ranges
        last[type(reading)] = k, signal
    columns = [np.array([row[kind][1] for row in rows]) for kind in range(len(_KINDS))]
    faces, posts = session.office.section(RIG.scan_height)
    tops, _ = session.office.section(0.73)
    seen = [session.at(time) for time in MOMENTS]
    return Signals(
        *(np.where(np.isfinite(column), column, 0.0) for column in columns[:2]),
        columns[2],
        readings=np.array([[row[kind][0] for kind in range(len(_KINDS))] for row in rows]),
        headings=np.array([moment.headings - pose[2] for moment in seen]),
        heads=np.array([person.head for person in session.people]),
        faces=se2.act(se2.inverse(pose), faces.reshape(-1, 2)).reshape(-1, 2, 2),
        tops=se2.act(se2.inverse(pose), tops.reshape(-1, 2)).reshape(-1, 2, 2),
        posts=np.column_stack([se2.act(se2.inverse(pose), posts[:, :2]), posts[:, 2]]),
    )


def recording() -> Recording:
    """Return what the detectors reported in the session of the page, with the truth."""
    return sessions.record(CONFIG)


def found(at: float, sensor: Sensor) -> Detections:
    """Return what a sensor detected last before a moment."""
    row = signals().readings[MOMENTS.index(at)]
    return recording().found(int(row[SENSORS.index(sensor)]))


def people(at: float) -> Float[np.ndarray, "p 2"]:
    """Return where the people were at a moment, ahead and to the left of the robot, m."""
    known = recording()
    row = np.searchsorted(known.times[known.judged], at, side="right") - 1
    return known.places[row]


@dataclass(frozen=True, eq=False, slots=True)
class History:
    """All hypotheses at each of k judged readings, persons or not.

    Parameters
    ----------
    rules
        Of the aggregation.
    rows : (k,)
        Which of the judged readings.
    hypotheses
        After each.
    """

    rules: AggregationRules
    rows: Int[np.ndarray, " k"]
    hypotheses: tuple[Hypotheses, ...]

    def at(self, moment: float) -> Hypotheses:
        """Return the hypotheses after the last judged reading before a moment."""
        times = recording().times[recording().judged[self.rows]]
        return self.hypotheses[int(np.searchsorted(times, moment, side="right")) - 1]

    def tracked(self) -> committee.Tracked:
        """Return the persons alone, and which of them have stayed in one place for too long."""
        known, stays = recording(), Stays.none()
        persons, static = [], []
        for row, hypotheses in zip(self.rows, self.hypotheses, strict=True):
            pose = known.reckoned[known.judged[row]]
            stays, still = watch(stays, hypotheses, pose, committee.STATIC)
            chosen = hypotheses.weight > self.rules.person
            persons.append(hypotheses.select(chosen))
            static.append(still[chosen])
        return committee.Tracked(known, self.rows, tuple(persons), tuple(static))


@cache
def history(
    rules: AggregationRules = committee.RULES, sensors: tuple[Sensor, ...] = SENSORS
) -> History:
    """Return what the aggregation makes of the session of the page.

    Parameters
    ----------
    rules
        Of the aggregation.
    sensors
        Who takes part.
    """
    known = recording()
    row_of = {int(k): row for row, k in enumerate(known.judged)}
    taken = np.isin(known.sensors, [SENSORS.index(sensor) for sensor in sensors])
    now, last = Hypotheses.none(), known.reckoned[0]
    rows, after = [], []
    for k in np.flatnonzero(taken).tolist():
        pose = known.reckoned[k]
        now, _ = step(now, known.found(k), se2.between(last, pose), rules)
        last = pose
        if k in row_of:
            rows.append(row_of[k])
            after.append(now)
    return History(rules, np.array(rows), tuple(after))


def picture(at: float) -> UInt8[np.ndarray, "height width 3"]:
    """Return the picture of the camera last before a moment: red, green and blue."""
    return signals().pictures[MOMENTS.index(at)][..., ::-1]
