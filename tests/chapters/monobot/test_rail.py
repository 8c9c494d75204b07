"""World and filter of the notebook: laws, and against those that share nothing with them."""

import numpy as np
import pytest
from scipy import stats

from data_synth.monobot import planned_path, simulate_rail
from robot_perception.beliefs import Gaussian
from robot_perception.book import monobot as book
from robot_perception.book.monobot import FIG3, FIG4, GOLDEN
from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.slam.monobot import Reference, run_filter, run_referenced
from studies import intervals

RUNS = 400
RNG = np.random.default_rng
FIGURES = pytest.mark.parametrize("noises", [FIG3, FIG4], ids=["fig3", "fig4"])


def ride(seed=0, runs=RUNS, **setting):
    return book.ride(book.monobot(**setting), runs, RNG(seed))


def noises_on(plan, landmarks, *, start_deviation, motion_deviation, motion_share=0.0,
              measurement_deviation, measurement_share=0.0):  # fmt: skip
    """Return the belief in the start, and the deviations of each move and of each measurement."""
    moves = motion_deviation + motion_share * np.abs(np.diff(plan))
    looks = measurement_deviation + measurement_share * np.abs(1.0 - plan)
    start = Gaussian(np.array([-1.0]), np.array([[start_deviation**2]]))
    return start, moves, np.tile(looks[:, None], landmarks)


def by_the_library(runs, seed, *, landmarks=1, shape="sine", steps=100, reach=1.0, **noises):
    """Return a drive of `data_synth.monobot`, and what the filter of `slam.monobot` makes of it."""
    plan = planned_path(shape, steps, start=-1.0, reach=reach)
    start, moves, looks = noises_on(plan, landmarks, **noises)
    world = simulate_rail(
        plan,
        np.full(landmarks, 1.0),
        runs,
        start_deviation=noises["start_deviation"],
        motion_deviation=moves,
        measurement_deviation=looks,
        rng=RNG(seed),
    )
    given = start, world.commands, world.measurements
    return world, run_filter(*given, motion_variance=moves**2, measurement_variance=looks**2)


@FIGURES
@pytest.mark.parametrize("changes", [{}, {"landmarks": 3, "shape": "at rest", "steps": 7}])
def test_world_is_that_of_the_simulation_and_filter_that_of_the_library(noises, changes):
    setting = noises | changes
    world, other = by_the_library(5, 3, **setting)
    found = ride(3, 5, **setting)
    theirs = {
        "positions": world.positions,
        "measurements": world.measurements,
        "means": other.means,
        "landmark_errors": other.means[..., 1:] - world.landmarks,
        "vehicle_errors": other.means[..., 0] - world.positions,
        "deviations": other.deviations[0],
        "gains": other.gains[0, :, :2, -setting.get("landmarks", 1)],
    }
    for name, expected in theirs.items():
        np.testing.assert_allclose(getattr(found, name), expected, atol=1e-12, err_msg=name)
    assert found.landmarks_at == 1.0


@FIGURES
def test_anchor_is_that_of_the_library(noises):
    """By the covariances, which need no draws."""
    noises = {key: value for key, value in noises.items() if key != "reach"}
    start, moves, looks = noises_on(planned_path("sine", 100, start=-1.0, reach=1.0), 2, **noises)
    anchor = Reference(-1, np.zeros((1, 100)), looks[1:, 0] ** 2, 0.0)
    given = start, np.zeros(100), np.zeros((1, 101, 2)), anchor
    other = run_referenced(*given, motion_variance=moves**2, measurement_variance=looks**2)
    found = book.stated(book.monobot(2, anchor=True, **noises))
    np.testing.assert_allclose(found.P, other.covs[0], atol=1e-12)
    np.testing.assert_allclose(found.K, other.gains[0], atol=1e-12)
    np.testing.assert_allclose(found.S, other.innovation_covs[0], atol=1e-12)


