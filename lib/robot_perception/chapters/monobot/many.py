"""Many landmarks: what they buy, and the two statements of the paper about it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

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
LESS = 0.9
PROPORTIONAL = (0.9, 1.1)
QUICK_COUNTS = (10, 20, 50, 100)


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
    "P0 = V = W = 1 m²; and by the filter's covariance at other uncertainties σ0 of the start.",
    accepted=Accepted(
        0, LESS, "less means below 1; 0.9 is three standard errors at 2 000 runs", "our choice"
    ),
    seed=6,
)
def many_landmarks_help(size: Size, rng: np.random.Generator) -> Finding:
    """Compare the last errors of one and of fifty landmarks, and with the vehicle's own start."""
    runs = 10_000 if size is Size.FULL else 2_000
    few, many = _one_and_fifty(runs, rng)
    stays = intervals.slope(many.config.start - many.world.positions[:, 0], many.last_errors[:, 0])
    ratios = {start: _expected_ratio(start) for start in STARTS}
    helped = max((start for start, ratio in ratios.items() if ratio <= LESS), default=0.0)
    alike = ratios[STARTS[-1]]
    return Finding(
        _variance_ratio(few, many),
        {
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
                "initial conditions means the first looks: the vehicle's own initial error stays "
                "in full, whatever the number of landmarks",
                stays.low > 0.5,
            ),
            Condition(
                "the start is not much less certain than a look: up to "
                f"σ0 = {helped:g} m beside looks of 1 m; at {STARTS[-1]:g} m the variance with 50 "
                f"landmarks is still {alike:.2f} of that with one",
                alike > LESS,
            ),
        ),
        note="The noise of the first looks averages out over the landmarks, down to the floor P0.",
    )


@many_landmarks_help.sabotage("one error that all looks of a step share")
def shared_look_error(size: Size, rng: np.random.Generator) -> Finding:
    """Give all landmarks the noise of the first, so that nothing averages out over them."""
    few, many = _one_and_fifty(500, rng)
    world = replace(many.world, looks=np.repeat(many.world.looks[..., :1], 50, axis=-1))
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


def _last_cov(landmarks: int, start: float = 1.0) -> Float[np.ndarray, "states states"]:
    """Return the covariance after 100 steps at V = W = 1 m² with a start known to ``start``, m."""
    return rail.covariances(replace(FIG3, landmarks=landmarks, start_deviation=start)).covs[0, -1]


@claim(
    "statement-proportional",
    paper=PAPER,
    place="§2.2, introduction",
    basis="paper",
    statement="The expected error of the state estimate is proportional to the number of "
    "landmarks.",
    paper_value="proportional",
    method="Exponent of the expected sum of squared errors (trace of P after 100 steps) "
    "against n, for n of 10 and more, at P0 = V = W = 1 m², and at other uncertainties σ0 of the "
    "start.",
    accepted=Accepted(
        *PROPORTIONAL, "proportional means exponent 1; 0.1 for the vehicle's share", "our choice"
    ),
    seed=7,
)
def statement_proportional(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the growth of three errors, all by the covariance of the same filter."""
    counts = (*QUICK_COUNTS, 200) if size is Size.FULL else QUICK_COUNTS
    by_start = {start: _growth(np.trace, counts, start) for start in STARTS}
    total = by_start[FIG3.start_deviation]
    grown = (start for start, power in by_start.items() if power.estimate >= PROPORTIONAL[0])
    least = min(grown, default=np.inf)
    below = max(start for start in STARTS if start < least)
    single = _growth(_error_of_one, counts).estimate
    whole = _growth(lambda cov: np.sqrt(np.trace(cov[1:, 1:])), counts)
    runs = 1_000 if size is Size.FULL else 300
    measured = rail.run(replace(FIG3, runs=runs, landmarks=50), rng=rng)
    squared = (measured.vehicle_errors[:, -1] ** 2) + (measured.last_errors**2).sum(axis=1)
    return Finding(
        total,
        {
            "exponent of the error of one landmark": exact(single),
            "exponent of the norm of the map's error": whole,
            "sum of squared errors by the filter, n = 50": exact(np.trace(_last_cov(50)), "m²"),
            "sum of squared errors, measured, n = 50": intervals.mean(squared, "m²"),
        },
        {
            "other starts": Table(
                {f"{start:g}": [power] for start, power in by_start.items()},
                {"exponent": "of the sum of squared errors against n"},
                "by the filter's covariance, V = W = 1 m²",
                "σ0 (m)",
            )
        },
        conditions=(
            Condition(
                "error means the sum of squared errors over the whole state, in which every "
                "landmark repeats the same frozen error; the error of one landmark falls with n, "
                f"with exponent {single:.3f}",
                not PROPORTIONAL[0] <= single <= PROPORTIONAL[1],
            ),
            Condition(
                f"the start is uncertain enough, σ0 of {least:g} m or more beside looks of 1 m: at "
                f"{below:g} m the exponent is {by_start[below].estimate:.2f}, with the start known "
                f"{by_start[0.0].estimate:.2f}. Only the start's error is repeated in full by "
                "every landmark",
                by_start[below].estimate < PROPORTIONAL[0],
            ),
        ),
        note="Both statements of the paper hold, for different errors: more landmarks make each "
        "estimate better and the sum over all of them larger.",
    )


@statement_proportional.sabotage("a start that is known exactly")
def known_start(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the growth of the sum where no error is common to all landmarks from the first."""
    return Finding(_growth(np.trace, QUICK_COUNTS, 0.0))


@statement_proportional.sabotage("the error of one landmark in place of the sum over the state")
def error_of_one(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the growth of the other error."""
    return Finding(_growth(_error_of_one, QUICK_COUNTS))


def _error_of_one(cov: np.ndarray) -> float:
    return float(np.sqrt(cov[1, 1]))


def _growth(
    error: Callable[[np.ndarray], float], counts: tuple[int, ...], start: float = 1.0
) -> Interval:
    """Return the exponent of an error, a function of the last covariance, against n."""
    values = np.array([error(_last_cov(n, start)) for n in counts])
    power = intervals.exponent(np.array(counts, dtype=float), values).estimate
    return exact(power, about=f"exponent over n = {counts[0]} to {counts[-1]}")
