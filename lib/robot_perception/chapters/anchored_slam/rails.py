"""Figs 5 and 6: the monobot with an anchor, and with a sensor that watches it.

World, seed and first measurement are those of Fig. 4 (chapter "The unobservable monobot"). What is
added is one measurement after each move. The paper is Andrade-Cetto, "Perception Issues in Mobile
Robotics", section 2.2, eqs (19) to (23).
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np
import sympy
from jaxtyping import Float
from scipy import stats

from data_synth.monobot import RailRuns, measure_anchor, simulate_rail, watch_vehicle
from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import FIG4, PAPER, Result
from robot_perception.chapters.monobot.steady import ends
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.slam import monobot
from robot_perception.slam.monobot import MonobotRun, Reference
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.explore import choice, slider
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

Kind = Literal["none", "anchor", "external sensor"]
KINDS: tuple[Kind, ...] = ("none", "anchor", "external sensor")
SIGNS: dict[Kind, Literal[-1, 1]] = {"anchor": -1, "external sensor": 1}
"""The first entry of the reference's row: eq. (20) and eq. (23)."""


@dataclass(frozen=True, slots=True)
class Config:
    """One study of a monobot with a reference.

    Parameters
    ----------
    base
        The monobot, its world and its noises.
    reference
        Which reference is read after each move.
    position
        Where the anchor or the fixed sensor stands, m; the origin stands in the caption of Fig. 5.
    deviation, share
        Standard deviation of the reference: constant part, m, and share of the planned distance to
        it. Neither stands in the paper.
    misplaced
        How far from its true place the filter believes the reference to be, m.
    """

    base: rail.Config = FIG4
    reference: Kind = "none"
    position: float = 0.0
    deviation: float = 0.0
    share: float = 0.0
    misplaced: float = 0.0

    @property
    def deviations(self) -> Float[np.ndarray, "steps"]:
        """Standard deviation of the reference after each move, m."""
        return self.deviation + self.share * np.abs(self.base.plan[1:] - self.position)


