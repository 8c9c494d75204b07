"""The answers of the exercises are what happens."""

import numpy as np

from robot_perception.appearance.colour_histograms import adapt
from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.book.head_tracking import (
    CROWD,
    EXERCISES,
    LIGHT,
    additions,
    missed_with,
    tried_out,
)


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


def test_a_small_ellipse_has_a_quarter_of_the_head_in_common_with_it():
    small, large = Ellipse(0, 0, 20).pixels, Ellipse(0, 0, 40).pixels
    assert abs(small / large - EXERCISES["head-half"].answer) < 0.01


def test_the_search_saves_a_factor_of_twenty_from_the_answer_on():
    ratios = {w: np.divide(*additions(w, 8)) for w in range(1, 60)}
    answer = EXERCISES["head-saving"].answer
    assert answer == 28  # as printed
    assert all((ratio >= 20) == (w >= answer) for w, ratio in ratios.items())


def test_a_rule_of_the_readers_is_followed_as_the_tracker_learns():
    """Eq. (29) gives what the explorer shows; only a rule that serves both films is right."""

    def learn(first, model, seen, score):
        return adapt(model, seen, 0.02) if score >= 0.4 else model

    def fixed(first, model, seen, score):
        return model

    ours = tried_out(LIGHT, 0.02, 0.4, 0.0).missed
    assert missed_with(learn, "light") == ours["adapted"]
    assert missed_with(fixed, "light") == ours["fixed"]
    assert missed_with(learn, "crowd") == tried_out(CROWD, 0.02, 0.4, 0.0).missed["adapted"]
    sheet = EXERCISES["head-own"]
    assert sheet.judge(learn)[0] == sheet.judge(fixed)[0] == "wrong"
