"""The answers of the exercises are what chance says."""

import numpy as np

from robot_perception.book import companion_day as page
from tests.chapters.exercises import assert_judged, assert_told


def test_a_chain_of_nine_by_chance():
    good = np.random.default_rng(1).random((200_000, 9)) < 0.9
    assert abs(page.EXERCISES["day-chain"].answer - good.all(axis=1).mean()) < 0.005


def test_a_heading_that_is_off_leads_against_the_wall():
    x, y = np.cumsum(np.full((1300, 2), 0.01) * [np.cos(0.05), np.sin(0.05)], axis=0)[-1]
    assert abs(page.EXERCISES["day-wall"].answer - y) < 0.002
    assert x > 12.9


def test_days_end_where_chance_ends_them():
    p = np.array([0.9, 0.6, 0.8])
    good = np.random.default_rng(2).random((200_000, 3)) < p
    first = np.where(good.all(axis=1), 3, (~good).argmax(axis=1))
    shares = np.bincount(first, minlength=4) / len(first)
    np.testing.assert_allclose(page.ends_of(p), shares, atol=0.005)
    assert page.ends_of(p).sum() == 1.0


def test_the_solution_is_judged_right_and_a_mistake_is_told():
    def ends(p):
        come = np.r_[1.0, np.cumprod(p)]
        return np.r_[come[:-1] * (1 - p), come[-1]]

    exercise = page.EXERCISES["day-rule"]
    assert_judged(exercise, ends)
    assert_told(exercise, lambda p: 1 - p, "if it is tried")
