r"""What a fused belief is worth in the worst case: over every correlation that may be there.

Errors a and b with covariances :math:`C_a, C_b` admit every cross-covariance
:math:`C_a^{1/2} M C_b^{1/2}` with singular values of M up to 1. A mean
:math:`(I - K) \mu_a + K \mu_b` then errs in the direction v by a variance of at most

.. math::
    s(v)^2 = \left(\lVert C_a^{1/2} (I - K)^\top v \rVert
        + \lVert C_b^{1/2} K^\top v \rVert\right)^2,

and some M attains it. So the worst case over all correlations is a search over directions.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception import checks, fusion
from robot_perception.beliefs import Gaussian
from robot_perception.evaluation.intervals import Interval, exact, proportion
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

PAPER = "sensor-aggregation"
ROUNDING = 1e-9
"""Share of a variance that rounding may add."""

Pairs = tuple[Gaussian, Gaussian]
Rule = Callable[[Gaussian, Gaussian], Gaussian]


def with_weight(omega: float) -> Rule:
    """Return the covariance intersection of a given weight as a rule."""
    return lambda a, b: fusion.covariance_intersection(a, b, omega)


def best(a: Gaussian, b: Gaussian) -> Gaussian:
    """Return the covariance intersection of the least determinant."""
    return fusion.covariance_intersection(a, b, fusion.omega_least_determinant(a, b))


def by_equation_4(a: Gaussian, b: Gaussian) -> Gaussian:
    """Return the covariance intersection whose weight is that of eq. (4)."""
    return fusion.covariance_intersection(a, b, fusion.omega_determinants(a, b))


def inverse(a: Gaussian, b: Gaussian) -> Gaussian:
    """Return the inverse covariance intersection with equal weights."""
    return fusion.inverse_covariance_intersection(a, b, 0.5)


OPINIONS = (
    Gaussian(np.zeros(2), np.array([[4.0, 0.6], [0.6, 0.5]])),
    Gaussian(np.zeros(2), np.array([[0.6, -0.4], [-0.4, 3.0]])),
)
"""The two beliefs that the chapter draws."""
RULES: Mapping[str, Rule] = {
    "Kalman": fusion.kalman_fusion,
    "intersection, eq. 4": by_equation_4,
    "intersection, best ω": best,
    "inverse intersection": inverse,
}
"""What is compared."""
WEIGHTED = {f"intersection, ω = {w:.1f}": with_weight(w) for w in np.linspace(0, 1, 11)}
INTERSECTIONS = (*WEIGHTED, "intersection, eq. 4", "intersection, best ω")


@dataclass(frozen=True, slots=True)
class Config:
    """Pairs of beliefs and the rules that fuse them; the paper gives none, all values are ours.

    Axes are turned at random, their lengths exp(``spread`` · standard normal). ``reach`` is the
    greatest singular value of M, and ``understated`` the true over the stated deviation of both.
    """

    pairs: int = 2000
    spread: float = 1.0
    directions: int = 360
    rules: tuple[str, ...] = tuple(RULES)
    reach: float = 1.0
    understated: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Greatest true over stated variance of each pair, by rule; 1 is honest at worst."""

    config: Config
    worst: Mapping[str, Float[np.ndarray, " pairs"]]


def pairs(number: int, spread: float = 1.0, *, rng: np.random.Generator) -> Pairs:
    """Draw pairs of beliefs about two numbers."""
    return _beliefs(number, spread, rng), _beliefs(number, spread, rng)


