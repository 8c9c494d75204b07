"""Five robots against motion capture: the UTIAS recording, data set 6.

What the filter is told of a robot's wheels and camera is estimated from the other four robots, for
whom motion capture is taken to be known; the robot's own motion capture only starts it and judges
it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from scipy import stats

from robot_perception.datasets import read_mrclam
from robot_perception.datasets.mrclam import MrclamRobot, SurveyedLandmarks
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.evaluation.trajectories import absolute_error, end_error
from robot_perception.geometry import wrap_angle
from robot_perception.slam.planar import (
    Association,
    History,
    MapBelief,
    Observations,
    Odometry,
    RangeBearing,
    Settings,
    Step,
    compound,
    dead_reckoning,
    run_filter,
)
from robot_perception.streams import hold, merge
from robot_perception.teaching.recordings import Recording

GAP = 0.5
"""Longest gap of the motion capture that is bridged, s."""
WINDOW = 2.0
"""Time over which wheels are compared with motion capture, and lag of the correlations, s."""
DELAYS = np.arange(0.0, 0.51, 0.05)
"""Delays of the wheels that are tried, s."""
MISREAD = 0.1
"""A bearing that is wrong by more, rad, is of another barcode than the camera read."""
START = np.diag([0.001, 0.001, 0.005]) ** 2
"""Covariance of the start pose, from motion capture; ours."""
ANCHORS = ("none", "one", "two")
METHODS = ("white", "lasting", "first", "unbiased", "nearest", "joint")
SAMPLES = 170
"""Times of each drive at which paths and errors are stored."""


@dataclass(frozen=True, eq=False, slots=True)
class Found(Mapping[str, np.ndarray]):
    """What was computed from a recording, by name."""

    parts: Mapping[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)


@dataclass(frozen=True, eq=False, slots=True)
class Calibration:
    """What motion capture says of the sensors of one robot, or of several together.

    Parameters
    ----------
    delay
        Time from a logged command to the motion, s: of `DELAYS` the one that explains turns best.
    scale : (2,)
        True over logged motion, forward and turning.
    drag
        Way that is lost for each radian logged, m/rad: who turns goes slower than the log says.
    density : (2,)
        Variance of the rest per second: m²/s, rad²/s.
    bias : (2,)
        Median error of range (m) and bearing (rad).
    sigma : (2,)
        Standard deviation of range and bearing without the misread barcodes.
    persistence : (2,)
        Correlation of two errors on one landmark, `WINDOW` seconds apart.
    interval
        Mean time between images while there are any, s.
    misread
        Sightings left out of all this, because the barcode cannot be the one that was read.
    """

    delay: float
    scale: Float[np.ndarray, "2"]
    drag: float
    density: Float[np.ndarray, "2"]
    bias: Float[np.ndarray, "2"]
    sigma: Float[np.ndarray, "2"]
    persistence: Float[np.ndarray, "2"]
    interval: float
    misread: int

    def correct(self, velocities: Float[np.ndarray, "k 2"]) -> Float[np.ndarray, "k 2"]:
        """Return the velocities that are driven where these (m/s, rad/s) are logged."""
        lost = self.drag * np.abs(velocities[:, 1])
        return velocities * self.scale - np.stack([lost, np.zeros(len(lost))], axis=1)

    @property
    def inflation(self) -> Float[np.ndarray, "2"]:
        r"""Factor by which lasting errors say less than fresh ones.

        If the correlation of errors falls by the factor ρ from image to image, the mean of many of
        them has the variance of one, over their number, times :math:`(1 + \rho) / (1 - \rho)`.
        """
        rho = np.maximum(self.persistence, 0.0) ** (self.interval / WINDOW)
        return (1 + rho) / (1 - rho)


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """What the filter gets of one robot, and what it is judged by.

    Parameters
    ----------
    steps
        One for each image used.
    times : (k + 1,)
        Of the start and of the images, s on the log's clock.
    truth : (k + 1, 3)
        Poses by motion capture; NaN where not covered.
    covered : (k + 1,)
    """

    steps: tuple[Step, ...]
    times: Float[np.ndarray, " images"]
    truth: Float[np.ndarray, "images 3"]
    covered: Bool[np.ndarray, " images"]


@dataclass(frozen=True, eq=False, slots=True)
class Judged:
    """A run beside motion capture.

    Parameters
    ----------
    history
        The run.
    ate, ate_aligned
        Absolute error as it stands and after alignment, m.
    end, end_heading
        Error of the last covered pose, m and rad.
    map_error
        Root mean squared distance of the estimated landmarks from the surveyed, m.
    nees : (covered,)
        Of the poses.
    nis
        Normalised innovation squared over its degrees of freedom.
    """

    history: History
    ate: float
    ate_aligned: float
    end: float
    end_heading: float
    map_error: float
    nees: Float[np.ndarray, " covered"]
    nis: float

    @property
    def inside(self) -> float:
        """Share of the poses inside the 95 % region of their covariance."""
        return float(np.mean(self.nees <= stats.chi2.ppf(0.95, 3)))


# ---- sensors -------------------------------------------------------------------------------------


def calibrate(robot: MrclamRobot, landmarks: SurveyedLandmarks) -> Calibration:
    """Compare the wheels and the camera of a robot with motion capture."""
    wheels = min((_wheels(robot, delay) for delay in DELAYS), key=lambda wheels: wheels[-1][1])
    seen = robot.landmarks
    poses, covered = robot.truth.at(seen.times, longest_gap=GAP)
    places = landmarks.positions[np.searchsorted(landmarks.ids, seen.subjects)]
    x, y = (places - poses[:, :2]).T
    expected = np.stack([np.hypot(x, y), np.arctan2(y, x) - poses[:, 2]], axis=1)
    errors = seen.values - expected
    errors[:, 1] = wrap_angle(errors[:, 1])
    bias = np.median(errors[covered], axis=0)
    right = covered & (np.abs(errors[:, 1] - bias[1]) <= MISREAD)
    sigma = errors[right].std(axis=0)
    rest = np.where(right[:, None], errors - errors[right].mean(axis=0), np.nan)
    pauses = np.diff(np.unique(seen.times))
    return Calibration(
        *wheels,
        bias,
        sigma,
        _persistence(seen.times, seen.subjects, rest) / sigma**2,
        float(pauses[pauses < WINDOW].mean()),
        int(np.count_nonzero(covered & ~right)),
    )


def _wheels(robot: MrclamRobot, delay: float) -> tuple[float, np.ndarray, float, np.ndarray]:
    """Return delay, scale and drag of the wheels, and the variance of the rest per second."""
    first = max(robot.commands.times[0], robot.truth.times[0])
    last = min(robot.commands.times[-1], robot.truth.times[-1] - delay)
    cuts = np.arange(first, last, WINDOW)
    held = hold(robot.commands.times, robot.commands.velocities, cuts)
    parts = held.commands * held.durations[:, None]
    parts = np.column_stack([parts, np.abs(parts[:, 1])])
    way, turn, bends = (np.bincount(held.intervals, part) for part in parts.T)
    poses, covered = robot.truth.at(cuts + delay, longest_gap=GAP)
    true_turn = wrap_angle(np.diff(poses[:, 2]))
    chord = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    true_way = chord / np.sinc(true_turn / (2 * np.pi))  # along the arc
    both = covered[1:] & covered[:-1]
    rows = np.stack([way, -bends], axis=1)[both]
    (ahead, drag), *_ = np.linalg.lstsq(rows, true_way[both])
    around = turn[both] @ true_turn[both] / (turn[both] @ turn[both])
    rest = np.stack([true_way[both] - rows @ [ahead, drag], (true_turn - around * turn)[both]])
    return delay, np.array([ahead, around]), float(drag), rest.var(axis=1) / WINDOW


def _persistence(times: np.ndarray, subjects: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the mean product of errors on one landmark that are `WINDOW` seconds apart."""
    products = []
    for subject in np.unique(subjects):
        mine = subjects == subject
        t, e = times[mine], rest[mine]
        later = np.minimum(np.searchsorted(t, t + WINDOW), len(t) - 1)
        near = np.abs(t[later] - t - WINDOW) < WINDOW / 4
        products.append((e * e[later])[near])
    return np.nanmean(np.concatenate(products), axis=0)


