"""What the chapter says under its explorers, beyond what these assert themselves."""

from itertools import product

import numpy as np
import pytest

from robot_perception.book import monobot as book
from robot_perception.book.monobot import FIG3, FIG4
from tests.unchecked import unchecked

SETTINGS = [
    {"landmarks": n, "known": known, "shape": shape}
    for n, known, shape in product((1, 10), (False, True), ("sine", "at rest"))
]


def named(setting):
    return " ".join(map(str, setting.values()))


def ends(setting):
    """Return errors after the first and after the last measurement, (runs, landmarks)."""
    errors = book.watched(**setting).landmark_errors
    return errors[:, 0], errors[:, -1]


# One run ---------------------------------------------------------------------------------------


def test_the_error_of_one_landmark_stops_within_two_dozen_measurements_in_every_run():
    errors = book.watched(landmarks=1, known=False, shape="sine").landmark_errors
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


@pytest.mark.parametrize("n", [1, 10])
def test_at_rest_and_from_a_known_start_no_error_ends_outside_three_deviations(n):
    setting = {"landmarks": n, "known": True, "shape": "at rest"}
    assert np.abs(ends(setting)[1]).max() < 3 * book.watched(**setting).deviations[-1, 1]


@pytest.mark.parametrize("setting", SETTINGS, ids=named)
def test_nothing_leaves_the_scales_of_one_run(setting):
    found = book.watched(**setting)
    axes = book.one_run.drawn(**setting)
    reach = 2 * found.deviations
    low, high = axes[0].get_ylim()
    assert low < (found.means - reach).min() < (found.means + reach).max() < high
    assert np.abs(found.landmark_errors).max() < axes[1].get_ylim()[1]
    assert reach[:, 1].max() < axes[1].get_ylim()[1]


# Vehicle and landmark --------------------------------------------------------------------------

MEASUREMENTS = book.plane.controls["measurements"].values


def deviations(anchored):
    """Return two deviations of vehicle and landmark in every state of the explorer."""
    return 2 * np.array([sigma for *_, sigma in book.plane.found(anchored=anchored)])


@pytest.mark.parametrize("anchored", [False, True])
def test_planes_are_those_of_one_run(anchored):
    robot = book.monobot(anchor=anchored, **FIG3)
    found, known = book.ride(robot, 1, np.random.default_rng(3)), book.information(robot)
    planes = book.planes(anchored)
    assert [now.measurements for now in planes] == list(range(101))
    for k in (0, 1, 7):
        now = planes[k]
        np.testing.assert_array_equal(now.truth, [found.positions[0, k], 1.0])
        np.testing.assert_array_equal(now.belief.mean, found.means[0, k])
        np.testing.assert_array_equal(now.belief.cov, found.P[k])
        np.testing.assert_array_equal(now.information, known[k])
        assert now.anchored == anchored


@pytest.mark.parametrize("anchored", [False, True])
def test_plane_is_dark_in_one_direction_unless_there_is_an_anchor(anchored):
    planes = book.planes(anchored)
    for k in (1, 5, 30):
        rank = book.kalman.scale_free_rank(planes[k].information)
        assert rank == (2 if anchored else 1)
    assert (np.sqrt(planes[30].belief.cov[1, 1]) < 0.3) == anchored


@pytest.mark.parametrize("anchored", [False, True])
def test_plane_is_what_the_measurements_allow_and_the_start_narrows(anchored):
    """The filter knows the measurements and the start; only an anchor makes the start forgotten."""
    planes = book.planes(anchored)
    added = [np.linalg.inv(now.belief.cov) - now.information for now in planes]
    assert np.linalg.eigvalsh(added).min() > -1e-6
    assert (np.abs(added[-1]).max() < 0.05 * np.abs(planes[-1].information).max()) == anchored


def test_without_an_anchor_strip_and_ellipse_stand_still_after_a_few_measurements():
    planes = [book.planes(False)[k] for k in MEASUREMENTS]
    width = [np.linalg.eigvalsh(plane.information)[1] ** -0.5 for plane in planes]
    assert np.ptp(width[3:]) < 0.01 * width[0] < np.ptp(width[:3])
    length = [np.linalg.eigvalsh(plane.belief.cov)[1] for plane in planes]
    assert np.all(np.diff(length) > -1e-9)
    vehicle, landmark = deviations(False).T
    assert np.ptp(landmark[3:]) < 0.01
    assert landmark.min() > 2 * FIG3["start_deviation"]
    assert vehicle[3:].min() > 2.9


def test_with_an_anchor_the_landmark_closes_with_the_root_and_the_vehicle_stays():
    vehicle, landmark = deviations(True).T
    np.testing.assert_allclose(landmark * np.sqrt(np.add(MEASUREMENTS, 1)), landmark[0])
    assert np.all(np.diff(vehicle) < 0)
    assert 1.2 < vehicle[-1] < vehicle[-4] < 1.25


# The factors of Fig. 4 -------------------------------------------------------------------------


def times(**fixed):
    return [one.times for one in book.factors.found(**fixed)]


def test_a_moving_robot_leaves_up_to_six_times_what_averaging_would():
    assert 6 < max(times(start_deviation=0.0, shape="sine")) < 6.5


def test_worse_wheels_and_a_better_sensor_leave_more_of_what_averaging_would_remove():
    for n, share in product((1, 5, 20), (0.05, 0.1)):
        fixed = {"landmarks": n, "start_deviation": 0.0, "shape": "sine"}
        good, bad = times(measurement_share=share, **fixed)  # in the order of the control
        assert bad > good
    for n, move in product((1, 5, 20), (0.1, 0.5)):
        fixed = {"landmarks": n, "start_deviation": 0.0, "shape": "sine"}
        sharp, blunt = times(motion_share=move, **fixed)
        assert sharp > blunt


def test_what_the_presets_of_the_study_promise():
    end = {
        name: book.stated(book.monobot(**FIG4 | preset)).deviations[:, 1]
        for name, preset in {"ours": {}, **book.factors.presets}.items()
    }
    assert 2 * end["ours"][-1] < end["lost from the start"][-1] < end["lost from the start"][0]
    assert end["good wheels"][-1] < end["ours"][-1]
    assert end["good wheels"][-1] > FIG4["start_deviation"]
    assert end["twenty landmarks, start known"][-1] < 0.5 * end["ours"][-1]


def test_nothing_leaves_the_scales_of_the_study():
    for state in book.factors.parameters():
        with unchecked():
            axes = book.factors.drawn(**state)
        for ax in axes:
            low, high = ax.get_ylim()
            drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in ax.lines])
            assert np.isfinite(drawn).all()
            assert low < drawn.min() <= drawn.max() < high, state
