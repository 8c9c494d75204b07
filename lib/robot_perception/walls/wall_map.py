r"""A map of walls, merged from the segments of many scans with known poses.

Fig. 1a of the paper shows the *search range* of a wall hypothesis. Here it is a gate: a segment
may belong to a wall if the difference of the two lines, taken at the middle of the segment, is
small against its covariance (χ² with two degrees of freedom), and if the two overlap along the
wall or nearly do.
"""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.checks import (
    array,
    computable,
    covariance,
    instance,
    not_negative,
    reals,
    whole,
)
from robot_perception.fields import Level, NotNegative, checked
from robot_perception.geometry import act, wrap_angle
from robot_perception.walls.segments import Segments, project


@dataclass(frozen=True, slots=True)
class Gate:
    """Search range of a wall hypothesis. The paper gives no values: all are our choice.

    Parameters
    ----------
    probability
        Share of true matches that the χ² gate lets through.
    roughness
        How far a real wall and a real pose stray from our model, perpendicular to the wall, as a
        standard deviation, m.
    roughness_angle
        The same for the direction, rad.
    widest_gap
        Longest hole along a wall that does not end it, m.
    """

    probability: Level = 0.99
    roughness: NotNegative = 0.02
    roughness_angle: Annotated[float, not_negative] = np.deg2rad(1.0)
    widest_gap: NotNegative = 0.5
    __post_init__ = checked

    @property
    def threshold(self) -> float:
        """Largest squared Mahalanobis distance that passes."""
        return -2.0 * math.log1p(-self.probability)  # χ² with two degrees of freedom


@dataclass(frozen=True, eq=False, slots=True)
class WallMap:
    """Walls in the frame of the world.

    Parameters
    ----------
    lines
        Distance and direction (ρ, θ) of each wall, m and rad; the direction points into the wall.
    covs
        Covariance of (ρ, θ).
    ends
        Both ends of each wall, m.
    scans
        In how many scans each wall was seen.
    """

    lines: Float[np.ndarray, "walls 2"]
    covs: Float[np.ndarray, "walls 2 2"]
    ends: Float[np.ndarray, "walls 2 2"]
    scans: Int[np.ndarray, " walls"]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.lines)

    @classmethod
    def empty(cls) -> "WallMap":
        """Return a map without walls."""
        return cls(np.empty((0, 2)), np.empty((0, 2, 2)), np.empty((0, 2, 2)), np.empty(0, int))

    @property
    def lengths(self) -> Float[np.ndarray, " walls"]:
        """Lengths, m."""
        return np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=-1)

    def seen_in(self, scans: int) -> "WallMap":
        """Return the walls that were seen in at least so many scans."""
        return self._take(self.scans >= whole("scans", scans, 0))

    def _take(self, keep: np.ndarray) -> "WallMap":
        return WallMap(self.lines[keep], self.covs[keep], self.ends[keep], self.scans[keep])


def to_world(
    segments: Segments,
    pose: Float[np.ndarray, "3"],
    pose_cov: Float[np.ndarray, "3 3"] | None = None,
) -> Segments:
    r"""Return segments of a scan in the frame of the world.

    .. math::

       \theta_w = \theta + \varphi, \qquad
       \rho_w = \rho + x \cos\theta_w + y \sin\theta_w

    Parameters
    ----------
    segments
        Segments in the frame of the scanner.
    pose
        Where the scanner stood (x, y, φ), m and rad.
    pose_cov
        Covariance of the pose; none if it is known exactly.

    Raises
    ------
    ValueError
        If the pose is not three finite numbers, or its covariance is none.
    """
    instance("segments", segments, Segments)
    pose = reals("pose", pose)
    if pose.shape != (3,) or not np.isfinite(pose).all():
        raise ValueError(f"pose must be three finite numbers, got {pose}")
    theta = wrap_angle(segments.lines[:, 1] + pose[2])
    cos, sin = np.cos(theta), np.sin(theta)
    rho = segments.lines[:, 0] + pose[0] * cos + pose[1] * sin
    lever = pose[1] * cos - pose[0] * sin
    J = np.zeros((len(segments), 2, 2))
    J[:, 0, 0] = J[:, 1, 1] = 1.0
    J[:, 0, 1] = lever
    covs = J @ segments.covs @ J.mT
    if pose_cov is not None:
        pose_cov = covariance("pose_cov", pose_cov, (3, 3))
        J_pose = np.zeros((len(segments), 2, 3))
        J_pose[:, 0, 0], J_pose[:, 0, 1], J_pose[:, 0, 2] = cos, sin, lever
        J_pose[:, 1, 2] = 1.0
        covs = covs + J_pose @ pose_cov @ J_pose.mT
    ends = act(pose, segments.ends)
    return Segments(np.stack([rho, theta], axis=-1), covs, ends, segments.spans)


def seen_from(
    lines: Float[np.ndarray, "walls 2"],
    covs: Float[np.ndarray, "walls 2 2"],
    point: Float[np.ndarray, "2"],
) -> tuple[Float[np.ndarray, "walls 2"], Float[np.ndarray, "walls 2 2"]]:
    r"""Return lines and covariances with the origin moved to a point.

    .. math:: \rho' = \rho - x \cos\theta - y \sin\theta

    Far from the origin ρ and θ are strongly correlated; at a point near the wall they are not, and
    the covariance shows how far the wall may lie off there.
    """
    lines, point = array("lines", lines, ("walls", 2)), array("point", point, (2,))
    covs = array("covs", covs, (len(lines), 2, 2), "lines")
    cos, sin = np.cos(lines[:, 1]), np.sin(lines[:, 1])
    J = np.zeros((len(lines), 2, 2))
    J[:, 0, 0] = J[:, 1, 1] = 1.0
    J[:, 0, 1] = point[0] * sin - point[1] * cos
    rho = lines[:, 0] - point[0] * cos - point[1] * sin
    return np.stack([rho, lines[:, 1]], axis=-1), J @ covs @ J.mT