def of_others(calibrations: Mapping[int, Calibration], robot: int) -> Calibration:
    """Return the mean calibration of all robots but one; biases are a robot's own and stay out."""
    others = [calibration for number, calibration in calibrations.items() if number != robot]

    def mean(name: str) -> np.ndarray | float:
        return np.mean([getattr(calibration, name) for calibration in others], axis=0)

    return Calibration(
        delay=mean("delay"),
        scale=mean("scale"),
        drag=mean("drag"),
        density=mean("density"),
        bias=np.zeros(2),
        sigma=np.sqrt(np.mean([calibration.sigma**2 for calibration in others], axis=0)),
        persistence=mean("persistence"),
        interval=mean("interval"),
        misread=sum(calibration.misread for calibration in others),
    )


# ---- steps ---------------------------------------------------------------------------------------


def make_drive(robot: MrclamRobot, sensors: Calibration, *, pause: float = 0.0) -> Drive:
    """Return the steps of a robot, one for each image at least ``pause`` seconds after the last.

    The drive lasts from the first command to the last, each moved by the delay of the wheels.
    """
    seen, logged = robot.landmarks, robot.commands
    merged = merge(logged.times, logged.velocities, seen.times, delay=sensors.delay, pause=pause)
    driven = replace(merged.held, commands=sensors.correct(merged.held.commands))
    times = merged.times
    steps = tuple(
        Step(Odometry(*motion), Observations(seen.subjects[rows], seen.values[rows]), time=time)
        for motion, rows, time in zip(
            zip(*compound(driven, sensors.density), strict=True),
            merged.rows,
            (times[1:] - times[0]).tolist(),
            strict=True,
        )
    )
    return Drive(steps, times, *robot.truth.at(times, longest_gap=GAP))


