"""The filter broken on purpose: what each mistake costs, against the laws of the right one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from robot_perception.chapters.monobot import broken, rail
from robot_perception.chapters.monobot.rail import FIG4
from robot_perception.evaluation.consistency import average_bounds

RUNS = 1000
RNG = np.random.default_rng


@pytest.fixture(scope="module")
def variants():
    return broken.run(replace(FIG4, runs=RUNS), rng=RNG(8))


def test_right_variant_is_the_library(variants):
    config = replace(FIG4, runs=RUNS)
    world = rail.simulate(config, rng=RNG(8))
    ours = rail.refilter(config, world)
    np.testing.assert_allclose(variants[0].errors, ours.means[..., 1] - 1.0, atol=1e-12)
    np.testing.assert_allclose(variants[0].deviations, ours.deviations[0, :, 1], atol=1e-12)


def test_too_small_a_start_changes_no_estimate_and_is_dishonest(variants):
    right, small = variants[0], variants[1]
    np.testing.assert_allclose(small.errors, right.errors, atol=1e-12)
    lost = right.deviations**2 - small.deviations**2
    np.testing.assert_allclose(lost, 0.99 * FIG4.start_deviation**2, rtol=1e-9)
    assert small.nees[-1] > average_bounds(1, RUNS, 1 - 1e-6)[1]


def test_early_update_is_biased(variants):
    right, late = variants[0].errors[:, -1], variants[2].errors[:, -1]
    assert abs(right.mean()) < 4 * stats.sem(right)
    assert abs(late.mean()) > 6 * stats.sem(late)


def test_forgotten_cross_covariance_is_dishonest(variants):
    low, high = average_bounds(1, RUNS, 1 - 1e-6)
    assert low < variants[0].nees[-1] < high
    assert variants[3].nees[-1] > high
    np.testing.assert_array_equal(variants[3].errors[:, 0], variants[0].errors[:, 0])
    np.testing.assert_allclose(variants[3].deviations[0], variants[0].deviations[0])


def test_known_landmark_repairs(variants):
    low, high = average_bounds(1, RUNS, 1 - 1e-6)
    known = variants[4]
    assert low < known.nees[-1] < high
    assert known.deviations[-1] < 0.15 * variants[0].deviations[-1]
    assert np.all(np.diff(known.deviations) < 0)


def test_table_has_the_errors_after_the_last_measurement(variants):
    shown = broken.table(variants)
    assert list(shown.rows) == [v.name for v in variants]
    for v in variants:
        assert shown[v.name, "mean (m)"] == pytest.approx(v.errors[:, -1].mean())
        assert shown[v.name, "rms (m)"] ** 2 == pytest.approx(np.mean(v.errors[:, -1] ** 2))
        assert shown[v.name, "states (m)"] == v.deviations[-1]
