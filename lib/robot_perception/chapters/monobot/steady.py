"""The steady state of Fig. 4: the gain dies out, the error stays, the ensemble is right."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import DECIMALS, FIG3, FIG4, GOLDEN, PAPER, Config
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import exact
from robot_perception.kalman import steady_state
from robot_perception.slam.monobot import relative_system
from robot_perception.teaching.claims import Accepted, Condition, Finding, Size, claim
from robot_perception.teaching.tables import Table


@dataclass(frozen=True, eq=False, slots=True)
class Gains:
    """Gains of a landmark: on all innovations moving together, and what is left for its own."""

    common: Float[np.ndarray, "steps"]
    own: Float[np.ndarray, "steps"]


def gain_curves(counts: tuple[int, ...], base: Config) -> dict[int, Gains]:
    """Return the gains of the first landmark by number of landmarks."""
    curves = {}
    for n in counts:
        gains = rail.covariances(replace(base, landmarks=n)).gains[0, :, 1]
        common = gains.sum(axis=1)
        curves[n] = Gains(common, gains[:, 0] - common / n)
    return curves


@claim(
    "gain-vanishes",
    paper=PAPER,
    place="§2.2, Fig. 4",
    basis="mathematics",
    statement="The Kalman gain of the landmark goes to zero, at the rate of the system's time "
    "constant.",
    paper_value="Fig. 4, last column",
    method="Factor per step by which the gain shrinks at P0 = V = W = 1 m² and n = 1, fitted, "
    "against the closed-loop pole of the Riccati solution.",
    accepted=Accepted(
        GOLDEN**-2 * (1 - 1e-4),
        GOLDEN**-2 * (1 + 1e-4),
        "the pole 1/φ² of the steady state; the fit begins at step 5, where the gain is "
        "within 1e-4 of its limit law",
    ),
)
def gain_vanishes(size: Size, rng: np.random.Generator) -> Finding:
    """Fit the rate of the gain for one landmark, and the power of its own part for two."""
    gain = rail.covariances(FIG3).gains[0, :, 1, 0]
    rate = np.exp(intervals.slope(np.arange(5.0, 16.0), np.log(gain[4:15])).estimate)
    state = steady_state(*relative_system(1, motion_variance=1.0, look_variance=1.0))
    pole = abs(state.poles[0])
    own = gain_curves((2,), replace(FIG3, steps=1000))[2].own
    slow = intervals.exponent(np.arange(500.0, 1001.0), own[499:]).estimate
    swinging = rail.covariances(FIG4).gains[0, -1, 1, 0]
    return Finding(
        exact(rate, about="factor per step, fitted over steps 5 to 15"),
        {
            "pole of the steady state (Riccati)": exact(pole),
            "time constant": exact(state.time_constant, "steps"),
            "gain at the first step": exact(gain[0]),
            "gain at step 15": exact(gain[14]),
            "gain at the end with the noise of Fig. 4": exact(swinging.round(DECIMALS)),
            "exponent of the own gain against k, n = 2": exact(slow),
        },
        conditions=(
            Condition(
                "there is one landmark: with several, only the gain on their common innovation "
                f"has this rate, and the rest falls like k to the power {slow:.2f}",
                bool(abs(own[-1] / own[-2] - pole) > 0.1),
            ),
        ),
        note="The gain does go to zero for every number of landmarks.",
    )


@claim(
    "initial-error-persists",
    paper=PAPER,
    place="§2.2, Fig. 4",
    basis="substitute",
    statement="The localisation errors do not converge to zero; their steady value is subject "
    "to the error of the first observation.",
    paper_value="Fig. 4, third column",
    method="Share of the variance of the last error (step 100) that the error after the first "
    "look explains (squared correlation), n = 1, noise of Fig. 4 with our factors.",
    accepted=Accepted(
        0.5,
        1,
        "subject to means that the first look is the main cause: it explains more than half; "
        "equality would be 1, and one landmark does not reach it",
        "our choice",
    ),
    seed=4,
)
def initial_error_persists(size: Size, rng: np.random.Generator) -> Finding:
    """Correlate the first error with the last, in the setting of Fig. 4 and in four others."""
    runs = 10_000 if size is Size.FULL else 2_000
    base = replace(FIG4, runs=runs)
    fig4 = rail.run(base, rng=rng)
    first, last = fig4.first_errors[:, 0], fig4.last_errors[:, 0]
    constant = rail.run(replace(FIG3, runs=runs), rng=rng).explained
    known = rail.run(replace(base, start_deviation=0.0), rng=rng).explained
    many = rail.run(replace(base, landmarks=20), rng=rng)
    common = intervals.explained(many.first_errors.mean(axis=1), many.last_errors.mean(axis=1))
    elsewhere = Table(
        {
            "only the first 100 runs": [intervals.explained(first[:100], last[:100])],
            "P0 = V = W = 1 (theory: φ/2)": [constant],
            "start known exactly": [known],
            "mean of 20 landmarks": [common],
        },
        {"share": "squared correlation of first and last error"},
        f"95 % over {runs} runs, but for the first row",
        "setting",
    )
    frozen = np.abs(last - fig4.landmark_errors[:, -25, 0]).max()
    off = int(np.sum(np.abs(last) > 0.02))
    return Finding(
        fig4.explained,
        {
            "root mean square of the first error": exact(np.sqrt(np.mean(first**2)), "m"),
            "root mean square of the last error": exact(np.sqrt(np.mean(last**2)), "m"),
            "largest change over the last quarter": exact(frozen.round(DECIMALS), "m"),
            "share of runs that end more than 2 cm off": intervals.proportion(off, runs),
        },
        {"the same in other settings": elsewhere},
        (
            Condition(
                "the first look is the main error: the vehicle's initial variance must not be "
                "small against that of a look. With the start known exactly the first error "
                f"explains {known.estimate:.2f} of the variance of the last",
                known.high < 0.5,
            ),
        ),
        note="It stays, but it is not equal to the first error: later looks take a part away. With "
        "several landmarks only the error that they share is frozen.",
    )


@claim(
    "monte-carlo-unbiased",
    paper=PAPER,
    place="§2.2, text to Fig. 4",
    basis="substitute",
    statement="Over 100 runs the mean landmark error is zero.",
    paper_value="0 over 100 runs",
    method="Mean last error over 10 000 runs with its 99 % interval, in units of the spread of "
    "single runs; the 100-run mean beside it.",
    accepted=Accepted(
        -0.05,
        0.05,
        "equivalence test: the whole 99 % interval within a twentieth of the spread, which an "
        "unbiased filter passes 98 times in 100 and a filter biased by 0.1 spreads fails",
        "our choice",
    ),
    seed=5,
)
def monte_carlo_unbiased(size: Size, rng: np.random.Generator) -> Finding:
    """Average the last errors, and those of a sensor that reads too long."""
    result = rail.run(replace(FIG4, runs=10_000), rng=rng)
    last, deviation = result.last_errors[:, 0], result.deviations[-1, 1]
    return Finding(
        intervals.mean(last / deviation, level=0.99),
        {
            "mean error over 10 000 runs": intervals.mean(last, "m"),
            "mean error over 100 runs": intervals.mean(last[:100], "m"),
            "spread of single runs": exact(deviation, "m"),
            "what a sensor that reads a fifth of the spread too long would give": intervals.mean(
                last / deviation + 0.2, level=0.99
            ),
        },
        note="The ensemble is right and single runs are wrong: the error of one run does not "
        "average out, because it is the same error at every step.",
    )
