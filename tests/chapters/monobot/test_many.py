"""What many landmarks buy."""

from dataclasses import replace

import numpy as np
from scipy import stats

from robot_perception.chapters.monobot import many
from robot_perception.chapters.monobot.rail import FIG3

RUNS = 400


def test_error_of_one_falls_to_the_floor_while_the_sum_grows():
    against = many.run(replace(FIG3, runs=RUNS), rng=np.random.default_rng(6))
    assert np.all(np.diff(against.expected) < 0)
    assert np.all(against.expected > against.floor)
    assert np.all(np.diff(against.total) > 0)
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], RUNS) / RUNS)
    # landmarks of one run share their error, so a run counts once, not n times
    assert np.all(low < against.measured / against.expected)
    assert np.all(against.measured / against.expected < high)
