"""Figs 5 and 6: the monobot with an anchor, and with a sensor that watches it.

World, seed and first measurement are those of Fig. 4 (chapter "The unobservable monobot"). What is
added is one measurement after each move. The paper is Andrade-Cetto, "Perception Issues in Mobile
Robotics", section 2.2, eqs (19) to (23).
"""

from dataclasses import replace

import numpy as np
import sympy
from jaxtyping import Float
from scipy import stats

from data_synth.monobot import RailRuns, measure_anchor, simulate_rail, watch_vehicle
from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import (
    FIG4,
    ORIGIN,
    PAPER,
    SIGNS,
    Config,
    Ends,
    Kind,
    Result,
    covariances,
    ends,
    remaining_share,
    sensor,
    total_information,
)
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.slam import monobot
from robot_perception.slam.monobot import MonobotRun, Reference
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

FIG5 = replace(
    FIG4,
    reference="anchor",
    reference_deviation=0.01,
    reference_share=FIG4.measurement_share,
)
"""The anchor is measured like a landmark; the centimetre is ours, since the planned path runs over
the origin, where noise in proportion to distance would vanish."""
FIG6 = replace(FIG4, reference="external sensor", reference_deviation=0.1)
"""The paper leaves the noise of the external sensor out; 0.1 m is ours."""
ALIKE = {kind: replace(FIG6, reference=kind) for kind in SIGNS}
"""Both references with the noise of Fig. 6."""
FIGURES = {"Fig. 4: no reference": FIG4, "Fig. 5: anchor": FIG5, "Fig. 6: camera": FIG6}


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Simulate a study and filter it; the same generator makes one world for every reference."""
    world = rail.simulate(config, rng=rng)
    return Result(config, world, refilter(config, world, rng=rng.spawn(1)[0]))


def refilter(config: Config, world: RailRuns, *, rng: np.random.Generator) -> MonobotRun:
    """Measure the reference in a world that is there already, and filter."""
    if config.reference == "none":
        return rail.refilter(config, world)
    measure = {"anchor": measure_anchor, "external sensor": watch_vehicle}[config.reference]
    values = measure(world, ORIGIN, config.reference_deviations, rng=rng)
    return rail.refilter(config, world, values)


def figures(*, rng: np.random.Generator) -> dict[str, Result]:
    """Return the studies of Figs 4, 5 and 6 on the same worlds, by name."""
    world, own = rail.simulate(FIG4, rng=rng), rng.spawn(len(FIGURES))
    return {
        name: Result(config, world, refilter(config, world, rng=stream))
        for (name, config), stream in zip(FIGURES.items(), own, strict=True)
    }


def setup_table() -> Table:
    """Return what the paper says of Figs 4 to 6, what is ours, and what of it matters."""
    share = f"{FIG5.reference_share:.0%} of the distance"
    rows = {
        "measurements": ("100", str(FIG4.steps), "yes: what is left falls like 1/k"),
        "place of the anchor": ("origin", f"{ORIGIN:g} m", "no"),
        "noise of wheels": ("–", f"{FIG4.motion_share:.0%} of the move", "little"),
        "noise of a measurement": ("–", share, "yes: scales all errors"),
        "noise of the anchor": (
            "–",
            f"{share} + {100 * FIG5.reference_deviation:g} cm",
            "yes: how fast",
        ),
        "noise of the camera": ("–", f"{100 * FIG6.reference_deviation:g} cm", "yes: how fast"),
    }
    return Table(rows, {"paper": "– where it says nothing", "ours": "", "matters": ""})


def remaining_shares(config: Config) -> Float[np.ndarray, "measurements"]:
    """Return the share of the first error's variance that is left after each measurement.

    If the model is right, this is the squared correlation with the first error, too.
    """
    variances = covariances(config).covs[0, :, 1, 1]
    return variances / variances[0]


# Information ----------------------------------------------------------------------------------


def information_on_start(config: Config) -> Float[np.ndarray, "steps states states"]:
    """Return the information of all measurements on the state at the start, 1/m².

    Eq. (14) counts each innovation as a fresh measurement of one state; this does not.
    """
    return kalman.start_information(*rail.system(config))


def symbolic_information(
    landmarks: int, reference: Kind = "anchor"
) -> tuple[sympy.Matrix, sympy.Matrix]:
    r"""Return one term of the information, and :math:`S^{-1}`, in symbols.

    .. math:: J_k = H^\top S_k^{-1} H

    ``"none"`` gives eq. (15), ``"anchor"`` eq. (22), ``"external sensor"`` its twin. The entries
    :math:`\varsigma_{ij}` of the inverse innovation covariance, any symmetric matrix, are numbered
    from 0 with a reference and from 1 without.
    """
    H = sympy.Matrix(sensor(Config(landmarks=landmarks, reference=reference)).astype(int))
    first = landmarks + 1 - H.rows
    weights = sympy.Matrix(
        H.rows, H.rows, lambda i, j: sympy.Symbol(f"s_{min(i, j) + first}{max(i, j) + first}")
    )
    return (H.T * weights * H).applyfunc(sympy.expand), weights


# What the anchor adds, and what it does not ---------------------------------------------------


def anchored_and_relative(
    runs: int, *, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "runs measurements"], Float[np.ndarray, "runs measurements"]]:
    """Return the landmark by a filter with an anchor, and landmark minus anchor by one without, m.

    The first filter learns where it starts from its first measurement of the anchor alone; the
    second takes the anchor for a landmark like any other and believes in its own start.
    """
    to_anchor = FIG5.reference_deviation + FIG5.reference_share * np.abs(FIG4.plan - ORIGIN)
    deviations = np.column_stack([to_anchor, FIG4.measurement_deviations])
    world = simulate_rail(
        FIG4.plan,
        np.array([ORIGIN, FIG4.landmarks_at]),
        runs,
        start_deviation=FIG4.start_deviation,
        motion_deviation=FIG4.motion_deviations,
        measurement_deviation=deviations,
        rng=rng,
    )
    V, W, measurements = FIG4.motion_deviations**2, deviations**2, world.measurements
    plain = monobot.run_filter(
        FIG4.belief, world.commands, measurements, motion_variance=V, measurement_variance=W
    )
    tied = monobot.run_referenced(
        Gaussian(ORIGIN - measurements[:, 0, :1], W[:1, :1]),
        world.commands,
        measurements[..., 1:],
        Reference(-1, measurements[:, 1:, 0], W[1:, 0], ORIGIN),
        motion_variance=V,
        measurement_variance=W[:, 1:],
    )
    return tied.means[..., 1] - ORIGIN, plain.means[..., 2] - plain.means[..., 1]


# The rank -------------------------------------------------------------------------------------


Sums = dict[int, Float[np.ndarray, "steps states states"]]


def sums(known: bool, *, rng: np.random.Generator) -> Sums:
    """Return the sum (14) after each step by number of landmarks; an unknown anchor is one."""
    study = FIG5 if known else FIG4
    return {n: total_information(replace(study, landmarks=n + (not known))) for n in rail.COUNTS}


def missing_ranks(totals: Sums) -> Interval:
    """Return the most ranks that a sum misses, at every step and for every n."""
    missing = max(int(J.shape[-1] - kalman.scale_free_rank(J).min()) for J in totals.values())
    return exact(missing, about=f"steps 1 to {FIG4.steps}, n = 1 to {rail.COUNTS[-1]}")


RANK = Study(sums, full=True, quick=True, seed=20)


@RANK.claim(
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
    sabotage=Change(
        "an anchor whose place is unknown, one more landmark of the state", config=False
    ),
    value=missing_ranks,
)
def anchor_full_rank(totals: Sums, value: Interval) -> Finding:
    """Count the missing ranks with the anchor, and prove eq. (22) in symbols."""
    least = {
        str(n): [
            np.linalg.eigvalsh(m)[..., 0].min() for m in (np.diff(J, axis=0, prepend=0), J[-1])
        ]
        for n, J in totals.items()
    }
    plain = total_information(FIG4)[-1]
    start = {
        f"{k} measurements": information_on_start(replace(FIG5, steps=k))[-1]
        for k in (FIG4.steps, 2 * FIG4.steps)
    }
    columns = {"term (22)": "of a single term", "sum (14)": "after all measurements"}
    vehicle, landmark = np.transpose([np.diag(J) for J in start.values()]).tolist()
    rows = {"vehicle": vehicle, "landmark": landmark}
    ranks = [int(kalman.scale_free_rank(J)) for J in (plain, *start.values())]
    return Finding(
        value,
        {
            "missing ranks without the anchor, n = 1": exact(2 - ranks[0]),
            "n of 1, 2, 3 for which eq. 22 holds in symbols, with det J = det S⁻¹": exact(
                sum(_symbolic_identity(n) for n in (1, 2, 3))
            ),
            "missing ranks of the information on the start, n = 1": exact(2 - ranks[1]),
        },
        {
            "smallest eigenvalue (1/m²)": Table(least, columns, corner="n"),
            "information on the start (1/m²)": Table(rows, dict.fromkeys(start, "")),
        },
        note="H of eq. 20 is square with determinant ±1, so every single term has the full rank of "
        "S⁻¹. The sums of ς run over all measurements, the anchor's (index 0) included.",
    )


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


# The first error ------------------------------------------------------------------------------

UNSEEN = float(np.tanh(stats.norm.ppf(0.975) / np.sqrt(97)) ** 2)
"""The squared correlation that 100 runs, the paper's number, cannot tell from none (95 %)."""
_FADED = Accepted(
    0,
    UNSEEN,
    "of a filter that is right both shares are the same number, and 100 runs, the paper's number, "
    f"cannot tell a squared correlation below {UNSEEN:.3f} from none (95 %)",
)
NOISES = (0.01, 0.1, 0.2, 0.3, 1.0)
"""Constant parts of a reference's deviation with which the claims are tried, m."""


