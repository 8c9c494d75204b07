"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.pattern_tracking import (
    EXERCISES,
    RULES,
    SIGMAS,
    START,
    error_with,
    gaussian,
    tried_patches,
)
from robot_perception.ceiling.patterns import Decay, deviations


def test_the_offset_is_judged_as_it_is_rounded():
    sheet = EXERCISES["pattern-offset"]
    V = np.array([10.0, 20, 60])
    exact = V @ (V + 40) / np.linalg.norm(V) / np.linalg.norm(V + 40)
    for answer in (exact, 0.9477, 0.948, 0.95):
        assert sheet.judge(answer)[0] == "right"
    for answer in (0.94, 0.96, 1.0):
        assert sheet.judge(answer)[0] == "wrong"
    assert "rounded up" in sheet.judge(0.94)[1]


def test_the_exponent_of_the_exercise_is_the_librarys():
    right, wrong = deviations(np.array([0.6, 0.6]), Decay(np.array([0.4, 0.2]), np.ones(2)))
    assert EXERCISES["pattern-deviation"].answer == pytest.approx((right / wrong) ** 2)


def test_draws_of_the_exercise_are_those_of_a_million():
    drawn = np.random.default_rng(0).standard_normal((10_000, 200))
    beyond = (np.abs(drawn) > 3).sum(axis=1).mean()
    assert EXERCISES["pattern-draws"].answer == pytest.approx(beyond, rel=0.05)


def test_a_distance_that_knows_directions_is_told_from_one_that_does_not():
    limit = np.sin(np.deg2rad(20))

    def right(d, turn):
        return min(d, 10.0) if abs(np.sin(turn)) <= limit else 10.0

    def with_a_sense(d, turn):
        return min(d, 10.0) if abs(turn) <= np.deg2rad(20) else 10.0

    sheet = EXERCISES["pattern-direction"]
    assert sheet.judge(right)[0] == "right"
    for wrong in (with_a_sense, lambda d, turn: min(d, 10.0), lambda d, turn: d):
        assert sheet.judge(wrong)[0] == "wrong"


def test_a_gaussian_factor_weighs_as_the_library_without_tolerance():
    """The printed solution is right, one of which a bad vector gains is not, bare or covered."""
    share, place, states, deviation = tried_patches()[0]
    assert share == 0.0
    logs = gaussian(deviation).sum(axis=1)
    weights = np.exp(logs - logs.max())
    off = np.abs((weights @ states / weights.sum() - place) / SIGMAS).mean()
    assert off < 0.5 < np.abs((START - place) / SIGMAS).max()
    sheet = EXERCISES["pattern-factor"]

    def capped(d):
        return -(np.minimum(d, 3.0) ** 2) / 2 / RULES.deviation**2

    def left_out(d):
        return np.where(d > 3.0, 0.0, gaussian(d))

    assert sheet.judge(capped)[0] == "right"
    assert sheet.judge(left_out)[0] == sheet.judge(gaussian)[0] == "wrong"
    assert error_with(left_out, 0.0) > 1.5 * error_with(gaussian, 0.0)
