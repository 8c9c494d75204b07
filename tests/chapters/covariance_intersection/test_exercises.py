"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.book import covariance_intersection as page
from robot_perception.book.covariance_intersection import EXERCISES, SIGMA, listened
from tests.chapters.exercises import assert_judged, assert_told


def test_echoes_of_the_exercise_are_those_of_the_rumour():
    _, stated = listened("Kalman", np.zeros((2, 16)), 0.0)
    assert SIGMA == 0.2
    assert EXERCISES["ci-echo"].answer == pytest.approx(stated[-1])


def test_three_opinions_may_be_one():
    one = Gaussian(np.zeros(1), np.eye(1))
    stated = fusion.kalman_fusion(fusion.kalman_fusion(one, one), one).cov[0, 0]
    assert EXERCISES["ci-three"].answer == pytest.approx(1 / stated)


def weight(Ci, Cj):
    ratio = np.linalg.solve(Cj, Ci)
    t, q = np.trace(ratio), np.linalg.det(ratio)
    if t <= 2:
        return 0.0
    if t <= 2 * q:
        return 1.0
    return (t - 2) / (2 * (t - 1 - q))


def searched(Ci, Cj):
    Yi, Yj = np.linalg.inv(Ci), np.linalg.inv(Cj)
    return max(np.linspace(0, 1, 11), key=lambda w: np.linalg.det((1 - w) * Yi + w * Yj))


def test_the_weight_of_the_solution_is_the_best_and_worse_ones_are_told():
    exercise = page.EXERCISES["ci-weight"]
    assert_judged(exercise, weight)
    np.testing.assert_allclose(page.excess(weight), 1, rtol=1e-9)
    assert_judged(exercise, searched)
    assert_told(exercise, lambda Ci, Cj: 1 - weight(Ci, Cj), "Exchange")
    assert_told(exercise, page.TRIED["eq. 4"], "that is eq. 4")


def test_the_solution_leaves_one_out_for_more_than_half_of_the_pairs():
    a, b, _ = page.some_pairs()
    alone = np.mean([weight(*both) in (0.0, 1.0) for both in zip(a.cov, b.cov, strict=True)])
    assert 0.5 < alone < 0.7


def test_matches_of_the_exercise_are_those_of_equation_5():
    w, matches = 0.0, 0
    while w <= 0.9:
        w, matches = w + 0.4 * (1 - w), matches + 1
    assert EXERCISES["ci-hits"].answer == matches