def choose_anchors(drive: Drive, landmarks: SurveyedLandmarks) -> list[dict[int, np.ndarray]]:
    """Return no anchor; the landmark seen first, as in the paper; and that and the one farthest."""
    places = dict(zip(landmarks.ids.tolist(), landmarks.positions, strict=True))
    first = int(drive.steps[0].observations.ids[0])
    far = max(places, key=lambda name: float(np.hypot(*(places[name] - places[first]))))
    return [{name: places[name] for name in names} for names in ((), (first,), (first, far))]


# ---- runs ----------------------------------------------------------------------------------------


def judge(history: History, drive: Drive, landmarks: SurveyedLandmarks, *, named: bool) -> Judged:
    """Compare a run with motion capture; landmarks the filter named itself go to the nearest."""
    seen = drive.covered[1:]
    poses, truth = history.poses[seen], drive.truth[1:][seen]
    errors = poses - truth
    errors[:, 2] = wrap_angle(errors[:, 2])
    end = end_error(poses, truth)
    found = history.belief.landmarks
    if named:
        apart = found - landmarks.positions[np.searchsorted(landmarks.ids, history.belief.ids)]
    else:
        offsets = found[:, None] - landmarks.positions
        nearest = np.hypot(*offsets.T).T.argmin(axis=1)
        apart = offsets[np.arange(len(found)), nearest]
    return Judged(
        history,
        absolute_error(poses, truth, aligned=False),
        absolute_error(poses, truth, aligned=True),
        end.position,
        end.heading,
        float(np.sqrt(np.mean(np.sum(apart**2, axis=1)))),
        normalised_squared(errors, history.pose_covs[seen]),
        float(history.nis.sum() / history.dof.sum()),
    )


