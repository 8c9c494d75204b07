"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.tutor_following import EXERCISES, whistle
from robot_perception.companion.hands.boosting import boost
from robot_perception.companion.hands.features import integral
from robot_perception.companion.interaction import Event, Interaction, InteractionState
from robot_perception.companion.robot import EVENTS


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


def test_two_whistles_halt_the_robot():
    rules = {**EVENTS, "whistle": Event(lambda seen: seen["whistle"], 2)}
    machine, state = Interaction(whistle, rules), InteractionState("follow")
    seen = {"hands": 0, "fresh": True, "hidden": False, "whistle": True}
    names = []
    for _ in range(2):
        state, _ = machine.step(state, seen)
        names.append(state.name)
    assert names == ["follow", "halt"]