FIG5 = Config(reference="anchor", deviation=0.01, share=FIG4.measurement_share)
"""The anchor is measured like a landmark; the centimetre is ours, since the planned path runs over
the origin, where noise in proportion to distance would vanish."""
FIG6 = Config(reference="external sensor", deviation=0.1)
"""The paper leaves the noise of the external sensor out; 0.1 m is ours."""
FIGURES = {"Fig. 4: no reference": Config(), "Fig. 5: anchor": FIG5, "Fig. 6: camera": FIG6}


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Simulate a study and filter it; the same generator makes the same world for every reference.

    The reference has a generator of its own, spawned after the world's; its innovation is the first
    of each step.
    """
    world = rail.simulate(config.base, rng=rng)
    return Result(config.base, world, refilter(config, world, rng=rng.spawn(1)[0]))


def refilter(config: Config, world: RailRuns, *, rng: np.random.Generator) -> MonobotRun:
    """Measure the reference in a world that is there already, and filter."""
    if config.reference == "none":
        return rail.refilter(config.base, world)
    measure = {"anchor": measure_anchor, "external sensor": watch_vehicle}[config.reference]
    values = measure(world, config.position, config.deviations, rng=rng)
    return _filtered(config, world.commands, world.measurements, values)


def covariances(config: Config) -> MonobotRun:
    """Return the covariances and gains of a study, which need no data (all of it is zero)."""
    if config.reference == "none":
        return rail.covariances(config.base)
    steps = config.base.steps
    measurements = np.zeros((1, steps + 1, config.base.landmarks))
    return _filtered(config, np.zeros(steps), measurements, np.zeros((1, steps)))


def _filtered(
    config: Config, commands: np.ndarray, measurements: np.ndarray, values: np.ndarray
) -> MonobotRun:
    believed = config.position + config.misplaced
    reference = Reference(SIGNS[config.reference], values, config.deviations**2, believed)
    return monobot.run_referenced(
        config.base.belief,
        commands,
        measurements,
        reference,
        motion_variance=config.base.motion_deviations**2,
        measurement_variance=config.base.measurement_deviations**2,
    )


def figures(*, rng: np.random.Generator) -> dict[str, Result]:
    """Return the studies of Figs 4, 5 and 6 on the same worlds, by name."""
    world = rail.simulate(FIG4, rng=rng)
    own = iter(rng.spawn(len(FIGURES)))
    return {
        name: Result(FIG4, world, refilter(config, world, rng=next(own)))
        for name, config in FIGURES.items()
    }


def setup_table() -> Table:
    """Return what the paper says of Figs 4 to 6, what is ours, and what of it matters."""
    share = f"{FIG5.share:.0%} of the distance"
    rows = {
        "measurements": ("100", str(FIG4.steps), "yes: what is left falls like 1/k"),
        "place of the anchor": ("origin", f"{FIG5.position:g} m", "no"),
        "noise of wheels": ("–", f"{FIG4.motion_share:.0%} of the move", "little"),
        "noise of a measurement": ("–", share, "yes: scales all errors"),
        "noise of the anchor": ("–", f"{share} + {100 * FIG5.deviation:g} cm", "yes: how fast"),
        "noise of the camera": ("–", f"{100 * FIG6.deviation:g} cm", "yes: how fast"),
    }
    return Table(rows, {"paper": "– where it says nothing", "ours": "", "matters": ""})


# How long the first error stays ---------------------------------------------------------------


def remaining_shares(config: Config) -> Float[np.ndarray, "measurements"]:
    """Return the share of the first error's variance that is left after each measurement.

    For a filter whose model is right this is also the squared correlation of the error with the
    first one, and the factor by which the first error is expected to be still there.
    """
    variances = covariances(config).covs[0, :, 1, 1]
    return variances / variances[0]


def lengthened(config: Config, steps: int) -> Config:
    """Return the same study with its loop cut into another number of moves."""
    return replace(config, base=replace(config.base, steps=steps))


# Information ----------------------------------------------------------------------------------


def total_information(config: Config) -> Float[np.ndarray, "steps states states"]:
    """Return the total Fisher information of eq. (14) with the terms of eq. (22), 1/m²."""
    if config.reference == "none":
        return rail.total_information(config.base)
    return kalman.fisher_information(_matrix(config), covariances(config).innovation_covs[0])


def information_on_start(config: Config) -> Float[np.ndarray, "steps states states"]:
    """Return the information of all measurements on the state at the start, 1/m².

    Eq. (14) counts each innovation as a fresh measurement of one state; this does not.
    """
    base, matrix = config.base, _matrix(config)
    moves = [monobot.motion(0.0, float(s) ** 2, base.landmarks) for s in base.motion_deviations]
    noises = base.measurement_deviations[1:] ** 2
    if config.reference != "none":
        noises = np.insert(noises, 0, config.deviations**2, axis=1)
    return kalman.start_information(moves, [kalman.Sensor(matrix, np.diag(w)) for w in noises])


def _matrix(config: Config) -> np.ndarray:
    if config.reference == "none":
        return monobot.sensor_matrix(config.base.landmarks)
    values = np.zeros((1, config.base.steps))
    return Reference(SIGNS[config.reference], values, 1.0).matrix(config.base.landmarks)


def symbolic_information(
    landmarks: int, reference: Kind = "anchor"
) -> tuple[sympy.Matrix, sympy.Matrix]:
    r"""Return one term of the information, and :math:`S^{-1}`, in symbols.

    .. math:: J_k = H^\top S_k^{-1} H

    ``"none"`` gives eq. (15), ``"anchor"`` eq. (22), ``"external sensor"`` its twin. The entries
    :math:`\varsigma_{ij}` of the inverse innovation covariance, any symmetric matrix, are numbered
    from 0 with a reference and from 1 without.
    """
    matrix = _matrix(Config(base=replace(FIG4, landmarks=landmarks), reference=reference))
    first = landmarks + 1 - len(matrix)
    H = sympy.Matrix(matrix.astype(int).tolist())
    weights = sympy.Matrix(
        H.rows, H.rows, lambda i, j: sympy.Symbol(f"s_{min(i, j) + first}{max(i, j) + first}")
    )
    return (H.T * weights * H).applyfunc(sympy.expand), weights


# What the anchor adds, and what it does not ---------------------------------------------------


def anchored_and_relative(
    runs: int, *, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "runs measurements"], Float[np.ndarray, "runs measurements"]]:
    """Return the landmark by a filter with an anchor, and landmark minus anchor by one without.

    Both estimate the same distance, m, in worlds with the noise of Figs 4 and 5. The first filter
    learns where it starts from its first measurement of the anchor, from nothing else. The second
    takes the anchor for a landmark like any other and believes in its own start.
    """
    base, plan = replace(FIG4, runs=runs), FIG4.plan
    posts = np.array([FIG5.position, base.landmarks_at])
    to_anchor = FIG5.deviation + FIG5.share * np.abs(plan - FIG5.position)
    deviations = np.column_stack([to_anchor, base.measurement_deviations])
    world = simulate_rail(
        plan,
        posts,
        runs,
        start_deviation=base.start_deviation,
        motion_deviation=base.motion_deviations,
        measurement_deviation=deviations,
        rng=rng,
    )
    V, W, measurements = base.motion_deviations**2, deviations**2, world.measurements
    plain = monobot.run_filter(
        base.belief, world.commands, measurements, motion_variance=V, measurement_variance=W
    )
    tied = monobot.run_referenced(
        Gaussian(FIG5.position - measurements[:, 0, :1], W[:1, :1]),
        world.commands,
        measurements[..., 1:],
        Reference(-1, measurements[:, 1:, 0], W[1:, 0], FIG5.position),
        motion_variance=V,
        measurement_variance=W[:, 1:],
    )
    return tied.means[..., 1] - FIG5.position, plain.means[..., 2] - plain.means[..., 1]


# Broken on purpose ----------------------------------------------------------------------------


CONTROLS = {
    "reference": choice("Reference", KINDS, "anchor"),
    "deviation": slider("σ of the reference", (0.02, 0.1, 0.5), 0.1, "m"),
    "offset": slider("It stands off by", (0.0, 0.1, 0.3), 0.0, "m"),
}
"""Controls of the explorer: noise of the reference, and how far it stands off."""
PRESETS = {
    "no reference": {"reference": "none"},
    "a good anchor": {"deviation": 0.02},
    "an anchor 10 cm off": {"offset": 0.1},
    "a camera 30 cm off": {"reference": "external sensor", "offset": 0.3},
}


def studies(*, rng: np.random.Generator) -> dict[tuple[Kind, float, float], Result]:
    """Return the study of each setting of the explorer, all in the same thirty worlds.

    A setting is the reference, its deviation and how far it stands off, both in m; every reference
    makes the same errors.
    """
    base = replace(FIG4, runs=30)
    world, seed = rail.simulate(base, rng=rng), rng.integers(2**32)
    return {
        (kind, deviation, offset): Result(
            base,
            world,
            refilter(
                Config(base, kind, deviation=deviation, misplaced=offset),
                world,
                rng=np.random.default_rng(seed),
            ),
        )
        for kind, deviation, offset in product(*(control.values for control in CONTROLS.values()))
    }


# The claims -----------------------------------------------------------------------------------


@claim(
    "anchor-full-rank",
    paper=PAPER,
    place="§2.2, eqs 20–22",
    basis="mathematics",
    statement="With one landmark as a fixed global reference the Fisher information matrix has "
    "full rank.",
    paper_value="full rank",
    method="Number of states minus scale-free rank of the sum (14) with the terms (22), at "
    "every step, for several n; the blocks and the determinant of (22) in symbols.",
    accepted=Accepted(0, 0, "full rank means that no direction is missing"),
    seed=20,
)
def anchor_full_rank(size: Size, rng: np.random.Generator) -> Finding:
    """Count the missing ranks with the anchor, and prove eq. (22) in symbols."""
    least = {}
    for n in rail.COUNTS:
        total = total_information(replace(FIG5, base=replace(FIG4, landmarks=n)))
        terms = np.concatenate([total[:1], np.diff(total, axis=0)])
        least[str(n)] = [np.linalg.eigvalsh(m)[..., 0].min() for m in (terms, total[-1])]
    plain = 2 - int(kalman.scale_free_rank(rail.total_information(FIG4)[-1]))
    start = {
        f"{k} measurements": information_on_start(lengthened(FIG5, k))[-1]
        for k in (FIG4.steps, 2 * FIG4.steps)
    }
    return Finding(
        _missing_ranks("anchor"),
        {
            "missing ranks without the anchor, n = 1": exact(plain),
            "n of 1, 2, 3 for which eq. 22 holds in symbols, with det J = det S⁻¹": exact(
                sum(_symbolic_identity(n) for n in (1, 2, 3))
            ),
            "missing ranks of the information on the start, n = 1": exact(
                2 - int(kalman.scale_free_rank(start["100 measurements"]))
            ),
        },
        {
            "smallest eigenvalue (1/m²)": Table(
                least,
                {"term (22)": "of a single term", "sum (14)": "after all measurements"},
                corner="n",
            ),
            "information on the start (1/m²)": Table(
                {
                    name: [J[i, i] for J in start.values()]
                    for i, name in enumerate(("vehicle", "landmark"))
                },
                dict.fromkeys(start, ""),
            ),
        },
        note="H of eq. 20 is square with determinant ±1, so every single term has the full rank of "
        "S⁻¹. The sums of ς run over all measurements, the anchor's (index 0) included.",
    )


@anchor_full_rank.sabotage("an anchor whose place is unknown, one more landmark of the state")
def anchor_at_an_unknown_place(size: Size, rng: np.random.Generator) -> Finding:
    """Count the missing ranks if the state has the anchor, too, and no reference is left."""
    return Finding(_missing_ranks("none", more=1))


def _missing_ranks(reference: Kind, more: int = 0) -> Interval:
    """Return the most ranks that a sum (14) misses, for several n and some landmarks more."""
    missing = 0
    for n in rail.COUNTS:
        base = replace(FIG4, landmarks=n + more)
        total = total_information(replace(FIG5, base=base, reference=reference))
        missing = max(missing, int(n + more + 1 - kalman.scale_free_rank(total).min()))
    return exact(missing, about=f"steps 1 to {FIG4.steps}, n = 1 to {rail.COUNTS[-1]}")


def _symbolic_identity(n: int) -> bool:
    """Return whether eq. (22) and its determinant hold for n landmarks, in symbols."""
    J, weights = symbolic_information(n)
    printed = sympy.zeros(n + 1, n + 1)
    printed[0, 0] = sum(weights)
    printed[1:, 1:] = weights[1:, 1:]  # the submatrix of the landmarks
    for j in range(1, n + 1):
        printed[0, j] = printed[j, 0] = -sum(weights[:, j])
    same = (J - printed).applyfunc(sympy.expand) == sympy.zeros(n + 1, n + 1)
    return same and _same_determinant(J, weights)


def _same_determinant(a: sympy.Matrix, b: sympy.Matrix) -> bool:
    return bool(sympy.expand(a.det(method="berkowitz") - b.det(method="berkowitz")) == 0)


UNSEEN = float(np.tanh(stats.norm.ppf(0.975) / np.sqrt(97)) ** 2)
"""The squared correlation that 100 runs, the paper's number, cannot tell from none (95 %)."""
_FADED = Accepted(
    0,
    UNSEEN,
    "of a filter that is right both shares are the same number, and 100 runs, the paper's number, "
    f"cannot tell a squared correlation below {UNSEEN:.3f} from none (95 %)",
)


