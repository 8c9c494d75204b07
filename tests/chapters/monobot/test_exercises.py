"""The exercises judge right and wrong answers, each wrong one with words of its own."""

import numpy as np
import pytest

from robot_perception.beliefs import Gaussian
from robot_perception.chapters.monobot.exercises import EXERCISES
from robot_perception.slam.monobot import run_filter, settled


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("monobot-1", 2 / (1 + np.sqrt(5)), [1.618034, 0.381966, 1.0, 7.0]),
        ("monobot-2", [0, 1, 0], [[0, -1, 1], [-1, 1, 0], [1, 0], [0, 0, 0]]),
        ("monobot-3", None, [1.618034, 0.25, 3.0]),
        ("monobot-4", None, [99, 10, 7]),
    ],
)
def test_exercises_judge_right_and_wrong(key, right, wrong):
    if key == "monobot-3":  # by the recursion, not by the closed form that the exercise uses
        start = Gaussian(np.zeros(1), np.array([[0.25]]))
        z = np.zeros((1, 500, 4))
        run = run_filter(start, np.zeros(499), z, motion_variance=1.0, measurement_variance=1.0)
        right = run.covs[0, -1, 1:, 1:].mean()
    if key == "monobot-4":
        right = next(
            n
            for n in range(80, 120)
            if settled(
                n, start_variance=1, motion_variance=1, measurement_variance=1
            ).landmark_variance
            <= 1.01
        )
    exercise = EXERCISES[key]
    assert exercise.judge(right)[0] == "right"
    assert exercise.judge(...)[0] == "not yet"
    for answer in wrong:
        outcome, words = exercise.judge(answer)
        assert outcome == "wrong"
        assert len(words) > 20
