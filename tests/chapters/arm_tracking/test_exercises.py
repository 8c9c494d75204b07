"""The exercises judge right and wrong answers, and their answers are what the library does."""

import numpy as np
import pytest

from robot_perception.arms.body_model import BodyModel
from robot_perception.chapters.arm_likelihoods.scene import CAMERA
from robot_perception.chapters.arm_tracking.exercises import EXERCISES
from tests.chapters.exercises import ExerciseTests


class TestSheet(ExerciseTests):
    stem = "arm_tracking"
    sheet = EXERCISES


def test_an_arm_out_of_the_plane_is_as_short_as_the_exercise_says():
    """Of arms far away, where a picture is a projection along its axis."""
    model = BodyModel(CAMERA, np.array([0.0, 0.0, 1000.0]))
    states = np.tile([np.pi / 2, 0, 0, 0], (2, 2))
    states[1, [1, 5]] = np.radians(EXERCISES["arms-depth"].answer)
    joints = model.pixels(model.joints(states))
    long, short = np.linalg.norm(joints[:, 0, 2] - joints[:, 0, 0], axis=-1)
    assert short / long == pytest.approx(0.9, abs=1e-3)


def test_tables_and_weights_are_what_the_exercises_say():
    assert EXERCISES["arms-grid"].answer == len(range(10)) ** 8
    assert EXERCISES["arms-weights"].answer == pytest.approx(0.2 / 0.4)
