"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book import map_localisation as page
from robot_perception.geometry import wrap_angle
from tests.teaching.test_grading import place_of


@pytest.fixture(scope="module")
def guesses():
    """Guesses all over the floor, and a robot that is far from its edges."""
    drawn = np.random.default_rng(0).uniform([0, 0, -np.pi], [20.1, 12.2, np.pi], (2_000_000, 3))
    off = drawn - [10.0, 6.0, 1.0]
    return np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2]))


def test_a_guess_is_right_as_seldom_as_the_exercise_says(guesses):
    far, turned = guesses
    right = np.mean((far < page.NEAR) & (turned < page.TURNED))
    assert page.EXERCISES["mcl-guess"].answer == pytest.approx(right, rel=0.1)


def test_so_many_particles_put_three_near_the_robot(guesses):
    far, turned = guesses
    near = np.mean((far < 0.5) & (turned < np.deg2rad(10)))
    assert page.EXERCISES["mcl-count"].answer * near == pytest.approx(3, rel=0.2)


def test_the_solution_gives_the_pose_and_slips_do_not():
    assert page.gives_the_pose(page.implied)
    assert not page.gives_the_pose(lambda p, q, m, n: page.implied(m, n, p, q))
    assert not page.gives_the_pose(lambda p, q, m, n: page.implied(p, q, n, m))


def test_the_place_is_found_by_agreement_and_not_by_the_mean_of_all():
    def mean(points, places):
        return [*(places - points).mean(axis=0), 0.0]

    assert page.finds_the_place(place_of)
    assert not page.finds_the_place(mean)
