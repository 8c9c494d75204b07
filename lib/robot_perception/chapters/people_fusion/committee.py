"""The whole system over a session, and how right it is: everywhere, ahead and behind."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.chapters.people_fusion import sessions
from robot_perception.chapters.people_fusion.sessions import Config, Recording
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import se2
from robot_perception.people.aggregation import (
    AggregationRules,
    Hypotheses,
    SensorRules,
    step,
)
from robot_perception.people.detections import SENSORS, Sensor
from robot_perception.people.scores import Frame, gospa, score
from robot_perception.people.trajectories import StaticRules, Stays, watch

RULES = AggregationRules(
    threshold=0.3,
    person=0.5,
    walk=0.5,
    laser=SensorRules(alpha=0.1, patience=3.0),
    sonar=SensorRules(alpha=0.1, patience=3.0),
    camera=SensorRules(alpha=0.1, patience=5.0, alpha_behind=0.4),
)
"""The best of 130 draws of all nine numbers on parts of the sessions ``sessions.CHOOSE``, by
:math:`F_2`, in which a person missed costs four times as much as a false hypothesis: the paper
prefers too many to too few."""
STATIC = StaticRules()
FARTHEST = 5.0
"""Who is further from the robot, or hidden by furniture, need not be found, m; ours."""
REACH = 0.6
"""A hypothesis is somebody's within that, m; ours."""
TURN = np.deg2rad(10.0)
"""Judged by direction alone, within that, rad; ours."""
CUTOFF = 1.0
"""Of the metric GOSPA, m; ours."""

DARK_AT = 1.0
"""When the lamps go out, if they do: from then on there is only daylight, s."""

Where = Literal["everywhere", "ahead", "behind"]
By = Literal["place", "direction"]


@dataclass(frozen=True, slots=True)
class System:
    """The whole system, as chosen or with something changed.

    Parameters
    ----------
    rules
        Of the aggregation.
    sensors
        Who takes part.
    dark
        Whether the lamps are out.
    """

    rules: AggregationRules = RULES
    sensors: tuple[Sensor, ...] = SENSORS
    dark: bool = False


@dataclass(frozen=True, slots=True)
class View:
    """What of a session is judged, and how.

    Parameters
    ----------
    where
        Which people count, and which hypotheses that are nobody.
    by
        Whether places are compared, or directions alone, as points of the unit circle.
    discard
        Whether static hypotheses are left out.
    farthest
        Who is further from the robot need not be found, m.
    reach
        A hypothesis is somebody's within that, m.
    after
        From when on it is judged, s.
    """

    where: Where = "everywhere"
    by: By = "place"
    discard: bool = False
    farthest: float = FARTHEST
    reach: float = REACH
    after: float = 0.0

    @property
    def gate(self) -> float:
        """How far a hypothesis may be from its person: m, or as a chord of the unit circle."""
        return self.reach if self.by == "place" else float(2 * np.sin(TURN / 2))

    @property
    def cutoff(self) -> float:
        """Of the metric GOSPA, in the same unit."""
        return CUTOFF if self.by == "place" else 2 * self.gate


ALL = View()


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """The persons of a session at the judged readings of its sensors.

    Parameters
    ----------
    recording
        The session.
    rows : (k,)
        Which of the judged readings: those of the sensors that take part.
    persons
        The hypotheses that count as persons after each.
    static
        Which of them have stayed in one place for too long.
    """

    recording: Recording
    rows: np.ndarray
    persons: tuple[Hypotheses, ...]
    static: tuple[Bool[np.ndarray, " _"], ...]


@cache
def tracked(config: Config, system: System = System()) -> Tracked:
    """Return the persons that a system finds in a session."""
    rules, sensors = system.rules, system.sensors
    if system.dark:
        config = replace(config, lights_out=DARK_AT)
    recording = sessions.record(config)
    row_of = {int(k): row for row, k in enumerate(recording.judged)}
    taken = [SENSORS.index(sensor) for sensor in sensors]
    hypotheses, stays, last = Hypotheses.none(), Stays.none(), recording.reckoned[0]
    rows, persons, static = [], [], []
    for k in np.flatnonzero(np.isin(recording.sensors, taken)).tolist():
        pose = recording.reckoned[k]
        hypotheses, _ = step(hypotheses, recording.found(k), se2.between(last, pose), rules)
        stays, still = watch(stays, hypotheses, pose, STATIC)
        last = pose
        if k in row_of:
            chosen = hypotheses.weight > rules.person
            rows.append(row_of[k])
            persons.append(hypotheses.select(chosen))
            static.append(still[chosen])
    return Tracked(recording, np.array(rows), tuple(persons), tuple(static))


def frames(run: Tracked, view: View = ALL) -> Iterator[Frame]:
    """Yield people and hypotheses at each judged reading.

    People who are hidden by furniture or far away need not be found, and who finds them all the
    same is not wrong: such hypotheses are left out.
    """
    for row, persons, static in zip(run.rows, run.persons, run.static, strict=True):
        if run.recording.times[run.recording.judged[row]] < view.after:
            continue
        some = persons.select(~static) if view.discard else persons
        yield _frame(run.recording, int(row), some.mean, some.identity, view)


