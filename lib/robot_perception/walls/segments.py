r"""Wall segments of one scan: break points, split, line fit with covariance.

A line is given by the length :math:`\rho` and the direction :math:`\theta` of the perpendicular
dropped on it, :math:`x \cos\theta + y \sin\theta = \rho`. The direction points from the side on
which the scanner stands to the wall, so a segment has a front and a back: in the frame of the
scanner :math:`\rho \ge 0`; seen from elsewhere it may be negative.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.beliefs import Gaussian
from robot_perception.checks import (
    array,
    check_batches,
    instance,
    number,
    reals,
    shaped,
)
from robot_perception.fields import NotNegative, Positive, checked, from_to
from robot_perception.geometry.angles import check_turn, closes
from robot_perception.walls.chains import simplify


def acute(name: str, angle: float) -> float:
    """Return an angle between zero and a right angle."""
    angle = number(name, angle)
    if not 0.0 < angle < np.pi / 2:
        raise ValueError(f"{name} must be between 0 and π/2 rad, got {angle}")
    return angle


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """Standard deviations of a scanner.

    Parameters
    ----------
    range_sigma
        Of a range, m.
    bearing_sigma
        Of the direction of a beam, rad.
    """

    range_sigma: Positive = 0.02
    bearing_sigma: NotNegative = 0.0
    __post_init__ = checked


@dataclass(frozen=True, slots=True)
class Extraction:
    """Rules by which points of a scan become a wall. The paper gives no values: all are our choice.

    Parameters
    ----------
    noise
        Noise of the scanner.
    tolerance
        Largest distance of a reading from its chord before the stretch is split, m.
    grazing
        Flattest angle under which a wall may be seen before neighbouring readings on it count as
        belonging to different things, rad.
    least_readings
        Fewest readings that make a segment, at least 3.
    least_length
        Shortest segment, m.
    """

    noise: RangeNoise = RangeNoise()
    tolerance: Positive = 0.08
    grazing: Annotated[float, acute] = np.deg2rad(10.0)
    least_readings: Annotated[int, from_to(3)] = 6
    least_length: Positive = 0.4
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Segments:
    """Straight segments with the uncertainty of their lines.

    Parameters
    ----------
    lines
        Distance and direction (ρ, θ) of each line, m and rad.
    covs
        Covariance of (ρ, θ).
    ends
        First and last point, on the line, m.
    spans
        Index of the first and the last reading of each segment in the scan; across the end of a
        full turn the last one is the lower.
    """

    lines: Float[np.ndarray, "segments 2"]
    covs: Float[np.ndarray, "segments 2 2"]
    ends: Float[np.ndarray, "segments 2 2"]
    spans: Int[np.ndarray, "segments 2"]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.lines)

    @property
    def lengths(self) -> Float[np.ndarray, " segments"]:
        """Lengths, m."""
        return np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=-1)


@dataclass(frozen=True, slots=True)
class ScanReport:
    """Account of the readings of one scan.

    Parameters
    ----------
    readings
        How many there are.
    no_return
        Infinite readings: nothing in range.
    not_a_number
        NaN readings.
    not_positive
        Zero or negative readings.
    stretches
        Runs of readings between break points.
    lone
        Readings in stretches too short to hold a segment.
    dropped
        Readings in pieces with too few readings or too little length for a segment.
    """

    readings: int
    no_return: int
    not_a_number: int
    not_positive: int
    stretches: int
    lone: int
    dropped: int

    def __add__(self, other: "ScanReport") -> "ScanReport":
        names = self.__slots__
        return ScanReport(**{name: getattr(self, name) + getattr(other, name) for name in names})


def as_scan(ranges: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return readings, which may be infinite or NaN, and the directions of their beams.

    Raises
    ------
    ValueError
        If ranges and angles differ in shape, or the angles are not finite and increasing over at
        most one turn.
    """
    ranges, angles = reals("ranges", ranges), reals("angles", angles)
    if ranges.ndim != 1 or ranges.shape != angles.shape:
        raise ValueError(
            f"ranges and angles must be one range per angle, got {ranges.shape} and {angles.shape}"
        )
    return ranges, check_turn(angles)


