"""What is known, and the direction in which nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.monobot import information, rail
from robot_perception.chapters.monobot.rail import FIG3, FIG4, GOLDEN
from robot_perception.kalman import scale_free_rank

RNG = np.random.default_rng


def test_likelihood_is_level_along_a_shift_and_curved_across():
    places = np.linspace(-3, 3, 25)
    values = information.likelihood_of_shift(FIG3, places, places, rng=RNG(1)).log_likelihood
    assert values.max() == 0
    for offset in (-5, 0, 9):
        assert np.ptp(np.diagonal(values, offset)) < 1e-9
    # across: the information on the distance at the start, with the first measurement's own 1/W
    row = values[12]
    curvature = np.diff(row, 2) / np.diff(places)[0] ** 2
    np.testing.assert_allclose(curvature, -GOLDEN, rtol=1e-6)


@pytest.mark.parametrize("anchored", [False, True])
def test_plane_is_dark_in_one_direction_unless_there_is_an_anchor(anchored):
    planes = information.planes(anchored=anchored, rng=RNG(3))
    for k in (1, 5, 30):
        assert scale_free_rank(planes[k].information) == (2 if anchored else 1)
    assert (np.sqrt(planes[30].belief.cov[1, 1]) < 0.3) == anchored


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
def test_measurements_and_the_start_together_know_what_the_filter_knows(base):
    """With a prior on the start the information is the inverse of the filter's covariance."""
    config = replace(base, landmarks=2, steps=20)
    vague = replace(config, start_deviation=300.0)
    gap = np.linalg.inv(rail.covariances(vague).covs[0]) - information.exact_information(config)
    assert np.abs(gap).max() < 1e-4 * np.abs(information.exact_information(config)).max()


@pytest.mark.parametrize("anchored", [False, True])
def test_plane_is_what_the_measurements_allow_and_the_start_narrows(anchored):
    """The filter knows the measurements and the start; only an anchor makes the start forgotten."""
    planes = information.planes(anchored=anchored, rng=RNG(3))
    added = [np.linalg.inv(now.belief.cov) - now.information for now in planes]
    assert np.linalg.eigvalsh(added).min() > -1e-6
    assert (np.abs(added[-1]).max() < 0.05 * np.abs(planes[-1].information).max()) == anchored


def test_information_for_one_landmark_is_that_of_neighbouring_fibonacci_numbers():
    known = information.exact_information(FIG3)[:, 0, 0]
    fibonacci = [1, 1]
    for _ in range(14):
        fibonacci.append(fibonacci[-2] + fibonacci[-1])
    ratios = np.divide(fibonacci[1:], fibonacci[:-1])
    np.testing.assert_allclose(known[:8], ratios[::2])
    assert known[-1] == pytest.approx(GOLDEN)


@pytest.mark.parametrize("anchored", [False, True])
def test_planes_are_those_of_the_run(anchored):
    config = replace(FIG3, runs=1, reference="anchor" if anchored else "none")
    result, known = rail.run(config, rng=RNG(3)), information.exact_information(config)
    planes = information.planes(anchored=anchored, rng=RNG(3))
    assert [now.measurements for now in planes] == list(range(FIG3.steps + 1))
    for k in (0, 1, 7):
        now = planes[k]
        np.testing.assert_array_equal(now.truth, [result.world.positions[0, k], FIG3.landmarks_at])
        np.testing.assert_array_equal(now.belief.mean, result.filtered.means[0, k])
        np.testing.assert_array_equal(now.belief.cov, result.filtered.covs[0, k])
        np.testing.assert_array_equal(now.information, known[k])
        assert now.anchored == anchored


def test_setup_of_fig_3_says_what_the_configuration_holds():
    shown = information.setup()
    assert shown["P0, V, W", "ours"] == "1, 1, 1 m²"
    assert shown["landmarks", "ours"] == "1 to 50"