def search(
    walls: WallMap, segments: Segments, index: int, gate: Gate
) -> tuple[Bool[np.ndarray, " walls"], Float[np.ndarray, " walls"]]:
    r"""Find the walls of a map to which a segment may belong.

    .. math::

       d^2 = e^\top (C_{wall} + C_{segment} + R)^{-1} e, \qquad
       e = (\rho_{wall} - \rho_{segment},\; \theta_{wall} - \theta_{segment})

    with both lines seen from the middle of the segment and :math:`R` the gate's roughness.

    Parameters
    ----------
    walls
        The map.
    segments, index
        Segments in the frame of the world, and which of them is meant.
    gate
        The search range.

    Returns
    -------
    accepted, squared_distances
        For each wall whether it passes, and :math:`d^2`.

    References
    ----------
    Andrade-Cetto, Fig. 1a.
    """
    instance("walls", walls, WallMap)
    instance("segments", segments, Segments)
    instance("gate", gate, Gate)
    index = whole("index", index, 0, len(segments) - 1)
    middle = segments.ends[index].mean(axis=0)
    lines, covs = seen_from(walls.lines, walls.covs, middle)
    one = slice(index, index + 1)
    line, cov = seen_from(segments.lines[one], segments.covs[one], middle)
    error = lines - line
    error[:, 1] = wrap_angle(error[:, 1])
    S = covs + cov + np.diag([gate.roughness**2, gate.roughness_angle**2])
    with computable("covs of walls and segments"):
        squared = (error * np.linalg.solve(S, error[..., None])[..., 0]).sum(axis=-1)
    along = np.array([-np.sin(line[0, 1]), np.cos(line[0, 1])])
    mine = np.sort((segments.ends[index] - middle) @ along)
    theirs = np.sort((walls.ends - middle) @ along, axis=-1)
    gap = np.maximum(theirs[:, 0] - mine[1], mine[0] - theirs[:, 1])
    return (squared <= gate.threshold) & (gap <= gate.widest_gap), squared


def merge(walls: WallMap, segments: Segments, gate: Gate) -> WallMap:
    r"""Add the segments of one scan to a map.

    A segment that passes the gate of no wall becomes a new wall. Otherwise it is fused with the
    walls it passes, weighted by information,

    .. math:: C^{-1} = \sum_m C_m^{-1}, \qquad \mu = C \sum_m C_m^{-1} \mu_m ,

    and the ends move outwards to hold all of them. Several segments of the scan may join one wall,
    as its parts left and right of a pillar do: the scan counts once for it.

    Parameters
    ----------
    walls
        The map so far.
    segments
        Segments of one scan in the frame of the world.
    gate
        The search range.

    Returns
    -------
    The new map; the old one is left alone.
    """
    instance("walls", walls, WallMap)
    instance("segments", segments, Segments)
    instance("gate", gate, Gate)
    lines, covs, ends, scans = walls.lines, walls.covs, walls.ends, walls.scans
    before = scans  # without this scan
    for k in range(len(segments)):
        accepted, _ = search(WallMap(lines, covs, ends, scans), segments, k, gate)
        one = slice(k, k + 1)
        group_lines = np.concatenate([lines[accepted], segments.lines[one]])
        group_covs = np.concatenate([covs[accepted], segments.covs[one]])
        group_ends = np.concatenate([ends[accepted], segments.ends[one]])
        line, cov = _fuse(group_lines, group_covs, segments.ends[k].mean(axis=0))
        earlier = before[accepted].max(initial=0)
        lines = np.concatenate([lines[~accepted], line[None]])
        covs = np.concatenate([covs[~accepted], cov[None]])
        ends = np.concatenate([ends[~accepted], _hull(line, group_ends)[None]])
        before = np.append(before[~accepted], earlier)
        scans = np.append(scans[~accepted], earlier + 1)
    return WallMap(lines, covs, ends, scans)


def _fuse(lines: np.ndarray, covs: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Information-weighted mean of lines, computed at a point near them."""
    lines, covs = seen_from(lines, covs, point)
    theta = lines[-1, 1] + wrap_angle(lines[:, 1] - lines[-1, 1])
    values = np.stack([lines[:, 0], theta], axis=-1)
    with computable("covs of walls, segments and pose_cov"):
        information = np.linalg.inv(covs)
        cov = np.linalg.inv(information.sum(axis=0))
    mean = cov @ (information @ values[..., None]).sum(axis=0)[:, 0]
    mean[1] = wrap_angle(mean[1])
    line, cov = seen_from(mean[None], cov[None], -point)
    return line[0], cov[0]


def _hull(line: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The two outermost of the ends, projected on the line."""
    feet = project(line, ends.reshape(-1, 2))
    along = feet @ np.array([-np.sin(line[1]), np.cos(line[1])])
    return feet[[along.argmin(), along.argmax()]]
