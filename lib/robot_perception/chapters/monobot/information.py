"""The Fisher information of Fig. 3, counted exactly, and the direction that it is blind to."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import COUNTS, DECIMALS, FIG3, FIG4, PAPER, Config
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.kalman import Sensor
from robot_perception.slam import monobot as slam
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted


def first_entries(counts: tuple[int, ...] = COUNTS, base: Config = FIG3) -> dict[int, np.ndarray]:
    """Return the curves of Fig. 3: first entry of eq. (14) by number of landmarks."""
    return {n: rail.total_information(replace(base, landmarks=n))[:, 0, 0] for n in counts}


def exact_information(config: Config) -> Float[np.ndarray, "measurements states states"]:
    """Return the information about the state, of all measurements up to each, 1/m².

    The first measurement counts; the belief in the start does not.
    """
    H, first = slam.sensor_matrix(config.landmarks), config.measurement_deviations[0] ** 2
    start = H.T @ np.diag(1 / first) @ H
    return np.concatenate([start[None], kalman.state_information(*rail.system(config), start)])


def setup() -> Table:
    """Return the set-up of Fig. 3: the paper's values, ours, and which of them matters."""
    values = FIG3.start_deviation, FIG3.motion_deviation, FIG3.measurement_deviation
    unit = ", ".join(f"{value**2:g}" for value in values)
    return Table(
        {
            "P0, V, W": ["1, 1, 1", f"{unit} m²", "yes: V and W set the slope"],
            "landmarks": ["various", f"{COUNTS[0]} to {COUNTS[-1]}", "yes, less than one thinks"],
            "a landmark enters": ["not said", "by the first measurement", "no: the slope stays"],
            "order": ["not said", "move, then measure", "no: the slope stays"],
        },
        {"paper": "caption and text", "ours": "", "matters": "for the slopes of the figure"},
        corner="Fig. 3",
    )


@dataclass(frozen=True, eq=False, slots=True)
class Ridge:
    """How likely one run makes each pair of start and landmark, m, relative to the best."""

    vehicle: Float[np.ndarray, "vehicle"]
    landmark: Float[np.ndarray, "landmark"]
    log_likelihood: Float[np.ndarray, "landmark vehicle"]


def likelihood_of_shift(
    config: Config, vehicle: np.ndarray, landmark: np.ndarray, *, rng: np.random.Generator
) -> Ridge:
    """Try start positions and landmarks, m, on the first run of a study with one landmark.

    The filter starts from the pair itself, known exactly, and adds up the log-likelihoods of its
    innovations; nothing of the closed forms is used.
    """
    world = rail.simulate(replace(config, runs=1), rng=rng)
    pairs = np.stack(np.meshgrid(vehicle, landmark), axis=-1)
    belief, total = Gaussian(pairs, np.zeros((2, 2))), 0.0
    for k in range(config.steps + 1):
        if k > 0:
            move = slam.motion(world.commands[k - 1], config.motion_deviations[k - 1] ** 2, 1)
            belief = kalman.predict(belief, move)
        sensor = Sensor(slam.sensor_matrix(1), config.measurement_deviations[k][None] ** 2)
        belief, info = kalman.update(belief, world.measurements[0, k], sensor)
        total = total + info.log_likelihood
    return Ridge(vehicle, landmark, total - np.max(total))


@dataclass(frozen=True, eq=False, slots=True)
class Plane:
    """What is known of vehicle and landmark in one run: truth, belief (m), information (1/m²).

    The information is that of the first measurement and of so many ``measurements`` after it,
    without the belief in the start.
    """

    measurements: int
    anchored: bool
    truth: Float[np.ndarray, "2"]
    belief: Gaussian
    information: Float[np.ndarray, "2 2"]


