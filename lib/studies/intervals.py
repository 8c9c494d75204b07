"""A measured number with its uncertainty: one way for each kind of measurement, SciPy underneath.

Every interval of the book is made here, so that the same kind of number always carries the same
kind of interval. Bootstrap intervals take percentiles of 4 000 resamples by runs.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import stats

from studies import checks

RESAMPLES = 4000


@dataclass(frozen=True, slots=True)
class Interval:
    """A value with its uncertainty.

    Parameters
    ----------
    estimate, low, high
        The value and the ends of its interval, ``low <= estimate <= high``; equal for a number
        that is exact or deterministic.
    unit
        Unit as printed, empty for a pure number.
    about
        What the interval is, for instance ``"95 % over 100 runs"``.

    Raises
    ------
    ValueError
        If a number is not finite or the order is broken.
    """

    estimate: float
    low: float
    high: float
    unit: str = ""
    about: str = "exact"

    def __post_init__(self) -> None:
        values = (self.estimate, self.low, self.high)
        for name, value in zip(("estimate", "low", "high"), values, strict=True):
            checks.number(f"{name} of an interval", value)
        checks.instance("unit", self.unit, str)
        checks.instance("about", self.about, str)
        if not self.low <= self.estimate <= self.high:
            raise ValueError(f"interval must satisfy low <= estimate <= high, got {values}")

    def overlaps(self, other: "Interval") -> bool:
        """Return whether the two intervals have a number in common."""
        checks.instance("other", other, Interval)
        return self.low <= other.high and other.low <= self.high

    def __str__(self) -> str:
        return f"{self.shown()}{f' {self.unit}' if self.unit else ''}"

    def shown(self, digits: int = 4) -> str:
        """Return the numbers without the unit, with so many significant digits, at most 17."""
        checks.whole("digits", digits, 1, 17)
        if self.low == self.high:
            return f"{self.estimate:.{digits}g}"
        return f"{self.estimate:.{digits}g} [{self.low:.{digits}g}, {self.high:.{digits}g}]"


def exact(value: float, unit: str = "", about: str = "exact") -> Interval:
    """Return the interval of a deterministic number: both ends are the number."""
    value = checks.number("value", value)
    return Interval(value, value, value, unit, about)


def mean(samples: Float[np.ndarray, "..."], unit: str = "", level: float = 0.95) -> Interval:
    r"""Return the mean of independent samples with its Student interval.

    .. math:: \bar x \pm t_{(1+\ell)/2,\,n-1}\, s / \sqrt n

    Raises
    ------
    ValueError
        If there are fewer than two samples, one of them is not finite, or the level is not between
        0 and 1.
    """
    samples = _samples("samples", samples, least=2)
    level = checks.level("level", level)
    ends = samples[:2]  # of samples that are all the same
    if np.ptp(samples) > 0:
        ends = stats.ttest_1samp(samples, 0.0).confidence_interval(level)
    return _between(
        samples.mean(), *ends, unit, f"{level:.0%} of the mean over {samples.size} runs"
    )


def proportion(successes: int, trials: int, level: float = 0.95) -> Interval:
    """Return a proportion with its Wilson interval.

    Raises
    ------
    ValueError
        Unless 0 <= successes <= trials, whole numbers, and there is a trial; or if the level is not
        between 0 and 1.
    """
    checks.whole("trials", trials, 1)
    level = checks.level("level", level)
    if not 0 <= checks.whole("successes", successes) <= trials:
        raise ValueError(f"need 0 <= successes <= trials, got {successes} of {trials}")
    ends = stats.binomtest(int(successes), int(trials)).proportion_ci(level, method="wilson")
    return _between(
        successes / trials, *ends, about=f"{level:.0%} of the rate over {trials} trials"
    )


def spread(
    samples: Float[np.ndarray, "..."], unit: str = "", level: float = 0.95, about: str = ""
) -> Interval:
    """Return the median of samples with the central range that holds ``level`` of them.

    Raises
    ------
    ValueError
        If there is no sample, one of them is not finite, or the level is not between 0 and 1.
    """
    samples = _samples("samples", samples, least=1)
    level = checks.level("level", level)
    checks.instance("about", about, str)
    low, mid, high = np.quantile(samples, [(1 - level) / 2, 0.5, (1 + level) / 2])
    return _between(
        mid, low, high, unit, about or f"median and central {level:.0%} of {samples.size} runs"
    )


def bootstrap_mean(samples: Float[np.ndarray, "..."], unit: str = "") -> Interval:
    """Return a mean over runs with its 95 % bootstrap interval, for values far from normal."""
    return _bootstrap(np.mean, {"samples": samples}, unit, "mean")


def bootstrap_median(samples: Float[np.ndarray, "..."], unit: str = "") -> Interval:
    """Return a median over runs with its 95 % bootstrap interval."""
    return _bootstrap(np.median, {"samples": samples}, unit, "median")


def bootstrap_ratio(
    above: Float[np.ndarray, "..."], below: Float[np.ndarray, "..."], about: str = "ratio"
) -> Interval:
    """Return the ratio of two means over the same runs with its 95 % bootstrap interval.

    Samples of the runs in which ``below`` is 0 everywhere have no ratio; the interval is that of
    the others.

    Raises
    ------
    ValueError
        If the lengths differ, there are fewer than two runs, or a value is not finite.
    """
    if not np.count_nonzero(checks.reals("below", below)):
        raise ValueError("below is 0 in all runs: no ratio")
    return _bootstrap(
        _ratio, {"above": above, "below": below}, "", checks.instance("about", about, str)
    )


def correlation(first: Float[np.ndarray, "..."], last: Float[np.ndarray, "..."]) -> Interval:
    """Return Pearson's correlation over runs with its 95 % interval by Fisher's transformation.

    Raises
    ------
    ValueError
        If there are fewer than four runs, a value is not finite, one of the two is constant, or
        they are not of the same runs.
    """
    first, last = _samples("first", first, least=4), _samples("last", last, least=4)
    if first.size != last.size:
        raise ValueError(f"first and last must be of the same runs, got {first.size}, {last.size}")
    for name, values in (("first", first), ("last", last)):
        if np.ptp(values) == 0:
            raise ValueError(f"{name} is constant at {values[0]:g}: it correlates with nothing")
    found = stats.pearsonr(first, last)
    about = f"95 % over {first.size} runs"
    return _between(found.statistic, *found.confidence_interval(0.95), about=about)


def explained(first: Float[np.ndarray, "..."], last: Float[np.ndarray, "..."]) -> Interval:
    """Return the share of the variance of ``last`` that ``first`` explains, r².

    A correlation whose interval holds zero explains a share from zero upwards.
    """
    r = correlation(first, last)
    ends = sorted((r.low**2, r.high**2))
    return Interval(r.estimate**2, 0.0 if r.low < 0 < r.high else ends[0], ends[1], "", r.about)


def slope(x: Float[np.ndarray, "..."], y: Float[np.ndarray, "..."], unit: str = "") -> Interval:
    """Return the slope of a straight line fitted to y over x with its 95 % interval.

    Raises
    ------
    ValueError
        If there are fewer than three points, not as many x as y, a value is not finite, or all x
        are the same.
    """
    x, y = _samples("x", x, least=3), _samples("y", y, least=3)
    if x.size != y.size or np.ptp(x) == 0:
        raise ValueError(f"need x for each y, not all the same, got {x.size} and {y.size}")
    fit = stats.linregress(x, y)
    half = stats.t.ppf(0.975, x.size - 2) * fit.stderr if np.ptp(y) > 0 else 0.0
    about = f"95 % of the slope over {x.size} points"
    return _between(fit.slope, fit.slope - half, fit.slope + half, unit, about)


def exponent(sizes: Float[np.ndarray, "..."], values: Float[np.ndarray, "..."]) -> Interval:
    """Return the exponent of a power law fitted to values over sizes, with its 95 % interval.

    Raises
    ------
    ValueError
        If there are fewer than three points, or one of the numbers is not positive and finite.
    """
    sizes, values = _samples("sizes", sizes, least=3), _samples("values", values, least=3)
    for name, numbers in (("sizes", sizes), ("values", values)):
        if numbers.min() <= 0:
            raise ValueError(f"{name} of a power law must be positive, got {numbers.min():g}")
    fit = slope(np.log(sizes), np.log(values))
    about = f"95 % of the slope of log cost over log n, n = {sizes[0]:g} to {sizes[-1]:g}"
    return Interval(fit.estimate, fit.low, fit.high, "", about)


def variance_ratio(above: Float[np.ndarray, "..."], below: Float[np.ndarray, "..."]) -> Interval:
    r"""Return the ratio of the variances of two normal samples with its 95 % interval by F.

    Raises
    ------
    ValueError
        If one has fewer than two samples, is not finite, or the lower one does not vary.
    """
    above, below = _samples("above", above, least=2), _samples("below", below, least=2)
    if np.ptp(below) == 0:
        raise ValueError("below does not vary: no ratio")
    ratio = above.var(ddof=1) / below.var(ddof=1)
    low, high = ratio / stats.f.ppf([0.975, 0.025], above.size - 1, below.size - 1)
    about = f"variance ratio, 95 % over {above.size} and {below.size} runs"
    return _between(ratio, low, high, "", about)


def root_mean_square(samples: Float[np.ndarray, "..."], unit: str = "") -> Interval:
    """Return the root mean square of normal samples about zero with its 95 % interval by χ².

    Raises
    ------
    ValueError
        If there is no sample or one of them is not finite.
    """
    samples = _samples("samples", samples, least=1)
    value, n = np.sqrt(np.mean(samples**2)), samples.size
    low, high = value * np.sqrt(n / stats.chi2.ppf([0.975, 0.025], n))
    return _between(value, low, high, unit, f"95 % over {n} runs")


def largest(*intervals: Interval) -> Interval:
    """Return the largest of several values: of estimates, of lower and of upper ends.

    Where each interval holds its value, this one holds the largest of them.

    Raises
    ------
    ValueError
        If there is no interval, or their units differ.
    """
    units = {interval.unit for interval in checks.instances("intervals", intervals, Interval)}
    if len(units) != 1:
        raise ValueError(f"intervals must be of one unit, got {sorted(units)}")
    top = max(intervals, key=lambda interval: interval.estimate)
    low, high = max(i.low for i in intervals), max(i.high for i in intervals)
    return Interval(top.estimate, low, high, top.unit, top.about)


def _ratio(above: np.ndarray, below: np.ndarray, axis: int) -> np.ndarray:
    whole = np.asarray(below.mean(axis=axis))
    return np.divide(
        above.mean(axis=axis), whole, out=np.full(whole.shape, np.nan), where=whole != 0
    )


def _bootstrap(statistic: Callable, named: dict[str, np.ndarray], unit: str, name: str) -> Interval:
    data = tuple(_samples(key, samples, least=2) for key, samples in named.items())
    sizes = {samples.size for samples in data}
    if len(sizes) > 1:
        raise ValueError(
            f"{', '.join(named)} must be of the same runs, got {sorted(sizes)} of them"
        )
    found = stats.bootstrap(
        data,
        statistic,
        paired=len(data) > 1,
        vectorized=True,
        n_resamples=RESAMPLES,
        method="percentile",
        rng=np.random.default_rng(0),
    )
    ends = found.confidence_interval
    if not np.isfinite(ends).all():  # of some samples there is no ratio
        ends = np.nanquantile(found.bootstrap_distribution, (0.025, 0.975))
    about = f"{name}, 95 % bootstrap over {data[0].size} runs"
    return _between(statistic(*data, axis=-1), *ends, unit, about)


def _between(estimate: float, low: float, high: float, unit: str = "", about: str = "") -> Interval:
    """Return an interval whose ends give way to the estimate by rounding."""
    estimate = float(estimate)
    return Interval(estimate, min(float(low), estimate), max(float(high), estimate), unit, about)


def _samples(name: str, samples: np.ndarray, least: int) -> np.ndarray:
    samples = checks.reals(name, samples).ravel()
    if samples.size < least:
        raise ValueError(f"need at least {least} {name}, got {samples.size}")
    return samples
