"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.tutor_following import EXERCISES
from robot_perception.companion.hands.boosting import boost
from robot_perception.companion.hands.features import integral
from robot_perception.companion.interaction import Event


def test_four_numbers_of_an_integral_image_are_the_sum_of_a_rectangle():
    image = np.random.default_rng(0).integers(0, 9, (6, 7), dtype=np.uint8)
    total, _ = integral(image)
    found = total[5, 6] - total[5, 2] - total[1, 6] + total[1, 2]
    assert found == image[1:5, 2:6].sum()
    assert EXERCISES["following-integral"].answer == 40 - 12 - 10 + 3


def test_the_vote_of_the_exercise_is_that_of_the_library():
    values = np.array([[0.0, 1, 2, 3, 8, 9, 10, 11, 12, 13]])
    labels = np.array([True, True, True, True, False, False, False, False, False, True])
    weights_of = boost(values, labels, lambda stumps: False, most=1)
    error = 0.1  # the last of five hands, each of which weighs a tenth
    assert weights_of.votes[0] == pytest.approx(np.log((1 - error) / error))
    assert EXERCISES["following-vote"].answer == pytest.approx(np.log((1 - 0.2) / 0.2))


def test_a_model_forgets_as_the_exercise_says():
    model, pictures = np.array([1.0, 0.0]), 0
    while model[0] >= 0.5:
        model = 0.9 * model + 0.1 * np.array([0.0, 1.0])
        pictures += 1
    assert EXERCISES["following-drift"].answer == pictures == 7


def test_a_rate_of_the_exercise_leaves_half_of_the_model():
    model = 1.0
    for _ in range(25):
        model *= 1 - EXERCISES["following-rate"].answer
    assert model == pytest.approx(0.5)


def test_three_whistles_in_a_row_halt_the_robot():
    sheet = EXERCISES["following-whistle"]
    assert sheet.judge(Event(lambda seen: seen["whistle"], 3))[0] == "right"
    assert "too early" in sheet.judge(Event(lambda seen: seen["whistle"], 2))[1]
    for wrong in (Event(lambda seen: seen["whistle"], 4), Event(lambda seen: seen["fresh"], 3)):
        assert sheet.judge(wrong)[0] == "wrong"


def test_a_gate_that_lets_all_patches_learn_or_none_is_out_of_the_dilemma():
    sheet = EXERCISES["following-gate"]
    assert sheet.judge(lambda far, change: np.full(4, far.max() <= 0.4))[0] == "right"
    assert "who stops" in sheet.judge(lambda far, change: True)[1]
    for wrong in (lambda far, change: 0.0, lambda far, change: (far <= 0.3) & (far.mean() <= 0.4)):
        assert "dark" in sheet.judge(wrong)[1]