def share_left(result: Result, noise: Float[np.ndarray, "runs"] | float = 0.0) -> Interval:
    """Return how much of the first error is left in the last, to which some noise is added.

    A last error may be large and independent, or small and a fixed share of the first; so this is
    the larger of two shares: of the last variance what the first error explains, and the last mean
    square over the first variance.
    """
    first, last = result.first_errors[:, 0], result.last_errors[:, 0] + noise
    size = intervals.root_mean_square(last / result.deviations[0, 1])
    square = Interval(size.estimate**2, size.low**2, size.high**2, "", size.about)
    return intervals.largest(intervals.explained(first, last), square)


def _studied(config: Config, size: Size, rng: np.random.Generator) -> dict[str, Result]:
    """Return the worlds of Fig. 4 filtered without a reference and with one, by its kind."""
    base = replace(FIG4, runs=10_000 if size is Size.FULL else 2_000)
    world, own = rail.simulate(base, rng=rng), rng.spawn(1)[0]
    tied = Result(base, world, refilter(replace(config, base=base), world, rng=own))
    return {"none": Result(base, world, rail.refilter(base, world)), config.reference: tied}


def _measures(
    config: Config, size: Size, rng: np.random.Generator
) -> tuple[Interval, dict[str, Interval], Table]:
    """Return how much of the first error is left, and what is shown beside it."""
    results, rows = _studied(config, size, rng), {}
    for name, result in results.items():
        first, last = result.first_errors[:, 0], result.last_errors[:, 0]
        rows[name] = (
            share_left(result),
            ends(result).explained,
            intervals.correlation(first, last),
            intervals.root_mean_square(first, "m"),
            intervals.root_mean_square(last, "m"),
            intervals.mean(last, "m"),
        )
    columns = {
        "left": "the value: the larger of the share explained and the ratio of mean squares",
        "explained": "share of the variance of the last error that the first explains",
        "correlation": "of last and first error",
        "first (m)": "root mean square of the first error",
        "last (m)": "root mean square of the last error",
        "mean (m)": "mean of the last error",
    }
    counts = np.array([100.0, 200.0, 400.0, 800.0])
    shares = np.array([remaining_shares(lengthened(config, int(k)))[-1] for k in counts])
    tied = results[config.reference]
    evidence = {
        "correlation with the first error over 100 runs": intervals.correlation(
            tied.first_errors[:100, 0], tied.last_errors[:100, 0]
        ),
        "exponent of the explained share against the measurements, by the covariances": (
            intervals.exponent(counts, shares)
        ),
        "gain on the landmark's own innovation at the last measurement": exact(tied.gains[-1, 1]),
    }
    about = f"95 % over {tied.config.runs} runs"
    return share_left(tied), evidence, Table(rows, columns, about, "reference")


