"""Calibration of a recorded robot by ground truth: its wheels, its camera, its landmark names.

The ground truth is motion capture, or the corrected poses of a recording. A filter must not call
these functions, because it does not know the truth.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Annotated, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.fields import NotNegative, checked, from_to
from robot_perception.geometry import act, between, wrap_angle
from robot_perception.observations import Observations
from robot_perception.slam.planar.belief import checked_places
from robot_perception.slam.planar.motions import Odometry, compound
from robot_perception.slam.planar.runs import Step
from robot_perception.streams import Merged, hold, merge

GAP = 0.5
"""Longest gap of the ground truth that is interpolated, s."""
WINDOW = 2.0
"""Length of the intervals over which wheels and truth are compared, and lag of the correlations of
sighting errors, s."""
MISREAD = 0.1
"""Largest bearing error of a right sighting, rad; a larger one means another landmark."""
BLIND = (
    "observed, names, values and places must give right sightings where truth is known, of one "
    f"landmark {WINDOW:g} s apart, too"
)


@runtime_checkable
class GroundTruth(Protocol):
    """Interface of a true path of a robot; `datasets.Track` has it."""

    times: np.ndarray

    def at(self, times: np.ndarray, *, longest_gap: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the poses (k, 3) at given times, NaN where unknown, and which are known (k,)."""


@dataclass(frozen=True, eq=False, slots=True)
class Calibration:
    r"""Calibration of the sensors of one robot, or of several together.

    The wheels are modelled by

    .. math:: d = s_1 d_0 - c\, |\alpha_0| + v_1, \qquad \alpha = s_2 \alpha_0 + v_2

    with the logged distance :math:`d_0` (m) and turn :math:`\alpha_0` (rad), the true ones
    :math:`d` and :math:`\alpha`, the scales :math:`s`, the drag :math:`c` and noise :math:`v`.

    Parameters
    ----------
    delay
        Time from a command to its motion, s.
    scale : (2,)
        :math:`s_1, s_2`, of distance and turn.
    drag
        :math:`c`, m/rad: how much shorter than logged the distance is for each radian of turn.
    density : (2,)
        Variance of the noise :math:`v` per second, m²/s and rad²/s.
    bias : (2,)
        Median error of range (m) and bearing (rad) of all sightings.
    sigma : (2,)
        Standard deviation of the errors of right sightings, m and rad.
    persistence : (2,)
        Correlation of two errors on one landmark that are `WINDOW` seconds apart, of range and of
        bearing.
    interval
        Mean time from one image to the next, s; pauses of `WINDOW` and more are left out.
    misread
        Number of sightings whose bearing shows that another landmark was seen than the one named.
    """

    delay: float
    scale: Float[np.ndarray, "2"]
    drag: float
    density: Float[np.ndarray, "2"]
    bias: Float[np.ndarray, "2"]
    sigma: Float[np.ndarray, "2"]
    persistence: Float[np.ndarray, "2"]
    interval: NotNegative
    misread: Annotated[int, from_to(0)]
    __post_init__ = checked

    @property
    def inflation(self) -> Float[np.ndarray, "2"]:
        r"""Factor by which correlation between images inflates the variance of a mean error (2,).

        .. math:: \operatorname{var} \bar e \approx \frac{\sigma^2}{n}\, \frac{1 + \rho}{1 - \rho}

        for the mean of n errors whose correlation falls by the factor ρ from image to image. A
        filter that takes errors for independent may multiply their variance by this factor.

        Raises
        ------
        ValueError
            If a persistence is 1 or more: such errors do not average out.
        """
        if (self.persistence >= 1).any():
            raise ValueError(f"persistence must be below 1, got {self.persistence}")
        rho = np.maximum(self.persistence, 0.0) ** (self.interval / WINDOW)
        return (1 + rho) / (1 - rho)


