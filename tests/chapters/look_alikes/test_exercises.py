"""The answers of the exercises are what happens."""

import numpy as np
import pytest
from scipy import stats

from robot_perception.book.look_alikes import EXERCISES
from robot_perception.slam.planar import MapBelief


def test_the_gate_is_that_of_two_coordinates():
    assert EXERCISES["look-gate"].answer == pytest.approx(stats.chi2(2).ppf(0.99))


def test_a_filter_of_so_many_landmarks_holds_so_many_numbers():
    size = 3 + 2 * 3
    belief = MapBelief(np.zeros(size), np.eye(size), np.arange(3))
    assert belief.cov.size == (3 + 2 * 3) ** 2
    assert EXERCISES["look-cost"].answer == (3 + 2 * 1500) ** 2


def test_of_twelve_names_some_are_wrong():
    wrong = np.random.default_rng(0).uniform(size=(200_000, 12)) < 0.16
    assert EXERCISES["look-some"].answer == pytest.approx(wrong.any(axis=1).mean(), abs=0.005)
