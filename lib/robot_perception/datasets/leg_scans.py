"""Scans at leg height, with the middles of legs where somebody has marked them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.datasets import limits
from robot_perception.datasets.bag_scans import read_bag_scans
from robot_perception.datasets.bags import Topics, check_topic, is_bag
from robot_perception.datasets.logs import CorruptLog, ReadReport, as_path, in_seconds
from robot_perception.datasets.tables import FARTHEST
from studies.files import reading

NEEDED = ("stamp", "ranges", "angle_min", "angle_increment", "range_min", "range_max")
LABELS = ("leg_scan", "leg_xy", "label_sector_deg_m")


@dataclass(frozen=True, slots=True)
class Sector:
    """Part of the floor before a scanner.

    Parameters
    ----------
    low, high
        Directions, rad.
    reach
        Distance, m.
    """

    low: float
    high: float
    reach: float

    def holds(self, points: Float[np.ndarray, "n 2"]) -> Bool[np.ndarray, " n"]:
        """Tell which points (n, 2), m, lie within.

        Raises
        ------
        ValueError
            If the shape is another, or a number is not finite.
        """
        x, y = checks.array("points", points, ("n", 2)).T
        angles = np.arctan2(y, x)
        return (angles >= self.low) & (angles <= self.high) & (np.hypot(x, y) <= self.reach)


@dataclass(frozen=True, eq=False, slots=True)
class LegScans:
    """Scans, and the legs that are marked in some of them.

    Parameters
    ----------
    times : (scans,)
        s.
    ranges : (scans, beams)
        m; infinite where nothing came back.
    angles : (beams,)
        Directions of the beams, rising, rad.
    scans_of_legs : (legs,)
        Scan that each marked leg is in, never falling.
    legs : (legs, 2)
        Mean of the readings on it, in the frame of the scanner, m. Two legs that touch are marked
        as one.
    sector
        Where all legs of a scan with marks are marked; ``None`` for a recording without marks.
    report
        What became of all messages, if they come from a ROS bag.
    """

    times: Float[np.ndarray, " scans"]
    ranges: Float[np.ndarray, "scans beams"]
    angles: Float[np.ndarray, " beams"]
    scans_of_legs: Int[np.ndarray, " legs"]
    legs: Float[np.ndarray, "legs 2"]
    sector: Sector | None
    report: ReadReport | None = None

    def __len__(self) -> int:
        return len(self.times)


def read_leg_scans(path: str | Path, *, time_unit: str = "s", topic: Topics = None) -> LegScans:
    """Read scans at leg height from a NumPy archive or a ROS bag.

    Readings that are NaN, beyond the scanner's range or nearer than its least distance, which
    scanners report where nothing came back, become infinite.

    Parameters
    ----------
    path
        File with the arrays ``stamp`` (s), ``ranges`` (m), ``angle_min``, ``angle_increment``
        (rad), ``range_min`` and ``range_max`` (m; it may be infinite); with marks also
        ``leg_scan``, ``leg_xy`` (m) and ``label_sector_deg_m`` (degrees, degrees, m). Or a bag, as
        `read_bag_scans` reads it.
    time_unit
        What ``stamp`` counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``. Bags tell.
    topic
        Of a bag, where several would do.

    Raises
    ------
    CorruptLog
        If the file cannot be read, an array is missing or of another shape, a number is not finite,
        time does not rise, times or angles are in another unit, or a mark is in no scan.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    Leigh, Pineau, Olmedo and Zhang, "Person tracking and following with 2D laser scanners", ICRA
    2015.
    """
    path, topic = as_path(path), check_topic(topic)
    limits.per_second(time_unit)
    if is_bag(path):
        scans = read_bag_scans(path, topic)
        ranges = np.where(np.isnan(scans.ranges), np.inf, scans.ranges)
        return LegScans(scans.times, ranges, scans.angles, *_unmarked(), report=scans.report)
    with (
        reading(path, "no NumPy archive, or a damaged one", CorruptLog),
        np.load(path, allow_pickle=False) as found,
    ):
        arrays = {name: np.asarray(found[name]) for name in found.files}
    marked = any(name in arrays for name in LABELS)
    missing = [name for name in NEEDED + LABELS * marked if name not in arrays]
    if missing:
        raise CorruptLog(f"{path}: has no array {', '.join(missing)}")
    try:
        return _scans(path, arrays, marked, time_unit)
    except CorruptLog:
        raise
    except (ValueError, TypeError) as error:
        raise CorruptLog(f"{path}: {error}") from error


def _scans(path: Path, arrays: dict[str, np.ndarray], marked: bool, time_unit: str) -> LegScans:
    first, step, nearest = (checks.array(name, arrays[name], ()) for name in NEEDED[2:5])
    farthest = checks.array("range_max", arrays["range_max"], (), finite=False)
    if not farthest > nearest:
        raise ValueError(f"range_max must be above range_min, got {farthest:g} and {nearest:g}")
    checks.positive("angle_increment", float(step))
    times = checks.array("stamp", arrays["stamp"], ("scans",))
    if not times.size:
        raise ValueError("stamp must hold one time at least, got none")
    if (np.diff(times) <= 0).any():
        k = int(np.argmax(np.diff(times) <= 0))
        two = f"{times[k]:.15g} before {times[k + 1]:.15g}"
        raise ValueError(f"stamp must rise, got {two} in scan {k + 2}")
    times = in_seconds(path, times, time_unit)
    ranges = checks.array("ranges", arrays["ranges"], (len(times), "beams"), finite=False)
    nothing = ~((ranges >= nearest) & (ranges <= min(farthest, FARTHEST)) & (ranges > 0))
    ranges = np.where(nothing, np.inf, ranges)
    angles = float(first) + float(step) * np.arange(ranges.shape[1])
    if abs(first) > limits.TURN or np.ptp(angles) > limits.TURN:
        ends = f"from {angles[0]:g} to {angles[-1]:g}"
        raise ValueError(f"beams must lie within a turn, got {ends}: are these radians?")
    if not marked:
        return LegScans(times, ranges, angles, *_unmarked())
    rows = checks.integers("leg_scan", arrays["leg_scan"], ("legs",), 0)
    bad = np.append(False, np.diff(rows) < 0) | (rows >= len(times))
    if bad.any():
        k = int(np.argmax(bad))
        told = f"got {rows[k]} in row {k + 1}"
        raise ValueError(f"leg_scan must not fall, and be below {len(times)}, {told}")
    legs = checks.array("leg_xy", arrays["leg_xy"], (len(rows), 2))
    low, high, reach = checks.vector("label_sector_deg_m", arrays["label_sector_deg_m"], 3)
    sector = Sector(float(np.deg2rad(low)), float(np.deg2rad(high)), float(reach))
    return LegScans(times, ranges, angles, rows, legs, sector)


def _unmarked() -> tuple[Int[np.ndarray, "0"], Float[np.ndarray, "0 2"], None]:
    """Return the scans of legs, the legs and the sector of a recording without marks."""
    return np.zeros(0, dtype=np.int64), np.zeros((0, 2)), None