def _beliefs(number: int, spread: float, rng: np.random.Generator) -> Gaussian:
    turn = rng.uniform(0, np.pi, number)
    axes = np.stack([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    axes = np.moveaxis(axes, -1, 0) * np.exp(spread * rng.standard_normal((number, 1, 2)))
    return Gaussian(np.zeros((number, 2)), axes @ axes.mT)


def gain(rule: Rule, a: Gaussian, b: Gaussian) -> Float[np.ndarray, "*batch 2 2"]:
    """Return K of a rule's mean, by what the rule makes of two unit differences."""
    n = a.mean.shape[-1]
    zero = Gaussian(np.zeros((*a.mean.shape[:-1], 1, n)), a.cov[..., None, :, :])
    units = Gaussian(np.broadcast_to(np.eye(n), a.cov.shape), b.cov[..., None, :, :])
    return rule(zero, units).mean.mT


def root(cov: Float[np.ndarray, "*batch n n"]) -> Float[np.ndarray, "*batch n n"]:
    """Return the symmetric root."""
    values, vectors = np.linalg.eigh(cov)
    return vectors * np.sqrt(np.maximum(values, 0))[..., None, :] @ vectors.mT


def true_cov(
    rule: Rule, a: Gaussian, b: Gaussian, M: Float[np.ndarray, "n n"]
) -> Float[np.ndarray, "n n"]:
    """Return the covariance of the error of a rule's mean at one correlation of the errors."""
    K = gain(rule, a, b)
    rest = np.eye(K.shape[-1]) - K
    mixed = rest @ root(a.cov) @ M @ root(b.cov) @ K.mT
    return rest @ a.cov @ rest.mT + K @ b.cov @ K.mT + mixed + mixed.mT


@dataclass(frozen=True, eq=False, slots=True)
class Fused:
    """Two beliefs of one correlation, and stated and true covariance of the fused one.

    Without ``omega`` they are fused by the Kalman filter.
    """

    rho: float
    omega: float | None
    beliefs: Pairs
    stated: Float[np.ndarray, "2 2"]
    true: Float[np.ndarray, "2 2"]

    @property
    def ratio(self) -> float:
        """Greatest true over stated variance over all directions; honest up to 1."""
        half = np.linalg.inv(np.linalg.cholesky(self.stated))
        return float(np.linalg.eigvalsh(half @ self.true @ half.T)[-1])


def fused(rho: float, omega: float | None, beliefs: Pairs = OPINIONS) -> Fused:
    """Fuse two beliefs whose errors have the same correlation in every direction."""
    rule = fusion.kalman_fusion if omega is None else with_weight(omega)
    true = true_cov(rule, *beliefs, rho * np.eye(2))
    return Fused(rho, omega, beliefs, rule(*beliefs).cov, true)


def worst_case(
    rule: Rule, a: Gaussian, b: Gaussian, *, directions: int = 360, reach: float = 1.0
) -> Float[np.ndarray, "*batch"]:
    """Return the greatest true over stated variance of a rule, over correlations and directions.

    Parameters
    ----------
    rule
        What is asked.
    a, b
        Beliefs about two numbers.
    directions
        How many are looked in.
    reach
        Greatest singular value of M: 1 is all that two covariances admit, 0 independent errors.
    """
    checks.whole("directions", directions, 8)
    turn = np.linspace(0, np.pi, directions, endpoint=False)
    v = np.stack([np.cos(turn), np.sin(turn)])
    K, stated = gain(rule, a, b), rule(a, b).cov
    first = np.linalg.norm(root(a.cov) @ (np.eye(2) - K).mT @ v, axis=-2)
    second = np.linalg.norm(root(b.cov) @ K.mT @ v, axis=-2)
    true = first**2 + second**2 + 2 * reach * first * second
    return (true / (v * (stated @ v)).sum(axis=-2)).max(axis=-1)


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Find the worst correlation of every pair for every rule."""
    a, b = pairs(config.pairs, config.spread, rng=rng)
    sizes = {"directions": config.directions, "reach": config.reach}
    rules = {name: (RULES | WEIGHTED)[name] for name in config.rules}
    worst = {name: worst_case(rule, a, b, **sizes) for name, rule in rules.items()}
    return Result(config, {name: config.understated**2 * w for name, w in worst.items()})


def fused_as_independent(config: Config, *, rng: np.random.Generator) -> Result:
    """Let the Kalman filter's fusion stand for every rule."""
    worst = run(replace(config, rules=("Kalman",)), rng=rng).worst["Kalman"]
    return Result(config, dict.fromkeys(config.rules, worst))


def setup_table() -> Table:
    """Return what the study takes."""
    config = Config()
    rows = {
        "beliefs": ("distance, direction", "any two numbers", "no: the proof holds for all"),
        "axes of an ellipse": ("–", "log-normal, turned at random", "for medians"),
        "correlation": ("unknown", "every one there may be", "yes"),
        "pairs": ("–", f"{config.pairs}", "little"),
    }
    return Table(rows, {"paper": "its values", "ours": "", "matters": ""})


def worst_table(result: Result) -> Table:
    """Return the worst cases of the rules over the pairs."""
    rows = {}
    for name, worst in result.worst.items():
        over = int((worst > 1 + ROUNDING).sum())
        rows[name] = (float(np.median(worst)), float(worst.max()), proportion(over, worst.size))
    columns = {
        "median": "true over stated variance in the worst case, median over pairs",
        "largest": "the same, largest pair",
        "overconfident": "share of pairs with a correlation for which the rule states too little",
    }
    return Table(rows, columns, f"share with its 95 % interval over {len(worst)} pairs", "rule")


intersected = Study(
    run,
    full=Config(rules=INTERSECTIONS),
    quick=Config(pairs=300, rules=INTERSECTIONS),
    seed=31,
)


@intersected.claim(
    "ci-consistent",
    paper=PAPER,
    place="§3.2, eq. 3",
    basis="mathematics",
    statement="Covariance intersection takes in readings whose correlation is unknown: its "
    "covariance is not too small for any cross-covariance.",
    paper_value="in words",
    method="Two thousand pairs of random covariances, eleven weights from 0 to 1 and those of "
    "eq. 4 and of the least determinant: greatest ratio of true to stated variance over all "
    "directions and all cross-covariances that the pair admits. The chapter has the proof.",
    accepted=Accepted(
        0.0, 1 + ROUNDING, "consistent means that the true variance is never above the stated one"
    ),
    sabotage=[
        Change("the Kalman filter's fusion in place of the intersection", fused_as_independent),
        Change("errors one and a half times as large as the two covariances say", understated=1.5),
    ],
)
def consistent(result: Result) -> Finding:
    """Look for a correlation that breaks the intersection."""
    largest = max(float(worst.max()) for worst in result.worst.values())
    half = result.worst["intersection, ω = 0.5"]
    tight = proportion(int((half > 0.999).sum()), half.size)
    return Finding(
        exact(largest, about="largest ratio found"),
        {"pairs for which the bound is attained, ω = 1/2": tight},
        note="No correlation makes the true variance larger than the stated one. Where the two "
        "ellipses cross, one makes it as large: the covariance is not larger than it must be.",
    )


overlooked = Study(
    run, full=Config(rules=("Kalman",)), quick=Config(pairs=300, rules=("Kalman",)), seed=32
)


@overlooked.claim(
    "kalman-overconfident",
    paper=PAPER,
    place="§3.2, text to eq. 3",
    basis="mathematics",
    statement="The Kalman filter, which the rule resembles, is overconfident if the errors of its "
    "inputs are correlated and it does not know.",
    paper_value="implied: “as an advantage … unknown correlations”",
    method="The same pairs fused as if independent: ratio of true to stated variance in the worst "
    "direction at the worst cross-covariance, median over pairs and the range that holds 95 % of "
    "them.",
    accepted=Accepted(
        1 + ROUNDING, float("inf"), "overconfident means that a true variance is above the stated"
    ),
    sabotage=Change("errors that are independent, as the filter believes", reach=0.0),
)
def overconfident(result: Result) -> Finding:
    """Fuse as if independent and look for the worst correlation."""
    worst = result.worst["Kalman"]
    low, middle, high = np.quantile(worst, [0.025, 0.5, 0.975]).tolist()
    return Finding(
        Interval(middle, low, high, about="median and central 95 % of pairs"),
        {
            "largest": exact(float(worst.max())),
            "pairs at the largest possible, 2": proportion(int((worst > 1.999).sum()), worst.size),
        },
        note="The true variance is up to twice the stated one, and never more: that is what one "
        "fusion can lose. It is attained where the two ellipses cross.",
    )
