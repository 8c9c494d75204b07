r"""Which weight: eq. (4) against the weight of the least determinant.

.. math:: \omega = \frac{|C_i|}{|C_i| + |C_j|}

Of two numbers it is the best weight only if :math:`|C_i| = |C_j|` or
:math:`\operatorname{tr}(C_j^{-1} C_i) = 2 (1 + |C_i| / |C_j|)`.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks, fusion
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.covariance_intersection import consistency
from robot_perception.chapters.covariance_intersection.consistency import (
    PAPER,
    ROUNDING,
    best,
    by_equation_4,
    pairs,
)
from robot_perception.evaluation.intervals import Interval, exact, proportion, spread
from robot_perception.people.skin import SkinRules
from robot_perception.people.sonar import SonarRules
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition


@dataclass(frozen=True, slots=True)
class Config:
    """Pairs of beliefs as in the study of consistency; the paper gives none."""

    pairs: int = 20_000
    spread: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Weights of eq. (4) and of the least determinant, and determinants, pair by pair.

    ``excess`` is the determinant with eq. (4) over the least one; ``alone`` over that of the
    belief that is better by itself.
    """

    config: Config
    printed: Float[np.ndarray, " pairs"]
    least: Float[np.ndarray, " pairs"]
    excess: Float[np.ndarray, " pairs"]
    alone: Float[np.ndarray, " pairs"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Weigh random pairs by both rules."""
    a, b = pairs(consistency.Config(pairs=config.pairs, spread=config.spread), rng=rng)
    return compare(a, b, config)


def compare(a: Gaussian, b: Gaussian, config: Config | None = None) -> Result:
    """Weigh given pairs by both rules."""
    by_4, at_best = (np.linalg.det(rule(a, b).cov) for rule in (by_equation_4, best))
    better = np.minimum(np.linalg.det(a.cov), np.linalg.det(b.cov))
    weights = fusion.omega_determinants(a, b), fusion.omega_least_determinant(a, b)
    return Result(config or Config(len(by_4)), *weights, by_4 / at_best, by_4 / better)


# Sonar and camera --------------------------------------------------------------------------------

BEARING = 2.7
"""Standard deviation of the camera's direction, degrees; our choice, the paper gives none."""


def sonar_and_camera(
    bearing: float = BEARING, depth: float | None = None
) -> tuple[Gaussian, Gaussian]:
    """Return what sonar and camera say of one person, two metres ahead: distance and direction.

    Parameters
    ----------
    bearing
        Standard deviation of the camera's direction, degrees.
    depth
        Standard deviation of the camera's distance, m; by default that of the detector.
    """
    sonar, camera = SonarRules(), SkinRules()
    checks.positive("bearing", bearing)
    depth = camera.range_sigma if depth is None else checks.positive("depth", depth)
    mean = np.array([2.0, 0.0])
    return (
        Gaussian(mean, np.diag([sonar.range_sigma, sonar.bearing_sigma]) ** 2),
        Gaussian(mean, np.diag([depth, np.deg2rad(bearing)]) ** 2),
    )


def pair_table() -> Table:
    """Return what two weights make of sonar and camera, and what the Kalman filter states."""
    a, b = sonar_and_camera()
    fused = {
        "sonar alone": (a, ""),
        "camera alone": (b, ""),
        "intersection, eq. 4": (by_equation_4(a, b), float(fusion.omega_determinants(a, b))),
        "intersection, best ω": (best(a, b), float(fusion.omega_least_determinant(a, b))),
        "Kalman": (fusion.kalman_fusion(a, b), ""),
    }
    rows = {}
    for name, (belief, omega) in fused.items():
        along, aside = np.sqrt(np.diagonal(belief.cov))
        rows[name] = (omega, float(along), float(np.rad2deg(aside)))
    columns = {
        "ω": "weight of the camera",
        "distance (m)": "stated standard deviation",
        "direction (°)": "stated standard deviation",
    }
    return Table(rows, columns, "exact", "belief")


def setup_table() -> Table:
    """Return what sonar and camera state, and what of it matters."""
    sonar, camera = SonarRules(), SkinRules()
    rows = {
        "sonar": (
            "“large”",
            f"{sonar.range_sigma:g} m, {np.rad2deg(sonar.bearing_sigma):.0f}°",
            "yes",
        ),
        "camera": (
            "“very large” in distance",
            f"{camera.range_sigma:g} m, {BEARING:g}°",
            "yes",
        ),
        "person at": ("–", "2 m", "no: (r, φ) is fused"),
    }
    return Table(rows, {"paper": "in its words", "ours": "1σ", "matters": ""})


# Claims ------------------------------------------------------------------------------------------


@claim(
    "ci-omega-least",
    paper=PAPER,
    place="§3.2, eq. 4",
    basis="mathematics",
    statement="The weight of eq. 4 minimises the determinant of the fused covariance.",
    paper_value="“chosen to minimize the determinant”",
    method="Random pairs of beliefs about two numbers: share for which the determinant with eq. 4 "
    f"exceeds the least one by more than rounding ({ROUNDING:g} of it). The least one is from the "
    "root of the derivative, checked against SciPy's minimiser.",
    accepted=Accepted(0.0, 0.0, "a weight that minimises does so for every pair"),
    seed=33,
)
def omega_least(size: Size, rng: np.random.Generator) -> Finding:
    """Compare eq. 4 with the true minimiser."""
    found = run(Config(20_000 if size is Size.FULL else 2000), rng=rng)
    inside = (found.least > 0) & (found.least < 1)
    sensors = compare(*(Gaussian(g.mean[None], g.cov[None]) for g in sonar_and_camera()))
    kept = found.alone[~inside]
    return Finding(
        _share_above(found.excess),
        {
            "determinant over the least one": spread(found.excess),
            "largest": exact(float(found.excess.max()), about="of these pairs; it has no bound"),
            "sonar with camera": exact(float(sensors.excess[0])),
            "pairs whose best weight is 0 or 1": proportion(int((~inside).sum()), inside.size),
            "of these, worse than the better belief alone": proportion(
                int((kept > 1 + ROUNDING).sum()), kept.size
            ),
        },
        note="Eq. 4 is the best weight of two numbers only if the determinants are equal or "
        "tr(Cj⁻¹ Ci) = 2 (1 + |Ci| / |Cj|). The median loss is small: the determinant is "
        f"{np.median(found.excess):.2f} times the least one.",
    )


@omega_least.sabotage("the weight of the least determinant in place of eq. 4")
def true_minimum(size: Size, rng: np.random.Generator) -> Finding:
    """Take the root of the derivative, and compare with the best of a fine grid."""
    a, b = pairs(consistency.Config(pairs=500), rng=rng)
    ours = np.linalg.det(best(a, b).cov)
    grid = [
        np.linalg.det(fusion.covariance_intersection(a, b, w).cov) for w in np.linspace(0, 1, 201)
    ]
    return Finding(_counted(ours / np.min(grid, axis=0)))


@omega_least.sabotage("pairs of equal determinant")
def equal_determinants(size: Size, rng: np.random.Generator) -> Finding:
    """Scale the second belief so that both determinants are equal."""
    a, b = pairs(consistency.Config(pairs=2000), rng=rng)
    scale = np.sqrt(np.linalg.det(a.cov) / np.linalg.det(b.cov))
    return Finding(_counted(compare(a, Gaussian(b.mean, b.cov * scale[:, None, None])).excess))


@omega_least.sabotage("pairs with tr(Cj⁻¹ Ci) = 2 (1 + |Ci| / |Cj|)")
def second_case(size: Size, rng: np.random.Generator) -> Finding:
    """Choose the eigenvalues of Cj⁻¹ Ci as the second case asks."""
    _, b = pairs(consistency.Config(pairs=2000), rng=rng)
    x = rng.uniform(2.5, 20, 2000)
    values = np.stack([x, (2 - x) / (1 - 2 * x)], axis=-1)  # x + y = 2 (1 + x y)
    half = consistency.root(b.cov)
    return Finding(_counted(compare(Gaussian(b.mean, half * values[:, None] @ half.mT), b).excess))


def _share_above(excess: np.ndarray) -> Interval:
    return proportion(int((excess > 1 + ROUNDING).sum()), excess.size)


def _counted(excess: np.ndarray) -> Interval:
    """Return the share itself: of pairs that were made to be cases, it is no sample of others."""
    return exact(float((excess > 1 + ROUNDING).mean()), about="share of the pairs made")


@claim(
    "ci-weight-reliable",
    paper=PAPER,
    place="§3.2, text to eq. 4",
    basis="mathematics",
    statement="The distribution with the smaller determinant is weighted higher.",
    paper_value="in words",
    method="The same pairs: share for which eq. 3 with the ω of eq. 4 gives the belief of smaller "
    "determinant more than half of the weight. Eq. 3 gives (1 − ω) to i.",
    accepted=Accepted(1.0, 1.0, "a rule that says so does so for every pair"),
    seed=34,
)
def weight_reliable(size: Size, rng: np.random.Generator) -> Finding:
    """Look which belief gets the larger weight."""
    return Finding(
        _smaller_first(*_pairs(size, rng), swapped=False),
        note="By the definition of ω: 1 − ω = |Cj| / (|Ci| + |Cj|). “More reliable” is the area of "
        "the ellipse here, which says nothing of a single direction.",
    )


@weight_reliable.sabotage("ω given to i in place of j")
def swapped_weights(size: Size, rng: np.random.Generator) -> Finding:
    """Exchange the two weights."""
    return Finding(_smaller_first(*_pairs(size, rng), swapped=True))


def _smaller_first(a: Gaussian, b: Gaussian, *, swapped: bool) -> Interval:
    omega = fusion.omega_determinants(a, b)
    of_a = omega if swapped else 1 - omega
    a_first = np.linalg.det(a.cov) < np.linalg.det(b.cov)
    return exact(float(np.mean((of_a > 0.5) == a_first)), about="share of pairs")


@claim(
    "ci-reduces",
    paper=PAPER,
    place="§3.2, text to eq. 4",
    basis="mathematics",
    statement="If the reading is more certain than the hypothesis, the covariance of the "
    "hypothesis is reduced.",
    paper_value="in words",
    method="Random pairs, the reading being the one of smaller determinant: largest determinant of "
    "the result over that of the hypothesis.",
    accepted=Accepted(0.0, 1 - 1e-12, "reduced: below that of the hypothesis, for every pair"),
    seed=35,
)
def reduces(size: Size, rng: np.random.Generator) -> Finding:
    """Fuse a hypothesis with a reading that is more certain."""
    reading, hypothesis = _ordered(*_pairs(size, rng))
    result = by_equation_4(reading, hypothesis)
    half = np.linalg.inv(np.linalg.cholesky(hypothesis.cov))
    widest = np.linalg.eigvalsh(half @ result.cov @ half.mT)[:, -1]
    grown = proportion(int((widest > 1 + ROUNDING).sum()), widest.size)
    return Finding(
        exact(_largest(reading, hypothesis), about="largest over pairs"),
        {"pairs in which some direction becomes less certain": grown},
        conditions=(
            Condition(
                "the determinant is meant: the variance of some direction grows in "
                f"{grown.estimate:.0%} of the pairs",
                bool(grown.low > 0),
            ),
        ),
        note="The logarithm of a determinant is concave in the information, so the determinant of "
        "the result lies below the weighted geometric mean of the two.",
    )


@reduces.sabotage("a reading that is less certain than the hypothesis")
def less_certain(size: Size, rng: np.random.Generator) -> Finding:
    """Exchange reading and hypothesis."""
    reading, hypothesis = _ordered(*_pairs(size, rng))
    return Finding(exact(_largest(hypothesis, reading)))


def _largest(reading: Gaussian, hypothesis: Gaussian) -> float:
    result = by_equation_4(reading, hypothesis)
    return float((np.linalg.det(result.cov) / np.linalg.det(hypothesis.cov)).max())


def _ordered(a: Gaussian, b: Gaussian) -> tuple[Gaussian, Gaussian]:
    """Return the more certain one of each pair first."""
    first = (np.linalg.det(a.cov) < np.linalg.det(b.cov))[:, None, None]
    covs = np.where(first, a.cov, b.cov), np.where(first, b.cov, a.cov)
    return Gaussian(a.mean, covs[0]), Gaussian(a.mean, covs[1])


def _pairs(size: Size, rng: np.random.Generator) -> tuple[Gaussian, Gaussian]:
    return pairs(consistency.Config(pairs=20_000 if size is Size.FULL else 2000), rng=rng)
