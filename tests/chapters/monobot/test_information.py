"""What is known, and the direction in which nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.monobot import information, rail
from robot_perception.chapters.monobot.rail import FIG3, GOLDEN
from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.kalman import scale_free_rank

RNG = np.random.default_rng


def test_likelihood_is_level_along_a_shift_and_curved_across():
    places = np.linspace(-3, 3, 25)
    values = information.likelihood_of_shift(FIG3, places, places, rng=RNG(1)).log_likelihood
    assert values.max() == 0
    for offset in (-5, 0, 9):
        assert np.ptp(np.diagonal(values, offset)) < 1e-9
    # across: the information on the distance at the start, with the first look's own 1/W
    row = values[12]
    curvature = np.diff(row, 2) / np.diff(places)[0] ** 2
    np.testing.assert_allclose(curvature, -GOLDEN, rtol=1e-6)


@pytest.mark.parametrize("known", [False, True])
def test_plane_is_dark_in_one_direction_unless_a_landmark_is_known(known):
    for looks in (1, 5, 30):
        now = information.plane_after(looks, known_landmark=known, rng=RNG(3))
        assert scale_free_rank(now.information) == (2 if known else 1)
    assert (np.sqrt(now.belief.cov[1, 1]) < 0.3) == known


def test_plane_is_that_of_the_run_after_so_many_looks():
    world = rail.simulate(replace(FIG3, runs=1), rng=RNG(3))
    run, total = rail.refilter(FIG3, world), rail.total_information(FIG3)
    for looks in (0, 1, 7):
        now = information.plane_after(looks, known_landmark=False, rng=RNG(3))
        np.testing.assert_array_equal(now.truth, [world.positions[0, looks], FIG3.landmarks_at])
        np.testing.assert_array_equal(now.belief.mean, run.means[0, looks])
        np.testing.assert_array_equal(now.belief.cov, run.covs[0, looks])
        expected = total[looks - 1] if looks else np.zeros((2, 2))
        np.testing.assert_array_equal(now.information, expected)


def test_plane_is_honest_with_a_known_landmark():
    planes = [information.plane_after(30, known_landmark=True, rng=own) for own in RNG(4).spawn(60)]
    errors = np.stack([now.belief.mean - now.truth for now in planes])
    low, high = average_bounds(2, len(planes), 1 - 1e-4)
    assert low < normalised_squared(errors, planes[0].belief.cov).mean() < high
