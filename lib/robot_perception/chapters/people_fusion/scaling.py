"""What the aggregation costs with more sensors and with more people, in pairs that are compared."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.people_fusion.committee import RULES
from robot_perception.chapters.people_fusion.members import STRANGERS
from robot_perception.chapters.people_sensors.sessions import PAPER, RIG, SENSORS
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, exponent
from robot_perception.people.aggregation import AggregationRules, Aggregator
from robot_perception.people.detections import Detections, polar
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition

SIGMAS = {"laser": (0.1, 0.05), "sonar": (0.3, 0.1), "camera": (2.0, 0.05)}
"""Standard deviations of a detection: distance and direction, m and rad."""
SEEN = 0.9  # share of its readings in which a sensor reports somebody, or a thing
SETTLED, COUNTED = 1.0, 2.0  # s, before the pairs are counted, and while they are
NEAR, FAR = 1.0, 4.0  # from the robot, m


@dataclass(frozen=True, slots=True)
class Config:
    """Worlds in which so many people stand round a robot with so many of each of its sensors.

    Paper: three sensors, up to three people, every fourth hypothesis a misdetection and most of
    these static; no number of a cost. Ours: to each three people a thing that all sensors take for
    one; every sensor with noise of its own; ``false`` detections a reading that are nowhere else.
    """

    copies: tuple[int, ...] = (1, 2, 4, 8, 16)
    people: tuple[int, ...] = (1, 2, 4, 8, 16, 32)
    worlds: int = 20
    false: float = 1.0
    rules: AggregationRules = RULES


@dataclass(frozen=True, eq=False, slots=True)
class Costs:
    """Pairs compared in a second, of w worlds: with more sensors, those clutter, and more people.

    ``sensors`` and ``cluttered`` are of three people, ``people`` of one sensor of each kind.
    """

    config: Config
    sensors: Float[np.ndarray, "w k"]
    cluttered: Float[np.ndarray, "w k"]
    people: Float[np.ndarray, "w p"]


def readings(
    copies: int, people: int, false: float, *, rng: np.random.Generator
) -> list[Detections]:
    """Return what copies of each sensor report of people and things that stand still.

    Each reads at the rate of its kind from a time of its own on.
    """
    count = people + round(people / 3)
    r, phi = rng.uniform(NEAR, FAR, count), rng.uniform(-np.pi, np.pi, count)
    found = []
    for kind, rate in zip(SENSORS, RIG.rates, strict=True):
        for copy in range(copies):
            for time in np.arange(rng.uniform(0, 1 / rate), SETTLED + COUNTED, 1 / rate):
                found.append(_detected(kind, copy, float(time), r, phi, false, rng))
    return sorted(found, key=lambda one: one.time)


def _detected(
    kind: str,
    copy: int,
    time: float,
    r: np.ndarray,
    phi: np.ndarray,
    false: float,
    rng: np.random.Generator,
) -> Detections:
    """Return a reading of a copy of a sensor."""
    along, across = SIGMAS[kind]
    seen, more = rng.random(len(r)) < SEEN, rng.poisson(false)
    away = np.r_[r[seen], rng.uniform(NEAR, FAR, more)]
    turn = np.r_[phi[seen], rng.uniform(-np.pi, np.pi, more)] + rng.normal(0, across, len(away))
    away = np.full(len(away), 2.0) if kind == "camera" else away + rng.normal(0, along, len(away))
    return Detections(time, f"{kind} {copy}", polar(np.maximum(away, 0.1), turn, along, across))


def pairs(
    copies: int, people: int, false: float, rules: AggregationRules, *, rng: np.random.Generator
) -> float:
    """Return how many pairs the aggregation compares in a second."""
    sensors = {f"{kind} {copy}": rules.sensors[kind] for kind in SENSORS for copy in range(copies)}
    aggregator = Aggregator(replace(rules, sensors=sensors))
    known, compared = aggregator.start(), 0
    for reading in readings(copies, people, false, rng=rng):
        known, info = aggregator.step(known, reading, np.zeros(3))
        compared += info.compared * (reading.time >= SETTLED)
    return compared / COUNTED


def count(config: Config, *, rng: np.random.Generator) -> Costs:
    """Return what the aggregation costs in each world."""
    sensors, cluttered, people = [], [], []
    for own in rng.spawn(config.worlds):
        sensors.append([pairs(k, 3, 0.0, config.rules, rng=own) for k in config.copies])
        cluttered.append([pairs(k, 3, config.false, config.rules, rng=own) for k in config.copies])
        people.append([pairs(1, p, 0.0, config.rules, rng=own) for p in config.people])
    return Costs(config, *(np.array(rows) for rows in (sensors, cluttered, people)))


def exponents(sizes: tuple[int, ...], costs: Float[np.ndarray, "w n"]) -> Interval:
    """Return the mean exponent of the costs over worlds."""
    numbers = np.array(sizes, dtype=float)
    return bootstrap_mean(np.array([exponent(numbers, row).estimate for row in costs]))


ALONE = "what sensors take for people are things that stand still, as most are, says the paper"
LINEAR = Accepted(
    0.0, 1.1, "in proportion, as all that looks at every reading; a tenth for chance", "our choice"
)
SCALES = Study(
    count, Config(), Config(copies=(1, 2, 4, 8), people=(1, 2, 4, 8, 16), worlds=4), seed=70
)


@SCALES.claim(
    "aggregation-scales",
    paper=PAPER,
    place="§1",
    basis="substitute",
    statement="The cost of the aggregation grows no faster than the number of sensors.",
    paper_value="“scales very well with the number of sensors and modalities”; no number",
    method="One to sixteen copies of laser, sonars and camera, each with noise of its own, three "
    "people and a thing that looks like one: pairs of distributions that the aggregation compares "
    "in a second, and the exponent of their number over that of the sensors.",
    accepted=LINEAR,
    sabotage=Change(
        "readings that are never taken for somebody who is known",
        copies=(1, 2, 4),
        people=(1, 2, 4),
        rules=STRANGERS.rules,
    ),
    value=lambda costs: exponents(costs.config.copies, costs.sensors),
)
def aggregation_scales(costs: Costs, value: Interval) -> Finding:
    """Compare the growth with sensors, without and with false detections, and with people."""
    copies, people = costs.config.copies, costs.config.people
    cluttered = exponents(copies, costs.cluttered)
    ends = {"one of each sensor": 0, f"{copies[-1]} of each": -1}
    return Finding(
        value,
        {
            "with false detections of their own": cluttered,
            "in people": exponents(people, costs.people),
        }
        | {
            f"pairs a second, {name}": bootstrap_mean(costs.sensors[:, k])
            for name, k in ends.items()
        },
        conditions=(Condition.judged(ALONE, LINEAR, inside=value, outside=cluttered),),
    )