def planes(*, anchored: bool, rng: np.random.Generator) -> list[Plane]:
    """Return what is known after each measurement of one run, without an anchor or with it."""
    config = replace(FIG3, runs=1, reference="anchor" if anchored else "none")
    result = rail.run(config, rng=rng)
    truths = np.insert(result.world.positions[0, :, None], 1, config.landmarks_at, axis=1)
    beliefs = map(Gaussian, result.filtered.means[0], result.filtered.covs[0])
    known = exact_information(config)
    states = enumerate(zip(truths, beliefs, known, strict=True))
    return [Plane(k, anchored, *state) for k, state in states]


def growth(base: Config, *, rng: np.random.Generator) -> Float[np.ndarray, "counts steps"]:
    """Return the curves of Fig. 3."""
    return np.stack(list(first_entries(base=base).values()))


def on_the_state_itself(base: Config, *, rng: np.random.Generator) -> np.ndarray:
    """Return what the measurements tell of the state as it is, which comes to an end."""
    return np.stack([exact_information(replace(base, landmarks=n))[1:, 0, 0] for n in COUNTS])


def shared_sensor(base: Config, *, rng: np.random.Generator) -> np.ndarray:
    """Return the curves of landmarks that are seen the worse the more there are."""
    bases = {n: replace(base, measurement_deviation=n**0.5) for n in COUNTS}
    return np.stack([first_entries((n,), config)[n] for n, config in bases.items()])


fig3 = Study(growth, full=FIG3, quick=FIG3)


@fig3.claim(
    "fisher-growth",
    paper=PAPER,
    place="§2.2, Fig. 3",
    basis="mathematics",
    statement="The first entry of the total Fisher information grows with the number of steps "
    "and with the number of landmarks.",
    paper_value="Fig. 3: rising curves for various sizes of the measurement vector",
    method="Eq. 14 at P0 = V = W = 1 m², n = 1, 2, 5, 10, 20, 50, 100 steps, landmarks from "
    "the first measurement, predict before update: least relative increase from step to step and "
    "from n to n.",
    accepted=Accepted(
        1e-6,
        1,
        "growing means that every increase, as a share of the new value, is positive; 1e-6 is "
        "far above rounding",
        "our choice",
    ),
    sabotage=[
        Change(
            "the information on the state itself in place of the sum of eq. 14",
            on_the_state_itself,
        ),
        Change("a sensor that shares its time among n landmarks, so that W = n m²", shared_sensor),
    ],
)
def fisher_growth(table: Float[np.ndarray, "counts steps"]) -> Finding:
    """Compare each curve of Fig. 3 with itself a step before, and with the one below."""
    over_steps, over_counts = np.diff(table, axis=1), np.diff(table, axis=0)
    least = min((over_steps / table[:, 1:]).min(), (over_counts / table[1:]).min())
    known = exact_information(FIG3)[-1, 0, 0]
    slopes = Table(
        {
            f"n = {n}": [slope, rail.limit(n).information_rate]
            for n, slope in zip(COUNTS, table[:, -1] - table[:, -2], strict=True)
        },
        {"last step (1/m²)": "", "closed form (1/m²)": "n / (a + W)"},
        "growth of the first entry of eq. 14 per step",
        "landmarks",
    )
    return Finding(
        exact(
            least.round(DECIMALS) + 0.0,
            about=f"least relative increase over {table.shape[1]} steps and {len(table)} n",
        ),
        {"information on the state itself after 100 steps, n = 1": exact(known, "1/m²")},
        {"slopes": slopes},
        note=f"The sum of eq. 14 grows without end, by at most 1/V per step. It adds up what each "
        f"measurement told of the state at its time, and the state has moved since: of the state "
        f"itself all measurements together tell {known:.3f} per m², and further ones add nothing.",
    )


def totals(bases: tuple[Config, ...], *, rng: np.random.Generator) -> list[np.ndarray]:
    """Return the total information of eq. (14) with each noise, for each number of landmarks."""
    configs = [replace(base, landmarks=n) for base in bases for n in COUNTS]
    return [rail.total_information(config) for config in configs]


both = Study(totals, full=(FIG3, FIG4), quick=(FIG3, FIG4))