def without_and_with(config: Config, *, rng: np.random.Generator) -> tuple[Ends, Ends]:
    """Return first and last errors in the same worlds without a reference and with one."""
    tied = run(config, rng=rng)
    untied = rail.refilter(replace(config, reference="none"), tied.world)
    plain = replace(tied, filtered=untied)
    return ends(plain), ends(tied)


def blurred(config: Config, *, rng: np.random.Generator) -> tuple[Ends, Ends]:
    """Make the last error large, and independent of the first."""
    plain, tied = without_and_with(config, rng=rng)
    return plain, replace(tied, last=tied.last + rng.standard_normal(len(tied.last)))


def share_left(found: Ends) -> Interval:
    """Return how much of the first error is left in the last, by the larger of two shares.

    For a last error may be large and independent, or small and a fixed share of the first.
    """
    return intervals.largest(found.explained, remaining_share(found))


def _table(found: tuple[Ends, Ends], reference: Kind) -> Table:
    """Return first and last errors without and with the reference."""
    rows = {
        name: (
            share_left(one),
            one.explained,
            intervals.correlation(one.first, one.last),
            intervals.root_mean_square(one.first, "m"),
            intervals.root_mean_square(one.last, "m"),
            intervals.mean(one.last, "m"),
        )
        for name, one in zip(("none", reference), found, strict=True)
    }
    columns = {
        "left": "the value: the larger of the share explained and the ratio of mean squares",
        "explained": "share of the variance of the last error that the first explains",
        "correlation": "of last and first error",
        "first (m)": "root mean square of the first error",
        "last (m)": "root mean square of the last error",
        "mean (m)": "mean of the last error",
    }
    return Table(rows, columns, f"95 % over {found[1].config.runs} runs", "reference")