@dataclass(frozen=True, eq=False, slots=True)
class Stretches:
    """Runs of valid readings between break points.

    Parameters
    ----------
    order
        The valid readings in order, by their index in the scan. Where the scan closes the order
        begins at a break; where it closes and nothing breaks it, at the farthest reading, which
        also ends it.
    starts, stops
        Where in this order each stretch begins, and where the next one does.
    ring
        Whether the scan closes, so that the first stretch follows the last.
    """

    order: Int[np.ndarray, " valid"]
    starts: Int[np.ndarray, " stretches"]
    stops: Int[np.ndarray, " stretches"]
    ring: bool

    @property
    def endless(self) -> bool:
        """True if there is one stretch, all the way round."""
        return self.ring and self.order.size > 1 and bool(self.order[0] == self.order[-1])


def cut(ranges: np.ndarray, angles: np.ndarray, noise: RangeNoise, grazing: float) -> Stretches:
    """Cut a scan at its break points; see `find_breaks`."""
    order, ring = np.flatnonzero((ranges > 0) & np.isfinite(ranges)), closes(angles)
    if not order.size:
        return Stretches(order, order, order, ring)
    r, a = ranges[order], angles[order]
    if ring:
        r, a = np.append(r, r[0]), np.append(a, max(a[0] + 2 * np.pi, a[-1]))
    breaks = np.flatnonzero(find_breaks(r, a, noise, grazing)) + 1
    if ring and breaks.size:
        order, breaks = np.roll(order, -breaks[0]), breaks[1:] - breaks[0]
    elif ring:
        order = np.roll(order, -np.argmax(ranges[order]))
        order = np.append(order, order[0])
    starts = np.concatenate([[0], breaks]).astype(np.int64)
    return Stretches(order, starts, np.append(starts[1:], order.size), ring)


def to_points(
    ranges: Float[np.ndarray, "*batch n"], angles: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "*batch n 2"]:
    """Return the Cartesian points of readings in the frame of the scanner, m."""
    angles = array("angles", angles, ("n",))
    ranges = array("ranges", ranges, (..., len(angles)), "angles")
    return np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)


def find_breaks(
    ranges: Float[np.ndarray, " n"],
    angles: Float[np.ndarray, " n"],
    noise: RangeNoise,
    grazing: float,
) -> Bool[np.ndarray, " gaps"]:
    r"""Say between which neighbouring readings a surface ends.

    A wall seen under the angle :math:`\lambda` or more puts its next reading no farther away than

    .. math:: D = r \frac{\sin\Delta\varphi}{\sin(\lambda - \Delta\varphi)} + 3\sigma_r .

    Parameters
    ----------
    ranges
        Valid readings, m.
    angles
        Their directions, increasing, rad.
    noise
        Noise of the scanner.
    grazing
        The angle λ, rad.

    Returns
    -------
    One entry for each gap between neighbours, ``True`` where the surface ends.

    References
    ----------
    Borges and Aldon (2004), adaptive breakpoint detector.
    """
    instance("noise", noise, RangeNoise)
    grazing = acute("grazing", grazing)
    angles = array("angles", angles, ("n",))
    ranges = array("ranges", ranges, (len(angles),), "angles")
    points = to_points(ranges, angles)
    jump = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    turn = np.diff(angles)
    reach = grazing - turn
    nearer = np.minimum(ranges[:-1], ranges[1:])
    bound = np.full(jump.shape, -1.0)  # a gap wider than λ always separates
    near = reach > 0
    bound[near] = nearer[near] * np.sin(turn[near]) / np.sin(reach[near]) + 3 * noise.range_sigma
    return jump > bound


