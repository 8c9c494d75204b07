"""The drawings hold what the results say."""

import numpy as np
import pytest

from explorables.figures import figure
from explorables.figures.style import MEANING
from robot_perception.book.monobot import FIG3, FIG4, monobot, planes, ride
from robot_perception.chapters.monobot import figures as draw
from robot_perception.chapters.monobot import recordings
from robot_perception.evaluation.consistency import average_bounds

RNG = np.random.default_rng


def check_band(band, low, high):
    """A band has its lower and its upper curve."""
    heights = {round(y, 9) for y in band.get_paths()[0].vertices[:, 1]}
    np.testing.assert_allclose(sorted(heights), sorted({round(y, 9) for y in (*low, *high)}))


def ordinates(ax):
    return [np.asarray(line.get_ydata(), dtype=float) for line in ax.lines]


@pytest.mark.parametrize("landmarks", [1, 3])
def test_one_run_is_drawn_from_its_own_truth_estimates_and_gains(landmarks):
    runs = ride(monobot(landmarks, **FIG4), 3, RNG(2))
    _, axes = figure(4, 1, height=9)
    draw.one_run(axes, runs, 1)
    path, errors, vehicle, gains = (ordinates(ax) for ax in axes)
    sightings = runs.positions[1] + runs.measurements[1, :, 0]
    np.testing.assert_array_equal(path[0], sightings[::3])
    assert len(axes[0].collections) == 2
    means, reach = runs.means[1], 2 * runs.deviations
    for i, band in enumerate(axes[0].collections):
        check_band(band, means[:, i] - reach[:, i], means[:, i] + reach[:, i])
    for i, ax in ((1, axes[1]), (0, axes[2])):
        check_band(ax.collections[0], -reach[:, i], reach[:, i])
    np.testing.assert_array_equal(path[1], runs.positions[1])
    np.testing.assert_array_equal(path[2:4], runs.means[1, :, :2].T)
    own = [line for line in errors if len(line) == 101]
    np.testing.assert_array_equal(own, runs.means[1, :, 1:].T - 1.0)
    np.testing.assert_array_equal(vehicle[0], path[2] - path[1])
    np.testing.assert_array_equal(gains[:2], runs.K[:, :2, 0].T)


def test_an_anchor_closes_the_strip_to_an_ellipse():
    _, ax = figure()
    for anchored, edges in ((False, 2), (True, 0)):
        draw.plane(ax, planes(anchored)[5])
        straight = [line for line in ax.lines if len(line.get_xdata()) == 2]
        assert len(straight) == edges
        assert len(ax.patches) == 2  # the inside of the strip or ellipse, and of the belief


@pytest.mark.parametrize("anchored", [False, True])
def test_what_is_drawn_of_the_information_lies_two_deviations_away(anchored):
    """Law: (p - m)ᵀ J (p - m) = 4 on the edges of the strip and on the rim of the ellipse."""
    plane = planes(anchored)[5]
    _, ax = figure()
    draw.plane(ax, plane)
    drawn = [line for line in ax.lines if line.get_color() == MEANING["information"]]
    for line in drawn:
        off = np.stack(line.get_data(), axis=-1) - (plane.belief.mean - plane.truth)
        off = off[np.isfinite(off).all(axis=1)]
        np.testing.assert_allclose(np.einsum("ki,ij,kj->k", off, plane.information, off), 4.0)
    assert len(drawn) == (1 if anchored else 2)


def test_mean_so_far_lies_in_a_band_that_narrows_with_the_root_of_the_runs():
    found = ride(monobot(steps=30, **FIG4), 60, RNG(5))
    last, sigma = found.landmark_errors[:, -1, 0], found.deviations[-1, 1]
    _, ax = figure()
    draw.ensemble.on(ax, last, sigma)
    runs, means = ax.lines[1].get_data()
    np.testing.assert_allclose(means, [last[: int(n)].mean() for n in runs])
    half = 2 * sigma / np.sqrt(runs)
    check_band(ax.collections[0], -half, half)


def test_two_origins_have_a_band_of_two_deviations_about_their_wall():
    run = recordings.filter_corridor(recordings.CORRIDOR.read().result, origin=0.0)
    _, axes = figure(1, 2)
    draw.two_origins.on(axes, {"here": run, "there": run})
    for ax in axes:
        wall, reach = run.means[0, :, 1], 2 * run.deviations[0, :, 1]
        check_band(ax.collections[0], wall - reach, wall + reach)


def test_first_against_last_has_the_slope_of_least_squares():
    first, last = ride(monobot(**FIG3), 40, RNG(4)).landmark_errors[:, [0, -1], 0].T
    _, ax = figure()
    draw.first_against_last.on(ax, first, last)
    line = ax.lines[1]
    slope = np.ptp(line.get_ydata()) / np.ptp(line.get_xdata())
    assert slope == pytest.approx(np.linalg.lstsq(first[:, None], last, rcond=None)[0][0])


def test_honesty_names_every_way_in_its_own_colour():
    rng = RNG(1)
    rms, nees = ({f"way {k}": rng.random(9) for k in range(5)} for _ in range(2))
    _, axes = figure(2, 1)
    draw.variants.on(axes, rms, nees, runs=4)
    ax = axes[1]
    named = {line.get_label().replace("\n", " "): line for line in ax.lines}
    assert list(named) == list(nees)
    assert len({line.get_color() for line in ax.lines}) == len(nees)
    for upper, (name, line) in zip(axes[0].lines, named.items(), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), nees[name])
        np.testing.assert_array_equal(upper.get_ydata(), rms[name])
    (honest,) = ax.patches  # the average of four runs lies in it, 95 times in 100
    span = honest.get_y(), honest.get_y() + honest.get_height()
    assert span == pytest.approx(average_bounds(1, 4))