def run_robot(
    robot: MrclamRobot,
    landmarks: SurveyedLandmarks,
    sensors: Calibration,
    range_bias: float,
) -> tuple[Drive, dict[str, list[Judged]]]:
    """Run the filter over a drive by each method, with no, one and two anchors.

    ``white``: barcodes known, the noise that of one measurement; ``lasting``: the noise multiplied
    by `Calibration.inflation`; ``first``: the same with Jacobians at the first estimates;
    ``unbiased``: as ``lasting``, less the range bias of this very robot; ``nearest`` and ``joint``:
    barcodes unknown, the noise of one measurement, one image a second. Known barcodes pass a gate
    (0.9999), for the camera takes one landmark for another now and then.
    """
    drive, sparse = make_drive(robot, sensors), make_drive(robot, sensors, pause=1.0)
    nameless = tuple(replace(s, observations=s.observations.anonymous()) for s in sparse.steps)
    one, many = np.diag(sensors.sigma**2), np.diag(sensors.sigma**2 * sensors.inflation)
    known = Association("known", 0.9999)
    ways = (
        (drive, drive.steps, RangeBearing(one), known, "latest"),
        (drive, drive.steps, RangeBearing(many), known, "latest"),
        (drive, drive.steps, RangeBearing(many), known, "first"),
        (drive, drive.steps, RangeBearing(many, range_bias), known, "latest"),
        (sparse, nameless, RangeBearing(one), "gated", "latest"),
        (sparse, nameless, RangeBearing(one), "joint", "latest"),
    )
    found: dict[str, list[Judged]] = {}
    start = MapBelief.start(drive.truth[0], START)
    for method, (way, steps, sensor, association, linearisation) in zip(METHODS, ways, strict=True):
        found[method] = []
        for anchors in choose_anchors(drive, landmarks):
            settings = Settings(sensor, anchors, association, linearisation)
            history = run_filter(start, steps, settings)
            named = association is known
            found[method].append(judge(history, way, landmarks, named=named))
    return drive, found


# ---- the recording -------------------------------------------------------------------------------


def study(folder: Path) -> dict[str, np.ndarray | float]:
    """Run all robots, and return what the chapter shows of them.

    Returns
    -------
    dict
        By robot: ``robots``; of the sensors ``delay``, ``scale``, ``drag``, ``wander`` (root of
        the density), ``bias``, ``sigma``, ``persistence``, ``inflation``, ``misread``, ``unknown``;
        ``images``, ``minutes``, ``uncovered``; ``dead`` (error of the wheels alone, m). By robot,
        method and
        anchors: the numbers of `Judged` and what became of the sightings (`Counts`). Of the runs
        with lasting errors, by robot, anchors and time: ``paths``, ``errors`` (m and rad),
        ``sigmas`` (likewise), ``nees``, beside ``times`` (s), ``truth``, ``dead_path``; and
        ``marks``, ``mark_covs`` (cm²), beside ``landmarks`` and the ``anchors`` (robots, 2).
    """
    data = read_mrclam(folder)
    calibrations = {n: calibrate(robot, data.landmarks) for n, robot in data.robots.items()}
    runs = [
        run_robot(robot, data.landmarks, of_others(calibrations, n), calibrations[n].bias[0])
        for n, robot in data.robots.items()
    ]
    names = (
        "delay",
        "scale",
        "drag",
        "density",
        "bias",
        "sigma",
        "persistence",
        "inflation",
        "misread",
    )
    sensors = {
        name: np.array([getattr(calibration, name) for calibration in calibrations.values()])
        for name in names
    }
    sensors["wander"] = np.sqrt(sensors.pop("density"))
    sensors["unknown"] = np.array([sum(r.unknown.values()) for r in data.robots.values()])
    return (
        {"robots": np.array(list(data.robots)), "landmarks": data.landmarks.positions}
        | sensors
        | _stack([_numbers(*run) for run in runs])
        | _stack([_series(*run, data.landmarks) for run in runs])
    )