def fit_line(
    ranges: Float[np.ndarray, "*batch n"], angles: Float[np.ndarray, " n"], noise: RangeNoise
) -> Gaussian:
    r"""Fit a line to readings by total least squares, with its covariance.

    The line minimises the sum of squared perpendicular distances,

    .. math::

       \tan 2\theta = \frac{-2 S_{xy}}{S_{yy} - S_{xx}}, \qquad
       \rho = \bar x \cos\theta + \bar y \sin\theta ,

    and the noise of every reading is carried through these formulae to first order,
    :math:`C = \sum_k J_k\, \mathrm{diag}(\sigma_r^2, \sigma_\varphi^2)\, J_k^\top`.

    Parameters
    ----------
    ranges
        Readings on one wall, m.
    angles
        Their directions, rad.
    noise
        Noise of the scanner.

    Returns
    -------
    Mean (ρ, θ) with ρ ≥ 0, m and rad, and covariance.

    Raises
    ------
    ValueError
        If there are fewer than two readings, one is not finite, or they lie in one point.

    References
    ----------
    Arras and Siegwart (1997); Deriche, Vaillant and Faugeras (1992).
    """
    instance("noise", noise, RangeNoise)
    angles = array("angles", angles, ("n",))
    ranges = reals("ranges", ranges)
    shaped("ranges", ranges, (..., len(angles)), "angles")
    if len(angles) < 2:
        raise ValueError(f"ranges and angles must be at least two readings, got {len(angles)}")
    if not np.isfinite(ranges).all():
        raise ValueError(f"ranges must be finite, {(~np.isfinite(ranges)).sum()} are not")
    n = ranges.shape[-1]
    cos, sin = np.cos(angles), np.sin(angles)
    x, y = ranges * cos, ranges * sin
    mean_x, mean_y = x.mean(axis=-1, keepdims=True), y.mean(axis=-1, keepdims=True)
    u, v = x - mean_x, y - mean_y
    numerator = -2 * (u * v).sum(axis=-1, keepdims=True)
    denominator = (v**2 - u**2).sum(axis=-1, keepdims=True)
    scale = numerator**2 + denominator**2
    if not (scale > 0).all():
        raise ValueError(
            "ranges and angles lie in one point or have no direction: no line through them"
        )
    theta = np.arctan2(numerator, denominator) / 2
    normal_x, normal_y = np.cos(theta), np.sin(theta)
    rho = mean_x * normal_x + mean_y * normal_y
    # derivatives of θ and ρ by the coordinates of each point
    theta_x = (-denominator * v + numerator * u) / scale
    theta_y = (-denominator * u - numerator * v) / scale
    lever = mean_y * normal_x - mean_x * normal_y  # dρ/dθ
    rho_x, rho_y = normal_x / n + lever * theta_x, normal_y / n + lever * theta_y
    # … by the range and the direction of each reading
    rho_r, theta_r = rho_x * cos + rho_y * sin, theta_x * cos + theta_y * sin
    rho_a, theta_a = rho_y * x - rho_x * y, theta_y * x - theta_x * y
    sign = np.where(rho < 0, -1.0, 1.0)  # the perpendicular points from the scanner to the wall
    jacobian_r = np.stack([sign * rho_r, theta_r], axis=-2)
    jacobian_a = np.stack([sign * rho_a, theta_a], axis=-2)
    cov = noise.range_sigma**2 * jacobian_r @ jacobian_r.mT
    cov += noise.bearing_sigma**2 * jacobian_a @ jacobian_a.mT
    turned = np.where(theta > 0, theta - np.pi, theta + np.pi)
    theta = np.where(rho < 0, turned, theta)
    return Gaussian(np.concatenate([sign * rho, theta], axis=-1), cov)


