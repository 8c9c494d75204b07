"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.visual_slam import EXERCISES
from robot_perception.particles import effective_number

RNG = np.random.default_rng


def test_a_proposal_that_knows_wheels_and_points_makes_all_count_and_others_do_not():
    propose = EXERCISES["slam-propose"]
    assert propose.judge(lambda z, r: (z / (1 + r**2), r / np.sqrt(1 + r**2)))[0] == "right"
    for own, words in (
        (lambda z, r: (np.zeros(3), 1.0), "sharp"),
        (lambda z, r: (z, r), "dull"),
    ):
        outcome, said = propose.judge(own)
        assert outcome == "wrong"
        assert words in said


def test_number_of_the_exercise():
    weights = np.log([0.5, 0.25, 0.25])
    assert EXERCISES["slam-number"].answer == pytest.approx(effective_number(weights))


def test_one_particle_adds_an_error_of_its_own():
    wheels, particle = RNG(1).standard_normal((2, 100_000))
    assert EXERCISES["slam-one"].answer == pytest.approx(np.std(wheels + particle), rel=0.01)
