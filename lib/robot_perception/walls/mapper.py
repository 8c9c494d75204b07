"""Mapper of walls, one scan at a time, from known poses.

`WallMapper` does all that a user with scans and poses needs: it extracts the segments of a scan,
transforms them into the frame of the world, and merges them into the map.
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
        Segments of the scan in the frame of the world.
    report
        Counts of the readings of the scan, by how they were used.
    """

    segments: Segments
    report: ScanReport


@dataclass(frozen=True, eq=False, slots=True)
class WallMapper:
    """Builds a map of walls scan by scan, from known poses.

    Parameters
    ----------
    angles
        Directions of the beams, strictly increasing, rad.
    extraction
        Rules for the segments of one scan.
    gate
        Gate between a segment and the walls of the map.
    pose_cov
        Covariance of every pose; ``None`` if poses are known exactly.

    Examples
    --------
    >>> mapper = WallMapper(np.linspace(-1.5, 1.5, 151))
    >>> state, info = mapper.step(mapper.start(), 2.0 / np.cos(mapper.angles), np.zeros(3))
    >>> state.ends.round(1).tolist()
    [[[2.0, -13.2], [2.0, 13.2]]]
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
            Map before the scan; it does not change.
        ranges
            Readings, m; infinite where nothing came back.
        pose
            Pose (x, y, φ) of the scanner, m and rad.

        Returns
        -------
        state, info
            The new map, and diagnostics of the scan. A wall of one scan alone is a hypothesis;
            `WallMap.seen_in` selects the walls that several scans confirm.

        Raises
        ------
        ValueError
            If there is not one reading for each beam, or the pose is not three finite numbers.
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
    """Return the map of walls of a whole drive with known poses; see `WallMapper`.

    Parameters
    ----------
    ranges
        Readings of each scan, m; infinite where nothing came back.
    angles
        Directions of the beams, strictly increasing, rad.
    poses
        Pose of the scanner at each scan, m and rad.
    extraction
        Rules for the segments of one scan.
    gate
        Gate between a segment and the walls of the map.
    pose_cov
        Covariance of every pose; ``None`` if poses are known exactly.

    Returns
    -------
    walls, report
        The map, and counts of all readings, by how they were used.

    Raises
    ------
    ValueError
        If there is no scan, the numbers of scans and poses differ, a scan has not one reading for
        each beam, a pose is not three finite numbers, or ``pose_cov`` is not a covariance.
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
