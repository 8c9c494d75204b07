"""When to draw particles anew: below M/2, always or never, and what eq. (7) prints."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import maps
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.maps import (
    PAPER,
    QUICK,
    Account,
    Config,
    Filter,
    over_drives,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio, exact
from robot_perception.particles import effective_number
from robot_perception.slam.rao_blackwellised import printed_number
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

RULES = {"below M/2": 0.5, "always": 1.0, "never": 0.0}
"""Share of M below which particles are drawn anew; paper: M/2, the others are ours."""
COUNTS = 3, 5, 10, 20
"""Particles, where the error still falls with their number; ours."""
RARE = 10.0
"""Points that count as so many times as uncertain as they are: then the rule spares draws."""
Found = Mapping[str, Account]


def filters(*counts: int, rules: Mapping[str, float] = RULES) -> tuple[Filter, ...]:
    """Return filters by rule and number of particles."""
    return tuple(
        Filter(f"{rule}, M = {count}", Options(count, share=share))
        for count in counts
        for rule, share in rules.items()
    )


def run(config: Config, *, rng: np.random.Generator) -> tuple[Found, Found]:
    """Drive with every rule, and once more where draws are spared.

    There the filters believe the points less than they are worth. So they learn less from each
    frame, and weights become unequal more slowly.
    """
    ours, other = rng.spawn(2)
    doubting = tuple(f._replace(options=replace(f.options, noise=RARE)) for f in config.filters)
    return maps.run(config, rng=ours), maps.run(replace(config, filters=doubting), rng=other)


def needed(found: Found, rule: str = "always") -> Interval:
    r"""Return the particles that the paper's rule needs, over those of another, for equal error.

    .. math:: \log \frac{M}{M'} = \frac{\overline{\log e_{M/2} - \log e'}}
        {-\, \mathrm d \log e / \mathrm d \log M}

    The errors fall with the number of particles. How far apart they are, over how steeply they
    fall, is how many more particles make up for it. Both are means over the buildings.
    """
    counts = [count for count in COUNTS if f"{rule}, M = {count}" in found]
    ours, other = (
        np.array([np.log(found[f"{name}, M = {count}"].path).mean(axis=1) for count in counts])
        for name in ("below M/2", rule)
    )
    sizes = np.log(counts) - np.mean(np.log(counts))
    fall = -sizes @ (ours + other) / 2 / (sizes @ sizes)
    ratio = bootstrap_ratio((ours - other).mean(axis=0), fall)
    ends = np.exp([ratio.estimate, ratio.low, ratio.high])
    return Interval(*ends.tolist(), about=f"below M/2 over {rule}, 95 % bootstrap over buildings")


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
