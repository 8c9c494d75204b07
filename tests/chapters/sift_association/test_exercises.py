"""The exercises judge right and wrong answers, and their answers are what happens."""

import numpy as np
import pytest

from robot_perception.book import sift_association as law
from robot_perception.book.sift_association import EXERCISES


def test_depth_of_the_exercise_is_what_triangulation_says():
    rig = law.rig()
    measured = rig.project(np.array([[0.0, 0.0, 5.0]]))
    cov = rig.triangulate(measured, 0.5).cov
    assert EXERCISES["sift-depth"].answer == pytest.approx(np.sqrt(cov[0, 2, 2]), rel=1e-6)


def test_distance_of_a_class_to_its_own_is_the_same_for_any_numbers():
    stack = np.random.default_rng(0).exponential(size=(5, law.LENGTH))
    apart = (stack - stack.mean(axis=0)) ** 2 / stack.var(axis=0, ddof=1)
    assert EXERCISES["sift-own"].answer == pytest.approx(apart.sum(axis=1).mean())


def test_distance_of_a_stranger_is_the_law():
    assert EXERCISES["sift-law"].answer == pytest.approx(law.expected_distance(5))
