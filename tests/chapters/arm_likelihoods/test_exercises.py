"""The exercises judge right and wrong answers, and their answers are what the library does."""

import numpy as np
import pytest

from robot_perception.arms.likelihoods import square_of_sum
from robot_perception.chapters.arm_likelihoods.exercises import EXERCISES
from robot_perception.companion.cues import bhattacharyya
from tests.chapters.exercises import ExerciseTests


class TestSheet(ExerciseTests):
    stem = "arm_likelihoods"
    sheet = EXERCISES


def test_twice_the_points_cost_what_the_exercise_says():
    wider = EXERCISES["likelihoods-sums"].answer
    one, two = (
        square_of_sum(np.full((1, n), 3.0), np.ones((1, n), bool), sigma)[0]
        for n, sigma in ((10, 1.0), (20, wider))
    )
    assert two == pytest.approx(one)


def test_one_bin_and_all_bins_are_as_far_as_the_exercise_says():
    one, even = np.eye(8)[3], np.full(8, 1 / 8)
    answer = EXERCISES["likelihoods-coefficient"].answer
    assert answer == pytest.approx(bhattacharyya(one, even) ** 2)
    assert EXERCISES["likelihoods-gain"].answer == min(4.0, 0.5 * 4.0)