@both.claim(
    "fisher-singular",
    paper=PAPER,
    place="§2.2, eqs 15–18",
    basis="mathematics",
    statement="The first row of the information is minus the sum of the others: it is singular "
    "with the null vector (1, …, 1), and the Cramér–Rao bound does not exist.",
    paper_value="one zero eigenvalue",
    method="Number of states minus scale-free rank, at every step, for six n, with the noise "
    "of Fig. 3 and of Fig. 4.",
    accepted=Accepted(1, 1, "exactly one direction, by the form of the measurement matrix"),
    sabotage=Change(
        "an anchor at the origin (eq. 20)",
        config=tuple(replace(base, reference="anchor") for base in (FIG3, FIG4)),
    ),
)
def fisher_singular(total: list[np.ndarray]) -> Finding:
    """Count the null directions, and compare the last one with a shift of the world."""
    row_sum, angle = [], []
    for J in total:
        row_sum.append(np.abs(J.sum(axis=-1)).max() / np.abs(J).max())
        kernel = np.linalg.eigh(J[-1])[1][:, 0]
        angle.append(np.arcsin(np.linalg.norm(kernel - kernel.mean())))
    nullity = np.concatenate([J.shape[-1] - kalman.scale_free_rank(J) for J in total])
    low, middle, high = (float(f(nullity)) for f in (np.min, np.median, np.max))
    return Finding(
        Interval(
            middle, low, high, about=f"dimension of the null space, all of {nullity.size} matrices"
        ),
        {
            f"largest row sum over largest entry, to {DECIMALS} decimals": exact(
                max(row_sum).round(DECIMALS)
            ),
            f"largest angle between kernel and (1, …, 1), to {DECIMALS} decimals": exact(
                max(angle).round(DECIMALS), "rad"
            ),
        },
        note="Rank n for n + 1 unknowns, with constant noise and with that of Fig. 4: moving the "
        "whole world changes no measurement, so the bound of eq. 16 does not exist. As eq. 15 "
        "shows, the first row is minus the sum of the others; the text leaves the sign out.",
    )


def eq17_gap(share: float, *, rng: np.random.Generator) -> float:
    """Return how far eq. (17) is off the sum of eq. (14) with a share of the correlation."""
    worst = 0.0
    for base in (FIG3, FIG4):
        before = rail.covariances(base).covs[0, :-1].copy()
        before[:, 0, 0] += base.motion_deviations**2
        deviations = np.sqrt(np.diagonal(before, axis1=1, axis2=2))
        correlation = share * before[:, 0, 1] / deviations.prod(axis=1)
        terms = slam.one_landmark_term(
            *deviations.T, correlation, base.measurement_deviations[1:, 0]
        )
        general = rail.total_information(base)
        gap = np.abs(np.cumsum(terms, axis=0) - general).max(axis=(1, 2))
        worst = max(worst, (gap / general[:, 0, 0]).max())
    return worst


written_out = Study(eq17_gap, full=1.0, quick=1.0)


@written_out.claim(
    "fisher-one-landmark",
    paper=PAPER,
    place="§2.2, eq. 17",
    basis="mathematics",
    statement="For one landmark the information is the sum of 1/s times [[1, −1], [−1, 1]], "
    "with s written out in deviations and correlation.",
    paper_value="eq. 17",
    method="Largest relative difference from the general sum of eq. 14 over 100 steps, with "
    "the noise of Fig. 3 and of Fig. 4.",
    accepted=Accepted(0, 1e-10, "an identity: equal up to the rounding of 100 additions"),
    sabotage=Change("the correlation of vehicle and landmark left out of s", config=0.0),
)
def fisher_one_landmark(gap: float) -> Finding:
    """Compare eq. (17) by the predicted deviations with the sum of eq. (14)."""
    about = f"largest relative difference of 200 matrices, to {DECIMALS} decimals"
    return Finding(exact(round(gap, DECIMALS), about=about))
