"""How the rules of the committee were chosen: on sessions of their own, in the order of section 3.

``python -m robot_perception.chapters.people_fusion.choosing`` draws rules, races them and prints
the best, as `committee.RULES` has them; and of those of microphones beside these, as
`hearing.TRUSTED`.
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from robot_perception.chapters.people_fusion import committee
from robot_perception.chapters.people_fusion.committee import Rates, System
from robot_perception.chapters.people_sensors.hearing import Ears, with_microphones
from robot_perception.chapters.people_sensors.sessions import CHOOSE, Config
from robot_perception.evaluation.sweep import sweep
from robot_perception.people.aggregation import AggregationRules, SensorRules

SESSIONS = tuple(Config(seed, 30.0) for seed in CHOOSE)
DRAWS = 160
RACE = ((2, 48), (4, 16), (len(SESSIONS), 1))
"""After so many sessions so many of the rules are left."""
ALPHAS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6)
PATIENCES = (1.0, 2.0, 3.0, 5.0, 8.0)  # t_v, s
THRESHOLDS, PERSONS, WALKS = (0.1, 0.2, 0.3), (0.4, 0.5, 0.6, 0.7, 0.8, 0.9), (0.3, 0.5, 0.8)


def drawn(rng: np.random.Generator) -> AggregationRules:
    """Return rules drawn at random in which α obeys the paper.

    "The more reliable the sensor, the higher" is α, section 3.2; the laser errs least, the sonars'
    impact is "minimal", and the camera's weight is higher behind the robot, section 3.1.
    """
    sonar, camera, behind, laser = np.sort(rng.choice(ALPHAS, 4, replace=False)).tolist()
    laser_s, sonar_s, camera_s = rng.choice(PATIENCES, 3).tolist()
    return AggregationRules(
        threshold=float(rng.choice(THRESHOLDS)),
        person=float(rng.choice(PERSONS)),
        walk=float(rng.choice(WALKS)),
        sensors={
            "laser": SensorRules(laser, laser_s),
            "sonar": SensorRules(sonar, sonar_s),
            "camera": SensorRules(camera, camera_s, alpha_behind=behind),
        },
    )


def heard() -> Iterator[System]:
    """Yield the committee with microphones that are trusted more or less.

    Either their silence says nothing, and then no patience counts, or it says that somebody is
    gone.
    """
    silences = [(patience, True) for patience in PATIENCES] + [(PATIENCES[0], False)]
    for alpha, (patience, silence) in product(ALPHAS, silences):
        trusted = SensorRules(alpha, patience, silence=silence)
        yield System(with_microphones(committee.RULES, trusted), ears=Ears())


def race(
    every: Sequence[System],
    sessions: Sequence[Config],
    rounds: Sequence[tuple[int, int]],
    *,
    rng: np.random.Generator,
) -> Iterator[tuple[System, float]]:
    """Yield the systems that are left after all rounds and their scores, the best first."""
    sums, done = {system: np.zeros(5) for system in every}, 0
    for count, left in rounds:
        jobs = [(system, session) for system in sums for session in sessions[done:count]]
        found = sweep(_judged, jobs, rng=rng, desc=f"{len(sums)} systems")
        for (system, _), row in zip(jobs, found, strict=True):
            sums[system] += row
        best = sorted(sums, key=lambda system: _worth(sums[system]), reverse=True)
        sums, done = {system: sums[system] for system in best[:left]}, count
    yield from ((system, _worth(row)) for system, row in sums.items())


def _judged(job: tuple[System, Config], *, rng: np.random.Generator) -> np.ndarray:
    system, session = job
    return np.array(committee.sums(committee.tracked(session, system), committee.ALL))


def _worth(sums: np.ndarray) -> float:
    return float(Rates(*sums[:, None]).worth()[0])


if __name__ == "__main__":
    source = np.random.default_rng(0)
    some = [System(drawn(source)) for _ in range(DRAWS)]
    for systems in (some, list(heard())):
        for best, score in race(systems, SESSIONS, RACE, rng=source):
            print(f"F₂ = {score:.4f}: {best.rules}")
