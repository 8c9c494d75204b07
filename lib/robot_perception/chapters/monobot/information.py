"""Experiments of the chapter "The unobservable monobot".

The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2. Step 0 is the first
look, which puts the landmarks into the map; every later step first moves, then looks.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy import stats

from data_synth.monobot import RailRuns
from robot_perception import datasets
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.monobot.rail import (
    COUNTS,
    FIG3,
    FIG4,
    GOLDEN,
    PAPER,
    Config,
    covariances,
    run,
    simulate,
    total_information,
)
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.kalman import (
    Sensor,
    fisher_information,
    predict,
    scale_free_rank,
    start_information,
    steady_state,
    update,
)
from robot_perception.slam.monobot import (
    MonobotRun,
    first_look,
    motion,
    one_landmark_term,
    relative_system,
    run_filter,
    sensor_matrix,
    settled,
)
from robot_perception.teaching.claims import Accepted, Claim, Condition, Finding, Interval, Size
from robot_perception.teaching.exercises import Exercise, Sheet
from robot_perception.teaching.explore import choice, slider
from robot_perception.teaching.recordings import Recording

CONTROLS = {
    "landmarks": slider("Landmarks", (1, 5, 20), 1),
    "start_deviation": slider("σ of the start", (0.0, 0.1, 0.3), 0.1, "m"),
    "motion_share": slider("σ of a move", (0.1, 0.5), 0.5, "of the command"),
    "look_share": slider("σ of a look", (0.05, 0.2), 0.05, "of the distance"),
    "shape": choice("Path", ("sine", "there and back", "at rest"), "sine"),
}
"""Controls over the settings of a study; their names are those of :class:`Config`."""


# Information -----------------------------------------------------------------------------------


def first_entries(counts: tuple[int, ...] = COUNTS, base: Config = FIG3) -> dict[int, np.ndarray]:
    """Return the curves of Fig. 3: first entry of eq. (14) by number of landmarks."""
    return {n: total_information(replace(base, landmarks=n))[:, 0, 0] for n in counts}


def information_on_start(config: Config) -> Float[np.ndarray, "steps states states"]:
    """Return the information of the looks after the first one about the state at the start."""
    n = config.landmarks
    moves = [motion(0.0, float(s) ** 2, n) for s in config.motion_deviations]
    sensors = [Sensor(sensor_matrix(n), np.diag(s**2)) for s in config.look_deviations[1:]]
    return start_information(moves, sensors)


def log_likelihood_of_shift(
    config: Config, vehicle: np.ndarray, landmark: np.ndarray, *, rng: np.random.Generator
) -> Float[np.ndarray, "landmark vehicle"]:
    """Return how likely one run makes each pair of start and landmark, relative to the best.

    The filter starts from the pair itself, known exactly, and adds up the log-likelihoods of its
    innovations; nothing of the closed forms is used.

    Parameters
    ----------
    config
        A study with one landmark; its first run is used.
    vehicle, landmark : (…,)
        Positions to try, m.
    rng
        Generator of the run.

    Returns
    -------
    (landmark, vehicle)
    """
    world = simulate(replace(config, runs=1), rng=rng)
    pairs = np.stack(np.meshgrid(vehicle, landmark), axis=-1)
    belief, total = Gaussian(pairs, np.zeros((2, 2))), 0.0
    for k in range(config.steps + 1):
        if k > 0:
            move = motion(world.commands[k - 1], config.motion_deviations[k - 1] ** 2, 1)
            belief = predict(belief, move)
        sensor = Sensor(sensor_matrix(1), config.look_deviations[k][None] ** 2)
        belief, info = update(belief, world.looks[0, k], sensor)
        total = total + info.log_likelihood
    return total - np.max(total)


@dataclass(frozen=True, eq=False, slots=True)
class Plane:
    """What is known about start position and landmark of one run, in the plane of both.

    Parameters
    ----------
    truth, mean : (2,)
        Vehicle and landmark, m.
    cov : (2, 2)
        Covariance of the filter, m².
    information : (2, 2)
        Total information of eq. (14), with the known landmark if there is one, 1/m².
    """

    truth: Float[np.ndarray, "2"]
    mean: Float[np.ndarray, "2"]
    cov: Float[np.ndarray, "2 2"]
    information: Float[np.ndarray, "2 2"]


def plane_after(looks: int, *, known_landmark: bool, rng: np.random.Generator) -> Plane:
    """Return what is known after some looks at one landmark, with or without one known post.

    Parameters
    ----------
    looks
        Number of looks after the first.
    known_landmark
        Whether the robot also measures its distance to a post at the origin, as in eq. (20).
    rng
        Generator of the run.

    Returns
    -------
    Plane
    """
    config = replace(FIG3, runs=1, steps=100)
    world = simulate(config, rng=rng)
    posts = rng.standard_normal(config.steps + 1) - world.positions[0]
    sensor = Sensor(sensor_matrix(1), np.eye(1))
    if known_landmark:
        sensor = Sensor(np.array([[-1.0, 0.0], [-1.0, 1.0]]), np.eye(2))
    belief = first_look(config.belief, world.looks[0, 0], 1.0)
    information = np.zeros((2, 2))
    for k in range(1, looks + 1):
        z = np.array([posts[k], world.looks[0, k, 0]]) if known_landmark else world.looks[0, k]
        belief = predict(belief, motion(world.commands[k - 1], 1.0, 1))
        belief, info = update(belief, z, sensor)
        information += fisher_information(sensor.matrix, info.innovation_cov[None])[-1]
    truth = np.array([world.positions[0, looks], config.landmarks_at])
    return Plane(truth, belief.mean, belief.cov, information)


# Many runs and many landmarks ------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Spread:
    """Errors at the end against the number of landmarks.

    Parameters
    ----------
    counts : (c,)
        Numbers of landmarks.
    measured : (c,)
        Root mean square error of one landmark over all runs, m.
    expected : (c,)
        The same by the covariance of the filter, m.
    total : (c,)
        Expected sum of squared errors over the whole state (trace of the covariance), m².
    floor
        What no number of landmarks removes: the deviation of the start, m.
    """

    counts: np.ndarray
    measured: np.ndarray
    expected: np.ndarray
    total: np.ndarray
    floor: float


def spread(base: Config, counts: tuple[int, ...] = COUNTS, *, rng: np.random.Generator) -> Spread:
    """Run a study once for each number of landmarks."""
    measured, expected, total = [], [], []
    for n, own in zip(counts, rng.spawn(len(counts)), strict=True):
        result = run(replace(base, landmarks=n), rng=own)
        cov = result.filtered.covs[0, -1]
        measured.append(np.sqrt(np.mean(result.last_errors**2)))
        expected.append(np.sqrt(cov[1, 1]))
        total.append(np.trace(cov))
    return Spread(
        np.array(counts),
        np.array(measured),
        np.array(expected),
        np.array(total),
        base.start_deviation,
    )


def gain_curves(counts: tuple[int, ...], base: Config) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Return, by number of landmarks, the gain of a landmark on the common innovation and its own.

    The common gain answers to all innovations moving together; the own gain is what remains of a
    landmark's answer to its own innovation.
    """
    curves = {}
    for n in counts:
        gains = covariances(replace(base, landmarks=n)).gains[0, :, 1:]
        common = gains.sum(axis=2)[:, 0]
        curves[n] = common, np.diagonal(gains, axis1=1, axis2=2)[:, 0] - common / n
    return curves