def _stack(rows: list[dict[str, np.ndarray | float]]) -> dict[str, np.ndarray]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _numbers(drive: Drive, found: Mapping[str, list[Judged]]) -> dict[str, np.ndarray | float]:
    """Return what is told of one robot in numbers; arrays by method and anchors."""
    numbers = {
        name: np.array([[getattr(run, name) for run in found[method]] for method in METHODS])
        for name in ("ate", "ate_aligned", "end", "end_heading", "map_error", "inside", "nis")
    }
    numbers["nees_mean"] = np.array([[run.nees.mean() for run in found[m]] for m in METHODS])
    for name in ("matched", "anchored", "new", "rejected", "ignored"):
        numbers[name] = np.array(
            [[getattr(run.history.counts, name) for run in found[m]] for m in METHODS]
        )
    seen = drive.covered
    dead = dead_reckoning(drive.truth[0], (s.motion for s in drive.steps))
    return numbers | {
        "dead": absolute_error(dead[seen], drive.truth[seen], aligned=False),
        "images": len(drive.steps),
        "uncovered": int(np.count_nonzero(~seen)),
        "minutes": float(drive.times[-1] - drive.times[0]) / 60,
    }


def _series(
    drive: Drive, found: Mapping[str, list[Judged]], landmarks: SurveyedLandmarks
) -> dict[str, np.ndarray]:
    """Return paths, errors and maps of one robot, thinned; arrays by anchors and time."""
    covered = np.flatnonzero(drive.covered[1:])
    kept = np.linspace(0, len(covered) - 1, SAMPLES).astype(int)
    rows = covered[kept]
    truth = drive.truth[1:][rows]
    runs = found["lasting"]
    poses = np.array([run.history.poses[rows] for run in runs])
    covs = np.array([run.history.pose_covs[rows] for run in runs])
    apart = poses - truth
    spread = np.sqrt(np.trace(covs[..., :2, :2], axis1=-2, axis2=-1))
    chosen = choose_anchors(drive, landmarks)
    maps = [_map(run, anchors, landmarks) for run, anchors in zip(runs, chosen, strict=True)]
    return {
        "times": np.round(drive.times[1:][rows] - drive.times[0], 1),
        "truth": np.round(truth[:, :2], 2),
        "dead_path": np.round(
            dead_reckoning(drive.truth[0], (s.motion for s in drive.steps))[1:][rows, :2], 2
        ),
        "paths": np.round(poses[..., :2], 2),
        "errors": np.round(
            np.stack([np.hypot(*apart[..., :2].T).T, wrap_angle(apart[..., 2])], axis=-1), 3
        ),
        "sigmas": np.round(np.stack([spread, np.sqrt(covs[..., 2, 2])], axis=-1), 3),
        "nees": np.round([run.nees[kept] for run in runs], 2),
        "marks": np.round([points for points, _ in maps], 3),
        "mark_covs": np.round([1e4 * covs for _, covs in maps], 2),
        "anchors": np.array(list(chosen[-1])),
    }


def _map(
    run: Judged, anchors: Mapping[int, np.ndarray], landmarks: SurveyedLandmarks
) -> tuple[np.ndarray, np.ndarray]:
    """Return the landmarks in the order of the survey; anchors stand where they are known to be."""
    points, covs = landmarks.positions.copy(), np.zeros((len(landmarks.ids), 2, 2))
    for row, name in enumerate(landmarks.ids.tolist()):
        if name not in anchors:
            marginal = run.history.belief.landmark(name)
            points[row], covs[row] = marginal.mean, marginal.cov
    return points, covs


def summary(found: Mapping[str, np.ndarray | float], *names: str) -> dict[str, float]:
    """Return those numbers about the five robots that are named; means, but counts are totals.

    Errors in m, shares in %, by anchors ``none``, ``one``, ``two``; ``fresh_*`` where errors are
    taken as white, ``first_*`` with first estimates, ``nearest_none``, ``joint_none`` where
    barcodes are unknown, ``unbiased_two`` where each robot's range bias is taken off.
    """
    way = {method: row for row, method in enumerate(METHODS)}
    ate, inside = found["ate"].mean(axis=0), 100 * found["inside"].mean(axis=0)
    numbers = {"wheels": found["dead"].mean(), "minutes": found["minutes"].sum()}
    for column, anchors in enumerate(ANCHORS):
        numbers[anchors] = ate[way["lasting"], column]
        numbers[f"{anchors}_aligned"] = found["ate_aligned"][:, way["lasting"], column].mean()
        numbers[f"{anchors}_inside"] = inside[way["lasting"], column]
        numbers[f"fresh_{anchors}_inside"] = inside[way["white"], column]
        numbers[f"first_{anchors}"] = ate[way["first"], column]
        numbers[f"first_{anchors}_inside"] = inside[way["first"], column]
    for method in ("nearest", "joint"):
        numbers[f"{method}_none"] = ate[way[method], 0]
    numbers["unbiased_two"] = ate[way["unbiased"], 2]
    numbers["fresh_nis"] = found["nis"][:, way["white"], 0].mean()
    for name in ("delay", "misread", "unknown"):
        numbers[name] = found[name].mean() if name == "delay" else found[name].sum()
    numbers["inflation"] = found["inflation"][:, 0].mean()
    numbers["persistence"] = found["persistence"][:, 0].mean()
    numbers["bias_low"], numbers["bias_high"] = found["bias"][:, 0].min(), found["bias"][:, 0].max()
    numbers["drag"] = found["drag"].mean()
    return {name: float(numbers[name]) for name in names}


