"""The session of the page by the committee: the states of its explorers."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from jaxtyping import Bool

from robot_perception.chapters.people_fusion import committee, rates
from robot_perception.chapters.people_fusion.committee import System, Tracked
from robot_perception.chapters.people_sensors.scene import CONFIG, MOMENTS, recording, row
from robot_perception.chapters.people_sensors.sessions import SENSORS, own
from robot_perception.evaluation.sweep import sweep
from robot_perception.people.aggregation import AggregationRules, Hypotheses
from robot_perception.people.scores import score
from robot_perception.teaching.recorded import recorded


def history(
    rules: AggregationRules = committee.RULES, sensors: tuple[str, ...] = SENSORS
) -> Tracked:
    """Return what the aggregation of some sensors makes of the session of the page."""
    return committee.tracked(CONFIG, System(rules, sensors))


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
            f"The room from above after {self.at:.0f} s, {who}: {count - missed} of {count} "
            f"people have a person's ellipse, and for {self.known} the distance is known; "
            f"{nobody} such ellipses are false, {len(self.persons) - self.persons.sum()} more "
            "are too light to count."
        )


@recorded("people-watched", product(WHO, MOMENTS))
def watched(who: str, at: float) -> State:
    """Return what some sensors together make of a moment."""
    hypotheses = history(sensors=WHO[who]).at(at)
    persons = hypotheses.weight > committee.RULES.person
    polar, sigma = recording().polar[row(at)], np.sqrt(hypotheses.cov[:, 0, 0])
    apart = committee.ALL.apart(polar, hypotheses.mean[persons], sigma[persons]).T
    theirs, whose = own(apart, committee.ALL.reach)
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
            f"people are tracked and {self.false:.0%} of the hypotheses are false, in one "
            f"session of {CONFIG.duration:.0f} s; the paper has {tracked:.0%} and about "
            f"{false:.0%}."
        )


def chosen(theta: float, alpha: float) -> Choice:
    """Return what a choice of the rules makes of the session."""
    return all_chosen()[theta, alpha]


@recorded("people-rules")
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
