"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from data_synth.people.sound import EARS
from data_synth.sonar import SonarRing
from robot_perception.book.people_sensors import EXERCISES
from robot_perception.people import sound


def test_a_leg_is_met_twice_up_to_the_distance_of_the_exercise():
    far, gap = EXERCISES["people-beams"].answer, np.deg2rad(1.0)
    for distance, least in ((0.999 * far, 2), (1.001 * far, 1)):
        starts = np.linspace(0, gap, 101)[:-1] * distance
        beams = starts[:, None] + gap * distance * np.arange(10)
        assert ((beams > 0) & (beams < 0.12)).sum(axis=1).min() == least


def test_a_cone_is_as_wide_as_in_the_exercise():
    half = SonarRing().cone / 2
    rims = 1.5 / np.cos(half) * np.array([np.sin(half), np.sin(-half)])
    assert np.ptp(rims) == pytest.approx(EXERCISES["people-cone"].answer)


def test_a_voice_is_late_as_in_the_exercise():
    left, right = sound.arrivals(EARS.places, np.deg2rad([30.0]))[0]
    assert 1e3 * (right - left) == pytest.approx(EXERCISES["people-delay"].answer)
