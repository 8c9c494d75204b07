"""Many landmarks: what they buy, and the two statements of the paper about it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import COUNTS, FIG3, PAPER, Config
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.evaluation.sweep import sweep
from robot_perception.slam.monobot import sensor_matrix
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

Errors = Float[np.ndarray, "kinds runs"]
STARTS = (0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 3.0)
"""Uncertainties of the start at which the claims are computed, m; Fig. 3 has 1 m."""
PROPORTIONAL = Accepted(
    0.9,
    1.1,
    "proportional means exponent 1; 0.1 to either side for the share of the vehicle, which does "
    "not grow",
    "our choice",
)
MANY = 20
"""So many landmarks count as many where the paper's sentence is tried on many alone."""
QUICK_COUNTS = (10, 20, 50, 100)
ONE, MAP, SUM = "error of one landmark", "error of the map, as a vector", "sum of squared errors"
READINGS: dict[str, Callable[[np.ndarray], float]] = {
    ONE: lambda cov: np.sqrt(cov[1, 1]),
    MAP: lambda cov: np.sqrt(np.trace(cov[1:, 1:])),
    SUM: np.trace,
}
"""What "expected error in state estimation" can mean, as functions of the last covariance."""


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Errors at the end against the number of landmarks.

    Root mean square error of one landmark over all runs, and as expected by the filter's
    covariance, m; expected sum of squared errors over the whole state, m²; and what no number of
    landmarks removes, the deviation of the start, m.
    """

    counts: np.ndarray
    measured: Float[np.ndarray, "counts"]
    expected: Float[np.ndarray, "counts"]
    total: Float[np.ndarray, "counts"]
    floor: float


def run(base: Config, counts: tuple[int, ...] = COUNTS, *, rng: np.random.Generator) -> Result:
    """Run a study once for each number of landmarks."""
    ends = sweep(partial(_end, base), counts, rng=rng, desc="numbers of landmarks")
    return Result(np.array(counts), *np.array(ends).T, base.start_deviation)


def _end(base: Config, landmarks: int, *, rng: np.random.Generator) -> tuple[float, ...]:
    result = rail.run(replace(base, landmarks=landmarks), rng=rng)
    cov = result.filtered.covs[0, -1]
    return np.sqrt(np.mean(result.last_errors**2)), np.sqrt(cov[1, 1]), np.trace(cov)


@dataclass(frozen=True, slots=True)
class Setting:
    """Runs with one landmark and with fifty at P0 = V = W = 1 m².

    Where the error is ``shared``, all measurements of a step have that of the first, and the
    filter does not know.
    """

    runs: int
    shared: bool = False


def few_and_many(setting: Setting, *, rng: np.random.Generator) -> tuple[Setting, Errors]:
    """Return the last errors with one landmark and with fifty, and the latter's at the start, m."""
    base = replace(FIG3, runs=setting.runs)
    few, many = rail.run(base, rng=rng), rail.run(replace(base, landmarks=50), rng=rng)
    if setting.shared:
        same = np.repeat(many.world.measurements[..., :1], 50, axis=-1)
        world = replace(many.world, measurements=same)
        many = replace(many, world=world, filtered=rail.refilter(many.config, world))
    start = base.start - many.world.positions[:, 0]
    return setting, np.stack([few.last_errors[:, 0], many.last_errors[:, 0], start])


fifty = Study(few_and_many, full=Setting(10_000), quick=Setting(2_000), seed=6)