def alone(recording: Recording, sensor: Sensor, view: View = ALL) -> Iterator[Frame]:
    """Yield people and what one reading of one sensor makes of them, without any memory."""
    for row, k in enumerate(recording.judged):
        if SENSORS[recording.sensors[k]] == sensor:
            mean = recording.found(int(k)).positions.mean
            yield _frame(recording, row, mean, np.arange(len(mean)), view)


def _frame(
    recording: Recording, row: int, found: np.ndarray, identities: np.ndarray, view: View
) -> Frame:
    """Return people who count, and the hypotheses that may be theirs or nobody's."""
    polar, present = recording.polar[row], recording.present[row]
    counts = (
        present & recording.clear[row] & (polar[:, 0] < view.farthest) & _side(polar, view.where)
    )
    people, points = _points(polar, view.by), _points(found, view.by)
    near = np.linalg.norm(points[:, None] - people, axis=-1) <= view.gate
    theirs, others = near[:, counts].any(axis=1), near[:, present & ~counts].any(axis=1)
    kept = theirs | (_side(found, view.where) & ~others)
    return Frame(people[counts], np.flatnonzero(counts), points[kept], identities[kept])


def _side(polar: np.ndarray, where: Where) -> np.ndarray:
    ahead = np.abs(polar[:, 1]) <= np.pi / 2
    return {"everywhere": np.ones_like(ahead), "ahead": ahead, "behind": ~ahead}[where]


def _points(polar: np.ndarray, by: By) -> Float[np.ndarray, "n 2"]:
    r, phi = polar.T
    circle = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    return circle if by == "direction" else r[:, None] * circle


@dataclass(frozen=True, eq=False, slots=True)
class Rates:
    """Sums of each session: how often people were there, hypotheses were, and both were one.

    Parameters
    ----------
    people, hypotheses, matched, switches, gospa : (sessions,)
        The last is the mean of the metric over a session, m.
    """

    people: Float[np.ndarray, " sessions"]
    hypotheses: Float[np.ndarray, " sessions"]
    matched: Float[np.ndarray, " sessions"]
    switches: Float[np.ndarray, " sessions"]
    gospa: Float[np.ndarray, " sessions"]

    @property
    def tracked(self) -> Interval:
        """Share of the people who have a hypothesis, as the paper's accuracy."""
        return bootstrap_ratio(self.matched, self.people, "of the people, by session")

    @property
    def false(self) -> Interval:
        """Share of the hypotheses that are nobody."""
        nobody = self.hypotheses - self.matched
        return bootstrap_ratio(nobody, self.hypotheses, "of the hypotheses, by session")

    @property
    def right(self) -> Float[np.ndarray, " sessions"]:
        """Both in one: 2 · matched / (people + hypotheses) of each session."""
        return 2 * self.matched / np.maximum(self.people + self.hypotheses, 1)

    @property
    def mota(self) -> Interval:
        """Accuracy of the field: 1 − (misses + false + switches) / people."""
        errors = self.people + self.hypotheses - 2 * self.matched + self.switches
        return bootstrap_ratio(self.people - errors, self.people, "by session")

    def cells(self) -> tuple[Interval, ...]:
        """Return the cells of :data:`COLUMNS`."""
        return self.tracked, self.false, self.mota, bootstrap_mean(self.gospa, "m")


COLUMNS = {
    "tracked": "share of the people in view within 5 m who have a hypothesis within 0.6 m",
    "false": "share of the hypotheses that are nobody",
    "MOTA": "1 − (misses + false + switches of identity) / people",
    "GOSPA (m)": "mean distance of the two sets of points, with a cutoff of 1 m",
}


def rates(runs: Iterable[Iterable[Frame]], view: View = ALL) -> Rates:
    """Return the sums of sessions.

    Parameters
    ----------
    runs
        The frames of each.
    view
        As they were made.
    """
    return _table([sums(run, view) for run in runs])


def sums(run: Iterable[Frame], view: View) -> tuple[float, ...]:
    """Return the sums of one session, in the order of `Rates`."""
    scenes = list(run)
    total = score(scenes, view.gate)
    apart = [gospa(f.people, f.hypotheses, view.cutoff).total for f in scenes]
    counts = (total.people, total.hypotheses, total.matched, total.switches)
    return (*map(float, counts), float(np.mean(apart)))


def compare(
    systems: Mapping[str, System], chosen: Sequence[Config], views: tuple[View, ...] = (ALL,)
) -> dict[str, tuple[Rates, ...]]:
    """Return the rates of some systems over the same sessions, one for each view."""
    different = list(dict.fromkeys(systems.values()))
    jobs = [(config, system, views) for system in different for config in chosen]
    found = sweep(_judged, jobs, rng=np.random.default_rng(0), desc="sessions")
    rows = np.array(found).reshape(len(different), len(chosen), len(views), -1)
    tables = dict(zip(different, rows, strict=True))
    return {
        name: tuple(_table(tables[system][:, v]) for v in range(len(views)))
        for name, system in systems.items()
    }


def _judged(job: tuple[Config, System, tuple[View, ...]], *, rng: np.random.Generator) -> list:
    config, system, views = job
    run = tracked(config, system)
    return [sums(frames(run, view), view) for view in views]


def _table(rows: Sequence[Sequence[float]] | np.ndarray) -> Rates:
    return Rates(*np.array(rows, dtype=float).T)