def exponent(x: np.ndarray, y: np.ndarray) -> float:
    """Return the slope of log y against log x by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


# Broken on purpose -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Variant:
    """One way to run the filter, right or broken.

    Parameters
    ----------
    name
        What was done.
    errors : (runs, looks)
        Landmark error, m.
    deviations : (looks,)
        What the filter believes it to be, m.
    """

    name: str
    errors: Float[np.ndarray, "runs looks"]
    deviations: Float[np.ndarray, "looks"]

    @property
    def nees(self) -> Float[np.ndarray, "looks"]:
        """Mean squared error over variance at each step; 1 for an honest filter."""
        value = normalised_squared(self.errors[..., None], self.deviations[:, None, None] ** 2)
        return value.mean(axis=0)


def variants(config: Config, *, rng: np.random.Generator) -> tuple[Variant, ...]:
    """Run the filter rightly, and in four other ways, on the same worlds with one landmark.

    Parameters
    ----------
    config
        A study with one landmark.
    rng
        Generator of the worlds.

    Returns
    -------
    tuple of Variant
        As the paper says; P0 a hundredth of the truth; update before predict; no cross-covariance
        at the first look; with a second landmark whose position is known.
    """
    config = replace(config, landmarks=1)
    world = simulate(config, rng=rng)
    posts = rng.standard_normal(world.positions.shape) * config.look_deviations[:, 0]
    posts -= world.positions  # distances to a post at the origin
    timid = replace(config, start_deviation=config.start_deviation / 10)
    return (
        _variant("as the paper says", config, world),
        _variant("P0 a hundredth of the truth", timid, world),
        _variant("update before predict", config, world, late=True),
        _variant("no cross-covariance", config, world, forget=True),
        _variant("one known landmark", config, world, posts=posts),
    )


def _variant(
    name: str,
    config: Config,
    world: RailRuns,
    *,
    late: bool = False,
    forget: bool = False,
    posts: np.ndarray | None = None,
) -> Variant:
    W = config.look_deviations**2
    belief = first_look(config.belief, world.looks[:, 0], W[0])
    if forget:
        belief = Gaussian(belief.mean, belief.cov * np.eye(2))
    history = [belief]
    for k in range(1, config.steps + 1):
        move = motion(world.commands[k - 1], config.motion_deviations[k - 1] ** 2, 1)
        sensor, z = Sensor(sensor_matrix(1), W[k][None]), world.looks[:, k]
        if posts is not None:
            sensor = Sensor(np.array([[-1.0, 0.0], [-1.0, 1.0]]), W[k] * np.eye(2))
            z = np.stack([posts[:, k], z[:, 0]], axis=-1)
        if late:
            belief = predict(update(belief, z, sensor)[0], move)
        else:
            belief = update(predict(belief, move), z, sensor)[0]
        history.append(belief)
    errors = np.stack([b.mean[:, 1] for b in history], axis=1) - config.landmarks_at
    return Variant(name, errors, np.sqrt([b.cov[1, 1] for b in history]))


# A real corridor -------------------------------------------------------------------------------

CORRIDOR_LOG = "intel_odom_and_corrected.log.gz"
CORRIDOR_SCANS = slice(72, 88)
"""A straight stretch of the Intel Research Lab log that ends in front of a wall; our choice."""
CORRIDOR_NOISE = {"start": 0.1, "motion": 0.05, "look": 0.03}
"""Deviations that we assume for it, m; odometry per step from the log's description."""