@FIGURES
@pytest.mark.parametrize("landmarks", [1, 3])
@pytest.mark.parametrize("anchor", [False, True])
def test_errors_are_as_large_as_the_filter_says(noises, landmarks, anchor):
    found = ride(landmarks=landmarks, anchor=anchor, **noises)
    errors = np.concatenate([found.vehicle_errors[..., None], found.landmark_errors], axis=-1)
    low, high = average_bounds(landmarks + 1, RUNS, 1 - 1e-4)
    for step in (0, 1, 7, 100):
        # whitened by the square root, as the covariance of many measurements is close to singular
        nees = normalised_squared(errors[:, step], found.P[step])
        assert low < nees.mean() < high, f"step {step}"


@FIGURES
def test_innovations_are_white_and_of_the_stated_size(noises):
    _, found = by_the_library(RUNS, 0, landmarks=2, **noises)
    S = found.innovation_covs[0]
    nis = normalised_squared(found.innovations, S)
    low, high = average_bounds(2, RUNS * 100, 1 - 1e-4)
    assert low < nis.mean() < high
    roots = np.linalg.inv(np.linalg.cholesky(S))
    white = np.einsum("kij,rkj->kri", roots, found.innovations)
    for lag in (1, 2, 5):
        correlation = np.mean(white[lag:] * white[:-lag])
        assert abs(correlation) < 4 / np.sqrt(white[lag:].size)


@pytest.mark.parametrize("landmarks", [1, 20])
def test_limit_of_the_error_has_the_closed_form_variance(landmarks):
    common = ride(runs=2000, landmarks=landmarks, steps=60).landmark_errors[:, -1].mean(axis=1)
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], 2000) / 2000
    assert low < np.mean(common**2) / book.limit(landmarks).landmark_variance < high


def test_share_explained_by_the_first_measurement_is_the_ratio_of_variances():
    """Estimates later in time differ from the first by what is orthogonal to the last error."""
    errors = ride(runs=4000, steps=40).landmark_errors[..., 0]
    share = intervals.explained(errors[:, 0], errors[:, -1])
    assert share.low < GOLDEN / 2 < share.high


def test_first_error_is_all_of_the_last_if_only_the_start_is_unknown_to_the_map():
    errors = ride(runs=50, first_measurement_factor=0.0, **FIG4).landmark_errors[..., 0]
    assert intervals.explained(errors[:, 0], errors[:, -1]).estimate == pytest.approx(1)


@pytest.mark.parametrize("changes", [{"start_deviation": 0.0}, {"landmarks": 5}, {"reach": 2.0}])
def test_a_share_by_covariance_is_the_squared_correlation_of_many_runs(changes):
    found = ride(9, 4000, **FIG4 | changes)
    measured = intervals.explained(*found.landmark_errors[:, [0, -1]].mean(axis=2).T)
    before, after = found.P[[0, -1], 1:, 1:].mean(axis=(1, 2))
    assert measured.low - 0.02 < after / before < measured.high + 0.02


def test_same_seed_same_result_and_a_run_does_not_depend_on_its_number():
    few, again, many = (ride(3, runs, **FIG4) for runs in (4, 4, 60))
    np.testing.assert_array_equal(few.means, again.means)
    np.testing.assert_allclose(few.means, many.means[:4], atol=1e-12)
    assert not np.allclose(ride(4, 4, **FIG4).means, few.means)


def test_noises_are_what_the_captions_print():
    three, four = book.monobot(**FIG3), book.monobot(**FIG4)
    assert three.P0 == 1
    np.testing.assert_array_equal(three.V, np.ones(100))
    np.testing.assert_array_equal(three.W, np.ones((101, 1)))
    assert (four.path[0], len(four.u)) == (-1.0, 100)
    assert four.path[-1] == pytest.approx(-1.0)
    np.testing.assert_allclose(np.sqrt(four.V) / np.abs(four.u), FIG4["motion_share"])
    distance = np.abs(1.0 - four.path)
    np.testing.assert_allclose(np.sqrt(four.W[:, 0]) / distance, FIG4["measurement_share"])


