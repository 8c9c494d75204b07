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


def law(distance, bearing):
    """Return the law of the page with other gains."""

    def steer(x, y, heading):
        alpha = np.arctan2(y, x)
        return distance * max(x, 0.0), bearing * alpha - 0.8 * wrap_angle(heading - alpha)

    return steer


def test_the_printed_law_bears_three_times_the_scale_and_a_slow_one_takes_too_long():
    judge = page.EXERCISES["nav-law"].judge
    assert judge(law(1.0, 5.0))[0] == "right"
    assert judge(law(0.5, 2.5))[0] == judge(law(1.0, 2.5))[0] == "wrong"


def test_the_law_of_the_page_arrives_as_often_as_its_table_says():
    ours = page.approached.rows().of("arrives", change="3 times").mean()
    assert page.arrives_by(law(1.0, 2.5), 3.0) == ours
