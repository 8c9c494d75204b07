"""When to draw particles anew: below M/2, always or never, and what eq. (7) prints."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import frontend, maps
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.maps import (
    PAPER,
    Account,
    Config,
    Filter,
    mean,
    ratio,
    table,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_ratio, exact
from robot_perception.particles import effective_number
from robot_perception.slam.rao_blackwellised import printed_number
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

RULES = {"below M/2": 0.5, "always": 1.0, "never": 0.0}
"""Share of M below which particles are drawn anew; paper: M/2, the others are ours."""
COUNTS = 3, 5, 10, 20, 50
"""Particles, over which the error falls; ours."""
DOUBTED = 10.0
"""How uncertain points count, of what they are, in filters that learn less from each frame: weights
become unequal more slowly, and the rule spares draws; ours."""
Found = Mapping[str, Account]


def filters(*counts: int, rules: Sequence[str], noise: float = 1.0) -> tuple[Filter, ...]:
    """Return filters by rule and number of particles."""
    return tuple(
        Filter(called(rule, count, noise), Options(count, share=RULES[rule], noise=noise))
        for count in counts
        for rule in rules
    )


def called(rule: str, count: int, noise: float) -> str:
    """Return the name of a filter."""
    return f"{rule}, M = {count}" + (", points doubted" if noise > 1 else "")


def needed(found: Found, noise: float = 1.0) -> Interval:
    r"""Return the particles that the paper's rule needs, over those drawn always, at equal error.

    .. math:: \log \frac{M}{M'} = \frac{\overline{\log e - \log e'}}
        {-\, \mathrm d \log e / \mathrm d \log M}

    The errors fall with the number of particles. How far apart they are, over how steeply they
    fall, is how many more particles make up for it. Both are means over the buildings.
    """
    counts = [count for count in COUNTS if called("always", count, noise) in found]
    ours, other = (
        np.array([np.log(found[called(rule, M, noise)].path).mean(axis=1) for M in counts])
        for rule in ("below M/2", "always")
    )
    sizes = np.log(counts) - np.mean(np.log(counts))
    fall = -sizes @ (ours + other) / 2 / (sizes @ sizes)
    logs = bootstrap_ratio((ours - other).mean(axis=0), fall)
    ends = np.exp([logs.estimate, logs.low, logs.high])
    return Interval(*ends.tolist(), about="particles, 95 % bootstrap over buildings")


TWO = "below M/2", "always"
RARELY = filters(3, 10, 50, rules=TWO, noise=DOUBTED)
SPARED = Study(
    maps.run,
    full=Config((*filters(*COUNTS, rules=TWO), *filters(10, rules=["never"]), *RARELY), 3),
    quick=Config(filters(3, 50, rules=TWO), 1, frontend.FEW),
    seed=44,
)
ACCEPTED = Accepted(0.0, 0.9, "a tenth fewer at least", "our choice")


@SPARED.claim(
    "neff-resampling",
    paper=PAPER,
    place="§3.3, text after eq. 7",
    basis="substitute",
    statement="To draw particles anew only where the effective number is below M/2 reduces the "
    "number of particles that good results need.",
    paper_value="“the number of particles needed to achieve good results is reduced”",
    method="Twenty rendered buildings, three draws of the wheels, 3 to 50 particles drawn anew by "
    "the paper's rule and always: the number that the rule needs over that for the same error "
    "where they are always drawn; interval over the buildings. The same where points count "
    "ten times as uncertain as they are, so that the rule spares draws.",
    accepted=ACCEPTED,
    sabotage=Change(
        "particles never drawn anew in place of always",
        filters=tuple(
            f if f.options.share < 1 else f._replace(options=replace(f.options, share=0.0))
            for f in filters(3, 50, rules=TWO)
        ),
    ),
)
def neff_resampling(found: Found) -> Finding:
    """Compare the numbers of particles that both rules need, and count the draws spared."""
    value, ours = needed(found), found["below M/2, M = 50"]
    evidence = {"effective number as a share of M": mean(ours.effective)}
    evidence |= {f"draws spared, {k}": mean(1 - a.drawn) for k, a in found.items() if "M/2" in k}
    conditions: tuple[Condition, ...] = ()
    if "never, M = 10" in found:
        other, ten = needed(found, DOUBTED), found["below M/2, M = 10"]
        evidence |= {
            "particles needed over always, points doubted": other,
            "ATE, below M/2 over never, M = 10": ratio(ten.path, found["never, M = 10"].path),
        }
        where = "points count ten times as uncertain as they are, so that draws are spared"
        conditions = (Condition.judged(where, ACCEPTED, inside=other),)
    return Finding(
        value,
        evidence,
        {"rules": table(found, ("ATE (m)", "right", "drawn", "effective"), "drawn anew")},
        conditions,
        note=f"The paper's rule needs {value.estimate:.2f} times as many particles; with fifty it "
        f"spares {1 - ours.drawn.mean():.2%} of the draws.",
    )


def by_count(rules: Table) -> Table:
    """Return the errors of both rules by number of particles, and the draws that one spares."""
    rows = {}
    for count in COUNTS:
        ours, other = (called(rule, count, 1.0) for rule in TWO)
        rows[f"M = {count}"] = (
            rules[ours, "ATE (m)"],
            rules[other, "ATE (m)"],
            100 * (1 - rules[ours, "drawn"]),
            rules[ours, "effective"],
        )
    columns = {
        "below M/2 (m)": "ATE where the rule says when particles are drawn anew",
        "always (m)": "ATE where they are drawn anew in each frame",
        "spared (%)": "frames after which the rule does not say so",
        "effective": "number before that, as a share of M",
    }
    return Table(rows, columns, rules.about, "particles")


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
