"""When to draw particles anew: below M/2, always or never, and what eq. (7) prints."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import maps
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.maps import PAPER, Account, Config, over_drives
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio, exact
from robot_perception.particles import effective_number
from robot_perception.slam.rao_blackwellised import printed_number
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

RULES = {"below M/2": 0.5, "always": 1.0, "never": 0.0}
"""Share of M below which particles are drawn anew; paper: M/2, the others are ours."""
Found = Mapping[str, Account]


def filters(*counts: int, noise: float = 1.0) -> tuple[tuple[str, Options], ...]:
    """Return filters by rule, that believe the points ``noise`` times as uncertain as they are.

    So they learn less from each frame, and weights become unequal more slowly.
    """
    return tuple(
        (f"{rule}, M = {count}", Options(count, share=share, noise=noise))
        for count in counts
        for rule, share in RULES.items()
    )


def run(config: Config, *, rng: np.random.Generator) -> tuple[Found, Found]:
    """Drive with every rule, and with ten particles once more where draws are spared."""
    ours, other = rng.spawn(2)
    rare = replace(config, filters=filters(10, noise=10.0))
    return maps.run(config, rng=ours), maps.run(rare, rng=other)


def run_alone(config: Config, *, rng: np.random.Generator) -> tuple[Found, Found]:
    """Drive with the filters of a configuration alone."""
    found = maps.run(config, rng=rng)
    return found, found


def over(found: Found, name: str) -> Interval:
    """Return the error with the paper's rule over that with another one."""
    rule, count = name.split(", ")
    ours = found[f"below M/2, {count}"]
    return bootstrap_ratio(ours.path, found[name].path, f"ATE, below M/2 over {rule}")


def rule_table(found: Found) -> Table:
    """Return errors, and how often particles were drawn."""
    rows = {
        name: (
            bootstrap_mean(a.path, "m"),
            bootstrap_mean(a.aligned, "m"),
            float(a.drawn.mean()),
            float(a.effective.mean()),
        )
        for name, a in found.items()
    }
    columns = {
        "ATE (m)": "root mean squared error of the position",
        "aligned (m)": "the same after the best rigid motion",
        "drawn": "share of the frames after which particles were drawn anew",
        "effective": "effective number before that, as a share of M",
    }
    return Table(rows, columns, over_drives(found), "drawn anew")


SPARED = Study(run, full=Config(filters(10, 50), 20), quick=Config(filters(10), 5), seed=44)


@SPARED.claim(
    "neff-resampling",
    paper=PAPER,
    place="§3.3, text after eq. 7",
    basis="substitute",
    statement="To draw particles anew only where the effective number is below M/2 reduces the "
    "number of particles that good results need.",
    paper_value="“the number of particles needed to achieve good results is reduced”",
    method="The rendered drive with ten particles: share of the frames with an observation after "
    "which the rule spares the draw. Where it spares none, it is the same as to draw always, and "
    "can reduce nothing.",
    accepted=Accepted(
        0.1, 1.0, "the rule differs from drawing always in one frame of ten", "our choice"
    ),
    sabotage=Change(
        "points that count as thirty times as uncertain as they are",
        run_alone,
        filters=filters(10, noise=30.0),
    ),
)
def neff_resampling(results: tuple[Found, Found]) -> Finding:
    """Count the draws that the paper's rule spares, and compare errors with other rules."""
    found, rare = results
    ten, there = found["below M/2, M = 10"], rare["below M/2, M = 10"]
    ratios = {
        f"ATE, below M/2 over {name}": over(found, name)
        for name in found
        if not name.startswith("below")
    }
    return Finding(
        bootstrap_mean(1 - ten.drawn),
        ratios
        | {
            "effective number as a share of M": bootstrap_mean(ten.effective),
            "spared where points count 10 times as uncertain": bootstrap_mean(1 - there.drawn),
            "ATE there, below M/2 over always": over(rare, "always, M = 10"),
        },
        {"rules": rule_table(found), "rules, points uncertain": rule_table(rare)},
        note=f"The effective number is below M/2 after {ten.drawn.mean():.1%} of the frames: a "
        "dozen points, each good to centimetres, tell almost all particles off.",
    )


# The printed number ------------------------------------------------------------------------------

PARTICLES = 100


def numbers(weights: np.ndarray) -> tuple[float, float]:
    """Return what eq. (7) prints and the effective number, of normalised weights."""
    with np.errstate(divide="ignore"):
        logs = np.log(weights / weights.sum())
    return printed_number(logs), effective_number(logs)


def number_table() -> Table:
    """Return both numbers for weights from equal to one that has all."""
    ranks = np.arange(PARTICLES)
    cases = {
        "all equal": np.ones(PARTICLES),
        "half of them nothing": np.where(ranks < PARTICLES // 2, 1.0, 0.0),
        "each 0.9 of the one before": 0.9**ranks,
        "one has all": np.where(ranks == 0, 1.0, 0.0),
    }
    return Table(
        {name: np.round(numbers(weights), 9).tolist() for name, weights in cases.items()},
        {"as printed": "1/Σω", "effective": "1/Σω²"},
        f"{PARTICLES} particles, weights normalised",
        "weights",
    )


def both_numbers(draws: int, *, rng: np.random.Generator) -> Float[np.ndarray, "draws 2"]:
    """Return both numbers of equal weights, and of weights that are drawn."""
    drawn = rng.dirichlet(np.full(PARTICLES, 0.1), size=draws)
    return np.array([numbers(weights) for weights in (np.ones(PARTICLES), *drawn)])


def squared_first(draws: int, *, rng: np.random.Generator) -> Float[np.ndarray, "draws 2"]:
    """Return the number with the square where the printed one is asked for."""
    return both_numbers(draws, rng=rng)[:, ::-1]


NUMBERS = Study(both_numbers, full=1000, quick=1000)


@NUMBERS.claim(
    "erratum-neff",
    paper=PAPER,
    place="§3.3, eq. 7",
    basis="mathematics",
    statement="N_eff = 1/Σω is the number of particles that count: M if all weights are equal.",
    paper_value="N_eff = 1/Σω",
    method="Eq. (7) as printed, of 100 equal weights that add up to one.",
    accepted=Accepted(
        99.999, 100.001, "a hundred particles of equal weight all count; rounding apart"
    ),
    sabotage=Change("the square that is missing", squared_first),
)
def erratum_neff(found: Float[np.ndarray, "draws 2"]) -> Finding:
    """Evaluate eq. (7) as printed and with the square."""
    (printed, effective), spread = found[0], found[1:]
    return Finding(
        exact(printed, about="as printed, 100 equal weights"),
        {
            "with the square": exact(effective),
            "as printed, largest of 1000 draws of weights": exact(spread[:, 0].max()),
            "as printed, smallest": exact(spread[:, 0].min()),
            "with the square, smallest": exact(spread[:, 1].min()),
        },
        {"both": number_table()},
        note="Of normalised weights the printed number is 1 whatever they are; compared with M/2 "
        "it says “draw” at every step for more than two particles, and never for one.",
    )