def _rounding(a: np.ndarray, b: np.ndarray, scale: float = 1.0, unit: str = "") -> Interval:
    """Return the largest difference to twelve decimals: processors differ in what is below."""
    return exact(np.abs((a - b) / scale).max().round(12), unit, "to twelve decimals")


def _effect(
    config: Config,
    found: tuple[Ends, Ends],
    value: Interval,
    more: dict[str, Interval],
    note: str,
) -> Finding:
    """Return what a reference does to the first error, by one rule for anchor and sensor."""
    (other,) = set(SIGNS) - {config.reference}
    both, tied = (config, replace(config, reference=other)), found[1]
    counts = np.array([100.0, 200.0, 400.0, 800.0])
    shares = np.array([remaining_shares(replace(config, steps=int(k)))[-1] for k in counts])
    one, twin = (covariances(each) for each in both)
    J, K = (total_information(each) for each in both)
    same = f"from an {other} of equal noise"
    evidence = {
        "correlation with the first error over 100 runs": intervals.correlation(
            tied.first[:100], tied.last[:100]
        ),
        "exponent of the explained share against the measurements, by the covariances": (
            intervals.exponent(counts, shares)
        ),
        "gain on the landmark's own innovation at the last measurement": exact(
            one.gains[0, -1, 1, 1]
        ),
        f"largest relative difference of the covariances {same}": _rounding(
            one.covs, twin.covs, twin.covs.max()
        ),
        f"largest relative difference of the sums (14) {same}": _rounding(J, K, K.max()),
    }
    noises = {
        d: covariances(replace(config, reference_deviation=d)).covs[0, :, 1, 1] for d in NOISES
    }
    shares = {d: variances[-1] / variances[0] for d, variances in noises.items()}
    rows = {f"{d} m": (noises[d][-1] ** 0.5, shares[d]) for d in NOISES}
    columns = {
        "stated (m)": "deviation of the landmark after 100 measurements",
        "left": "share of the first error's variance after 100 measurements, by the covariances",
    }
    worse = min((d for d, share in shares.items() if share > UNSEEN), default=np.inf)
    good_enough = Condition(
        f"the reference is good enough for the number of measurements: the constant part of its "
        f"error is {config.reference_deviation} m here (ours); with {worse} m a hundred leave too "
        "much",
        bool(shares[NOISES[-1]] > UNSEEN),
    )
    tables = {
        "with and without the reference": _table(found, config.reference),
        "other noises": Table(rows, columns, corner="deviation"),
    }
    return Finding(value, evidence | more, tables, (good_enough,), note)


