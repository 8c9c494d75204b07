"""One more sensor: microphones that hear who speaks, in a rhythm of their own."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Float

from data_synth.people import sound as world
from robot_perception.chapters.people_sensors import sessions
from robot_perception.chapters.people_sensors.sessions import Config, Recording
from robot_perception.people import sound
from robot_perception.people.aggregation import AggregationRules, SensorRules
from robot_perception.people.detections import Detections

NAME = "microphones"
FOUR, PAIR = "four", "pair"
ARRAYS = {FOUR: world.MicrophoneArray(), PAIR: world.EARS}
ACOUSTICS = world.Acoustics()
QUIET = 20  # windows in which the robot listens to itself before anybody speaks
TRUSTED = SensorRules(alpha=0.4, patience=2.0)
"""The best of 48 that were tried on eight other sessions; their silence counts, too."""


@dataclass(frozen=True, slots=True)
class Ears:
    """Microphones of a robot: four round its head, or a pair, as the paper's robot has.

    With ``elsewhere`` they hear people of another session in another office.
    """

    kind: Literal["four", "pair"] = FOUR
    elsewhere: bool = False


# What it takes to join: `another` counts the lines of these three ---------------------------------


def with_microphones(rules: AggregationRules, trusted: SensorRules = TRUSTED) -> AggregationRules:
    """Return rules that know one sensor more."""
    return replace(rules, sensors={**rules.sensors, NAME: trusted})


@cache
def heard(config: Config, ears: Ears) -> tuple[Detections, ...]:
    """Return who seems to speak in a session, four times a second."""
    session, _ = sessions.staged(replace(config, seed=config.seed + 100 * ears.elsewhere))
    array, rng = ARRAYS[ears.kind], np.random.default_rng([config.seed, 4])
    talk = world.converse(session, rng=rng)
    quiet = [world.own_noise(array, ACOUSTICS, rng=rng) for _ in range(QUIET)]
    noise = sound.background(np.array(quiet))
    return tuple(
        Detections(
            window.time + ACOUSTICS.window / 2,  # when it ends
            NAME,
            sound.detect(window.signals, array.places, array.rate, noise),
        )
        for window in world.hear(session, talk, array, ACOUSTICS, rng=rng)
    )


def joined(
    recording: Recording, rows: list[int], more: tuple[Detections, ...]
) -> list[tuple[int, Detections, Float[np.ndarray, "3"]]]:
    """Return readings of a recording and of one sensor more in the order of time.

    Each has its row, -1 of those that are not the recording's, and the pose at the time.
    """
    own = [(k, recording.found(k), recording.reckoned[k]) for k in rows]
    last = np.searchsorted(recording.times, [one.time for one in more], side="right") - 1
    own += [(-1, one, recording.reckoned[k]) for one, k in zip(more, last, strict=True)]
    return sorted(own, key=lambda reading: reading[1].time)