@fifty.claim(
    "many-landmarks-help",
    paper=PAPER,
    place="§2.2, text to Fig. 4",
    basis="paper",
    statement="The steady-state error is less sensitive to the initial conditions when many "
    "landmarks are used.",
    paper_value="less sensitive",
    method="Variance of one landmark's last error with 50 landmarks over that with one, at "
    "P0 = V = W = 1 m², by the filter's covariance; the same over simulated runs, and at other "
    "uncertainties σ0 of the start.",
    accepted=Accepted(0, 1, "less means a ratio below 1"),
    sabotage=Change("one error that all measurements of a step share", shared=True),
)
def many_landmarks_help(result: tuple[Setting, Errors]) -> Finding:
    """Compare the last errors of one and of fifty landmarks, and with the vehicle's own start."""
    setting, (few, many, start) = result
    stays = intervals.slope(start, many)
    ratios = {start: variance_ratio(start, setting.shared) for start in STARTS}
    return Finding(
        exact(ratios[FIG3.start_deviation]),
        {
            "the same, measured": intervals.variance_ratio(many, few),
            "variance of the limit, n = 1 (closed form: φ)": exact(
                rail.limit(1).landmark_variance, "m²"
            ),
            "variance of the limit, n = 50": exact(rail.limit(50).landmark_variance, "m²"),
            "floor P0": exact(FIG3.start_deviation**2, "m²"),
            "share of the vehicle's initial error that stays, n = 50": stays,
        },
        {
            "other starts": Table(
                {f"{start:g}": [ratio] for start, ratio in ratios.items()},
                {"n = 50 over n = 1": "ratio of a landmark's variances after 100 steps"},
                "by the filter's covariance, V = W = 1 m²",
                "σ0 (m)",
            )
        },
        conditions=(
            Condition(
                "initial conditions means the first measurements: the vehicle's own initial error "
                "stays in full, whatever the number of landmarks",
                stays.low > 0.5,
            ),
        ),
        note="The noise of the first measurements averages out over the landmarks, down to the "
        "floor P0. The less certain the start is beside a measurement, the less that helps: at "
        f"σ0 = {STARTS[-1]:g} m the ratio is {ratios[STARTS[-1]]:.2f}.",
    )


def variance_ratio(start: float, shared: bool = False) -> float:
    """Return the variance of a landmark's last error with fifty landmarks over that with one.

    Exact, at V = W = 1 m² with a start known to ``start``, m; where all measurements of a step
    share one error, with the gains of a filter that takes them for independent.
    """
    many = _cov_of_shared_errors(50, start) if shared else _last_cov(50, start)
    return float(many[1, 1] / _last_cov(1, start)[1, 1])


def _cov_of_shared_errors(landmarks: int, start: float) -> Float[np.ndarray, "states states"]:
    config = replace(FIG3, landmarks=landmarks, start_deviation=start)
    H, gains = sensor_matrix(landmarks), rail.covariances(config).gains[0]
    on_landmarks = np.arange(landmarks + 1) > 0
    P = start**2 + np.outer(on_landmarks, on_landmarks) * 1.0  # after the first measurement
    for K in gains:
        P[0, 0] += 1.0
        rest, error = np.eye(landmarks + 1) - K @ H, K.sum(axis=1)
        P = rest @ P @ rest.T + np.outer(error, error)
    return P


@cache
def _last_cov(landmarks: int, start: float) -> Float[np.ndarray, "states states"]:
    """Return the covariance after 100 steps at V = W = 1 m² with a start known to ``start``, m."""
    return rail.covariances(replace(FIG3, landmarks=landmarks, start_deviation=start)).covs[0, -1]


@dataclass(frozen=True, slots=True)
class Growth:
    """Numbers of landmarks, how well the start is known, m, and runs with fifty of them."""

    counts: tuple[int, ...]
    runs: int
    start: float = FIG3.start_deviation


def grow(config: Growth, *, rng: np.random.Generator) -> tuple[Growth, Float[np.ndarray, "runs"]]:
    """Measure the sum of squared errors over the state, m²."""
    base = replace(FIG3, runs=config.runs, landmarks=50, start_deviation=config.start)
    measured = rail.run(base, rng=rng)
    return config, measured.vehicle_errors[:, -1] ** 2 + (measured.last_errors**2).sum(axis=1)


growth = Study(
    grow, full=Growth((*QUICK_COUNTS, 200), 1_000), quick=Growth(QUICK_COUNTS, 300), seed=7
)


