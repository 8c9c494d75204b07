"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.visual_slam import EXERCISES
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.particles import effective_number

RNG = np.random.default_rng


def test_depth_of_the_exercise_is_what_noisy_pixels_do():
    rig = StereoRig(Pinhole((280.0, 280.0), (159.5, 119.5), (320, 240)), 0.15)
    at = rig.project(np.array([[0.0, 0.0, 4.0]]))
    noisy = at + 0.5 * RNG(0).standard_normal((20_000, 3)) * [1, 0, 1]
    depth = rig.triangulate(noisy, 0.5).mean[:, 2]
    low, high = np.quantile(depth, [0.158655, 0.841345])
    assert EXERCISES["slam-depth"].answer == pytest.approx((high - low) / 2, rel=0.03)


def test_number_of_the_exercise():
    weights = np.log([0.5, 0.25, 0.25])
    assert EXERCISES["slam-number"].answer == pytest.approx(effective_number(weights))


def test_one_particle_adds_an_error_of_its_own():
    wheels, particle = RNG(1).standard_normal((2, 100_000))
    assert EXERCISES["slam-one"].answer == pytest.approx(np.std(wheels + particle), rel=0.01)
