"""When to draw particles anew: below M/2, always or never, and what eq. (7) prints."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from robot_perception.chapters.visual_slam import frontend, maps
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.maps import OPTIONS, PAPER, Account
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio, exact
from robot_perception.particles import effective_number
from robot_perception.slam.rao_blackwellised import printed_number
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

RARE = 10.0
"""Factor of the points' uncertainty at which draws are spared; ours."""
RULES = {"below M/2": 0.5, "always": 1.0, "never": 0.0}
"""Share of M below which particles are drawn anew; the paper's is the first."""


@dataclass(frozen=True, slots=True)
class Config:
    """Rules of resampling on the drive; paper: M/2. The other rules and ``noise`` are ours.

    A filter that believes the points ``noise`` times as uncertain as the pixels make them learns
    less from each frame, and its weights become unequal more slowly.
    """

    particles: tuple[int, ...] = (10, 50)
    seeds: int = 10
    noise: float = 1.0
    film: frontend.Config = frontend.PAPER


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Accounts of all drives by rule and number of particles."""

    config: Config
    drives: Mapping[tuple[str, int], Account]

    def ratio(self, count: int, over: str = "always") -> Interval:
        """Return the error with the paper's rule over that with another one."""
        above, below = (self.drives[rule, count].path for rule in ("below M/2", over))
        return bootstrap_ratio(above, below, f"ATE, below M/2 over {over}")

    def table(self) -> Table:
        """Return errors, and how often particles were drawn."""
        rows = {
            f"{rule}, M = {count}": (
                bootstrap_mean(a.path, "m"),
                bootstrap_mean(a.aligned, "m"),
                float(a.drawn.mean()),
                float(a.effective.mean()),
            )
            for (rule, count), a in self.drives.items()
        }
        columns = {
            "ATE (m)": "root mean squared error of the position",
            "aligned (m)": "the same after the best rigid motion",
            "drawn": "share of the frames after which particles were drawn anew",
            "effective": "effective number before that, as a share of M",
        }
        about = f"mean and 95 % bootstrap interval over {self.config.seeds} drives"
        return Table(rows, columns, about, "drawn anew")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive with every rule and number of particles, on the same wheels."""
    keys = {f"{r}|{m}": (r, m) for m in config.particles for r in RULES}
    options = replace(OPTIONS, noise=config.noise)
    variants: dict[str, Options] = {
        name: replace(options, particles=count, share=RULES[rule])
        for name, (rule, count) in keys.items()
    }
    found = maps.compare(variants, config.film, config.seeds, rng=rng)
    return Result(config, {keys[name]: account for name, account in found.items()})


@claim(
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
    seed=44,
)
def neff_resampling(size: Size, rng: np.random.Generator) -> Finding:
    """Count the draws that the paper's rule spares, and compare errors with other rules."""
    full = size is Size.FULL
    ours, other = rng.spawn(2)
    result = run(Config(seeds=20) if full else Config((10,), 5), rng=ours)
    rare = run(Config((10,), 20 if full else 5, noise=RARE), rng=other)
    ten = result.drives["below M/2", 10]
    return Finding(
        bootstrap_mean(1 - ten.drawn),
        {
            f"ATE, below M/2 over {rule}, M = {count}": result.ratio(count, rule)
            for count in result.config.particles
            for rule in ("always", "never")
        }
        | {
            "effective number as a share of M": bootstrap_mean(ten.effective),
            f"spared where points count {RARE:g} times as uncertain": bootstrap_mean(
                1 - rare.drives["below M/2", 10].drawn
            ),
            "ATE there, below M/2 over always": rare.ratio(10),
        },
        {"rules": result.table(), "rules, points uncertain": rare.table()},
        note=f"The effective number is below M/2 after {ten.drawn.mean():.1%} of the frames: a "
        "dozen points, each good to centimetres, tell almost all particles off.",
    )


@neff_resampling.sabotage("points that count as thirty times as uncertain as they are")
def doubtful_points(size: Size, rng: np.random.Generator) -> Finding:
    """Let each frame tell so little that weights stay alike for some frames."""
    result = run(Config((10,), 5, noise=30.0), rng=rng)
    return Finding(bootstrap_mean(1 - result.drives["below M/2", 10].drawn))


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
    rows = {name: np.round(numbers(weights), 9).tolist() for name, weights in cases.items()}
    return Table(
        rows,
        {"as printed": "1/Σω", "effective": "1/Σω²"},
        f"{PARTICLES} particles, weights normalised",
        "weights",
    )


@claim(
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
)
def erratum_neff(size: Size, rng: np.random.Generator) -> Finding:
    """Evaluate eq. (7) as printed and with the square."""
    printed, effective = numbers(np.ones(PARTICLES))
    weights = rng.dirichlet(np.full(PARTICLES, 0.1), size=1000)
    spread = np.array([numbers(row) for row in weights])
    return Finding(
        exact(printed, about="as printed, 100 equal weights"),
        {
            "with the square": exact(effective),
            "as printed, largest of 1000 draws of weights": exact(float(spread[:, 0].max())),
            "as printed, smallest": exact(float(spread[:, 0].min())),
            "with the square, smallest": exact(float(spread[:, 1].min())),
        },
        {"both": number_table()},
        note="Of normalised weights the printed number is 1 whatever they are; compared with M/2 "
        "it says “draw” at every step for more than two particles, and never for one.",
    )


@erratum_neff.sabotage("the square that is missing")
def with_the_square(size: Size, rng: np.random.Generator) -> Finding:
    """Evaluate the effective number."""
    return Finding(exact(numbers(np.ones(PARTICLES))[1]))