def _rounding(a: np.ndarray, b: np.ndarray, unit: str = "") -> Interval:
    """Return the largest difference to twelve decimals: processors differ in what is below."""
    return exact(np.abs(a - b).max().round(12), unit, "to twelve decimals")


NOISES = (0.01, 0.1, 0.2, 0.3, 1.0)
"""Constant parts of a reference's deviation with which the claims are tried, m."""


def _effect(config: Config, size: Size, rng: np.random.Generator) -> Finding:
    """Return what a reference does to the first error: one verdict for the anchor and the sensor.

    With equal noise the two are one system, which the evidence shows; their noise decides how much
    is left after the paper's hundred measurements.
    """
    value, evidence, table = _measures(config, size, rng)
    (other,) = set(SIGNS) - {config.reference}
    twin = replace(config, reference=other)
    a, b = covariances(config), covariances(twin)
    J, K = total_information(config), total_information(twin)
    evidence |= {
        f"largest relative difference of the covariances from an {other} of equal noise": (
            _rounding(a.covs / b.covs.max(), b.covs / b.covs.max())
        ),
        f"largest relative difference of the sums (14) from an {other} of equal noise": (
            _rounding(J / K.max(), K / K.max())
        ),
    }
    noises = {d: replace(config, deviation=d) for d in NOISES}
    shares = {d: remaining_shares(config)[-1] for d, config in noises.items()}
    rows = {
        f"{d} m": (covariances(config).deviations[0, -1, 1], shares[d])
        for d, config in noises.items()
    }
    columns = {
        "stated (m)": "deviation of the landmark after 100 measurements",
        "left": "share of the first error's variance after 100 measurements, by the covariances",
    }
    worse = min((d for d, share in shares.items() if share > UNSEEN), default=np.inf)
    good_enough = Condition(
        f"the reference is good enough for the number of measurements: the constant part of its "
        f"error is {config.deviation} m here (ours); with {worse} m a hundred leave too much",
        bool(shares[NOISES[-1]] > UNSEEN),
    )
    tables = {
        "with and without the reference": table,
        "other noises": Table(rows, columns, corner="deviation"),
    }
    return Finding(value, evidence, tables, (good_enough,))