@growth.claim(
    "statement-proportional",
    paper=PAPER,
    place="§2.2, introduction",
    basis="mathematics",
    statement="The expected error of the state estimate is proportional to the number of "
    "landmarks.",
    paper_value="proportional",
    method="Exponent of the expected error after 100 steps against n, for n of 10 and more, by the "
    "filter's covariance at P0 = V = W = 1 m². The error in estimating a state is read as the sum "
    "of squares over the state (trace of P); the map as a vector and one landmark stand beside it. "
    "The interval runs over numbers of landmarks, each with the next.",
    accepted=PROPORTIONAL,
    sabotage=Change("a start that is known exactly", start=0.0),
)
def statement_proportional(result: tuple[Growth, Float[np.ndarray, "runs"]]) -> Finding:
    """Fit the growth of three errors, all by the covariance of the same filter."""
    config, squared = result
    counts, start = config.counts, config.start
    by_reading, known = _exponents(counts, start), _exponents(counts, 0.0)
    with_many = _exponents(tuple(n for n in counts if n >= MANY), start)[SUM]
    by_start = {start: _growth(np.trace, counts, start) for start in STARTS}
    totals = {n: float(np.trace(_last_cov(n, start))) for n in (1, 2, *counts)}
    added = [(totals[more] - totals[n]) / (more - n) for n, more in pairwise(counts)]
    return Finding(
        by_reading[SUM],
        {
            f"exponent of the sum of squares, n = {MANY} and more": with_many,
            "sum of squares by the filter, n = 50": exact(totals[50], "m²"),
            "the same, measured": intervals.mean(squared, "m²"),
            "what each further landmark adds to it": Interval(
                float(np.median(added)), min(added), max(added), "m²", f"n = {counts[0]} and more"
            ),
            "what doubling one landmark multiplies it by": exact(totals[2] / totals[1]),
            "what doubling 50 landmarks multiplies it by": exact(totals[100] / totals[50]),
        },
        {
            "readings": Table(
                {
                    name: [power, known[name], _verdict_of(power)]
                    for name, power in by_reading.items()
                },
                {
                    "exponent": "of the error against n, at P0 = V = W = 1 m²",
                    "start known": "the same at P0 = 0",
                    "proportional": "whether the first exponent lies in the accepted range",
                },
                f"by the filter's covariance after 100 steps; fitted over n = {counts[0]} to "
                f"{counts[-1]}, and from the least to the largest between two numbers",
                "error",
            ),
            "other starts": Table(
                {f"{start:g}": [power] for start, power in by_start.items()},
                {"exponent": "of the sum of squares against n"},
                "by the filter's covariance, V = W = 1 m²",
                "σ0 (m)",
            ),
        },
        (
            Condition.judged(
                "the sum of squared errors over the state is meant, and there are many landmarks "
                f"({MANY} or more here): of one landmark the exponent is "
                f"{by_reading[ONE].estimate:.2f}, of the map as a vector "
                f"{by_reading[MAP].estimate:.2f}",
                PROPORTIONAL,
                inside=with_many,
                outside=intervals.largest(by_reading[ONE], by_reading[MAP]),
            ),
            Condition.judged(
                "the start is about as uncertain as a measurement: from a start known exactly the "
                f"exponent of the sum of squares is {known[SUM].estimate:.2f}",
                PROPORTIONAL,
                inside=with_many,
                outside=known[SUM],
            ),
        ),
        note="The paper does not say which error, and the verdict depends on it. The sum of "
        "squares is affine in n: each further landmark adds P0, the start's error that all of them "
        "repeat, to what is there without any. Of one landmark the error falls.",
    )


def _exponents(counts: tuple[int, ...], start: float) -> dict[str, Interval]:
    return {name: _growth(error, counts, start) for name, error in READINGS.items()}


def _verdict_of(power: Interval) -> str:
    if PROPORTIONAL.contains(power):
        return "yes"
    return "no" if PROPORTIONAL.excludes(power) else f"for {MANY} and more"


def _growth(
    error: Callable[[np.ndarray], float], counts: tuple[int, ...], start: float
) -> Interval:
    """Return the exponent of an error, a function of the last covariance, against n."""
    sizes = np.array(counts, dtype=float)
    values = np.array([error(_last_cov(n, start)) for n in counts])
    steps = np.diff(np.log(values)) / np.diff(np.log(sizes))
    fitted = intervals.exponent(sizes, values).estimate
    about = f"fitted over n = {counts[0]} to {counts[-1]}; ends: least and largest between two"
    return Interval(fitted, float(steps.min()), float(steps.max()), about=about)
