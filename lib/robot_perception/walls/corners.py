"""Point landmarks of one scan: corners where two walls meet, and thin round poles."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from jaxtyping import Float

from robot_perception.checks import array, instance, positive
from robot_perception.fields import NotNegative, Positive, checked, from_to
from robot_perception.gating import gate
from robot_perception.geometry.angles import closes
from robot_perception.observations import Observations, unnamed
from robot_perception.walls.segments import (
    Extraction,
    RangeNoise,
    ScanReport,
    Segments,
    acute,
    as_scan,
    cut,
    extract_segments,
    to_points,
)

_THIN = Extraction(RangeNoise(0.0155), tolerance=0.05, least_length=0.25)


@dataclass(frozen=True, slots=True)
class LandmarkRules:
    """Rules by which a corner becomes a landmark. All values are our choice.

    Parameters
    ----------
    extraction
        What is taken for a wall, and the noise of the scanner. Its tolerance is about three
        deviations of a range here: readings beyond the corner pull it along when more are let in.
    least_angle
        Least angle between the two walls of a corner, rad.
    reach
        Farthest that a wall may end from the corner, beside the spacing of its readings there, m.
    edge
        Deviation ascribed to a corner, in each direction, for readings next to it that are counted
        with the wrong wall, m: what the covariances of the two lines do not know.
    pole_radius
        Radius of the poles, m: the columns of one building are alike, and a few readings on one
        side of a thin pole say little about how thick it is.
    least_on_pole
        Fewest readings on a pole, at least 3.
    step
        How much farther away the readings beside a pole must be, m.
    """

    extraction: Extraction = field(default_factory=lambda: _THIN)
    least_angle: Annotated[float, acute] = np.deg2rad(40.0)
    reach: Positive = 0.1
    edge: NotNegative = 0.003
    pole_radius: Positive = 0.15
    least_on_pole: Annotated[int, from_to(3)] = 5
    step: Positive = 0.15
    __post_init__ = checked


@dataclass(frozen=True, slots=True)
class LandmarkReport:
    """Account of what was looked at in one scan.

    Parameters
    ----------
    readings
        What became of the readings.
    kinds
        What each landmark is: ``"concave"`` (a recess), ``"convex"`` (a wall that juts out) or
        ``"pole"``.
    apart
        Neighbouring walls that do not meet: one ends in front of the other.
    flat
        Neighbouring walls that meet under too flat an angle.
    not_round
        Small things that stand free but are no pole.
    """

    readings: ScanReport
    kinds: tuple[str, ...]
    apart: int
    flat: int
    not_round: int


def find_landmarks(
    ranges: Float[np.ndarray, " n"], angles: Float[np.ndarray, " n"], rules: LandmarkRules
) -> tuple[Observations, LandmarkReport]:
    """Find the corners and poles of one scan.

    Parameters
    ----------
    ranges
        Readings, m; infinite where nothing came back. Readings that are infinite, NaN or not
        positive are left out and counted.
    angles
        Directions of the beams, strictly increasing, rad.
    rules
        What is taken for a landmark.

    Returns
    -------
    landmarks, report
        Corners in order of angle, then poles, without names: positions in the frame of the scanner,
        m, with covariances, m²; what they are, and what was passed over.

    Raises
    ------
    ValueError
        If ranges and angles differ in shape, or the angles are not finite and increasing over at
        most one turn.
    """
    instance("rules", rules, LandmarkRules)
    segments, readings = extract_segments(ranges, angles, rules.extraction)
    corners, kinds, apart, flat = find_corners(segments, angles, rules)
    poles, not_round = find_poles(ranges, angles, rules)
    points = np.concatenate([corners.values, poles.values])
    found = unnamed(points, np.concatenate([corners.covs, poles.covs]))
    kinds += ("pole",) * len(poles)
    return found, LandmarkReport(readings, kinds, apart, flat, not_round)


def find_corners(
    segments: Segments, angles: Float[np.ndarray, " n"], rules: LandmarkRules
) -> tuple[Observations, tuple[str, ...], int, int]:
    r"""Intersect neighbouring walls of one scan that really meet.

    The corner solves both line equations,

    .. math::

       A p = \begin{pmatrix}\rho_1\\ \rho_2\end{pmatrix}, \qquad
       A = \begin{pmatrix}\cos\theta_1 & \sin\theta_1\\ \cos\theta_2 & \sin\theta_2\end{pmatrix},
       \qquad \frac{\partial p}{\partial \rho_i} = A^{-1} e_i, \quad
       \frac{\partial p}{\partial \theta_i} = -A^{-1} e_i\, (n'_i \cdot p) ,

    where :math:`n'` is the normal turned by a right angle, and its covariance is that of both
    lines carried through these derivatives. Both walls must be seen up to the corner; where one
    ends in front of the other there is an edge of sight and no landmark.

    Parameters
    ----------
    segments
        Walls of one scan, in the order of `extract_segments`.
    angles
        Directions of the beams of that scan, rad.
    rules
        What is taken for a corner.

    Returns
    -------
    corners, kinds, apart, flat
        Where the corners are, what each is, and how many neighbours do not meet, or meet under too
        flat an angle.

    Raises
    ------
    ValueError
        If a segment ends at a reading that has no angle.
    """
    instance("segments", segments, Segments)
    instance("rules", rules, LandmarkRules)
    angles = array("angles", angles, ("n",))
    if segments.spans.max(initial=-1) >= len(angles):
        raise ValueError(
            f"angles must be those of the scan, got {len(angles)} for {segments.spans.max() + 1}"
        )
    rho, theta = segments.lines[:, 0], segments.lines[:, 1]
    neighbours = np.stack([np.arange(len(segments)), np.roll(np.arange(len(segments)), -1)], -1)
    if len(segments) < 2 or not closes(angles):
        neighbours = neighbours[:-1]
    turn = np.sin(theta[neighbours[:, 1]] - theta[neighbours[:, 0]])
    flat = np.abs(turn) < np.sin(rules.least_angle)
    pairs = neighbours[~flat]
    first, second = pairs.T
    normals = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    inverse = np.linalg.inv(normals[pairs])
    points = (inverse @ rho[pairs][..., None])[..., 0]
    near, far = segments.ends[first, 1], segments.ends[second, 0]
    beams = angles[segments.spans[second, 0]] - angles[segments.spans[first, 1]]
    beams = np.maximum(np.where(beams < 0, beams + 2 * np.pi, beams), 0)
    spacing = [_spacing(rho[i], points, beams) for i in (first, second)]
    meet = np.hypot(*(near - points).T) <= rules.reach + spacing[0]
    meet &= np.hypot(*(far - points).T) <= rules.reach + spacing[1]
    meet &= beams <= 4.5 * np.min(np.diff(angles), initial=np.inf)
    pairs, inverse, points = pairs[meet], inverse[meet], points[meet]
    across = np.stack([-normals[..., 1], normals[..., 0]], axis=-1)
    lever = (across[pairs] * points[:, None]).sum(axis=-1)
    jacobian = np.stack([np.ones_like(lever), -lever], axis=-1)  # of A p by (ρ, θ) of each line
    spread = (jacobian[..., None, :] @ segments.covs[pairs] @ jacobian[..., None])[..., 0]
    covs = (inverse * spread.mT) @ inverse.mT + rules.edge**2 * np.eye(2)
    kinds = tuple("concave" if inwards else "convex" for inwards in turn[~flat][meet] > 0)
    return unnamed(points, covs), kinds, int((~meet).sum()), int(flat.sum())


def _spacing(rho: np.ndarray, points: np.ndarray, beams: np.ndarray) -> np.ndarray:
    """Distance along a wall between two beams that meet it near a point."""
    return beams * (points**2).sum(axis=-1) / np.maximum(rho, 1e-3)


def find_poles(
    ranges: Float[np.ndarray, " n"], angles: Float[np.ndarray, " n"], rules: LandmarkRules
) -> tuple[Observations, int]:
    """Find small round things that stand free in front of whatever is behind.

    Parameters
    ----------
    ranges
        Readings, m; infinite where nothing came back.
    angles
        Their directions, increasing, rad.
    rules
        What is taken for a pole.

    Returns
    -------
    poles, not_round
        And how many small free things are not round.

    Raises
    ------
    ValueError
        As :func:`find_landmarks`.
    """
    instance("rules", rules, LandmarkRules)
    ranges, angles = as_scan(ranges, angles)
    noise = rules.extraction.noise
    found = cut(ranges, angles, noise, rules.extraction.grazing)
    r = ranges[found.order]
    points = to_points(r, angles[found.order])
    inner = slice(None if found.ring else 1, None if found.ring else -1)  # with two sides
    centres, covs, not_round = [], [], 0
    for start, stop in zip(found.starts[inner], found.stops[inner], strict=True):
        wide = np.hypot(*(points[stop - 1] - points[start])) > 2 * rules.pole_radius + rules.reach
        free = min(r[start - 1] - r[start], r[stop % len(r)] - r[stop - 1]) > rules.step
        if wide or not free or stop - start < rules.least_on_pole:
            continue
        fit = fit_pole(points[start:stop], rules.pole_radius, noise.range_sigma)
        if fit is None:
            not_round += 1
            continue
        centres.append(fit[0])
        covs.append(fit[1])
    return unnamed(np.reshape(centres, (-1, 2)), np.reshape(covs, (-1, 2, 2))), not_round


def fit_pole(
    points: Float[np.ndarray, "n 2"], radius: float, sigma: float
) -> tuple[Float[np.ndarray, "2"], Float[np.ndarray, "2 2"]] | None:
    r"""Fit a circle of known radius to readings on the side that faces the scanner.

    Gauss-Newton on :math:`|p_i - c| - r`. With :math:`n_i` from the centre to a reading and
    :math:`u_i` along its beam, a range error of :math:`\sigma` shows as
    :math:`\sigma\, n_i \cdot u_i`, so that

    .. math::

       C = N^{-1} \Big(\sum_i \sigma^2 (n_i \cdot u_i)^2 n_i n_i^\top\Big) N^{-1}, \qquad
       N = \sum_i n_i n_i^\top .

    Parameters
    ----------
    points
        Readings in the frame of the scanner, m.
    radius
        Of the pole, m.
    sigma
        Deviation of a range, m.

    Returns
    -------
    centre, covariance, or ``None`` if the readings do not lie on such a circle (their squared
    distances exceed the 99.9 % quantile of χ²).

    Raises
    ------
    ValueError
        If there are fewer than three readings, one is where the scanner is, all lie in one
        direction from it, or a number is beyond 1e100.
    """
    points = array("points", points, ("n", 2))
    radius = positive("radius", radius)
    sigma = positive("sigma", sigma)
    if len(points) < 3:
        raise ValueError(f"points must be at least 3, got {len(points)}")
    away, middle = np.hypot(*points.T), points.mean(axis=0)
    if not away.min() > 0 or not np.hypot(*middle) > 0:
        raise ValueError("points must lie on one side of the scanner, got some at or around it")
    across = points[:, 0] * points[0, 1] - points[:, 1] * points[0, 0]
    if (np.abs(across) <= 1e-12 * away * away[0]).all():
        raise ValueError(f"points must lie in different directions, got {len(points)} in one")
    centre = middle * (1 + radius / np.hypot(*middle))
    for _ in range(6):
        arms = points - centre
        lengths = np.hypot(*arms.T)
        normals = arms / np.maximum(lengths, np.finfo(float).tiny)[:, None]
        information = normals.T @ normals
        if not np.linalg.det(information) > 1e-12 * len(points) ** 2:
            return None  # no direction but one fixes the centre
        error = lengths - radius
        centre = centre + np.linalg.solve(information, normals.T @ error)
    beams = points / away[:, None]
    seen = normals * (normals * beams).sum(axis=-1, keepdims=True)
    if (error**2).sum() > sigma**2 * gate(0.999, len(points) - 2):
        return None
    inverse = np.linalg.inv(information)
    return centre, sigma**2 * inverse @ (seen.T @ seen) @ inverse