def corridor(folder: Path) -> dict[str, np.ndarray]:
    """Return a straight stretch of a real log as a monobot: moves, and distances to the end wall.

    The moves are those of the wheels alone. The beam that looks along the corridor is picked with
    the heading of the corrected log, since a monobot has no heading.

    Parameters
    ----------
    folder
        Folder of the data set ``carmen_intel``.

    Returns
    -------
    dict
        ``commands`` (steps,), ``looks`` (steps + 1,), ``track`` (steps + 1,): distance along the
        corridor by the corrected poses; all in m.
    """
    log = datasets.read_carmen_log(folder / CORRIDOR_LOG)
    poses, wheels = log.poses[CORRIDOR_SCANS], log.odometry[CORRIDOR_SCANS]
    way = poses[-1, :2] - poses[0, :2]
    direction = np.arctan2(way[1], way[0])
    looks = []
    for pose, ranges in zip(poses, log.ranges[CORRIDOR_SCANS], strict=True):
        turn = np.angle(np.exp(1j * (log.angles - direction + pose[2])))
        nearest = np.argsort(np.abs(turn))[:3]
        looks.append(np.median(ranges[nearest]))
    along = (poses[:, :2] - poses[0, :2]) @ way / np.linalg.norm(way)
    commands = np.linalg.norm(np.diff(wheels[:, :2], axis=0), axis=1)
    return {"commands": commands, "looks": np.array(looks), "track": along}


