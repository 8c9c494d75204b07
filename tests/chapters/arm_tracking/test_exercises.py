"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.arm_tracking import EXERCISES


def normalised(left):
    weights = np.exp(left - left.max())
    return weights / weights.sum()


def test_the_look_ahead_is_taken_off_once_and_for_the_ancestor():
    sheet = EXERCISES["arms-weights"]
    assert sheet.judge(lambda log, ahead, drawn: normalised(log - ahead[drawn]))[0] == "right"
    for wrong in (
        lambda log, ahead, drawn: normalised(log - ahead),
        lambda log, ahead, drawn: normalised(log),
        lambda log, ahead, drawn: normalised(log + ahead[drawn]),
    ):
        assert sheet.judge(wrong)[0] == "wrong"


@pytest.mark.filterwarnings("ignore:invalid value")
def test_weights_that_all_vanish_are_not_right():
    def careless(log, ahead, drawn):
        weights = np.exp(log) / np.exp(ahead[drawn])
        return weights / weights.sum()

    assert EXERCISES["arms-weights"].judge(careless)[0] == "wrong"


def test_arms_that_go_on_as_they_went_are_tracked_better_than_by_a_walk():
    sheet = EXERCISES["arms-motion"]
    assert sheet.judge(lambda before, last: (0.8 * (last - before), 1.0))[0] == "right"
    assert sheet.judge(lambda before, last: (np.zeros(8), 1.0))[0] == "wrong"
    assert "lost" in sheet.judge(lambda before, last: (np.zeros(8), 0.05))[1]
