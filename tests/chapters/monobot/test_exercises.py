"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.book.monobot import EXERCISES, heard, limit
from robot_perception.slam.monobot import run_filter
from tests.chapters.exercises import assert_judged, assert_told


def settles_at(landmarks, start_variance):
    """Return all covariances of a long run at V = W = 1 m²."""
    start, z = Gaussian(np.zeros(1), np.array([[start_variance]])), np.zeros((1, 500, landmarks))
    run = run_filter(start, np.zeros(499), z, motion_variance=1.0, measurement_variance=1.0)
    return run.covs[0, -1]


def test_variance_of_the_distance_is_that_after_many_measurements():
    P = settles_at(1, 1.0)
    assert EXERCISES["monobot-1"].answer == pytest.approx(P[0, 0] + P[1, 1] - 2 * P[0, 1])


@pytest.mark.parametrize("row", [[0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, -1, 1], [-2, 1, 1]])
def test_a_row_restores_the_rank_if_its_entries_do_not_add_up_to_zero(row):
    matrix = np.array([row, [-1, 1, 0], [-1, 0, 1]], dtype=float)
    regular = np.linalg.matrix_rank(matrix) == 3
    assert (EXERCISES["monobot-2"].judge(row)[0] == "right") == regular == (np.sum(row) != 0)
    assert kalman.scale_free_rank(matrix.T @ matrix) == (3 if regular else 2)


def test_four_landmarks_settle_where_the_recursion_does():
    variance = settles_at(4, 0.25)[1:, 1:].mean()  # of their mean: what is their own dies slowly
    assert EXERCISES["monobot-3"].answer == pytest.approx(variance)


def test_so_many_landmarks_and_not_one_less_come_within_a_per_cent():
    enough = EXERCISES["monobot-4"].answer
    assert limit(enough).landmark_variance <= 1.01 < limit(enough - 1).landmark_variance


def spread(innovations, S, u):
    return np.mean(innovations**2 / S) > 1.05


def leaning(innovations, S, u):
    t = (innovations * u / S).sum() / np.sqrt(len(innovations) * (u**2 / S).sum())
    return abs(t) > 2.5


def test_an_alarm_hears_the_early_filter_by_what_its_innovations_go_along_with():
    exercise = EXERCISES["monobot-alarm"]
    assert_judged(exercise, leaning)
    assert_told(exercise, spread, "hardly larger")
    assert_told(exercise, lambda *_: True, "right filters")
    assert heard(spread) == (0.0, 0.45)


@pytest.mark.parametrize("key", ["monobot-1", "monobot-3"])
def test_two_digits_are_enough(key):
    assert EXERCISES[key].judge(round(EXERCISES[key].answer, 2))[0] == "right"
