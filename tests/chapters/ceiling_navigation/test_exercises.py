"""The exercises of the chapter."""

import numpy as np

from robot_perception.book import ceiling_navigation as page
from robot_perception.geometry import wrap_angle


def test_answers_by_hand():
    assert page.EXERCISES["nav-tilt"].judge(7.0)[0] == "right"
    assert page.EXERCISES["nav-pixels"].judge(0.0125)[0] == "right"


def test_the_new_pattern_is_where_complex_numbers_put_it():
    (x, y, a), (u, v, b) = page.SEEN_KNOWN, page.SEEN_NEW
    way = ((u - x) + 1j * (v - y)) * np.exp(-1j * a) * 0.0125
    there = 1 + 2j + way * np.exp(0.3j)
    answer = np.array([there.real, there.imag, 0.3 + b - a])
    assert page.EXERCISES["nav-place"].judge(answer)[0] == "right"


def test_the_printed_solution_steers_and_one_that_drives_backwards_does_not():
    def steer(x, y, heading, speed=lambda x: max(x, 0.0)):
        alpha = np.arctan2(y, x)
        return speed(x), 2.5 * alpha - 0.8 * wrap_angle(heading - alpha)

    assert page.EXERCISES["nav-steer"].judge(steer)[0] == "right"
    back = page.partial(steer, speed=lambda x: x)
    assert page.EXERCISES["nav-steer"].judge(back)[0] == "wrong"
