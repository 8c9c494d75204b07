"""The states of the explorers: a scene with sensors switched off, and the rules of the weights.

All states are of the session of the page, so that they compare.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool
from scipy.optimize import linear_sum_assignment

from robot_perception.chapters.people_fusion import committee, rates, scene
from robot_perception.evaluation.sweep import sweep
from robot_perception.people.aggregation import Hypotheses
from robot_perception.people.detections import SENSORS, Sensor
from robot_perception.people.scores import score
from robot_perception.teaching.explore import choice, slider, timeline

WHO: Mapping[str, tuple[Sensor, ...]] = MappingProxyType(
    {
        "all three": SENSORS,
        "without the laser": ("sonar", "camera"),
        "without the sonars": ("laser", "camera"),
        "without the camera": ("laser", "sonar"),
        "the laser alone": ("laser",),
        "the sonars alone": ("sonar",),
        "the camera alone": ("camera",),
    }
)
SHOWN = 4.86
"""The moment of the hero and of the drawings of single readings, s."""
SCENE_CONTROLS = {
    "who": choice("Sensors", tuple(WHO), "all three"),
    "at": timeline("Time", scene.MOMENTS, SHOWN, "s", fps=1),
}
SCENE_PRESETS = {
    "the camera alone": {"who": "the camera alone"},
    "no camera": {"who": "without the camera"},
    "no sonars": {"who": "without the sonars", "at": 21.66},
    "the worst moment": {"at": 9.66},
}

RATES_CONTROLS = {
    "theta": slider("θ", rates.THRESHOLDS, committee.RULES.threshold),
    "alpha": slider("α of all sensors", rates.FACTORS, 1.0, "× ours"),
}
RATES_PRESETS = {
    "slow to believe": {"alpha": 0.25},
    "quick to believe": {"alpha": 3.0},
    "the most people": {"theta": 0.4, "alpha": 3.0},
    "the fewest false": {"theta": 0.1, "alpha": 0.25},
}
PAPER = 0.25, 0.93
"""Share of the hypotheses that are nobody, and of the people who are tracked, in the paper."""


# One scene over time -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """The hypotheses of some sensors at a moment.

    Parameters
    ----------
    who
        The sensors, in words.
    at
        When, s.
    hypotheses
        All of them, persons or not.
    persons, nobody : (n,)
        Which of them count as persons, and which of these are nobody's.
    missed : (p,)
        Which people have none.
    """

    who: str
    at: float
    hypotheses: Hypotheses
    persons: Bool[np.ndarray, " n"]
    nobody: Bool[np.ndarray, " n"]
    missed: Bool[np.ndarray, " p"]

    @property
    def right(self) -> bool:
        """Whether everybody is found, and nobody else."""
        return not (self.missed.any() or self.nobody.any())


@cache
def shown(who: str, at: float) -> State:
    """Return a state of the explorer of the scene."""
    hypotheses, people = scene.history(sensors=WHO[who]).at(at), scene.people(at)
    persons = hypotheses.weight > committee.RULES.person
    some = np.flatnonzero(persons)
    apart = np.linalg.norm(hypotheses.points[some][:, None] - people, axis=-1)
    near = apart <= committee.REACH
    row, column = linear_sum_assignment(np.where(near, apart, 1e3))
    row, column = row[near[row, column]], column[near[row, column]]
    nobody, missed = persons.copy(), np.ones(len(people), dtype=bool)
    nobody[some[row]], missed[column] = False, False
    return State(who, at, hypotheses, persons, nobody, missed)


def describe_scene(who: str, at: float) -> str:
    """Return what a state of the explorer of the scene shows, in words."""
    state = shown(who, at)
    count, light = len(state.missed), len(state.persons) - state.persons.sum()
    return (
        f"The room from above after {at:.0f} s, with {who}: {count - state.missed.sum()} of "
        f"{count} people have a person's ellipse, {state.nobody.sum()} such ellipses are nobody's, "
        f"{light} more are too light to count."
    )


# The rules of the weights ------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Choice:
    """What a choice of the rules makes of the session.

    Parameters
    ----------
    false
        Share of the hypotheses that are nobody.
    tracked
        Share of the people who have a hypothesis.
    """

    false: float
    tracked: float


def chosen(theta: float, alpha: float) -> Choice:
    """Return a state of the explorer of the rules."""
    return all_chosen()[theta, alpha]


@cache
def all_chosen() -> dict[tuple[float, float], Choice]:
    """Return all states of the explorer of the rules."""
    states = list(product(*(control.values for control in RATES_CONTROLS.values())))
    scene.recording()  # before the work is handed out
    done = sweep(_choose, states, rng=np.random.default_rng(0), desc="rules")
    return dict(zip(states, done, strict=True))


def _choose(state: tuple[float, float], *, rng: np.random.Generator) -> Choice:
    theta, alpha = state
    rules = replace(rates.scaled(committee.RULES, alpha=alpha), threshold=theta)
    run = scene.history(rules).tracked()
    total = score(committee.frames(run), committee.ALL.gate)
    return Choice(total.false, total.tracked)


def describe_rates(theta: float, alpha: float) -> str:
    """Return what a state of the explorer of the rules shows, in words."""
    found = chosen(theta, alpha)
    return (
        f"With θ = {theta:g} and {alpha:g} times our α {found.tracked:.0%} of the people are "
        f"tracked and {found.false:.0%} of the hypotheses are nobody, in one session of "
        f"{scene.CONFIG.duration:.0f} s; the paper has {PAPER[1]:.0%} and about {PAPER[0]:.0%}."
    )