CORRIDOR = Recording("carmen_intel", corridor, store="monobot-corridor")
RECORDINGS = (CORRIDOR,)


def filter_corridor(stretch: Mapping[str, np.ndarray], *, origin: float) -> MonobotRun:
    """Filter the corridor with the origin of the world put anywhere.

    Parameters
    ----------
    stretch
        What :func:`corridor` returned.
    origin
        Where the robot believes that it starts, m.

    Returns
    -------
    MonobotRun
        One run with one landmark, the end wall.
    """
    start = Gaussian(np.array([origin]), np.array([[CORRIDOR_NOISE["start"] ** 2]]))
    return run_filter(
        start,
        stretch["commands"],
        stretch["looks"][None, :, None],
        motion_variance=CORRIDOR_NOISE["motion"] ** 2,
        look_variance=CORRIDOR_NOISE["look"] ** 2,
    )


# The claims ------------------------------------------------------------------------------------


def _fisher_growth(size: Size, rng: np.random.Generator) -> Finding:
    curves = first_entries()
    table = np.stack(list(curves.values()))
    least = min(
        (np.diff(table, axis=1) / table[:, 1:]).min(), (np.diff(table, axis=0) / table[1:]).min()
    )
    evidence = {}
    for n in (1, 10, 50):
        slope = table[COUNTS.index(n), -1] - table[COUNTS.index(n), -2]
        exact = settled(n, start_variance=1, motion_variance=1, look_variance=1).information_rate
        evidence[f"slope per step, n = {n}"] = Interval.exact(slope, "1/m²")
        evidence[f"closed form, n = {n}"] = Interval.exact(exact, "1/m²")
    start = information_on_start(replace(FIG3, steps=60))[-1, 0, 0]
    evidence["information on the start itself, n = 1"] = Interval.exact(start, "1/m²")
    return Finding(
        Interval.exact(least, about="least relative increase over 100 steps and six n"),
        evidence,
        note=f"The sum of eq. 14 grows without end, by at most 1/V per step; it counts each "
        f"innovation as a fresh look at one state. The information that all later looks together "
        f"hold on the start stays at {start:.3f} per m².",
    )


def _fisher_singular(size: Size, rng: np.random.Generator) -> Finding:
    nullity, row_sum, angle = [], [], []
    for base in (FIG3, FIG4):
        for n in COUNTS:
            J = total_information(replace(base, landmarks=n))
            nullity.append(n + 1 - scale_free_rank(J))
            row_sum.append(np.abs(J.sum(axis=-1)).max() / np.abs(J).max())
            kernel = np.linalg.eigh(J[-1])[1][:, 0]
            angle.append(np.arccos(min(1.0, abs(kernel.sum()) / np.sqrt(n + 1))))
    nullity = np.concatenate(nullity)
    return Finding(
        Interval(
            float(np.median(nullity)),
            float(nullity.min()),
            float(nullity.max()),
            about=f"null directions, all of {nullity.size} matrices",
        ),
        {
            "largest row sum over largest entry": Interval.exact(max(row_sum)),
            "largest angle between kernel and (1, …, 1)": Interval.exact(max(angle), "rad"),
        },
        note="Rank n for n + 1 unknowns, with constant noise and with that of Fig. 4: moving the "
        "whole world changes no measurement, so the bound of eq. 16 does not exist. As eq. 15 "
        "shows, the first row is minus the sum of the others; the text leaves the sign out.",
    )


