r"""Which weight: eq. (4) against the weight of the least determinant.

.. math:: \omega = \frac{|C_i|}{|C_i| + |C_j|}

Of two numbers it is the best weight only if :math:`|C_i| = |C_j|` or
:math:`\operatorname{tr}(C_j^{-1} C_i) = 2 (1 + |C_i| / |C_j|)`.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from robot_perception import checks, fusion
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.covariance_intersection.consistency import (
    PAPER,
    ROUNDING,
    Pairs,
    best,
    by_equation_4,
    pairs,
    root,
)
from robot_perception.evaluation.intervals import exact, proportion, spread
from robot_perception.people.skin import SkinRules
from robot_perception.people.sonar import SonarRules
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

EQUAL, SECOND, LEAST = "equal determinants", "the second case", "the least determinant"


@dataclass(frozen=True, slots=True)
class Config:
    """Pairs of beliefs as in the study of consistency; the paper gives none.

    ``made`` says what makes the printed weight the best one: pairs of equal determinant, pairs of
    the second case, or the least determinant in the place of eq. (4).
    """

    pairs: int = 20_000
    made: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Pairs, weights of eq. (4) and of the least determinant, and determinants, pair by pair.

    ``excess`` is the determinant with eq. (4) over the least one; ``alone`` over that of the
    belief that is better by itself.
    """

    config: Config
    a: Gaussian
    b: Gaussian
    printed: Float[np.ndarray, " pairs"]
    least: Float[np.ndarray, " pairs"]
    excess: Float[np.ndarray, " pairs"]
    alone: Float[np.ndarray, " pairs"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Weigh pairs by both rules: random ones, or as the configuration makes them."""
    a, b = pairs(config.pairs, rng=rng)
    if config.made == EQUAL:
        scale = np.sqrt(np.linalg.det(a.cov) / np.linalg.det(b.cov))
        b = Gaussian(b.mean, b.cov * scale[:, None, None])
    elif config.made == SECOND:
        x = rng.uniform(2.5, 20, config.pairs)
        values = np.stack([x, (2 - x) / (1 - 2 * x)], axis=-1)  # x + y = 2 (1 + x y)
        half = root(b.cov)
        a = Gaussian(b.mean, half * values[:, None] @ half.mT)
    found = compare(a, b, config)
    if config.made != LEAST:
        return found
    grid = [
        np.linalg.det(fusion.covariance_intersection(a, b, w).cov) for w in np.linspace(0, 1, 201)
    ]
    excess = np.linalg.det(best(a, b).cov) / np.min(grid, axis=0)
    return replace(found, printed=found.least, excess=excess)


def compare(a: Gaussian, b: Gaussian, config: Config) -> Result:
    """Weigh given pairs by both rules."""
    by_4, at_best = (np.linalg.det(rule(a, b).cov) for rule in (by_equation_4, best))
    better = np.minimum(np.linalg.det(a.cov), np.linalg.det(b.cov))
    weights = fusion.omega_determinants(a, b), fusion.omega_least_determinant(a, b)
    return Result(config, a, b, *weights, by_4 / at_best, by_4 / better)


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


@dataclass(frozen=True, eq=False, slots=True)
class Weighed:
    """Sonar, camera, and area of the fused ellipse over that of the sonar, by weight."""

    sonar: Gaussian
    camera: Gaussian
    omegas: Float[np.ndarray, " k"]
    areas: Float[np.ndarray, " k"]
    printed: float
    least: float

    def area(self, omega: float) -> float:
        """Return the area at a weight over that of the sonar's ellipse."""
        return float(_areas(self.sonar, self.camera, omega))


def weighed(bearing: float, depth: float) -> Weighed:
    """Return what the weights make of sonar and camera, as `sonar_and_camera` makes them."""
    sonar, camera = sonar_and_camera(bearing, depth)
    omegas = np.linspace(0, 1, 201)
    return Weighed(
        sonar,
        camera,
        omegas,
        _areas(sonar, camera, omegas),
        float(fusion.omega_determinants(sonar, camera)),
        float(fusion.omega_least_determinant(sonar, camera)),
    )


def _areas(sonar: Gaussian, camera: Gaussian, omega: Any) -> Any:
    found = fusion.covariance_intersection(sonar, camera, omega)
    return np.sqrt(np.linalg.det(found.cov) / np.linalg.det(sonar.cov))


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

weighing = Study(run, full=Config(), quick=Config(2000), seed=33)


@weighing.claim(
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
    sabotage=[
        Change("the weight of the least determinant in place of eq. 4", pairs=500, made=LEAST),
        Change("pairs of equal determinant", made=EQUAL),
        Change("pairs with tr(Cj⁻¹ Ci) = 2 (1 + |Ci| / |Cj|)", made=SECOND),
    ],
)
def omega_least(found: Result) -> Finding:
    """Compare eq. 4 with the true minimiser."""
    above = found.excess > 1 + ROUNDING
    share = exact(float(above.mean()), about="share of these pairs; one is enough")
    inside = (found.least > 0) & (found.least < 1)
    sensors = weighed(BEARING, SkinRules().range_sigma)
    evidence = {
        "determinant over the least one": spread(found.excess),
        "largest": exact(float(found.excess.max()), about="of these pairs; it has no bound"),
        "error of the mean over that with the least": spread(_errors(found)),
        "sonar with camera": exact(
            (sensors.area(sensors.printed) / sensors.area(sensors.least)) ** 2
        ),
        "pairs whose best weight is 0 or 1": proportion(int((~inside).sum()), inside.size),
    }
    if not inside.all():
        worse = found.alone[~inside] > 1 + ROUNDING
        evidence["of these, worse than the better belief alone"] = proportion(
            int(worse.sum()), worse.size
        )
    return Finding(
        share,
        evidence,
        note="Eq. 4 is the best weight of two numbers only if the determinants are equal or "
        "tr(Cj⁻¹ Ci) = 2 (1 + |Ci| / |Cj|). The median loss is small: the determinant is "
        f"{np.median(found.excess):.2f} times the least one.",
    )


def _errors(found: Result) -> Float[np.ndarray, " pairs"]:
    r"""Return root mean squared errors of the fused means, with eq. (4) over the least determinant.

    The errors of a pair are independent here. Eq. (3) then leaves, with :math:`C` as fused,

    .. math:: E = C \left((1 - \omega)^2 C_i^{-1} + \omega^2 C_j^{-1}\right) C .
    """

    def error(omega: np.ndarray) -> np.ndarray:
        one, other = (1 - omega)[:, None, None], omega[:, None, None]
        C = fusion.covariance_intersection(found.a, found.b, omega).cov
        left = one**2 * np.linalg.inv(found.a.cov) + other**2 * np.linalg.inv(found.b.cov)
        return np.sqrt(np.trace(C @ left @ C, axis1=1, axis2=2))

    return error(found.printed) / error(found.least)


def swapped(config: Config, *, rng: np.random.Generator) -> Result:
    """Exchange the two weights of eq. (4)."""
    found = run(config, rng=rng)
    return replace(found, printed=1 - found.printed)


halves = Study(run, full=Config(), quick=Config(2000), seed=34)


@halves.claim(
    "ci-weight-reliable",
    paper=PAPER,
    place="§3.2, text to eq. 4",
    basis="mathematics",
    statement="The distribution with the smaller determinant is weighted higher.",
    paper_value="in words",
    method="The same pairs: share for which eq. 3 with the ω of eq. 4 gives the belief of smaller "
    "determinant more than half of the weight. Eq. 3 gives (1 − ω) to i.",
    accepted=Accepted(1.0, 1.0, "a rule that says so does so for every pair"),
    sabotage=Change("ω given to i in place of j", swapped),
)
def weight_reliable(found: Result) -> Finding:
    """Look which belief gets the larger weight."""
    a_first = np.linalg.det(found.a.cov) < np.linalg.det(found.b.cov)
    right = (1 - found.printed > 0.5) == a_first
    return Finding(
        exact(float(np.mean(right)), about="share of pairs"),
        note="By the definition of ω: 1 − ω = |Cj| / (|Ci| + |Cj|). “More reliable” is the area of "
        "the ellipse here, which says nothing of a single direction.",
    )


def ordered(number: int, *, rng: np.random.Generator) -> Pairs:
    """Return readings and hypotheses: of each pair the more certain belief is the reading."""
    a, b = pairs(number, rng=rng)
    first = (np.linalg.det(a.cov) < np.linalg.det(b.cov))[:, None, None]
    covs = np.where(first, a.cov, b.cov), np.where(first, b.cov, a.cov)
    return Gaussian(a.mean, covs[0]), Gaussian(a.mean, covs[1])


def less_certain(number: int, *, rng: np.random.Generator) -> Pairs:
    """Exchange reading and hypothesis."""
    reading, hypothesis = ordered(number, rng=rng)
    return hypothesis, reading


reading = Study(ordered, full=20_000, quick=2000, seed=35)


@reading.claim(
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
    sabotage=Change("a reading that is less certain than the hypothesis", less_certain),
)
def reduces(pairs: Pairs) -> Finding:
    """Fuse a hypothesis with a reading that is more certain."""
    reading, hypothesis = pairs
    result = by_equation_4(reading, hypothesis)
    exchanged = fusion.covariance_intersection(
        reading, hypothesis, 1 - fusion.omega_determinants(reading, hypothesis)
    )
    apart, before = np.linalg.det(exchanged.cov), np.linalg.det(hypothesis.cov)
    share, other = np.linalg.det(result.cov) / before, apart / before
    half = np.linalg.inv(np.linalg.cholesky(hypothesis.cov))
    widest = np.linalg.eigvalsh(half @ result.cov @ half.mT)[:, -1]
    grown = proportion(int((widest > 1 + ROUNDING).sum()), widest.size)
    return Finding(
        exact(float(share.max()), about="largest over pairs"),
        {
            "pairs in which some direction becomes less certain": grown,
            "the same with the weights of eq. 4 exchanged": exact(float(other.max())),
            "determinant over that with them exchanged": spread(share / other),
        },
        conditions=(
            Condition(
                "the determinant is meant: the variance of some direction grows in "
                f"{grown.estimate:.0%} of the pairs",
                bool(grown.low > 0),
            ),
        ),
        note="The logarithm of a determinant is concave in the information, so the determinant of "
        "the result lies below the weighted geometric mean of the two, whatever the weights: the "
        "statement holds for any ω between 0 and 1, and eq. 4 only decides how much is gained.",
    )
