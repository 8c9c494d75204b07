"""When is somebody lost whom no sensor sees any more? Eq. (6), run until the hypothesis is gone."""

from dataclasses import dataclass

import numpy as np

from robot_perception.chapters.people_sensors.sessions import PAPER
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.people.aggregation import (
    AggregationRules,
    Aggregator,
    Hypotheses,
    SensorRules,
)
from robot_perception.people.detections import Detections, polar
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition

NOBODY = polar(np.zeros(0), np.zeros(0), 0.1, 0.1)
RATE = 20.0  # readings a second, of all sensors together
WEIGHTS = (0.35, 0.5, 0.65, 0.8, 0.95)  # of hypotheses that are not certain


@dataclass(frozen=True, slots=True)
class Config:
    """Thresholds θ and patiences t_v (s) that are tried, and the weight at the last sight.

    Paper: neither; both ours. The result does not depend on them, which is why several are tried.
    """

    thresholds: tuple[float, ...] = (0.1, 0.2, 0.3)
    patiences: tuple[float, ...] = (1.0, 3.0, 5.0)
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class Lost:
    """After how many t_v somebody is lost, for each θ and t_v; and of other weights with one pair.

    Of two sensors that speak in turn, with the first and the last t_v, it is seconds.
    """

    shares: tuple[float, ...]
    others: tuple[float, ...]
    in_turn: float


def lost_after(weight: float, threshold: float, *patiences: float) -> float:
    """Return after how long a hypothesis is deleted, s, of sensors that report nobody in turn."""
    sensors = {f"sensor {k}": SensorRules(0.1, t) for k, t in enumerate(patiences)}
    rules = AggregationRules(threshold=threshold, walk=0.0, sensors=sensors)
    one, zero = np.array([[2.0, 0.0]]), np.zeros(1)
    start = np.array([weight]), np.zeros(1, dtype=np.int64), zero, zero, zero
    found = Hypotheses(one, 0.01 * np.eye(2)[None], *start, {"sensor 0": 0.0}, 1)
    aggregator, count = Aggregator(rules), 0
    while len(found):
        count += 1
        name = f"sensor {count % len(sensors)}"
        found, _ = aggregator.step(found, Detections(count / RATE, name, NOBODY), np.zeros(3))
    return count / RATE


def forget(config: Config, *, rng: np.random.Generator) -> Lost:
    """Return when somebody is lost; nothing is drawn."""
    pairs = [(theta, t) for theta in config.thresholds for t in config.patiences]
    theta, t = pairs[-1]
    return Lost(
        tuple(lost_after(config.weight, theta, t) / t for theta, t in pairs),
        tuple(lost_after(weight, theta, t) / t for weight in WEIGHTS),
        lost_after(config.weight, theta, config.patiences[0], t),
    )


AT_TV = Accepted(1.0, 1.05, "t_v, and the reading after it, which notices", "theory")
FORGOTTEN = Study(forget, Config(), Config((0.1, 0.3), (1.0, 3.0)), 73)


@FORGOTTEN.claim(
    "lost-after-tv",
    paper=PAPER,
    place="§3.2, eq. (6)",
    basis="mathematics",
    statement="A person is lost when t_v seconds have passed without a detection.",
    paper_value="“lost if t_v seconds passed and no sensor has made a new detection”",
    method="Eq. (6) as printed, 20 silent readings a second, until the hypothesis falls below θ: "
    "the time that takes, in t_v, over all θ and t_v that were tried.",
    accepted=AT_TV,
    sabotage=Change("a hypothesis that has a weight of 0.65 when it is last seen", weight=0.65),
    value=lambda lost: _range(lost.shares),
)
def lost_after_tv(lost: Lost, value: Interval) -> Finding:
    """Compare the time with t_v, from a weight of 1 and from others."""
    certain, others = "the weight is 1 when they are last seen", _range(lost.others)
    return Finding(
        value,
        {
            f"from a weight of {weight:g}": exact(share)
            for weight, share in zip(WEIGHTS, lost.others, strict=True)
        }
        | {"two sensors in turn (s)": exact(lost.in_turn)},
        conditions=(Condition.judged(certain, AT_TV, inside=value, outside=others),),
    )


def _range(shares: tuple[float, ...]) -> Interval:
    return Interval(float(np.median(shares)), min(shares), max(shares), about="all θ and t_v")