@claim(
    "anchor-unbiased",
    paper=PAPER,
    place="§2.2, Fig. 5",
    basis="substitute",
    statement="With the anchor observed, the error of a landmark fades, and what is left no longer "
    "depends on its first estimate.",
    paper_value="Fig. 5, second and third column",
    method="How much of the error after the first measurement is left at the last (step 100): the "
    "larger of squared correlation and ratio of mean squares; n = 1, worlds of Fig. 4, anchor at "
    "the origin; and covariances and information against an external sensor of equal noise.",
    accepted=_FADED,
    seed=21,
)
def anchor_unbiased(size: Size, rng: np.random.Generator) -> Finding:
    """Measure what is left of the first error with the anchor, and what else the anchor does."""
    found = _effect(FIG5, size, rng)
    right, off = (covariances(replace(FIG5, misplaced=m)).means[0, -1, 1] for m in (0.0, 0.1))
    anchored, relative = anchored_and_relative(100, rng=rng)
    more = {
        "what an anchor surveyed 0.1 m off adds to the last error": exact(off - right, "m"),
        "largest difference from landmark minus anchor by the plain filter": _rounding(
            anchored, relative, "m"
        ),
    }
    return replace(
        found,
        evidence={**found.evidence, **more},
        note="The dependence fades like one over the number of measurements: at 100 it is small, "
        "not zero. The distance to the anchor is what the filter without an anchor knows as well: "
        "the anchor names the origin, it does not sharpen the map.",
    )


