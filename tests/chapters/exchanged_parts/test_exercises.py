"""The answers of the exercises are what the code says."""

import numpy as np
import pytest

from robot_perception.book import exchanged_parts as page
from robot_perception.particles import effective_number
from tests.chapters.exercises import assert_judged, assert_told


def test_a_dot_has_half_of_the_colours_in_common():
    dot, head = np.array([10.0, 0.0]), np.array([50.0, 50.0])
    assert page.EXERCISES["parts-common"].answer == page.of_shares(dot, head)
    assert page.printed(dot, head) == 1


def test_a_new_picture_is_further_by_the_answer():
    rng, p = np.random.default_rng(1), 5
    classes = page.classes_of(30 * rng.normal(size=(40_000, p, 20)))
    new = 30 * rng.normal(size=(40_000, 20))
    L = ((new - classes.means) ** 2 / page.VARIANCES[page.OWN](classes)).sum(axis=1)
    assert page.EXERCISES["parts-views"].answer == pytest.approx(L.mean() / 20, rel=0.05)


def test_so_many_guesses_count_in_eight_coordinates():
    h = 4.0  # six of ten count along each coordinate: √(1 + 2h) / (1 + h)
    y = np.random.default_rng(2).standard_normal((400_000, 8))
    share = effective_number(-0.5 * h * (y**2).sum(axis=1)) / len(y)
    assert page.EXERCISES["parts-count"].answer == pytest.approx(400 * share, rel=0.1)


def test_the_rule_of_the_solution_beats_those_of_the_page_and_mistakes_are_told():
    def compare(C, M):
        c, m = C / C.sum(), M / M.sum()
        both = c + m > 0
        return -((c - m)[both] ** 2 / (c + m)[both]).sum()

    exercise = page.EXERCISES["parts-rule"]
    assert_judged(exercise, compare)
    for rule in (page.printed, page.ballard, lambda C, M: C.sum(), lambda C, M: 0.0):
        assert_told(exercise, rule, "half an octave")
    assert_told(exercise, lambda C, M: (C * M).sum() / np.linalg.norm(C), "does not reach")
