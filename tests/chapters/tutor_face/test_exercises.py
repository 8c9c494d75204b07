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


def test_a_limit_is_that_of_strangers_and_its_price_the_tutors():
    def right(later, strangers):
        limit = np.sort(strangers)[round(0.05 * len(strangers)) - 1]
        return limit, np.mean(later > limit)

    def of_the_tutors(later, strangers):
        limit = np.quantile(later, 0.95)
        return limit, np.mean(later > limit)

    def what_passes(later, strangers):
        limit = np.quantile(strangers, 0.05)
        return limit, np.mean(later <= limit)

    sheet = EXERCISES["tutor-limit"]
    assert sheet.judge(right)[0] == "right"
    for wrong in (of_the_tutors, what_passes):
        assert sheet.judge(wrong)[0] == "wrong"


def test_whoever_is_near_to_one_person_alone_is_known():
    def decide(d):
        nearest, second = np.sort(d.mean(axis=0))[:2]
        return nearest <= 1 and nearest <= 0.75 * second

    sheet = EXERCISES["tutor-decide"]
    assert sheet.judge(decide)[0] == "right"
    assert "one look" in sheet.judge(lambda d: d[0].min() <= 1)[1]
    for wrong in (lambda d: False, lambda d: d.max(axis=0).min() <= 1):
        assert "refuses" in sheet.judge(wrong)[1]