def _spoilt(
    config: Config, size: Size, rng: np.random.Generator, deviation: float = 0.0
) -> Finding:
    """Return how much of the first error a reference leaves, with noise added to the last error."""
    result = _studied(config, size, rng)[config.reference]
    return Finding(share_left(result, deviation * rng.standard_normal(result.config.runs)))


@anchor_unbiased.sabotage("no anchor")
def no_anchor(size: Size, rng: np.random.Generator) -> Finding:
    """Filter the worlds of Fig. 4 without a reference."""
    return _spoilt(replace(FIG5, reference="none"), size, rng)


@anchor_unbiased.sabotage("an anchor that stands 0.1 m from where the robot believes it")
def misplaced_anchor(size: Size, rng: np.random.Generator) -> Finding:
    """Filter with an anchor in the wrong place."""
    return _spoilt(replace(FIG5, misplaced=0.1), size, rng)


@anchor_unbiased.sabotage("1 m of noise added to the last error")
def blurred_by_the_anchor(size: Size, rng: np.random.Generator) -> Finding:
    """Make the last error large, and independent of the first."""
    return _spoilt(FIG5, size, rng, deviation=1.0)


@claim(
    "external-sensor",
    paper=PAPER,
    place="§2.2, eq. 23, Fig. 6",
    basis="substitute",
    statement="A fixed sensor that measures the vehicle has the same effect as the anchor.",
    paper_value="theoretically equivalent",
    method="As for the anchor, by the same rule, with a sensor of 0.1 m (ours) that watches the "
    "vehicle.",
    accepted=_FADED,
    seed=21,
)
def external_sensor(size: Size, rng: np.random.Generator) -> Finding:
    """Measure the same as for the anchor, against one of equal noise, and with other noises."""
    found = _effect(FIG6, size, rng)
    regular = [_same_determinant(*symbolic_information(n, "external sensor")) for n in (1, 2, 3)]
    more = {"n of 1, 2, 3 for which det J = det S⁻¹ in symbols": exact(sum(regular))}
    return replace(
        found,
        evidence={**found.evidence, **more},
        note="With equal noise the two are one system: a sign in the first row of H, which no "
        "covariance feels. What tells Fig. 6 from Fig. 5 is the noise, which the paper leaves out "
        "and we chose.",
    )


@external_sensor.sabotage("no sensor")
def no_sensor(size: Size, rng: np.random.Generator) -> Finding:
    """Filter the worlds of Fig. 4 without a reference."""
    return _spoilt(replace(FIG6, reference="none"), size, rng)


@external_sensor.sabotage("a sensor that stands 0.1 m from where the robot believes it")
def misplaced_sensor(size: Size, rng: np.random.Generator) -> Finding:
    """Filter with a sensor in the wrong place."""
    return _spoilt(replace(FIG6, misplaced=0.1), size, rng)


@external_sensor.sabotage("1 m of noise added to the last error")
def blurred_by_the_sensor(size: Size, rng: np.random.Generator) -> Finding:
    """Make the last error large, and independent of the first."""
    return _spoilt(FIG6, size, rng, deviation=1.0)
