"""Wall maps of two real buildings, measured without any floor plan."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from scipy.stats import median_abs_deviation

from robot_perception import walls
from robot_perception.datasets import LaserLog, read_graph_log
from robot_perception.geometry import act
from studies.stored.recordings import Recording

EXTRACTION = walls.Extraction(walls.RangeNoise(0.02), tolerance=0.1)
GATE = walls.Gate(roughness=0.05, roughness_angle=float(np.deg2rad(2.0)))
POSE = np.diag([0.03, 0.03, np.deg2rad(0.4)]) ** 2
"""Covariance of the poses of the graph logs; their description says 3–4 cm and 0.4–0.5°."""
LEAST_SCANS = 4


@dataclass(frozen=True, eq=False, slots=True)
class RecordedMap:
    """The wall map of a recording, and how sure one can be of it without a floor plan.

    ``points`` and ``way`` are thinned; lengths are in m where no unit is named, angles in degrees.
    ``explained`` is the share of the readings within ``reach`` (3σ) of a wall, ``direction_share``
    that of the length by direction modulo 90°, ``square`` that within 5° of two perpendicular
    directions, the first at ``square_at``. The ``shared`` walls were found in both halves of the
    drive and differ by ``offset_mm`` and ``turn_deg`` (robust standard deviations).
    """

    points: Float[np.ndarray, "points 2"]
    ends: Float[np.ndarray, "walls 2 2"]
    scans: Int[np.ndarray, " walls"]
    way: Float[np.ndarray, "places 2"]
    used: int
    readings: int
    walls: int
    length: float
    explained: float
    reach: float
    directions: Float[np.ndarray, " bins"]
    direction_share: Float[np.ndarray, " bins"]
    square: float
    square_at: float
    offset_mm: float
    turn_deg: float
    shared: int


def recorded_map(log: LaserLog, every: int) -> RecordedMap:
    """Build the wall map of a recording from one scan of ``every`` and measure it."""
    ranges, poses = log.ranges[::every], log.poses[::every]
    found, report = _map(ranges, log.angles, poses)
    points = world_points(ranges, log.angles, poses)
    reach = 3 * float(np.hypot(EXTRACTION.noise.range_sigma, GATE.roughness))
    checked = points[:: max(1, len(points) // 20_000)]
    folded = np.rad2deg(found.lines[:, 1]) % 90.0
    share, edges = np.histogram(folded, 18, (0.0, 90.0), weights=found.lengths)
    candidates = np.arange(0.0, 90.0, 0.5)
    apart = np.abs((folded[:, None] - candidates + 45.0) % 90.0 - 45.0)
    square = (found.lengths @ (apart <= 5.0)) / found.lengths.sum()
    half = len(ranges) // 2
    first, _ = _map(ranges[:half], log.angles, poses[:half])
    second, _ = _map(ranges[half:], log.angles, poses[half:])
    both = walls.score_map(second, first.ends, reach=0.3)
    return RecordedMap(
        points=points[:: max(1, len(points) // 2000)],
        ends=found.ends,
        scans=found.scans,
        way=poses[:: max(1, len(poses) // 500), :2],
        used=len(ranges),
        readings=report.readings,
        walls=len(found),
        length=float(found.lengths.sum()),
        explained=float(walls.explained(checked, found, reach).mean()),
        reach=reach,
        directions=(edges[1:] + edges[:-1]) / 2,
        direction_share=share / share.sum(),
        square=float(square.max()),
        square_at=float(candidates[square.argmax()]),
        offset_mm=float(1e3 * median_abs_deviation(both.offsets, scale="normal")),
        turn_deg=float(np.rad2deg(median_abs_deviation(both.angles, scale="normal"))),
        shared=len(both.offsets),
    )


def world_points(
    ranges: Float[np.ndarray, "scans beams"],
    angles: Float[np.ndarray, " beams"],
    poses: Float[np.ndarray, "scans 3"],
) -> Float[np.ndarray, "readings 2"]:
    """Return the readings that came back, in the frame of the world, m."""
    valid = np.isfinite(ranges)
    return act(poses, walls.to_points(np.where(valid, ranges, 0.0), angles))[valid]


def _map(
    ranges: np.ndarray, angles: np.ndarray, poses: np.ndarray
) -> tuple[walls.WallMap, walls.ScanReport]:
    found, report = walls.build_map(ranges, angles, poses, EXTRACTION, GATE, pose_cov=POSE)
    return found.seen_in(LEAST_SCANS), report


def _recording(name: str, every: int) -> Recording[RecordedMap]:
    def compute(folder: Path) -> RecordedMap:
        return recorded_map(read_graph_log(folder / f"{name}_graph.log.gz"), every)

    return Recording(f"carmen_{name}", compute, RecordedMap, store=f"walls-{name}")


FR079, INTEL = _recording("fr079", every=2), _recording("intel", every=3)
