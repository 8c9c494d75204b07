"""Many landmarks: what they buy, and the two statements of the paper about it."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import COUNTS, FIG3, PAPER, Config
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import exact
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Accepted, Condition, Finding, Size, claim


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
    "P0 = V = W = 1 m².",
    accepted=Accepted(
        0, 0.9, "less means below 1; 0.9 is three standard errors at 2 000 runs", "our choice"
    ),
    seed=6,
)
def many_landmarks_help(size: Size, rng: np.random.Generator) -> Finding:
    """Compare the last errors of one and of fifty landmarks, and with the vehicle's own start."""
    runs = 10_000 if size is Size.FULL else 2_000
    few = rail.run(replace(FIG3, runs=runs), rng=rng)
    many = rail.run(replace(FIG3, runs=runs, landmarks=50), rng=rng)
    last = many.last_errors[:, 0]
    stays = intervals.slope(many.config.start - many.world.positions[:, 0], last)
    return Finding(
        intervals.variance_ratio(last, few.last_errors[:, 0]),
        {
            "variance of the limit, n = 1 (closed form: φ)": exact(
                rail.limit(1).landmark_variance, "m²"
            ),
            "variance of the limit, n = 50": exact(rail.limit(50).landmark_variance, "m²"),
            "floor P0": exact(FIG3.start_deviation**2, "m²"),
            "share of the vehicle's initial error that stays, n = 50": stays,
        },
        conditions=(
            Condition(
                "initial conditions means the first looks: the vehicle's own initial error stays "
                "in full, whatever the number of landmarks",
                stays.low > 0.5,
            ),
        ),
        note="The noise of the first looks averages out over the landmarks, down to the floor P0.",
    )


@claim(
    "statement-proportional",
    paper=PAPER,
    place="§2.2, introduction",
    basis="paper",
    statement="The expected error of the state estimate is proportional to the number of "
    "landmarks.",
    paper_value="proportional",
    method="Exponent of the expected sum of squared errors (trace of P after 100 steps) "
    "against n, for n of 10 and more, at P0 = V = W = 1 m².",
    accepted=Accepted(
        0.9, 1.1, "proportional means exponent 1; 0.1 for the vehicle's share", "our choice"
    ),
    seed=7,
)
def statement_proportional(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the growth of three errors, all by the covariance of the same filter."""
    counts = (10, 20, 50, 100, 200) if size is Size.FULL else (10, 20, 50, 100)
    ends = [rail.covariances(replace(FIG3, landmarks=n)).covs[0, -1] for n in counts]
    total, single, whole = (
        intervals.exponent(np.array(counts, float), np.array(values)).estimate
        for values in (
            [np.trace(cov) for cov in ends],
            [np.sqrt(cov[1, 1]) for cov in ends],
            [np.sqrt(np.trace(cov[1:, 1:])) for cov in ends],
        )
    )
    runs = 1_000 if size is Size.FULL else 300
    measured = rail.run(replace(FIG3, runs=runs, landmarks=50), rng=rng)
    squared = (measured.vehicle_errors[:, -1] ** 2) + (measured.last_errors**2).sum(axis=1)
    return Finding(
        exact(total, about=f"exponent over n = {counts[0]} to {counts[-1]}"),
        {
            "exponent of the error of one landmark": exact(single),
            "exponent of the norm of the map's error": exact(whole),
            "sum of squared errors by the filter, n = 50": exact(
                np.trace(ends[counts.index(50)]), "m²"
            ),
            "sum of squared errors, measured, n = 50": intervals.mean(squared, "m²"),
        },
        conditions=(
            Condition(
                "error means the sum of squared errors over the whole state, in which every "
                "landmark repeats the same frozen error; the error of one landmark falls with n, "
                f"with exponent {single:.3f}",
                not 0.9 <= single <= 1.1,
            ),
        ),
        note="Both statements of the paper hold, for different errors: more landmarks make each "
        "estimate better and the sum over all of them larger.",
    )
