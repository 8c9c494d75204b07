"""Calibration of a robot by ground truth: its wheels, its camera, and which landmark it saw.

Motion capture or the corrected poses of a recording stand for the truth; nothing here is for a
filter to call.
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
"""Longest gap of the ground truth that is bridged, s."""
WINDOW = 2.0
"""Time over which wheels are compared with the truth, and lag of the correlations, s."""
MISREAD = 0.1
"""A bearing that is wrong by more, rad, is of another landmark than the one named."""
BLIND = (
    "observed, names, values and places must give right sightings where truth is known, of one "
    f"landmark {WINDOW:g} s apart, too"
)


@runtime_checkable
class GroundTruth(Protocol):
    """True path of a robot, as `datasets.Track` has it."""

    times: np.ndarray

    def at(self, times: np.ndarray, *, longest_gap: float) -> tuple[np.ndarray, np.ndarray]:
        """Return poses (k, 3), NaN where they are not known, and which are known."""


@dataclass(frozen=True, eq=False, slots=True)
class Calibration:
    """Calibration of the sensors of one robot, or of several together.

    Pairs are of way and turn, or of range (m) and bearing (rad).

    Parameters
    ----------
    delay
        From a command to its motion, s.
    scale, drag
        A motion is ``scale`` times the logged one less ``drag`` for each radian logged (m/rad: who
        turns goes slower than the log says).
    density
        Variance of the rest per second, m²/s, rad²/s.
    bias, sigma
        Median error of the camera, and standard deviation of its right sightings.
    persistence
        Correlation of two errors on one landmark, `WINDOW` seconds apart.
    interval
        Mean time between images while there are any, s.
    misread
        Sightings whose landmark cannot be the one named.
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
        r"""Factor by which lasting errors say less than fresh ones.

        If the correlation of errors falls by the factor ρ from image to image, the mean of many of
        them has the variance of one, over their number, times :math:`(1 + \rho) / (1 - \rho)`.
        """
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
    times, velocities
        When commands were given, s, and speed (m/s) and turn rate (rad/s) held from then on.
    observed, names, values
        When landmarks were seen, s, which, and at what range (m) and bearing (rad).
    places : identifier -> (2,)
        Where they are, m.
    truth
        Where the robot was.
    delays
        From command to motion, s; the one that explains turns best is taken.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, times fall, a landmark has no place, or too
        little of the log is known to the truth.
    """
    times = checks.array("times", times, ("commands",))
    velocities = checks.array("velocities", velocities, (times.size, 2), f"times {times.shape}")
    delays = checks.array("delays", delays, ("delays",))
    observed, names, values = _sightings(observed, names, values)
    if not delays.size:
        raise ValueError("delays must hold one at least, got none")
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

    Parameters and errors are those of :func:`calibrate`.
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
    """Tell which landmarks can be the ones named; of those that nobody checked, none."""
    errors = checks.array("errors", errors, ("sightings", 2), finite=False)
    return np.abs(errors[:, 1] - checks.vector("bias", bias, 2)[1]) <= MISREAD


def pooled(calibrations: Iterable[Calibration]) -> Calibration:
    """Return the mean calibration of several robots; biases are a robot's own and stay out.

    Raises
    ------
    ValueError
        If there is none.
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
    """Return the steps of a calibrated robot's log, for the filter, and how it was merged.

    There is one for each image at least ``pause`` seconds after the last; their times count from
    the first motion. The log is as in :func:`calibrate`, errors are those of `streams.merge`.
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
    """Return the motions between poses after what a constant calibration can do for them.

    A heading drift per metre and an offset of each step are fitted to the true poses (m, m, rad);
    the noise is the variance of what is left.

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
    """Name points by where they lie in the frame of given poses; a pose sees each name once.

    Parameters
    ----------
    poses : (k, 3)
        m, m, rad.
    seen
        Points in the frame of each pose, m.
    within
        Distance from the mean of its earlier sightings at which a point is the same, m.

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
        for point in act(pose, marks.values):
            apart = np.hypot(*(places - point).T)
            apart[mine] = np.inf
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
    observed = checks.array("observed", observed, ("sightings",))
    beside = f"observed {observed.shape}"
    names = checks.integers("names", names, observed.shape, beside=beside)
    return observed, names, checks.array("values", values, (observed.size, 2), beside)


def _wheels(
    times: np.ndarray, velocities: np.ndarray, truth: GroundTruth, delay: float
) -> tuple[float, np.ndarray, float, np.ndarray]:
    """Return delay, scale and drag of the wheels, and the variance of the rest per second."""
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
    true_way = np.hypot(x, y) / np.sinc(true_turn / (2 * np.pi))  # along the arc
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
