"""What the chapter says under its explorers and of its pictures, over all states."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from robot_perception.chapters.monobot import (
    bets,
    broken,
    explorers,
    rail,
    recordings,
    steady,
)
from robot_perception.chapters.monobot.rail import FIG3, FIG4
from robot_perception.evaluation.consistency import average_bounds
from tests.chapters.findings import limits
from tests.unchecked import unchecked

RUNS = range(1, 11)
SETTINGS = [
    {"landmarks": n, "known": known, "shape": shape}
    for n, known, shape in product((1, 10), (False, True), ("sine", "at rest"))
]
BOTH = {"known": True, "shape": "at rest"}


def named(setting):
    return " ".join(map(str, setting.values()))


def ends(setting):
    """Return errors after the first and after the last measurement, (runs, landmarks)."""
    errors = explorers.watched(**setting).landmark_errors
    return errors[:, 0], errors[:, -1]


# One run ---------------------------------------------------------------------------------------


def test_the_error_of_one_landmark_stops_within_two_dozen_measurements_in_every_run():
    errors = explorers.watched(landmarks=1, known=False, shape="sine").landmark_errors
    assert np.abs(errors[:, 24:] - errors[:, -1:]).max() < 1e-3
    assert np.abs(errors[:, :2] - errors[:, -1:]).max(axis=1).min() > 1e-3


def test_where_it_stops_is_related_to_the_first_error_and_not_equal():
    first, last = (e[:, 0] for e in ends({"landmarks": 1, "known": False, "shape": "sine"}))
    assert 0.3 < np.corrcoef(first, last)[0, 1] < 0.95


@pytest.mark.parametrize("setting", [s for s in SETTINGS if s["landmarks"] == 10], ids=named)
def test_ten_errors_come_together_in_every_run(setting):
    first, last = ends(setting)
    assert np.all(last.std(axis=1) < first.std(axis=1) / 6)


def test_ten_errors_gather_about_a_common_value_that_a_known_start_shrinks_and_keeps():
    common = {
        known: ends({"landmarks": 10, "known": known, "shape": "sine"})[1]
        for known in (False, True)
    }
    rms = {known: np.sqrt(np.mean(last.mean(axis=1) ** 2)) for known, last in common.items()}
    apart = max(last.std(axis=1).max() for last in common.values())
    assert rms[False] > 2 * rms[True] > 4 * apart


@pytest.mark.parametrize("setting", SETTINGS, ids=named)
def test_errors_fall_for_good_only_at_rest_and_from_a_known_start(setting):
    stated = explorers.watched(**setting).deviations[:, 1]
    falls = BOTH.items() <= setting.items()
    assert (stated[-1] < 0.11 * stated[0]) == falls
    assert (stated[-1] < 0.9 * stated[50]) == falls
    if falls:
        assert np.abs(ends(setting)[1]).max() < 3 * stated[-1]


# Vehicle and landmark --------------------------------------------------------------------------

MEASUREMENTS = explorers.plane.controls["measurements"].values


def deviations(anchored):
    """Return two deviations of vehicle and landmark in every state of the explorer."""
    planes = explorers.plane.found(anchored=anchored)
    return np.array([2 * np.sqrt(np.diagonal(plane.belief.cov)) for plane in planes])


@pytest.mark.parametrize("anchored", [False, True])
def test_the_ellipse_never_sticks_out_of_what_the_measurements_allow(anchored):
    for plane in explorers.plane.found(anchored=anchored):
        root = np.linalg.cholesky(plane.belief.cov)
        reach = np.linalg.eigvalsh(root.T @ plane.information @ root).max()
        assert 0.9 < reach < 1 + 1e-9  # 1: it touches the edge


def test_without_an_anchor_strip_and_ellipse_stand_still_after_a_few_measurements():
    planes = explorers.plane.found(anchored=False)
    width = [np.linalg.eigvalsh(plane.information)[1] ** -0.5 for plane in planes]
    assert np.ptp(width[3:]) < 0.01 * width[0] < np.ptp(width[:3])
    length = [np.linalg.eigvalsh(plane.belief.cov)[1] for plane in planes]
    assert np.all(np.diff(length) > -1e-9)
    vehicle, landmark = deviations(False).T
    assert np.ptp(landmark[3:]) < 0.01
    assert landmark.min() > 2 * FIG3.start_deviation
    assert vehicle[3:].min() > 2.9


def test_with_an_anchor_the_landmark_closes_with_the_root_and_the_vehicle_stays():
    vehicle, landmark = deviations(True).T
    np.testing.assert_allclose(landmark * np.sqrt(np.add(MEASUREMENTS, 1)), landmark[0])
    assert np.all(np.diff(vehicle) < 0)
    assert 1.2 < vehicle[-1] < vehicle[-4] < 1.25


# The factors of Fig. 4 -------------------------------------------------------------------------


def test_no_band_ends_narrower_than_the_start():
    for state in explorers.study.parameters():
        end = rail.covariances(replace(FIG4, **state)).deviations[0, -1, 1]
        assert end > state["start_deviation"], state


def test_from_a_known_start_a_robot_at_rest_averages_and_a_moving_one_does_not():
    at_rest = explorers.study.found(start_deviation=0.0, shape="at rest")
    moving = explorers.study.found(start_deviation=0.0, shape="sine")
    np.testing.assert_allclose(at_rest, np.sqrt(100 / 101))
    assert min(moving) > 1.3
    assert 6 < max(moving) < 6.5


def test_worse_wheels_and_a_better_sensor_leave_more_of_what_averaging_would_remove():
    for n, share in product((1, 5, 20), (0.05, 0.1)):
        fixed = {"landmarks": n, "start_deviation": 0.0, "shape": "sine"}
        fixed["measurement_share"] = share
        good, bad = explorers.study.found(**fixed)  # in the order of the control
        assert bad > good
    for n, move in product((1, 5, 20), (0.1, 0.5)):
        fixed = {"landmarks": n, "motion_share": move, "start_deviation": 0.0, "shape": "sine"}
        sharp, blunt = explorers.study.found(**fixed)
        assert sharp > blunt


def test_what_the_presets_of_the_study_promise():
    end = {
        name: rail.covariances(replace(FIG4, **preset)).deviations[0, :, 1]
        for name, preset in {"ours": {}, **explorers.study.presets}.items()
    }
    assert 2 * end["ours"][-1] < end["lost from the start"][-1] < end["lost from the start"][0]
    assert end["good wheels"][-1] < end["ours"][-1]
    assert end["good wheels"][-1] > FIG4.start_deviation
    assert end["twenty landmarks, start known"][-1] < 0.5 * end["ours"][-1]


# All explorers ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["one_run", "plane", "study"])
def test_presets_show_something_of_their_own_on_scales_that_stay(name):
    shown = getattr(explorers, name)
    scales, words = set(), set()
    with unchecked():
        explorer = shown.show()
        frames = [explorer.frame(**state) for state in ({}, *shown.presets.values())]
        for state in ({}, *shown.presets.values()):
            axes = np.atleast_1d(shown.drawn(**state))
            assert all(ax.lines for ax in axes)
            scales.add(tuple(limits(ax) for ax in axes))
            words.add(shown.described(**state))
    assert len(words) == len({frame.data for frame in frames}) == len(frames)
    assert len(scales) == 1


@pytest.mark.parametrize("setting", SETTINGS, ids=named)
def test_nothing_leaves_the_scales_of_one_run(setting):
    result = explorers.watched(**setting)
    axes = explorers.one_run.drawn(**setting)
    means, reach = result.filtered.means, 2 * result.deviations
    low, high = axes[0].get_ylim()
    assert low < (means - reach).min() < (means + reach).max() < high
    assert np.abs(result.landmark_errors).max() < axes[1].get_ylim()[1]
    assert reach[:, 1].max() < axes[1].get_ylim()[1]


def test_nothing_leaves_the_scales_of_the_study():
    for state in explorers.study.parameters():
        with unchecked():
            axes = explorers.study.drawn(**state)
        for ax in axes:
            low, high = ax.get_ylim()
            drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in ax.lines])
            assert np.isfinite(drawn).all()
            assert low < drawn.min() <= drawn.max() < high, state


# Findings beside the explorers -----------------------------------------------------------------


def test_the_share_falls_below_a_half_for_two_of_eight_changes():
    table = steady.factor_table()
    changed = {(row, col): table[row, col] for row in table.rows for col in ("half", "twice")}
    below = {place for place, share in changed.items() if share < 0.5}
    assert below == {("σ of the start", "half"), ("σ of a measurement", "twice")}


def test_setup_of_fig_4_doubles_and_halves_what_it_says():
    table = steady.setup()
    assert len(table.rows) == 6
    end = 1e3 * rail.covariances(FIG4).deviations[0, -1, 1]
    assert f"{end:.0f} mm" in table.about
    for name, field in steady.VARIED.items():
        config = replace(FIG4, **{field: 2 * getattr(FIG4, field)})
        again = 1e3 * rail.covariances(config).deviations[0, -1, 1]
        assert table[name, "twice (mm)"] == pytest.approx(again)


def test_only_too_small_a_start_changes_no_estimate():
    right, *others = broken.run(replace(FIG4, runs=20), rng=np.random.default_rng(8))
    same = [v.name for v in others if np.abs(v.errors - right.errors).max() < 1e-9]
    assert same == ["P0 a hundredth of the truth"]


def test_a_hundred_runs_find_the_bias_of_an_early_update_by_its_mean_and_not_by_its_spread():
    late = broken.run(replace(FIG4, runs=1000), rng=np.random.default_rng(8))[2]
    end = late.errors[:, -1]
    assert late.nees[-1] < average_bounds(1, 100)[1]
    assert abs(end.mean()) > 3 * end.std() / np.sqrt(100)


def test_innovations_of_the_corridor_are_rather_small_and_not_too_small():
    stretch = recordings.CORRIDOR.read().result
    here, there = (recordings.filter_corridor(stretch, origin=origin) for origin in (0.0, 100.0))
    said = recordings.compared(here, there)
    assert said["shift"] == pytest.approx(100)
    assert np.ptp(there.means - here.means) < 1e-9
    assert said["start"] < said["wall"] < 1.1 * said["start"]
    assert said["share"] == pytest.approx(0.52, abs=0.01)
    assert said["count"] == 15
    assert 5 < said["percentile"] < 10


def test_the_right_answers_of_the_bets_are_right():
    slopes = [rail.limit(n).information_rate for n in (1, 50)]
    assert 1 < slopes[1] / slopes[0] < 3
    assert bets.FIFTY["right"] == "Less than three times"
    alone = [
        {"landmarks": 1, "known": False, "shape": "at rest"},
        {"landmarks": 1, "known": True, "shape": "sine"},
        {"landmarks": 10, "known": False, "shape": "sine"},
    ]
    for setting in alone:
        stated = explorers.watched(**setting).deviations[:, 1]
        assert stated[-1] > 0.45 * stated[0]
    assert bets.CURES["right"] == "None of them alone"
    for asked in (bets.CURES, bets.FIFTY, bets.SAME):
        assert asked["right"] in asked["replies"]
