"""Mapper of walls, one scan at a time.

A user who has readings and the pose at which they were taken needs one object: it extracts the
segments of a scan, brings them into the frame of the world and merges them into the map.
"""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from jaxtyping import Float

from robot_perception.checks import array, instance, reals
from robot_perception.fields import checked, covariance
from robot_perception.geometry.angles import check_turn
from robot_perception.walls.segments import (
    Extraction,
    ScanReport,
    Segments,
    extract_segments,
)
from robot_perception.walls.wall_map import Gate, WallMap, merge, to_world


@dataclass(frozen=True, eq=False, slots=True)
class WallInfo:
    """Diagnostics of one scan.

    Parameters
    ----------
    segments
        Its segments in the frame of the world.
    report
        What became of its readings.
    """

    segments: Segments
    report: ScanReport


@dataclass(frozen=True, eq=False, slots=True)
class WallMapper:
    """Takes scans, one by one, to a map of walls; the poses are known, up to a covariance.

    Parameters
    ----------
    angles
        Directions of the beams, strictly increasing, rad.
    extraction
        What is taken for a wall in one scan.
    gate
        Search range for walls already in the map.
    pose_cov
        Covariance of every pose; none if they are known exactly.

    Examples
    --------
    >>> mapper = WallMapper(np.linspace(-1.5, 1.5, 151))
    >>> state, info = mapper.step(mapper.start(), 2.0 / np.cos(mapper.angles), np.zeros(3))
    >>> state.ends.round(1).tolist()
    [[[2.0, -28.2], [2.0, 28.2]]]
    """

    angles: Annotated[Float[np.ndarray, " beams"], lambda name, value: check_turn(value)]
    extraction: Extraction = field(default_factory=Extraction)
    gate: Gate = field(default_factory=Gate)
    pose_cov: Annotated[Float[np.ndarray, "3 3"], covariance] | None = None
    __post_init__ = checked

    def start(self) -> WallMap:
        """Return a map without walls."""
        return WallMap.empty()

    def step(
        self, state: WallMap, ranges: Float[np.ndarray, " beams"], pose: Float[np.ndarray, "3"]
    ) -> tuple[WallMap, WallInfo]:
        """Add a scan to the map.

        Parameters
        ----------
        state
            The map so far; it is left alone.
        ranges
            Readings, m; infinite where nothing came back.
        pose
            Where the scanner stood (x, y, φ), m and rad.

        Returns
        -------
        state, info
            The new map, in which `WallMap.seen_in` tells hypotheses from what further scans have
            confirmed; and what the scan gave.

        Raises
        ------
        ValueError
            If there is not a reading for each beam, or the pose is not three finite numbers.
        """
        instance("state", state, WallMap)
        segments, report = extract_segments(ranges, self.angles, self.extraction)
        segments = to_world(segments, pose, self.pose_cov)
        return merge(state, segments, self.gate), WallInfo(segments, report)


def build_map(
    ranges: Float[np.ndarray, "scans beams"],
    angles: Float[np.ndarray, " beams"],
    poses: Float[np.ndarray, "scans 3"],
    extraction: Extraction,
    gate: Gate,
    *,
    pose_cov: Float[np.ndarray, "3 3"] | None = None,
) -> tuple[WallMap, ScanReport]:
    """Build the wall map of a drive with known poses; `WallMapper` does so scan by scan.

    Parameters
    ----------
    ranges
        Readings of each scan, m; infinite where nothing came back.
    angles
        Directions of the beams, rad.
    poses
        Pose of the scanner at each scan, m and rad.
    extraction
        What is taken for a wall in one scan.
    gate
        Search range for walls already in the map.
    pose_cov
        Covariance of every pose; none if they are known exactly.

    Returns
    -------
    walls, report
        The map, and what became of all readings.

    Raises
    ------
    ValueError
        If there is no scan, the numbers of scans and poses differ, one of these is not as it should
        be, or the covariance is none.
    """
    ranges, poses = reals("ranges", ranges), array("poses", poses, ("scans", 3))
    mapper = WallMapper(angles, extraction, gate, pose_cov)
    if ranges.ndim == 0 or len(ranges) == 0 or len(ranges) != len(poses):
        count = len(ranges) if ranges.ndim else 0
        raise ValueError(
            f"ranges and poses must have a pose for each scan, got {count} and {len(poses)}"
        )
    walls, report = mapper.start(), ScanReport(0, 0, 0, 0, 0, 0, 0)
    for scan, pose in zip(ranges, poses, strict=True):
        walls, info = mapper.step(walls, scan, pose)
        report = report + info.report
    return walls, report