def extract_segments(
    ranges: Float[np.ndarray, " n"], angles: Float[np.ndarray, " n"], settings: Extraction
) -> tuple[Segments, ScanReport]:
    """Extract the wall segments of one scan.

    The readings are cut at break points, every stretch is split by
    :func:`~robot_perception.walls.simplify`, and a line is fitted to the readings of each piece;
    a reading at which a stretch was split belongs to neither side. Readings that are infinite,
    NaN or not positive are left out and counted. In a scan that goes all the way round, the last
    beam stands beside the first (`geometry.closes`).

    Parameters
    ----------
    ranges
        Readings, m; infinite where nothing came back.
    angles
        Directions of the beams, strictly increasing, rad.
    settings
        What is taken for a wall.

    Returns
    -------
    segments, report
        In the frame of the scanner, in the order of their first readings, where a wall across the
        end of a full turn comes last; and what became of the readings.

    Raises
    ------
    ValueError
        If ranges and angles differ in shape, or the angles are not finite and increasing over at
        most one turn.

    References
    ----------
    Andrade-Cetto, section 2.1; Nguyen et al. (2007).
    """
    ranges, angles = as_scan(ranges, angles)
    instance("settings", settings, Extraction)
    found = cut(ranges, angles, settings.noise, settings.grazing)
    r, a = ranges[found.order], angles[found.order]
    points = to_points(r, a)
    lines, covs, ends, spans = [], [], [], []
    lone = dropped = 0
    for start, stop in zip(found.starts, found.stops, strict=True):
        if stop - start < settings.least_readings:
            lone += int(stop - start)
            continue
        corners = start + simplify(points[start:stop], settings.tolerance)
        for first, last in _pieces(corners, found.endless):
            span = slice(first, last + 1)
            extent = np.hypot(*(points[last] - points[first])) if last > first else 0.0
            if last + 1 - first < settings.least_readings or extent < settings.least_length:
                dropped += int(max(last + 1 - first, 0))
                continue
            line = fit_line(r[span], a[span], settings.noise)
            lines.append(line.mean)
            covs.append(line.cov)
            ends.append(project(line.mean, points[[first, last]]))
            spans.append(found.order[[first, last]])
    spans = np.reshape(np.array(spans, dtype=np.int64), (-1, 2))
    rows = np.argsort(spans[:, 0])
    segments = Segments(
        np.reshape(lines, (-1, 2))[rows],
        np.reshape(covs, (-1, 2, 2))[rows],
        np.reshape(ends, (-1, 2, 2))[rows],
        spans[rows],
    )
    report = ScanReport(
        readings=ranges.size,
        no_return=int(np.isinf(ranges).sum()),
        not_a_number=int(np.isnan(ranges).sum()),
        not_positive=int((np.isfinite(ranges) & (ranges <= 0)).sum()),
        stretches=int(found.starts.size),
        lone=lone,
        dropped=dropped,
    )
    return segments, report


def project(
    line: Float[np.ndarray, "*batch 2"], points: Float[np.ndarray, "*batch n 2"]
) -> Float[np.ndarray, "*batch n 2"]:
    """Return the feet of the perpendiculars from points on a line (ρ, θ), m."""
    line = array("line", line, (..., 2))
    points = array("points", points, (..., "n", 2))
    check_batches(line=line.shape[:-1], points=points.shape[:-2])
    normal = np.stack([np.cos(line[..., 1]), np.sin(line[..., 1])], axis=-1)[..., None, :]
    height = (points * normal).sum(axis=-1) - line[..., 0, None]
    return points - height[..., None] * normal


def _pieces(corners: np.ndarray, endless: bool) -> list[tuple[int, int]]:
    """First and last reading of each piece, without the readings at which the stretch was split.

    An endless stretch was split where it begins and ends, too.
    """
    firsts, lasts = corners[:-1].copy(), corners[1:].copy()
    inner = 0 if endless else 1
    firsts[inner:] += 1
    lasts[: len(lasts) - inner] -= 1
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))