ANCHOR, SENSOR = (
    Study(without_and_with, full=replace(c, runs=10_000), quick=replace(c, runs=2_000), seed=21)
    for c in (FIG5, FIG6)
)


@ANCHOR.claim(
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
    sabotage=(
        Change("no anchor", reference="none"),
        Change("an anchor that stands 0.1 m from where the robot believes it", misplaced=0.1),
        Change("1 m of noise added to the last error", blurred),
    ),
    value=lambda found: share_left(found[1]),
)
def anchor_unbiased(found: tuple[Ends, Ends], value: Interval) -> Finding:
    """Measure what is left of the first error with the anchor, and what else the anchor does."""
    right, off = (covariances(replace(FIG5, misplaced=m)).means[0, -1, 1] for m in (0.0, 0.1))
    distances = anchored_and_relative(100, rng=np.random.default_rng(5))
    return _effect(
        FIG5,
        found,
        value,
        {
            "what an anchor surveyed 0.1 m off adds to the last error": exact(off - right, "m"),
            "largest difference from landmark minus anchor by the plain filter": _rounding(
                *distances, unit="m"
            ),
        },
        "The dependence fades like one over the number of measurements: at 100 it is small, "
        "not zero. The distance to the anchor is what the filter without an anchor knows as well: "
        "the anchor names the origin, it does not sharpen the map.",
    )


@SENSOR.claim(
    "external-sensor",
    paper=PAPER,
    place="§2.2, eq. 23, Fig. 6",
    basis="substitute",
    statement="A fixed sensor that measures the vehicle has the same effect as the anchor.",
    paper_value="theoretically equivalent",
    method="As for the anchor, by the same rule, with a sensor of 0.1 m (ours) that watches the "
    "vehicle.",
    accepted=_FADED,
    sabotage=(
        Change("no sensor", reference="none"),
        Change("a sensor that stands 0.1 m from where the robot believes it", misplaced=0.1),
        Change("1 m of noise added to the last error", blurred),
    ),
    value=lambda found: share_left(found[1]),
)
def external_sensor(found: tuple[Ends, Ends], value: Interval) -> Finding:
    """Measure the same as for the anchor, against one of equal noise, and with other noises."""
    regular = [_same_determinant(*symbolic_information(n, "external sensor")) for n in (1, 2, 3)]
    return _effect(
        FIG6,
        found,
        value,
        {"n of 1, 2, 3 for which det J = det S⁻¹ in symbols": exact(sum(regular))},
        "With equal noise the two are one system: a sign in the first row of H, which no "
        "covariance feels. What tells Fig. 6 from Fig. 5 is the noise, which the paper leaves out "
        "and we chose.",
    )
