"""Worlds against filter: the world is written without the filter's equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from robot_perception.chapters.monobot import rail, steady
from robot_perception.chapters.monobot.rail import FIG3, FIG4, GOLDEN
from robot_perception.evaluation.consistency import average_bounds, normalised_squared

RUNS = 400
RNG = np.random.default_rng


def study(base, seed=0, **changes):
    return rail.run(replace(base, **({"runs": RUNS} | changes)), rng=RNG(seed))


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
@pytest.mark.parametrize("landmarks", [1, 3])
@pytest.mark.parametrize("reference", ["none", "anchor"])
def test_errors_are_as_large_as_the_filter_says(base, landmarks, reference):
    result = study(base, landmarks=landmarks, reference=reference)
    errors = np.concatenate([result.vehicle_errors[..., None], result.landmark_errors], axis=-1)
    low, high = average_bounds(landmarks + 1, RUNS, 1 - 1e-4)
    for step in (0, 1, 7, 100):
        # whitened by the square root, as the covariance of many measurements is close to singular
        nees = normalised_squared(errors[:, step], result.filtered.covs[0, step])
        assert low < nees.mean() < high, f"step {step}"


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
@pytest.mark.parametrize("reference", ["none", "anchor"])
def test_innovations_are_white_and_of_the_stated_size(base, reference):
    result = study(base, landmarks=2, reference=reference)
    S = result.filtered.innovation_covs[0]
    nis = normalised_squared(result.filtered.innovations, S)
    low, high = average_bounds(S.shape[-1], RUNS * base.steps, 1 - 1e-4)
    assert low < nis.mean() < high
    white = np.stack(
        [
            z @ np.linalg.inv(np.linalg.cholesky(s)).T
            for z, s in zip(result.filtered.innovations.transpose(1, 0, 2), S, strict=True)
        ]
    )
    for lag in (1, 2, 5):
        correlation = np.mean(white[lag:] * white[:-lag])
        assert abs(correlation) < 4 / np.sqrt(white[lag:].size)


@pytest.mark.parametrize("landmarks", [1, 20])
def test_limit_of_the_error_has_the_closed_form_variance(landmarks):
    result = study(FIG3, landmarks=landmarks, steps=60, runs=2000)
    form = rail.limit(landmarks)
    common = result.last_errors.mean(axis=1)
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], 2000) / 2000
    assert low < np.mean(common**2) / form.landmark_variance < high


@pytest.mark.parametrize("landmarks", [1, 5])
def test_information_grows_in_the_end_at_the_rate_of_the_closed_form(landmarks):
    total = rail.total_information(replace(FIG3, landmarks=landmarks))[:, 0, 0]
    assert total[-1] - total[-2] == pytest.approx(rail.limit(landmarks).information_rate, rel=1e-9)


def test_share_explained_by_the_first_measurement_is_the_ratio_of_variances():
    """Estimates later in time differ from the first by what is orthogonal to the last error."""
    share = steady.ends(study(FIG3, steps=40, runs=4000)).explained
    assert share.low < GOLDEN / 2 < share.high


def test_same_seed_same_result_and_a_run_does_not_depend_on_its_number():
    few, again, many = (study(FIG4, seed=3, runs=n) for n in (4, 4, 60))
    np.testing.assert_array_equal(few.filtered.means, again.filtered.means)
    np.testing.assert_allclose(few.filtered.means, many.filtered.means[:4], atol=1e-12)
    assert not np.allclose(study(FIG4, seed=4, runs=4).last_errors, few.last_errors)


def test_configurations_hold_what_the_captions_print():
    assert FIG3.start_deviation == FIG3.motion_deviation == FIG3.measurement_deviation == 1.0
    np.testing.assert_array_equal(FIG3.motion_deviations, np.ones(100))
    assert (FIG4.start, FIG4.landmarks_at, FIG4.steps) == (-1.0, 1.0, 100)
    assert FIG4.plan[0] == -1.0
    assert FIG4.plan[-1] == pytest.approx(-1.0)
    commands, distances = np.diff(FIG4.plan), 1.0 - FIG4.plan
    np.testing.assert_allclose(FIG4.motion_deviations / np.abs(commands), FIG4.motion_share)
    np.testing.assert_allclose(
        FIG4.measurement_deviations[:, 0] / distances, FIG4.measurement_share
    )


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
def test_an_anchor_leaves_less_than_half_of_the_error(base):
    tied, plain = (study(base, landmarks=2, reference=name) for name in ("anchor", "none"))
    assert tied.deviations[-1, 1] < 0.5 * plain.deviations[-1, 1]
