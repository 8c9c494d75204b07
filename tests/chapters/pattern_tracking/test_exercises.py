"""The exercises judge right and wrong answers, and their answers are what happens."""

import numpy as np
import pytest

from robot_perception.ceiling.patterns import Decay, deviations
from robot_perception.chapters.pattern_tracking.exercises import EXERCISES
from tests.chapters.exercises import ExerciseTests


class TestSheet(ExerciseTests):
    stem = "pattern_tracking"
    sheet = EXERCISES


def test_deviation_of_the_exercise_is_the_librarys():
    found = deviations(np.array([0.6]), Decay(np.array([0.2]), np.ones(1)))
    assert EXERCISES["pattern-deviation"].answer == pytest.approx(found[0])


def test_draws_of_the_exercise_are_those_of_a_million():
    drawn = np.random.default_rng(0).standard_normal((10_000, 200))
    beyond = (np.abs(drawn) > 3).sum(axis=1).mean()
    assert EXERCISES["pattern-draws"].answer == pytest.approx(beyond, rel=0.05)


def test_blurs_of_the_exercise_add_as_variances():
    assert np.hypot(1, EXERCISES["pattern-blur"].answer) == pytest.approx(2)