def _fisher_one_landmark(size: Size, rng: np.random.Generator) -> Finding:
    worst = 0.0
    for base in (FIG3, FIG4):
        filtered = covariances(base)
        before = filtered.covs[0, :-1].copy()
        before[:, 0, 0] += base.motion_deviations**2
        deviations = np.sqrt(np.diagonal(before, axis1=1, axis2=2))
        correlation = before[:, 0, 1] / deviations.prod(axis=1)
        terms = one_landmark_term(*deviations.T, correlation, base.look_deviations[1:, 0])
        general = total_information(base)
        gap = np.abs(np.cumsum(terms, axis=0) - general).max(axis=(1, 2))
        worst = max(worst, float((gap / general[:, 0, 0]).max()))
    return Finding(Interval.exact(worst, about="largest relative difference, 200 matrices"))


def _gain_vanishes(size: Size, rng: np.random.Generator) -> Finding:
    steps = np.arange(5, 16)
    gain = covariances(FIG3).gains[0, :, 1, 0]
    rate = float(np.exp(np.polyfit(steps, np.log(gain[steps - 1]), 1)[0]))
    state = steady_state(*relative_system(1, motion_variance=1.0, look_variance=1.0))
    pole = float(np.abs(state.poles[0]))
    _, own = gain_curves((2,), replace(FIG3, steps=1000))[2]
    late = np.arange(500, 1001)
    slow = exponent(late, own[late - 1])
    slowest_ratio = float(own[-1] / own[-2])
    return Finding(
        Interval.exact(rate, about="factor per step, fitted over steps 5 to 15"),
        {
            "pole of the steady state (Riccati)": Interval.exact(pole),
            "time constant": Interval.exact(state.time_constant, "steps"),
            "gain at the first step": Interval.exact(gain[0]),
            "gain at step 15": Interval.exact(gain[14]),
            "gain at the end with the noise of Fig. 4": Interval.exact(
                covariances(FIG4).gains[0, -1, 1, 0]
            ),
            "exponent of the own gain against k, n = 2": Interval.exact(slow),
        },
        (
            Condition(
                "there is one landmark: with several, only the gain on their common innovation "
                f"has this rate, and the rest falls like k to the power {slow:.2f}",
                abs(slowest_ratio - pole) > 0.1,
            ),
        ),
        note="The gain does go to zero for every number of landmarks.",
    )


def _explained(first: np.ndarray, last: np.ndarray) -> Interval:
    """Return the squared correlation with its 95 % interval by Fisher's transformation."""
    r = float(np.corrcoef(first, last)[0, 1])
    half = stats.norm.ppf(0.975) / np.sqrt(first.size - 3)
    low, high = np.tanh(np.arctanh(r) + np.array([-half, half]))
    ends = (max(low, 0.0) ** 2, high**2)
    return Interval(r**2, *map(float, ends), about=f"95 % over {first.size} runs")


def _initial_error_persists(size: Size, rng: np.random.Generator) -> Finding:
    runs = 10_000 if size is Size.FULL else 2_000
    base = replace(FIG4, runs=runs)
    fig4 = run(base, rng=rng)
    first, last = fig4.first_errors[:, 0], fig4.last_errors[:, 0]
    value = _explained(first, last)
    hundred = _explained(first[:100], last[:100])
    fig3 = run(replace(FIG3, runs=runs), rng=rng)
    constant = _explained(fig3.first_errors[:, 0], fig3.last_errors[:, 0])
    known = run(replace(base, start_deviation=0.0), rng=rng)
    known_start = _explained(known.first_errors[:, 0], known.last_errors[:, 0])
    many = run(replace(base, landmarks=20), rng=rng)
    common = _explained(many.first_errors.mean(axis=1), many.last_errors.mean(axis=1))
    frozen = np.abs(last - fig4.landmark_errors[:, -25, 0]).max()
    off = int(np.sum(np.abs(last) > 0.02))
    return Finding(
        value,
        {
            "the same over 100 runs": hundred,
            "the same at P0 = V = W = 1 (theory: φ/2)": constant,
            "the same with the start known exactly": known_start,
            "the same for the mean of 20 landmarks": common,
            "root mean square of the first error": Interval.exact(np.sqrt(np.mean(first**2)), "m"),
            "root mean square of the last error": Interval.exact(np.sqrt(np.mean(last**2)), "m"),
            "largest change over the last quarter": Interval.exact(frozen, "m"),
            "share of runs that end more than 2 cm off": Interval.of_proportion(off, runs),
        },
        (
            Condition(
                "the first look is the main error: the vehicle's initial variance must not be "
                "small against that of a look. With the start known exactly the first error "
                f"explains {known_start.estimate:.2f} of the variance of the last",
                known_start.high < 0.5,
            ),
        ),
        note="It stays, but it is not equal to the first error: later looks take a part away. With "
        "several landmarks only the error that they share is frozen.",
    )