@FIGURES
def test_an_anchor_leaves_less_than_half_of_the_error(noises):
    tied, plain = (
        book.stated(book.monobot(2, anchor=anchor, **noises)) for anchor in (True, False)
    )
    assert tied.deviations[-1, 1] < 0.5 * plain.deviations[-1, 1]


# What is known --------------------------------------------------------------------------------


def test_likelihood_is_level_along_a_shift_and_curved_across():
    robot, places = book.monobot(**FIG3), np.linspace(-3, 3, 25)
    _, z = book.drive(robot, 1, RNG(1))
    values = book.log_likelihood(robot, z[0], places, places)
    assert values.max() == 0
    for offset in (-5, 0, 9):
        assert np.ptp(np.diagonal(values, offset)) < 1e-9
    # across: the information on the distance at the start, with the first measurement's own 1/W
    curvature = np.diff(values[12], 2) / np.diff(places)[0] ** 2
    np.testing.assert_allclose(curvature, -GOLDEN, rtol=1e-6)


@FIGURES
def test_measurements_and_the_start_together_know_what_the_filter_knows(noises):
    """With a prior on the start the information is the inverse of the filter's covariance."""
    robot = book.monobot(2, 20, **noises | {"start_deviation": 300.0})
    known = book.information(robot)
    gap = np.linalg.inv(book.stated(robot).P) - known
    assert np.abs(gap).max() < 1e-4 * np.abs(known).max()


def test_information_for_one_landmark_is_that_of_neighbouring_fibonacci_numbers():
    known = book.information(book.monobot(**FIG3))[:, 0, 0]
    fibonacci = [1, 1]
    for _ in range(14):
        fibonacci.append(fibonacci[-2] + fibonacci[-1])
    ratios = np.divide(fibonacci[1:], fibonacci[:-1])
    np.testing.assert_allclose(known[:8], ratios[::2])
    assert known[-1] == pytest.approx(GOLDEN)


@FIGURES
@pytest.mark.parametrize("n", [1, 2, 5])
def test_own_gain_is_what_tells_a_landmark_from_the_others(noises, n):
    """Equal landmarks: every gain is one number on the diagonal and another beside it."""
    K = book.stated(book.monobot(n, 20, **noises)).K
    gains = K[:, 1:]
    beside = gains[:, 0, -1] if n > 1 else 0.0
    diagonal = gains[:, 0, 0] - beside
    common, own = book.parts(K)
    np.testing.assert_allclose(common, diagonal + n * beside, atol=1e-12 * gains.max())
    np.testing.assert_allclose(own, (1 - 1 / n) * diagonal, atol=1e-12 * gains.max())


def test_true_covariance_of_a_shared_error_is_that_of_many_runs():
    robot = book.monobot(3, 12, **FIG3)
    r, z = book.drive(robot, 4000, RNG(2))
    found = book.filtered(robot, np.repeat(z[..., :1], 3, axis=-1))
    errors = np.concatenate([found.means[:, -1, :1] - r[:, -1:], found.means[:, -1, 1:] - 1], 1)
    exact = book.with_one_error(robot, found.K)
    np.testing.assert_allclose(np.cov(errors.T), exact, atol=0.1 * exact.max())


def test_start_stands_alone_before_the_first_measurement():
    """What a belief without cross-covariance forgets, and nothing else."""
    start = Gaussian(np.array([-1.0]), np.array([[0.01]]))
    right = book.first_measurement(start, np.array([2.0]), np.array([0.04]))
    wrong = book.forgetful(start, np.array([2.0]), np.array([0.04]))
    np.testing.assert_array_equal(wrong.mean, right.mean)
    np.testing.assert_array_equal(wrong.cov, np.diag(np.diag(right.cov)))
