"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.book.covariance_intersection import EXERCISES, SIGMA, listened


def test_echoes_of_the_exercise_are_those_of_the_rumour():
    _, stated = listened("Kalman", np.zeros((2, 16)), 0.0)
    assert SIGMA == 0.2
    assert EXERCISES["ci-echo"].answer == pytest.approx(stated[-1])


def test_three_opinions_may_be_one():
    one = Gaussian(np.zeros(1), np.eye(1))
    stated = fusion.kalman_fusion(fusion.kalman_fusion(one, one), one).cov[0, 0]
    assert EXERCISES["ci-three"].answer == pytest.approx(1 / stated)


def test_weight_of_the_exercise_is_where_the_solution_looks_for_it():
    w = np.linspace(0, 1, 10001)
    product = ((1 - w) / 0.2**2 + w / 2**2) * ((1 - w) / 10**2 + w / 2.7**2)
    assert EXERCISES["ci-weight"].answer == pytest.approx(w[product.argmax()], abs=1e-4)


def test_matches_of_the_exercise_are_those_of_equation_5():
    w, matches = 0.0, 0
    while w <= 0.9:
        w, matches = w + 0.4 * (1 - w), matches + 1
    assert EXERCISES["ci-hits"].answer == matches
