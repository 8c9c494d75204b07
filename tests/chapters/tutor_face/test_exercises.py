"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.beliefs import Gaussian
from robot_perception.book.tutor_face import EXERCISES, FOUR
from robot_perception.companion.faces.eigenfaces import Eigenfaces
from robot_perception.companion.faces.region import FaceTracker, RegionState


def test_the_share_of_the_exercise_is_that_of_the_librarys_deviations():
    variances = Eigenfaces.learn(FOUR[:, None], list("abcd"), 2).deviations ** 2
    assert EXERCISES["tutor-eigen"].answer == pytest.approx(variances[0] / variances.sum())


def test_the_window_of_the_exercise_reaches_as_far_as_that_of_the_tracker():
    mean = np.array([160.0, 120.0, 50.0, 0.0, 0.0, 0.0])
    cov = np.diag([16.0 - 1.0, 16.0 - 1.0, 4.0, 1.0, 1.0, 1.0])  # 4 px of middle and half a side
    wide, high = FaceTracker().window(RegionState(Gaussian(mean, cov)))[2:]
    assert EXERCISES["tutor-window"].answer == pytest.approx(320 * 240 / (wide * high))