def _monte_carlo_unbiased(size: Size, rng: np.random.Generator) -> Finding:
    runs = 10_000
    result = run(replace(FIG4, runs=runs), rng=rng)
    last = result.last_errors[:, 0]
    deviation = float(result.filtered.deviations[0, -1, 1])
    scaled = Interval.of_mean(last / deviation, level=0.99)
    hundred = Interval.of_mean(last[:100], "m")
    offset = 0.2 * deviation
    shifted = Interval.of_mean((last + offset) / deviation, level=0.99)
    return Finding(
        scaled,
        {
            "mean error over 10 000 runs": Interval.of_mean(last, "m"),
            "mean error over 100 runs": hundred,
            "spread of single runs": Interval.exact(deviation, "m"),
            "what a sensor that reads a fifth of the spread too long would give": shifted,
        },
        note="The ensemble is right and single runs are wrong: the error of one run does not "
        "average out, because it is the same error at every step.",
    )


def _many_landmarks_help(size: Size, rng: np.random.Generator) -> Finding:
    runs = 10_000 if size is Size.FULL else 2_000
    few = run(replace(FIG3, runs=runs), rng=rng)
    many = run(replace(FIG3, runs=runs, landmarks=50), rng=rng)
    a, b = few.last_errors[:, 0], many.last_errors[:, 0]
    ratio = float(b.var(ddof=1) / a.var(ddof=1))
    low, high = ratio / stats.f.ppf([0.975, 0.025], runs - 1, runs - 1)
    start = many.config.start - many.world.positions[:, 0]
    fit = stats.linregress(start, b)
    half = stats.t.ppf(0.975, runs - 2) * fit.stderr
    persists = Interval(
        float(fit.slope), float(fit.slope - half), float(fit.slope + half), "", f"95 %, {runs} runs"
    )
    form = {
        n: settled(n, start_variance=1, motion_variance=1, look_variance=1).landmark_variance
        for n in (1, 50)
    }
    return Finding(
        Interval(ratio, float(low), float(high), "", f"variance ratio, 95 % over {runs} runs each"),
        {
            "variance of the limit, n = 1 (closed form: φ)": Interval.exact(form[1], "m²"),
            "variance of the limit, n = 50": Interval.exact(form[50], "m²"),
            "floor P0": Interval.exact(FIG3.start_deviation**2, "m²"),
            "share of the vehicle's initial error that stays, n = 50": persists,
        },
        (
            Condition(
                "initial conditions means the first looks: the vehicle's own initial error stays "
                "in full, whatever the number of landmarks",
                persists.low > 0.5,
            ),
        ),
        note="The noise of the first looks averages out over the landmarks, down to the floor P0.",
    )


