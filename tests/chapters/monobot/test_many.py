"""What many landmarks buy."""

from dataclasses import replace

import numpy as np
from scipy import stats

from robot_perception.chapters.monobot import many, rail
from robot_perception.chapters.monobot.rail import FIG3

RUNS = 400


def test_expected_errors_are_those_of_the_covariances_after_the_last_measurement():
    base = replace(FIG3, runs=2, steps=9, start_deviation=0.5)
    found = many.run(base, (1, 4), rng=np.random.default_rng(0))
    assert found.floor == 0.5
    for n, one, total in zip(found.counts.tolist(), found.expected, found.total, strict=True):
        cov = rail.covariances(replace(base, landmarks=n)).covs[0, -1]
        np.testing.assert_allclose([one**2, total], [cov[1, 1], np.trace(cov)])


def test_error_of_one_falls_to_the_floor_while_the_sum_grows():
    against = many.run(replace(FIG3, runs=RUNS), rng=np.random.default_rng(6))
    assert np.all(np.diff(against.expected) < 0)
    assert np.all(against.expected > against.floor)
    assert np.all(np.diff(against.total) > 0)
    assert np.all(np.diff(against.total) / np.diff(against.counts) < 1.03)
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], RUNS) / RUNS)
    # landmarks of one run share their error, so a run counts once, not n times
    assert np.all(low < against.measured / against.expected)
    assert np.all(against.measured / against.expected < high)
