"""The answers of the exercises are what happens."""

import numpy as np

from robot_perception.appearance.colour_histograms import adapt
from robot_perception.book.head_tracking import EXERCISES


def test_half_of_the_first_frame_is_left_until_the_answer():
    first, other = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    model, frames = first, 0
    while model[0] >= 0.5:
        model, frames = adapt(model, other, rate=0.1), frames + 1
    assert frames == EXERCISES["head-forget"].answer


def test_a_model_that_does_not_forget_is_no_other():
    sheet = EXERCISES["head-keep"]
    assert sheet.judge(lambda M, C, a: np.maximum(M, (1 - a) * M + a * C))[0] == "right"
    for wrong in (lambda M, C, a: (1 - a) * M + a * C, lambda M, C, a: np.maximum(M, C),
                  lambda M, C, a: M):  # fmt: skip
        assert sheet.judge(wrong)[0] == "wrong"