def _statement_proportional(size: Size, rng: np.random.Generator) -> Finding:
    counts = (10, 20, 50, 100, 200) if size is Size.FULL else (10, 20, 50, 100)
    total, each, norm = [], [], []
    for n in counts:
        cov = covariances(replace(FIG3, landmarks=n)).covs[0, -1]
        total.append(np.trace(cov))
        each.append(np.sqrt(cov[1, 1]))
        norm.append(np.sqrt(np.trace(cov[1:, 1:])))
    x = np.array(counts)
    runs = 1_000 if size is Size.FULL else 300
    measured = run(replace(FIG3, runs=runs, landmarks=50), rng=rng)
    squared = (measured.vehicle_errors[:, -1] ** 2) + (measured.last_errors**2).sum(axis=1)
    single = exponent(x, np.array(each))
    return Finding(
        Interval.exact(exponent(x, np.array(total)), about=f"exponent over n = {x[0]} to {x[-1]}"),
        {
            "exponent of the error of one landmark": Interval.exact(single),
            "exponent of the norm of the map's error": Interval.exact(exponent(x, np.array(norm))),
            "sum of squared errors by the filter, n = 50": Interval.exact(
                total[counts.index(50)], "m²"
            ),
            "sum of squared errors, measured, n = 50": Interval.of_mean(squared, "m²"),
        },
        (
            Condition(
                "error means the sum of squared errors over the whole state, in which every "
                "landmark repeats the same frozen error; the error of one landmark falls with n, "
                f"with exponent {single:.3f}",
                not 0.9 <= single <= 1.1,
            ),
        ),
        note="Both statements of the paper hold, for different errors: more landmarks make each "
        "estimate better and the sum over all of them larger.",
    )


CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="fisher-growth",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, Fig. 3",
        statement="The first entry of the total Fisher information grows with the number of steps "
        "and with the number of landmarks.",
        paper_value="Fig. 3: rising curves for various sizes of the measurement vector",
        method="Eq. 14 at P0 = V = W = 1 m², n = 1, 2, 5, 10, 20, 50, 100 steps, landmarks from "
        "the first look, predict before update: least relative increase from step to step and "
        "from n to n.",
        accepted=Accepted(
            1e-6,
            1,
            "growing means that every increase, as a share of the new value, is positive; 1e-6 is "
            "far above rounding",
        ),
        compute=_fisher_growth,
    ),
    Claim(
        id="fisher-singular",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, eqs 15–18",
        statement="The first row of the information is minus the sum of the others: it is singular "
        "with the null vector (1, …, 1), and the Cramér–Rao bound does not exist.",
        paper_value="one zero eigenvalue",
        method="Number of states minus scale-free rank, at every step, for six n, with the noise "
        "of Fig. 3 and of Fig. 4.",
        accepted=Accepted(1, 1, "exactly one direction, by the form of the measurement matrix"),
        compute=_fisher_singular,
    ),
    Claim(
        id="fisher-one-landmark",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, eq. 17",
        statement="For one landmark the information is the sum of 1/s times [[1, −1], [−1, 1]], "
        "with s written out in deviations and correlation.",
        paper_value="eq. 17",
        method="Largest relative difference from the general sum of eq. 14 over 100 steps, with "
        "the noise of Fig. 3 and of Fig. 4.",
        accepted=Accepted(0, 1e-10, "an identity: equal up to the rounding of 100 additions"),
        compute=_fisher_one_landmark,
    ),
    Claim(
        id="gain-vanishes",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, Fig. 4",
        statement="The Kalman gain of the landmark goes to zero, at the rate of the system's time "
        "constant.",
        paper_value="Fig. 4, last column",
        method="Factor per step by which the gain shrinks at P0 = V = W = 1 m² and n = 1, fitted, "
        "against the closed-loop pole of the Riccati solution.",
        accepted=Accepted(
            GOLDEN**-2 * (1 - 1e-4),
            GOLDEN**-2 * (1 + 1e-4),
            "the pole 1/φ² of the steady state; the fit begins at step 5, where the gain is "
            "within 1e-4 of its limit law",
        ),
        compute=_gain_vanishes,
    ),
    Claim(
        id="initial-error-persists",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, Fig. 4",
        statement="The localisation errors do not converge to zero; their steady value is subject "
        "to the error of the first observation.",
        paper_value="Fig. 4, third column",
        method="Share of the variance of the last error (step 100) that the error after the first "
        "look explains (squared correlation), n = 1, noise of Fig. 4 with our factors.",
        accepted=Accepted(
            0.5,
            1,
            "subject to means that the first look is the main cause: it explains more than half; "
            "equality would be 1, and one landmark does not reach it",
        ),
        compute=_initial_error_persists,
        seed=4,
    ),
    Claim(
        id="monte-carlo-unbiased",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, text to Fig. 4",
        statement="Over 100 runs the mean landmark error is zero.",
        paper_value="0 over 100 runs",
        method="Mean last error over 10 000 runs with its 99 % interval, in units of the spread of "
        "single runs; the 100-run mean beside it.",
        accepted=Accepted(
            -0.05,
            0.05,
            "equivalence test: the whole 99 % interval within a twentieth of the spread, which an "
            "unbiased filter passes 98 times in 100 and a filter biased by 0.1 spreads fails",
        ),
        compute=_monte_carlo_unbiased,
        seed=5,
    ),
    Claim(
        id="many-landmarks-help",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, text to Fig. 4",
        statement="The steady-state error is less sensitive to the initial conditions when many "
        "landmarks are used.",
        paper_value="less sensitive",
        method="Variance of one landmark's last error with 50 landmarks over that with one, at "
        "P0 = V = W = 1 m².",
        accepted=Accepted(0, 0.9, "less means below 1; 0.9 is three standard errors at 2 000 runs"),
        compute=_many_landmarks_help,
        seed=6,
    ),
    Claim(
        id="statement-proportional",
        chapter="monobot",
        paper=PAPER,
        place="§2.2, introduction",
        statement="The expected error of the state estimate is proportional to the number of "
        "landmarks.",
        paper_value="proportional",
        method="Exponent of the expected sum of squared errors (trace of P after 100 steps) "
        "against n, for n of 10 and more, at P0 = V = W = 1 m².",
        accepted=Accepted(0.9, 1.1, "proportional means exponent 1; 0.1 for the vehicle's share"),
        compute=_statement_proportional,
        seed=7,
    ),
)


