"""The exercises of the chapter."""

import numpy as np

from robot_perception.chapters.ceiling_navigation.exercises import EXERCISES, SEEN_KNOWN, SEEN_NEW
from tests.chapters.exercises import ExerciseTests


class TestExercises(ExerciseTests):
    stem = "ceiling_navigation"
    sheet = EXERCISES


def test_answers_by_hand():
    assert EXERCISES["nav-tilt"].judge(8.7)[0] == "right"
    assert EXERCISES["nav-pixels"].judge(0.0125)[0] == "right"


def test_the_new_pattern_is_where_complex_numbers_put_it():
    (x, y, a), (u, v, b) = SEEN_KNOWN, SEEN_NEW
    way = ((u - x) + 1j * (v - y)) * np.exp(-1j * a) * 0.0125
    there = 1 + 2j + way * np.exp(0.3j)
    answer = np.array([there.real, there.imag, 0.3 + b - a])
    assert EXERCISES["nav-place"].judge(answer)[0] == "right"
