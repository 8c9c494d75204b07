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
from robot_perception.teaching.claims import Accepted, Condition, Finding, Size, claim
from robot_perception.teaching.tables import Table

STARTS = (0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 3.0)
"""Uncertainties of the start at which the claims are computed, m; Fig. 3 has 1 m."""
PROPORTIONAL = (0.9, 1.1)
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

    Parameters
    ----------
    measured, expected
        Root mean square error of one landmark over all runs, and by the filter's covariance, m.
    total
        Expected sum of squared errors over the whole state (trace of the covariance), m².
    floor
        What no number of landmarks removes: the deviation of the start, m.
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


@claim(
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
    seed=6,
)
def many_landmarks_help(size: Size, rng: np.random.Generator) -> Finding:
    """Compare the last errors of one and of fifty landmarks, and with the vehicle's own start."""
    runs = 10_000 if size is Size.FULL else 2_000
    few, many = _one_and_fifty(runs, rng)
    stays = intervals.slope(many.config.start - many.world.positions[:, 0], many.last_errors[:, 0])
    ratios = {start: _expected_ratio(start) for start in STARTS}
    return Finding(
        exact(ratios[FIG3.start_deviation]),
        {
            "the same, measured": _variance_ratio(few, many),
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


@many_landmarks_help.sabotage("one error that all measurements of a step share")
def shared_measurement_error(size: Size, rng: np.random.Generator) -> Finding:
    """Give all landmarks the noise of the first, so that nothing averages out over them."""
    few, many = _one_and_fifty(2_000, rng)
    world = replace(
        many.world, measurements=np.repeat(many.world.measurements[..., :1], 50, axis=-1)
    )
    return Finding(
        _variance_ratio(few, replace(many, world=world, filtered=rail.refilter(many.config, world)))
    )


def _one_and_fifty(runs: int, rng: np.random.Generator) -> tuple[rail.Result, rail.Result]:
    base = replace(FIG3, runs=runs)
    return rail.run(base, rng=rng), rail.run(replace(base, landmarks=50), rng=rng)


def _variance_ratio(few: rail.Result, many: rail.Result) -> Interval:
    return intervals.variance_ratio(many.last_errors[:, 0], few.last_errors[:, 0])


def _expected_ratio(start: float) -> float:
    few, many = (_last_cov(n, start)[1, 1] for n in (1, 50))
    return float(many / few)


@cache
def _last_cov(landmarks: int, start: float = 1.0) -> Float[np.ndarray, "states states"]:
    """Return the covariance after 100 steps at V = W = 1 m² with a start known to ``start``, m."""
    return rail.covariances(replace(FIG3, landmarks=landmarks, start_deviation=start)).covs[0, -1]


@claim(
    "statement-proportional",
    paper=PAPER,
    place="§2.2, introduction",
    basis="mathematics",
    statement="The expected error of the state estimate is proportional to the number of "
    "landmarks.",
    paper_value="proportional",
    method="Exponent of the expected error after 100 steps against n, for n of 10 and more, by the "
    "filter's covariance at P0 = V = W = 1 m², for each error that the sentence can mean: of one "
    "landmark, of the map as a vector, and the sum of squares over the state (trace of P).",
    accepted=Accepted(
        *PROPORTIONAL,
        "proportional means exponent 1; 0.1 to either side for the share of the vehicle, which "
        "does not grow",
        "our choice",
    ),
    seed=7,
)
def statement_proportional(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the growth of three errors, all by the covariance of the same filter."""
    counts = (*QUICK_COUNTS, 200) if size is Size.FULL else QUICK_COUNTS
    by_reading = _exponents(counts)
    by_start = {start: _growth(np.trace, counts, start) for start in STARTS}
    known = _exponents(counts, 0.0)
    totals = {n: float(np.trace(_last_cov(n))) for n in (1, 2, *counts)}
    added = [(totals[more] - totals[n]) / (more - n) for n, more in pairwise(counts)]
    runs = 1_000 if size is Size.FULL else 300
    measured = rail.run(replace(FIG3, runs=runs, landmarks=50), rng=rng)
    squared = (measured.vehicle_errors[:, -1] ** 2) + (measured.last_errors**2).sum(axis=1)
    return Finding(
        _over_readings(by_reading, counts),
        {
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
                "by the filter's covariance after 100 steps",
                "error",
            ),
            "other starts": Table(
                {f"{start:g}": [power] for start, power in by_start.items()},
                {"exponent": "of the sum of squares against n"},
                "by the filter's covariance, V = W = 1 m²",
                "σ0 (m)",
            ),
        },
        note="The paper does not say which error, and the verdict hangs on it. The sum of squares "
        "is affine in n: each further landmark adds P0, the start's error that all of them repeat, "
        f"to what is there without any. Of one landmark the error falls, with exponent "
        f"{by_reading[ONE]:.3f}.",
    )


@statement_proportional.sabotage("a start that is known exactly")
def known_start(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the growth where no error is common to all landmarks from the first."""
    return Finding(_over_readings(_exponents(QUICK_COUNTS, 0.0), QUICK_COUNTS))


def _exponents(counts: tuple[int, ...], start: float = 1.0) -> dict[str, float]:
    return {name: _growth(error, counts, start) for name, error in READINGS.items()}


def _over_readings(exponents: dict[str, float], counts: tuple[int, ...]) -> Interval:
    """Return the exponent of the sum of squares between the least and the largest of all."""
    about = f"sum of squares; ends: least and largest of three readings, n = {counts[0]} to "
    ends = min(exponents.values()), max(exponents.values())
    return Interval(exponents[SUM], *ends, about=f"{about}{counts[-1]}")


def _verdict_of(power: float) -> str:
    low, high = PROPORTIONAL
    return "yes" if low <= power <= high else "no"


def _growth(
    error: Callable[[np.ndarray], float], counts: tuple[int, ...], start: float = 1.0
) -> float:
    """Return the exponent of an error, a function of the last covariance, against n."""
    values = np.array([error(_last_cov(n, start)) for n in counts])
    return intervals.exponent(np.array(counts, dtype=float), values).estimate