# The exercises ---------------------------------------------------------------------------------


def _landmarks_for(share: float) -> int:
    """Return the least n whose landmark variance is within a share of the floor, P0 = V = W = 1."""
    n = 1
    while (
        settled(n, start_variance=1, motion_variance=1, look_variance=1).landmark_variance
        > 1 + share
    ):
        n += 1
    return n


_ONE = settled(1, start_variance=1, motion_variance=1, look_variance=1)

EXERCISES = Sheet(
    {
        "monobot-1": Exercise(
            1 / GOLDEN,
            mistakes=(
                (GOLDEN, "that is the variance before the look; ask for the one after it."),
                (GOLDEN**-2, "that is the pole, by which errors shrink."),
                (1.0, "that is the variance after the very first look; it still shrinks."),
            ),
            hint="After a move and a look p becomes (p + 1) / (p + 2). Where does it stay?",
            rtol=1e-4,
        ),
        "monobot-2": Exercise(
            lambda row: _restores_rank(row),
            mistakes=(
                (
                    lambda row: np.allclose(np.sum(row), 0),
                    "its entries add up to zero, so it cannot feel a shift of the world either.",
                ),
            ),
            hint="It must be a row of three numbers: vehicle, first landmark, second landmark.",
        ),
        "monobot-3": Exercise(
            settled(4, start_variance=0.25, motion_variance=1, look_variance=1).landmark_variance,
            mistakes=(
                (_ONE.landmark_variance, "that is one landmark and P0 = 1."),
                (0.25, "that is the floor; four landmarks do not reach it."),
            ),
            hint="P0 + W/n · a/(a + W), with a = (nV + √(n²V² + 4nVW))/2.",
            rtol=1e-4,
        ),
        "monobot-4": Exercise(
            _landmarks_for(0.01),
            mistakes=(
                (_landmarks_for(0.01) - 1, "one more is needed: within means at most."),
                (_landmarks_for(0.1), "that is ten per cent."),
            ),
            hint="Ask `settled` for its landmark_variance and raise n until it is at most 1.01.",
        ),
    }
)
check = EXERCISES.check


def _restores_rank(row: object) -> bool:
    """Return whether one more row makes the information of two landmarks regular."""
    extra = np.asarray(row, dtype=float)
    if extra.shape != (3,):
        return False
    matrix = np.vstack([extra, sensor_matrix(2)])
    return bool(scale_free_rank(fisher_information(matrix, np.eye(3)[None])[-1]) == 3)
