"""A short session for the pages: what the sensors reported."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8

from data_synth.people import readings
from robot_perception.chapters.people_sensors import sessions
from robot_perception.chapters.people_sensors.sessions import RIG, SENSORS, Config, Recording
from robot_perception.evaluation.progress import progress
from robot_perception.geometry import se2
from robot_perception.people.detections import Detections
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.results import kept

CONFIG = Config(43, duration=30.0)
"""The session of the pages; none of those that are learnt on, chosen on, or scored."""
MOMENTS = tuple(np.arange(2.46, 30.0, 2.4).round(2).tolist())
"""Of the timeline, s: all sensors have just reported, and the truth is known."""


@dataclass(frozen=True, eq=False, slots=True)
class Signals:
    """What the sensors reported last at k moments, and the room, all from where the robot stands.

    Laser and sonars give distances (m), 0 where nothing came back; pictures are blue, green and
    red; of each moment it is told which readings these were. There are the directions of the
    people's bodies (rad) and the heights of their heads (m); walls and furniture at the heights of
    the laser and of tables, and round things with their radius, ahead and to the left (m).
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
    """Return the signals of the session of the pages: the same noise, the same readings."""
    session, rng = sessions.staged(CONFIG)
    known = recording()
    last = [[(known.times <= at) & (known.sensors == kind) for kind in range(3)] for at in MOMENTS]
    numbers = np.array(last).shape[-1] - 1 - np.array(last)[..., ::-1].argmax(axis=-1)
    every = progress(readings(session, RIG, rng=rng), "signals", len(known.times))
    taken = {k: one for k, one in enumerate(every) if k in numbers}
    scans, echoes = (np.array([taken[k].ranges for k in numbers[:, kind]]) for kind in (0, 1))
    room = se2.inverse(session.robot[0])
    faces, posts = session.office.section(RIG.scan_height)
    tops, _ = session.office.section(0.73)
    headings = np.array([session.at(moment).headings for moment in MOMENTS])
    return Signals(
        *(np.where(np.isfinite(ranges), ranges, 0.0) for ranges in (scans, echoes)),
        np.array([taken[k].image for k in numbers[:, 2]]),
        readings=numbers,
        headings=headings - session.robot[0, 2],
        heads=np.array([person.head for person in session.people]),
        faces=se2.act(room, faces.reshape(-1, 2)).reshape(-1, 2, 2),
        tops=se2.act(room, tops.reshape(-1, 2)).reshape(-1, 2, 2),
        posts=np.column_stack([se2.act(room, posts[:, :2]), posts[:, 2]]),
    )


@recorded("people-session")
def recording() -> Recording:
    """Return what the detectors reported in the session of the pages, with the truth."""
    return sessions.record(CONFIG)


def found(at: float, sensor: str) -> Detections:
    """Return what a sensor detected last before a moment."""
    row = signals().readings[MOMENTS.index(at)]
    return recording().found(int(row[SENSORS.index(sensor)]))


def people(at: float) -> Float[np.ndarray, "p 2"]:
    """Return where the people were at a moment, ahead and to the left of the robot, m."""
    return recording().places[row(at)]


def row(at: float) -> int:
    """Return the last judged reading before a moment."""
    return int(np.searchsorted(recording().judged_at, at, side="right")) - 1


def picture(at: float) -> UInt8[np.ndarray, "height width 3"]:
    """Return the picture of the camera last before a moment: red, green and blue."""
    return signals().pictures[MOMENTS.index(at)][..., ::-1]


SHOWN = 4.86  # the moment of the hero and of the drawings of single readings, s
