"""The answers of the exercises are what happens."""

import numpy as np
import pytest
from scipy import stats

from data_synth.wheels import Slip, roll
from robot_perception.book.loop_closing import EXERCISES, met_again, recognised
from robot_perception.slam import planar
from tests.chapters.exercises import assert_judged, assert_told
from tests.teaching.test_grading import recognise

RNG = np.random.default_rng


def test_drift_of_the_exercise_is_what_the_wheels_do():
    poses = np.stack([np.linspace(0, 88.3, 442), np.zeros(442), np.zeros(442)], axis=-1)
    slip = Slip(along=0.0, across=0.0, bend=np.deg2rad(0.5), turn=0.0)
    ends = []
    for own in RNG(0).spawn(1000):
        ahead, _, turned = roll(poses, slip, rng=own).increments.T
        heading = np.r_[0.0, np.cumsum(turned)[:-1]]
        ends.append(ahead @ np.sin(heading))
    answer = EXERCISES["loop-drift"].answer
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], 1000) / 1000)
    assert low < np.std(ends) / answer < high


def test_exercise_of_the_frozen_landmark_is_the_nees_of_many_measurements():
    rng = RNG(1)
    error = 0.10 * rng.standard_normal(20_000) + 0.03 * rng.standard_normal(20_000)
    answer = EXERCISES["loop-frozen"].answer
    assert np.mean(error**2) / 0.03**2 == pytest.approx(answer, rel=0.05)


def test_exercise_of_the_start_is_what_the_filter_says():
    sensor = planar.CartesianSensor(0.03**2 * np.eye(2))
    seen = planar.Observations(np.array([7]), np.array([[4.0, 0.0]]))
    aside = []
    for deviations in ((0.10, 0.10, np.deg2rad(3.0)), (0.0, 0.0, 0.0)):
        start = planar.MapBelief.start(np.zeros(3), np.diag(deviations) ** 2)
        aside.append(np.sqrt(planar.add_landmarks(start, seen, sensor).cov[-1, -1]))
    assert EXERCISES["loop-start"].answer == pytest.approx(aside[0] / aside[1])


def nearest(old, new):
    away = np.linalg.norm(new[:, None] - old, axis=2)
    return np.where(away.min(axis=1) < 2.0, away.argmin(axis=1), -1)


def test_doors_are_recognised_by_their_distances_and_not_by_where_they_lie():
    exercise = EXERCISES["loop-recognise"]
    assert_judged(exercise, recognise)
    assert_told(exercise, nearest, "more than one name is wrong")
    assert_told(exercise, lambda old, new: np.full(len(new), -1), "stays open")
    assert [recognised(one) for one in (nearest, recognise)] == [(4, 13), (27, 0)]
    assert sum((meant >= 0).sum() for *_, meant in map(met_again, range(3))) == 27


@pytest.mark.parametrize(
    ("key", "printed"), [("loop-drift", 4.2), ("loop-start", 7.8), ("loop-frozen", 12)]
)
def test_the_printed_digits_are_enough(key, printed):
    assert EXERCISES[key].judge(printed)[0] == "right"
