"""The exercises judge right and wrong answers, and their answers are what happens."""

import numpy as np
import pytest

from robot_perception.chapters.tutor_following.exercises import EXERCISES
from robot_perception.companion.hands.features import integral
from tests.chapters.exercises import ExerciseTests


class TestSheet(ExerciseTests):
    stem = "tutor_following"
    sheet = EXERCISES


def test_four_numbers_of_an_integral_image_are_the_sum_of_a_rectangle():
    image = np.random.default_rng(0).integers(0, 9, (6, 7), dtype=np.uint8)
    total, _ = integral(image)
    found = total[5, 6] - total[5, 2] - total[1, 6] + total[1, 2]
    assert found == image[1:5, 2:6].sum()
    assert EXERCISES["following-integral"].answer == 40 - 12 - 10 + 3


def test_a_model_forgets_as_the_exercise_says():
    model = np.array([1.0, 0.0])
    for _ in range(25):
        model = 0.95 * model + 0.05 * np.array([0.0, 1.0])
    assert EXERCISES["following-drift"].answer == pytest.approx(model[1])