def sensor_table(found: Mapping[str, np.ndarray | float]) -> str:
    """Return what motion capture says of each robot's wheels and camera."""
    head = (
        "       delay  speed   turn   drag  range bias    sd  ρ(2 s)  bearing    sd  wrong  other\n"
        "robot      s      ×      ×  m/rad           m     m               °     °"
    )
    rows = []
    for row, robot in enumerate(found["robots"]):
        speed, turn = found["scale"][row]
        (far, bearing), (far_sd, bearing_sd) = found["bias"][row], found["sigma"][row]
        rows.append(
            f"{robot:5d}{found['delay'][row]:7.2f}{speed:7.2f}{turn:7.2f}{found['drag'][row]:7.3f}{far:12.3f}{far_sd:6.2f}"
            f"{found['persistence'][row, 0]:8.2f}{np.rad2deg(bearing):9.2f}"
            f"{np.rad2deg(bearing_sd):6.2f}{found['misread'][row]:7d}{found['unknown'][row]:7d}"
        )
    return "\n".join([head, *rows])


def robot_table(found: Mapping[str, np.ndarray | float], method: str = "lasting") -> str:
    """Return errors and consistency of the robots by one of the `METHODS`."""
    way = METHODS.index(method)
    head = (
        "         wheels  error / m         aligned / m       inside 95 %\n"
        "robot    alone   no   one  two     no   one  two     no   one  two"
    )
    rows = []
    for row, robot in enumerate(found["robots"]):
        cells = [
            "  ".join(f"{value:.{places}f}" for value in found[name][row, way])
            for name, places in (("ate", 2), ("ate_aligned", 2), ("inside", 2))
        ]
        rows.append(f"{robot:5d}  {found['dead'][row]:7.2f}  {'    '.join(cells)}")
    means = [
        "  ".join(f"{value:.2f}" for value in found[name][:, way].mean(axis=0))
        for name in ("ate", "ate_aligned", "inside")
    ]
    rows.append(f" mean  {found['dead'].mean():7.2f}  {'    '.join(means)}")
    return "\n".join([head, *rows])


def method_table(found: Mapping[str, np.ndarray | float]) -> str:
    """Return the mean over the robots of error, consistency and innovations, by method."""
    words = {
        "white": "barcodes, errors taken as fresh",
        "lasting": "barcodes, errors that last",
        "first": "the same, first estimates",
        "unbiased": "errors that last, less the bias",
        "nearest": "nearest neighbour",
        "joint": "joint compatibility",
    }
    head = (
        "                                  error / m         inside 95 %       NIS\n"
        "                                  no   one  two     no   one  two     no"
    )
    rows = []
    for way, method in enumerate(METHODS):
        ate, inside = found["ate"][:, way].mean(axis=0), found["inside"][:, way].mean(axis=0)
        cells = ["  ".join(f"{value:.2f}" for value in values) for values in (ate, inside)]
        nis = found["nis"][:, way, 0].mean()
        rows.append(f"{words[method]:32s}  {'    '.join(cells)}    {nis:.2f}")
    return "\n".join([head, *rows])


UTIAS = Recording("utias_mrclam_6", lambda at: Found(study(at)), Found, store="anchored-utias")
