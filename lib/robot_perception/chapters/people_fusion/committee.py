"""The whole system over a session, and how right it is: everywhere, ahead and behind."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.chapters.people_sensors import hearing, sessions
from robot_perception.chapters.people_sensors.hearing import Ears
from robot_perception.chapters.people_sensors.sessions import SENSORS, Config, Recording, points
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import AggregationRules, Hypotheses, SensorRules
from robot_perception.people.scores import Frame, gospa, score
from robot_perception.people.tracker import PeopleTracker
from robot_perception.people.trajectories import StaticRules
from robot_perception.teaching.studies import Study
from robot_perception.teaching.tables import Table

RULES = AggregationRules(
    threshold=0.3,
    person=0.4,
    walk=0.5,
    sensors={
        "laser": SensorRules(alpha=0.2, patience=5.0),
        "sonar": SensorRules(alpha=0.02, patience=8.0),
        "camera": SensorRules(alpha=0.05, patience=1.0, alpha_behind=0.15),
    },
)
"""The best of 160 draws on eight sessions that are not scored; `choosing` draws and races them."""
STATIC = StaticRules()
FARTHEST = 5.0  # who is further from the robot, or hidden by furniture, need not be found, m; ours
REACH = 0.6  # a hypothesis is somebody's within that, m; ours
TURN = np.deg2rad(10.0)  # judged by direction alone, within that, rad; ours
KNOWN = 1.2
"""A distance is known where it has a standard deviation below this, m: the camera, which sees
directions, reports 2 m."""
CUTOFF = 1.0  # of the metric GOSPA, m; ours
BETA = 2.0
"""Of the measure F: a person missed costs four times as much as a hypothesis that is nobody.

Paper, section 4: "more important not to miss to many people than finding to many"; 2 is ours.
"""
DARK_AT = 1.0  # when the lamps go out, if they do: from then on there is only daylight, s


@dataclass(frozen=True, slots=True)
class System:
    """The whole system, as chosen or changed: the rules, who takes part, the lamps out or not.

    And the microphones that it has beside the paper's sensors, or none.
    """

    rules: AggregationRules = RULES
    sensors: tuple[str, ...] = SENSORS
    dark: bool = False
    ears: Ears | None = None


@dataclass(frozen=True, slots=True)
class View:
    """What of a session is judged, and how.

    Which people count, and which hypotheses that are false; what is compared; and whether static
    hypotheses are left out. Compared ``by="place"`` a hypothesis is somebody's within ``reach``
    (m), by ``"direction"`` within ``TURN``, and by ``"covariance"`` in the way that its own
    covariance allows: by direction if its distance is not `KNOWN`, by place if it is. Who is
    further than ``farthest`` from the robot need not be found, and nothing is judged before the
    time ``after`` (s).
    """

    where: Literal["everywhere", "ahead", "behind"] = "everywhere"
    by: Literal["covariance", "place", "direction"] = "covariance"
    discard: bool = False
    farthest: float = FARTHEST
    reach: float = REACH
    after: float = 0.0

    def apart(
        self, people: Float[np.ndarray, "p 2"], found: Float[np.ndarray, "h 2"], sigma: np.ndarray
    ) -> Float[np.ndarray, "p h"]:
        """Return how far hypotheses are from people, so that ``reach`` is the limit of each.

        Both are distances and directions about the robot; ``sigma`` are the standard deviations of
        the distances of the hypotheses, m.
        """
        place = np.linalg.norm(points(people)[:, None] - points(found), axis=-1)
        turned = np.abs(wrap_angle(people[:, None, 1] - found[:, 1])) * (self.reach / TURN)
        unknown = {"place": False, "direction": True, "covariance": sigma > KNOWN}[self.by]
        return np.where(unknown, turned, place)


ALL = View()


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """The hypotheses of a session after k judged readings: those of the sensors that take part.

    ``rows`` says which of the judged readings these are, and ``static`` which of the hypotheses
    have stayed in one place for too long. They count as persons above a weight.
    """

    recording: Recording
    rows: Int[np.ndarray, " k"]
    hypotheses: tuple[Hypotheses, ...]
    static: tuple[Bool[np.ndarray, " _"], ...]
    person: float = RULES.person

    @property
    def persons(self) -> Iterator[tuple[int, Hypotheses, Bool[np.ndarray, " _"]]]:
        """Yield the row, the hypotheses that count as persons, and which of these are static."""
        for row, found, static in zip(self.rows, self.hypotheses, self.static, strict=True):
            counts = found.weight > self.person
            yield int(row), found.select(counts), static[counts]

    def at(self, moment: float) -> Hypotheses:
        """Return the hypotheses after the last judged reading before a moment."""
        times = self.recording.judged_at[self.rows]
        return self.hypotheses[int(np.searchsorted(times, moment, side="right")) - 1]


@cache
def tracked(config: Config, system: System = System()) -> Tracked:
    """Return the hypotheses of a system in a session."""
    recording = sessions.record(replace(config, lights_out=DARK_AT) if system.dark else config)
    row_of = {int(k): row for row, k in enumerate(recording.judged)}
    taken = [SENSORS.index(sensor) for sensor in system.sensors]
    own = np.flatnonzero(np.isin(recording.sensors, taken)).tolist()
    more = hearing.heard(config, system.ears) if system.ears else ()
    tracker = PeopleTracker(system.rules, STATIC)
    state = tracker.start(recording.reckoned[0])
    judged = []
    for k, found, pose in hearing.joined(recording, own, more):
        state, info = tracker.step(state, found, pose)
        if k in row_of:
            judged.append((row_of[k], state.hypotheses, info.static))
    rows, *found = zip(*judged, strict=True)
    return Tracked(recording, np.array(rows), *found, system.rules.person)


def frames(run: Tracked, view: View = ALL) -> Iterator[Frame]:
    """Yield people and hypotheses at each judged reading.

    People who are hidden by furniture or far away need not be found, and who finds them all the
    same is not wrong: such hypotheses are left out.
    """
    times = run.recording.judged_at
    for row, persons, static in run.persons:
        if times[row] >= view.after:
            some = persons.select(~static) if view.discard else persons
            yield frame(run.recording, row, some, view)


def frame(recording: Recording, row: int, found: Hypotheses, view: View) -> Frame:
    """Return people who count, and the hypotheses that may be theirs or nobody's."""
    polar, present = recording.polar[row], recording.present[row]
    counts = (
        present & recording.clear[row] & (polar[:, 0] < view.farthest) & _side(polar, view.where)
    )
    apart = view.apart(polar, found.mean, np.sqrt(found.cov[:, 0, 0]))
    near = apart <= view.reach
    theirs, others = near[counts].any(axis=0), near[present & ~counts].any(axis=0)
    kept = theirs | (_side(found.mean, view.where) & ~others)
    return Frame(
        points(polar[counts]),
        np.flatnonzero(counts),
        found.points[kept],
        found.identity[kept],
        apart[np.ix_(counts, kept)],
    )