def calibrate(
    times: Float[np.ndarray, " commands"],
    velocities: Float[np.ndarray, "commands 2"],
    observed: Float[np.ndarray, " sightings"],
    names: Int[np.ndarray, " sightings"],
    values: Float[np.ndarray, "sightings 2"],
    *,
    places: Mapping[int, np.ndarray],
    truth: GroundTruth,
    delays: Float[np.ndarray, " delays"],
) -> Calibration:
    """Compare the wheels and the camera of a robot with ground truth.

    Parameters
    ----------
    times : (commands,)
        Times of the commands, s, not falling.
    velocities : (commands, 2)
        Speed (m/s) and turn rate (rad/s), held until the next command.
    observed : (sightings,)
        Times at which landmarks were seen, s, not falling.
    names : (sightings,)
        Identifiers of these landmarks.
    values : (sightings, 2)
        Their measured range (m) and bearing (rad).
    places : identifier -> (2,)
        True positions of the landmarks, m.
    truth
        True path of the robot.
    delays : (delays,)
        Times from a command to its motion to try, s; the one that explains the turns best is taken.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, times fall, a landmark has no place, or the
        truth covers too little of the log.
    """
    times = checks.array("times", times, ("commands",))
    velocities = checks.array("velocities", velocities, (times.size, 2), f"times {times.shape}")
    delays = checks.array("delays", delays, ("delays",))
    observed, names, values = _sightings(observed, names, values)
    if not delays.size:
        raise ValueError("delays must hold one at least, got none")
    if (fall := np.flatnonzero(np.diff(observed) < 0)).size:
        k = int(fall[0])
        raise ValueError(f"observed must not fall, got {observed[k + 1]} after {observed[k]}")
    errors = sighting_errors(observed, names, values, places=places, truth=truth)
    with checks.computable("velocities"):
        wheels = [_wheels(times, velocities, truth, delay) for delay in delays.tolist()]
    known, pauses = np.isfinite(errors[:, 0]), np.diff(np.unique(observed))
    pauses = pauses[pauses < WINDOW]
    if not known.any() or not pauses.size:
        raise ValueError(BLIND)
    bias = np.nanmedian(errors, axis=0)
    right = is_right(errors, bias)
    sigma = errors[right].std(axis=0)
    rest = np.where(right[:, None], errors - errors[right].mean(axis=0), np.nan)
    persistence = _persistence(observed, names, rest) / sigma**2
    interval, misread = float(pauses.mean()), int(known.sum() - right.sum())
    best = min(wheels, key=lambda found: found[-1][1])
    return Calibration(*best, bias, sigma, persistence, interval, misread)


def sighting_errors(
    observed: Float[np.ndarray, " sightings"],
    names: Int[np.ndarray, " sightings"],
    values: Float[np.ndarray, "sightings 2"],
    *,
    places: Mapping[int, np.ndarray],
    truth: GroundTruth,
) -> Float[np.ndarray, "sightings 2"]:
    """Return the errors of ranges (m) and bearings (rad), NaN where the truth is not known.

    An error is the measured value less the true one. Parameters and exceptions are those of
    :func:`calibrate`.
    """
    observed, names, values = _sightings(observed, names, values)
    places = checked_places("place", places)
    lost = sorted(set(names.tolist()) - set(places))
    if lost:
        raise ValueError(f"places must have all names seen, none of {lost}")
    poses, known = checks.instance("truth", truth, GroundTruth).at(observed, longest_gap=GAP)
    there = np.array([places[name] for name in names.tolist()]).reshape(-1, 2)
    x, y = (there - poses[:, :2]).T
    errors = values - np.stack([np.hypot(x, y), np.arctan2(y, x) - poses[:, 2]], axis=1)
    errors[known, 1] = wrap_angle(errors[known, 1])
    return errors


def is_right(
    errors: Float[np.ndarray, "sightings 2"], bias: Float[np.ndarray, "2"]
) -> Bool[np.ndarray, " sightings"]:
    """Tell which sightings can be of the landmark they name: bearing error within `MISREAD`.

    The error is taken relative to the bias. A sighting whose error is NaN is not right.
    """
    errors = checks.array("errors", errors, ("sightings", 2), finite=False)
    return np.abs(errors[:, 1] - checks.vector("bias", bias, 2)[1]) <= MISREAD


