"""The exercises judge right and wrong answers, and their answers are what happens."""

import numpy as np
import pytest

from robot_perception.chapters.tutor_face.exercises import EXERCISES
from robot_perception.companion.faces.eigenfaces import Eigenfaces
from tests.chapters.exercises import ExerciseTests


class TestSheet(ExerciseTests):
    stem = "tutor_face"
    sheet = EXERCISES


def test_the_share_of_the_exercise_is_that_of_the_librarys_deviations():
    faces = np.array([[[1.0, 2.0]], [[3.0, 2.0]], [[1.0, 6.0]], [[3.0, 6.0]]])
    variances = Eigenfaces.learn(faces, list("abcd"), 2).deviations ** 2
    assert EXERCISES["tutor-eigen"].answer == pytest.approx(variances[0] / variances.sum())
