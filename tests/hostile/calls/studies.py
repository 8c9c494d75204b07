"""Valid calls of `studies`."""

import numpy as np

from studies import intervals
from studies.sweep import sweep
from tests.hostile.sweep import call

RNG = np.random.default_rng(0)
FIRST, LAST = RNG.uniform(1, 2, 8), RNG.uniform(1, 2, 8)


def double(item: int, rng: np.random.Generator) -> int:
    return 2


CALLS = {
    intervals.Interval: lambda: call(1.0, 0.5, 1.5, "m", "95 %"),
    intervals.Interval.shown: lambda: call(intervals.exact(1.0), 3),
    intervals.Interval.overlaps: lambda: call(intervals.exact(1.0), intervals.exact(2.0)),
    intervals.largest: lambda: call(intervals.exact(1.0), intervals.exact(2.0)),
    intervals.exact: lambda: call(1.0, "m", "exact"),
    intervals.mean: lambda: call(FIRST, "m", 0.9),
    intervals.proportion: lambda: call(3, 10, 0.9),
    intervals.spread: lambda: call(FIRST, "m", 0.9, "range"),
    intervals.bootstrap_mean: lambda: call(FIRST, "m"),
    intervals.bootstrap_median: lambda: call(FIRST, "m"),
    intervals.bootstrap_ratio: lambda: call(FIRST, LAST, "ratio"),
    intervals.correlation: lambda: call(FIRST, LAST),
    intervals.explained: lambda: call(FIRST, LAST),
    intervals.slope: lambda: call(FIRST, LAST, "m"),
    intervals.exponent: lambda: call(FIRST, LAST),
    intervals.variance_ratio: lambda: call(FIRST, LAST),
    intervals.root_mean_square: lambda: call(FIRST, "m"),
    sweep: lambda: call(double, [1, 2], rng=np.random.default_rng(0), desc=""),
}