def pooled(calibrations: Iterable[Calibration]) -> Calibration:
    """Return the mean calibration of several robots, with a bias of 0: each robot has its own.

    Variances are averaged, and misread sightings are added up.

    Raises
    ------
    ValueError
        If there is no calibration.
    """
    given = checks.instances("calibrations", calibrations, Calibration)
    if not given:
        raise ValueError("calibrations must hold one at least, got none")
    every = {f.name: np.array([getattr(c, f.name) for c in given]) for f in fields(Calibration)}
    found = {name: values.mean(axis=0) for name, values in every.items()}
    found["bias"], found["misread"] = np.zeros(2), int(every["misread"].sum())
    found["sigma"] = np.sqrt(np.mean(every["sigma"] ** 2, axis=0))
    return Calibration(**found)


def make_steps(
    sensors: Calibration,
    times: Float[np.ndarray, " commands"],
    velocities: Float[np.ndarray, "commands 2"],
    observed: Float[np.ndarray, " sightings"],
    names: Int[np.ndarray, " sightings"],
    values: Float[np.ndarray, "sightings 2"],
    *,
    pause: float = 0.0,
) -> tuple[tuple[Step, ...], Merged]:
    """Return the steps of a robot's log for the filter, motions corrected, and the merged log.

    There is one step for each image; images less than ``pause`` seconds after the last used one are
    skipped. Times count from the first motion. The log is as in :func:`calibrate`, the exceptions
    are those of `streams.merge`. The bias of the camera is not subtracted.
    """
    delay = checks.instance("sensors", sensors, Calibration).delay
    velocities = checks.array("velocities", velocities, ("commands", 2))
    observed, names, values = _sightings(observed, names, values)
    merged = merge(times, velocities, observed, delay=delay, pause=pause)
    corrected = merged.held.commands * sensors.scale
    corrected[:, 0] -= sensors.drag * np.abs(merged.held.commands[:, 1])
    motions = map(Odometry, *compound(replace(merged.held, commands=corrected), sensors.density))
    seen = (Observations(names[rows], values[rows]) for rows in merged.rows)
    clock = (merged.times[1:] - merged.times[0]).tolist()
    steps = zip(motions, seen, clock, strict=True)
    return tuple(Step(motion, marks, time=time) for motion, marks, time in steps), merged


def calibrate_odometry(
    odometry: Float[np.ndarray, "k 3"], poses: Float[np.ndarray, "k 3"]
) -> list[Odometry]:
    """Return the odometry between poses, corrected by a constant calibration.

    Two things are fitted to the true poses: a constant offset of each step, ahead and to the side,
    and a drift of the heading in proportion to the length of the step. The noise is the variance of
    the remaining errors.

    Parameters
    ----------
    odometry : (k, 3)
        Poses by the wheels, m, m, rad.
    poses : (k, 3)
        True poses at the same times.

    Raises
    ------
    ValueError
        If the two are of different length, a number is not finite, or the robot never moves.
    """
    odometry = checks.array("odometry", odometry, ("k", 3))
    poses = checks.array("poses", poses, odometry.shape, f"odometry {odometry.shape}")
    raw = between(odometry[:-1], odometry[1:])
    errors = between(poses[:-1], poses[1:]) - raw
    errors[:, 2] = wrap_angle(errors[:, 2])
    length = np.hypot(*raw[:, :2].T)
    if not length.any():
        raise ValueError("odometry must move, got one place")
    change = np.tile(errors.mean(axis=0), (len(raw), 1))
    change[:, 2] = length * (length @ errors[:, 2] / (length @ length))
    noise = np.diag((errors - change).var(axis=0))
    return [Odometry(increment, noise) for increment in raw + change]


