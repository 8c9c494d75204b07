"""A short session for the page: what the sensors reported, and the states of its explorers."""

from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from data_synth.people import readings
from robot_perception.chapters.people_fusion import committee, rates, sessions
from robot_perception.chapters.people_fusion.committee import System, Tracked
from robot_perception.chapters.people_fusion.sessions import RIG, SENSORS, Config, Recording
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import se2
from robot_perception.people.aggregation import AggregationRules, Hypotheses
from robot_perception.people.detections import Detections
from robot_perception.people.scores import score
from robot_perception.teaching.results import kept

CONFIG = Config(43, duration=30.0)
"""The session of the page; none of those that are learnt on, chosen on, or scored."""
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
    """Return the signals of the session of the page: the same noise, the same readings."""
    session, rng = sessions.staged(CONFIG)
    known = recording()
    last = [[(known.times <= at) & (known.sensors == kind) for kind in range(3)] for at in MOMENTS]
    numbers = np.array(last).shape[-1] - 1 - np.array(last)[..., ::-1].argmax(axis=-1)
    taken = {k: one for k, one in enumerate(readings(session, RIG, rng=rng)) if k in numbers}
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


def recording() -> Recording:
    """Return what the detectors reported in the session of the page, with the truth."""
    return sessions.record(CONFIG)


def found(at: float, sensor: str) -> Detections:
    """Return what a sensor detected last before a moment."""
    row = signals().readings[MOMENTS.index(at)]
    return recording().found(int(row[SENSORS.index(sensor)]))


def people(at: float) -> Float[np.ndarray, "p 2"]:
    """Return where the people were at a moment, ahead and to the left of the robot, m."""
    return recording().places[_row(at)]


def _row(at: float) -> int:
    """Return the last judged reading before a moment."""
    return int(np.searchsorted(recording().judged_at, at, side="right")) - 1


def history(
    rules: AggregationRules = committee.RULES, sensors: tuple[str, ...] = SENSORS
) -> Tracked:
    """Return what the aggregation of some sensors makes of the session of the page."""
    return committee.tracked(CONFIG, System(rules, sensors))


def picture(at: float) -> UInt8[np.ndarray, "height width 3"]:
    """Return the picture of the camera last before a moment: red, green and blue."""
    return signals().pictures[MOMENTS.index(at)][..., ::-1]


# The states of the explorers ---------------------------------------------------------------------

SHOWN = 4.86  # the moment of the hero and of the drawings of single readings, s
WHO: dict[str, tuple[str, ...]] = {
    "all three": SENSORS,
    "without the laser": ("sonar", "camera"),
    "without the sonars": ("laser", "camera"),
    "without the camera": ("laser", "sonar"),
    "the laser alone": ("laser",),
    "the sonars alone": ("sonar",),
    "the camera alone": ("camera",),
}


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """The hypotheses of some sensors at a moment (s), persons or not.

    It is told which of them count as persons, which of these are nobody's, of which the distance is
    known, and which people have none.
    """

    who: str
    at: float
    hypotheses: Hypotheses
    persons: Bool[np.ndarray, " n"]
    nobody: Bool[np.ndarray, " n"]
    placed: Bool[np.ndarray, " n"]
    missed: Bool[np.ndarray, " p"]

    @property
    def errors(self) -> tuple[int, int]:
        """How many people are missed, and how many persons are nobody."""
        return int(self.missed.sum()), int(self.nobody.sum())

    @property
    def known(self) -> int:
        """Of how many people the distance is known, too."""
        return int((self.persons & self.placed & ~self.nobody).sum())

    @property
    def words(self) -> str:
        """What the explorer shows."""
        count, (missed, nobody) = len(self.missed), self.errors
        who = self.who if self.who.startswith("without") else f"with {self.who}"
        return (
            f"The room from above after {self.at:.0f} s, {who}: {count - missed} of "
            f"{count} people have a person's ellipse, of {self.known} the distance is known; "
            f"{nobody} such ellipses are nobody's, {len(self.persons) - self.persons.sum()} more "
            "are too light to count."
        )


@cache
def watched(who: str, at: float) -> State:
    """Return what some sensors together make of a moment."""
    hypotheses = history(sensors=WHO[who]).at(at)
    persons = hypotheses.weight > committee.RULES.person
    polar, sigma = recording().polar[_row(at)], np.sqrt(hypotheses.cov[:, 0, 0])
    apart = committee.ALL.apart(polar, hypotheses.mean[persons], sigma[persons]).T
    theirs, whose = sessions.own(apart, committee.ALL.reach)
    nobody, missed = persons.copy(), np.ones(len(polar), dtype=bool)
    nobody[np.flatnonzero(persons)[theirs]], missed[whose] = False, False
    return State(who, at, hypotheses, persons, nobody, sigma <= committee.KNOWN, missed)


@dataclass(frozen=True, slots=True)
class Choice:
    """What a choice of θ and α makes of the session: shares false of the hypotheses, and tracked
    of the people.
    """

    theta: float
    alpha: float
    false: float
    tracked: float

    @property
    def words(self) -> str:
        """What the explorer shows."""
        false, tracked = rates.OF_THE_PAPER
        return (
            f"With θ = {self.theta:g} and {self.alpha:g} times our α {self.tracked:.0%} of the "
            f"people are tracked and {self.false:.0%} of the hypotheses are nobody, in one session "
            f"of {CONFIG.duration:.0f} s; the paper has {tracked:.0%} and about {false:.0%}."
        )


def chosen(theta: float, alpha: float) -> Choice:
    """Return what a choice of the rules makes of the session."""
    return all_chosen()[theta, alpha]


@cache
def all_chosen() -> dict[tuple[float, float], Choice]:
    """Return what all choices make of it."""
    choices = list(product(rates.THRESHOLDS, rates.FACTORS))
    recording()  # before the work is handed out
    done = sweep(_choose, choices, rng=np.random.default_rng(0), desc="rules")
    return dict(zip(choices, done, strict=True))


def _choose(choice: tuple[float, float], *, rng: np.random.Generator) -> Choice:
    theta, alpha = choice
    run = history(replace(rates.scaled(committee.RULES, alpha=alpha), threshold=theta))
    total = score(committee.frames(run), committee.ALL.reach)
    return Choice(theta, alpha, total.false, total.tracked)