def _side(polar: np.ndarray, where: str) -> Bool[np.ndarray, " n"]:
    ahead = np.abs(polar[:, 1]) <= np.pi / 2
    return {"everywhere": np.ones_like(ahead), "ahead": ahead, "behind": ~ahead}[where]


@dataclass(frozen=True, eq=False, slots=True)
class Rates:
    """Sums of each session: how often people were there, hypotheses were, and both were one.

    The last is the mean of the metric GOSPA over a session, m.
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
        """Share of the hypotheses that are false."""
        nobody = self.hypotheses - self.matched
        return bootstrap_ratio(nobody, self.hypotheses, "of the hypotheses, by session")

    def worth(self, beta: float = BETA) -> Float[np.ndarray, " sessions"]:
        r"""Both in one, of each session: a person missed costs as much as β² that are nobody.

        .. math:: F_\beta = \frac{(1 + \beta^2)\, matched}{\beta^2\, people + hypotheses}
        """
        square = beta**2
        return (1 + square) * self.matched / np.maximum(square * self.people + self.hypotheses, 1)

    @property
    def mota(self) -> Interval:
        """Accuracy of the field: 1 − (misses + false + switches) / people."""
        errors = self.people + self.hypotheses - 2 * self.matched + self.switches
        return bootstrap_ratio(self.people - errors, self.people, "by session")


COLUMNS = {
    "tracked": "share of the people in view within 5 m who have a hypothesis within 0.6 m",
    "false": "share of the hypotheses that are false",
    "MOTA": "1 − (misses + false + switches of identity) / people",
    "GOSPA (m)": "mean distance of the two sets of points, with a cutoff of 1 m",
}


def table(found: Mapping[str, Rates], about: str, corner: str) -> Table:
    """Return rates by name."""
    rows = {
        name: (rates.tracked, rates.false, rates.mota, bootstrap_mean(rates.gospa, "m"))
        for name, rates in found.items()
    }
    return Table(rows, COLUMNS, about, corner)


def sums(run: Tracked, view: View) -> tuple[float, ...]:
    """Return the sums of one session, in the order of `Rates`."""
    scenes = list(frames(run, view))
    total = score(scenes, view.reach)
    apart = [gospa(f.people, f.hypotheses, CUTOFF).total for f in scenes]
    return total.people, total.hypotheses, total.matched, total.switches, float(np.mean(apart))


Row = tuple[str, System, View]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Systems over the same sessions, each judged in a view and named.

    And others with names and sessions of their own.
    """

    sessions: tuple[Config, ...]
    rows: tuple[Row, ...]
    more: tuple["Comparison", ...] = ()


def compare(config: Comparison, *, rng: np.random.Generator) -> dict[str, Rates]:
    """Return the rates of each row of a comparison, and of those beside it."""
    found = _compared(config, rng)
    for beside in config.more:
        found |= compare(beside, rng=rng)
    return found


def _compared(config: Comparison, rng: np.random.Generator) -> dict[str, Rates]:
    views = {
        system: [v for _, other, v in config.rows if other == system]
        for _, system, _ in config.rows
    }
    jobs = [
        (session, system, seen) for system, seen in views.items() for session in config.sessions
    ]
    done = iter(sweep(_judged, jobs, rng=rng, desc="sessions"))
    found = {one: np.array([next(done) for _ in config.sessions], float) for one in views}
    return {
        name: Rates(*found[system][:, views[system].index(view)].T)
        for name, system, view in config.rows
    }


def _judged(job: tuple[Config, System, list[View]], *, rng: np.random.Generator) -> list:
    config, system, views = job
    run = tracked(config, system)
    return [sums(run, view) for view in views]


def study(rows: tuple[Row, ...], *more: Comparison, seed: int) -> Study:
    """Return the study of a comparison; the quick size has less time, and no others beside it."""
    full = Comparison(sessions.FULL, rows, more)
    return Study(compare, full, Comparison(sessions.QUICK, rows), seed)