def name_landmarks(
    poses: Float[np.ndarray, "k 3"], seen: Iterable[Observations], within: float
) -> list[Int[np.ndarray, " _"]]:
    """Return a name for each observed point, by its position in the world: near points share it.

    A point takes the name of the nearest landmark so far, or a new name if none is near. From one
    pose each name is given once.

    Parameters
    ----------
    poses : (k, 3)
        Known poses of the robot in the world, m, m, rad.
    seen
        Observed points in the robot's frame, one `Observations` for each pose, m.
    within
        Largest distance of a point from the mean of a landmark's earlier points, m.

    Raises
    ------
    ValueError
        If there are not as many poses as observations, or ``within`` is not positive.
    """
    seen = checks.instances("seen", seen, Observations)
    poses = checks.array("poses", poses, (len(seen), 3), f"seen of {len(seen)} poses")
    within = checks.positive("within", within)
    places, counts = np.empty((0, 2)), np.empty(0)
    names = []
    for pose, marks in zip(poses, seen, strict=True):
        mine = np.empty(0, dtype=int)
        for point in act(pose, marks.values):  # in the world
            apart = np.hypot(*(places - point).T)
            apart[mine] = np.inf  # names that this pose has given already
            near = int(apart.argmin()) if apart.size and apart.min() <= within else len(places)
            if near == len(places):
                places, counts = np.vstack([places, point]), np.append(counts, 0)
            counts[near] += 1
            places[near] += (point - places[near]) / counts[near]
            mine = np.append(mine, near)
        names.append(mine)
    return names


def _sightings(
    observed: np.ndarray, names: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return checked times, names and values of sightings."""
    observed = checks.array("observed", observed, ("sightings",))
    beside = f"observed {observed.shape}"
    names = checks.integers("names", names, observed.shape, beside=beside)
    return observed, names, checks.array("values", values, (observed.size, 2), beside)


def _wheels(
    times: np.ndarray, velocities: np.ndarray, truth: GroundTruth, delay: float
) -> tuple[float, np.ndarray, float, np.ndarray]:
    """Return delay, scale and drag of the wheels, and the variance of the noise per second.

    Distance and turn by the log are fitted to those by the truth over intervals of `WINDOW`
    seconds, by least squares; see `Calibration`.
    """
    span = checks.instance("truth", truth, GroundTruth).times
    first, last = max(times[0], span[0]), min(times[-1], span[-1] - delay)
    cuts = np.arange(first, last, WINDOW) if abs(last - first) < 1e9 else np.empty(0)
    if cuts.size < 3:
        least = f"{2 * WINDOW:g} s of the truth after each of delays"
        raise ValueError(f"times must share {least}, got {last - first:g} s")
    held = hold(times, velocities, cuts)
    parts = held.commands * held.durations[:, None]
    parts = np.column_stack([parts, np.abs(parts[:, 1])])
    poses, covered = truth.at(cuts + delay, longest_gap=GAP)
    both = covered[1:] & covered[:-1]
    way, turn, bends = (np.bincount(held.intervals, part)[both] for part in parts.T)
    x, y, true_turn = np.diff(poses, axis=0)[both].T
    if not turn.any():
        raise ValueError("velocities must turn where truth is known, after each of delays")
    true_turn = wrap_angle(true_turn)
    true_way = np.hypot(x, y) / np.sinc(true_turn / (2 * np.pi))  # chord to arc
    rows = np.stack([way, -bends], axis=1)
    (ahead, drag), *_ = np.linalg.lstsq(rows, true_way)
    around = turn @ true_turn / (turn @ turn)
    rest = np.stack([true_way - rows @ [ahead, drag], true_turn - around * turn])
    return delay, np.array([ahead, around]), float(drag), rest.var(axis=1) / WINDOW


def _persistence(times: np.ndarray, names: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the mean product of errors on one landmark that are `WINDOW` seconds apart."""
    products = []
    for name in np.unique(names):
        mine = names == name
        t, e = times[mine], rest[mine]
        later = np.minimum(np.searchsorted(t, t + WINDOW), len(t) - 1)
        near = np.abs(t[later] - t - WINDOW) < WINDOW / 4
        products.append((e * e[later])[near])
    products = np.concatenate(products)
    if not np.isfinite(products).any():
        raise ValueError(BLIND)
    return np.nanmean(products, axis=0)
