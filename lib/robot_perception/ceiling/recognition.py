r"""Recognition of a known pattern in a picture without a prior pose, by its contours (section 3.2).

Each pair of a corner of the pattern's contours and a similar corner of the picture's contours gives
a hypothesis of the pattern's pose. It is scored by the share of the pattern's contour points that
lie on edges of the same direction. The best poses are refined by least squares and returned as
candidates. Several poses may fit contours alone, so the caller has to decide between the candidates
by the grey values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Float
from scipy.ndimage import distance_transform_edt

from robot_perception import checks
from robot_perception.ceiling.contours import Arc, Edges, Segment
from robot_perception.ceiling.patterns import Pattern, placed
from robot_perception.fields import Positive, Share, checked, from_to
from robot_perception.geometry.angles import wrap_angle
from robot_perception.kernels import kernel

__all__ = ["Candidate", "EdgeField", "RecognitionRules", "contour_log_likelihoods", "recognise"]

FAR = 10.0
"""Largest distance to an edge; larger ones are cut to it, px."""


def _below(most: float) -> Callable[[str, float], float]:
    """Return a check that a number is positive and below another one."""

    def check(name: str, value: float) -> float:
        found = checks.positive(name, value)
        if found >= most:
            raise ValueError(f"{name} must be below {most:.4g}, got {found:g}")
        return found

    return check


def _scales(name: str, value: Sequence[float]) -> tuple[float, ...]:
    """Return positive numbers, at least one, or raise ``ValueError``."""
    found = checks.array(name, value, ("n",))
    if not (len(found) and (found > 0).all()):
        raise ValueError(f"{name} must be positive, one at least, got {found.tolist()}")
    return tuple(found.tolist())


@dataclass(frozen=True, slots=True)
class RecognitionRules:
    """Rules of the search for candidates. The paper gives no values: all are our choice.

    Parameters
    ----------
    near
        Largest distance from a contour point to the edge on which it lies, px.
    aligned
        Largest difference between their directions, rad.
    opening
        Largest difference between the openings of two corners that match, rad.
    gap
        Largest distance from the ends of two segments to the point where they meet in a corner, px.
    scales
        Scales that are tried; 1 alone for a robot at a constant distance from the ceiling.
    refined
        Number of the best poses that are refined by least squares.
    apart
        Two poses are one candidate if they are closer than this, px, and differ in direction by
        less than this over a quarter of the shorter side of the pattern's window, rad.
    least
        Least score of a candidate.

    Raises
    ------
    ValueError
        If ``near`` is not below the 10 px at which distances are cut, ``aligned`` is not below a
        right angle, or there is no scale.
    """

    near: Annotated[float, _below(FAR)] = 2.0
    aligned: Annotated[float, _below(np.pi / 2)] = np.deg2rad(20.0)
    opening: Annotated[float, checks.positive] = np.deg2rad(12.0)
    gap: Positive = 8.0
    scales: Annotated[tuple[float, ...], _scales] = (1.0,)
    refined: Annotated[int, from_to(1, 10**4)] = 30
    apart: Positive = 6.0
    least: Share = 0.4
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """A pose that a pattern may have in a picture.

    Parameters
    ----------
    pose : (4,)
        (x, y, θ, s): position, px, px; direction, rad; scale.
    score
        Share of the pattern's contour points that lie on edges of their own direction.
    """

    pose: Float[np.ndarray, " 4"]
    score: float


class EdgeField:
    """Distance from each pixel to the nearest edge, with the place and direction of that edge.

    Parameters
    ----------
    edges
        Edges of a picture.
    """

    def __init__(self, edges: Edges) -> None:
        mask = checks.instance("edges", edges, Edges).mask
        self.size = mask.shape[1], mask.shape[0]
        self.distance = np.full(mask.shape, FAR, np.float32)
        self._nearest = np.zeros((*mask.shape, 2), np.int64)
        self.normal = np.zeros(mask.shape)
        if mask.any():
            distance, (v, u) = distance_transform_edt(~mask, return_indices=True)
            self.distance = np.minimum(distance, FAR).astype(np.float32)
            self._nearest = np.stack([u, v], axis=-1)
            self.normal = np.arctan2(edges.gradient[..., 1], edges.gradient[..., 0])[v, u]

    def look(
        self, points: Float[np.ndarray, "... 2"]
    ) -> tuple[Float[np.ndarray, "..."], Float[np.ndarray, "... 2"], Float[np.ndarray, "..."]]:
        """Return the distance to the nearest edge, the pixel of that edge, and its normal.

        Parameters
        ----------
        points : (…, 2)
            Points of the picture, px, rounded to pixels. A point outside is at the cut-off distance
            of 10 px.

        Returns
        -------
        distance : (…)
            px.
        pixel : (…, 2)
            Nearest pixel of an edge, px.
        normal : (…)
            Direction across the edge, rad.

        Raises
        ------
        ValueError
            If the points are not (…, 2) and finite.
        """
        points = checks.array("points", points, (..., 2))
        at = np.rint(np.clip(points, -1, self.size)).astype(int)
        within = np.clip(at, 0, np.subtract(self.size, 1))
        u, v = within[..., 0], within[..., 1]
        distance = np.where((within == at).all(axis=-1), self.distance[v, u], FAR)
        return distance, self._nearest[v, u].astype(float), self.normal[v, u]


def recognise(
    pattern: Pattern,
    field: EdgeField,
    contours: Sequence[Segment | Arc],
    rules: RecognitionRules | None = None,
) -> tuple[Candidate, ...]:
    """Return the poses that a pattern may have in a picture by its contours, the best first.

    Parameters
    ----------
    pattern
        Pattern with its contours.
    field
        Distances to the edges of the picture.
    contours
        Segments and arcs found in the picture.
    rules
        Rules of the search; the defaults of `RecognitionRules` if not given.

    Returns
    -------
    tuple of Candidate
        Empty if no pose reaches the least score.

    Raises
    ------
    ValueError
        If the pattern has no contour.

    References
    ----------
    Section 3.2: "The contour representation is used to automatic generation and recognition and
    thus to the tracking initialization." The paper does not say how; the procedure is ours.
    """
    checks.instance("pattern", pattern, Pattern)
    checks.instance("field", field, EdgeField)
    rules = (
        RecognitionRules() if rules is None else checks.instance("rules", rules, RecognitionRules)
    )
    contours = checks.instances("contours", contours, Segment, Arc)
    if not pattern.contours:
        raise ValueError("pattern must have contours, got none")
    points, normals = _along(pattern)
    poses = _hypotheses(_corners(pattern.contours, rules), _corners(contours, rules), rules)
    if not len(poses):
        return ()
    scores = _scores(points, normals, poses, field, rules)
    best = np.argsort(-scores, kind="stable")[: 4 * rules.refined]
    chosen = _distinct(poses[best], scores[best], pattern, rules)[: rules.refined]
    fine = np.array([_refined(points, normals, poses[best][k], field, rules) for k in chosen])
    scores = _scores(points, normals, fine, field, rules)
    order = np.argsort(-scores, kind="stable")
    kept = _distinct(fine[order], scores[order], pattern, rules)
    found = (Candidate(fine[order][k], float(scores[order][k])) for k in kept)
    return tuple(one for one in found if one.score >= rules.least)


def contour_log_likelihoods(
    field: EdgeField,
    pattern: Pattern,
    poses: Float[np.ndarray, "m 4"],
    *,
    sigma: float = 2.0,
    aligned: float | None = None,
) -> Float[np.ndarray, " m"]:
    r"""Return the log-likelihood of poses by the pattern's contours alone, up to a constant.

    .. math:: \log p(z \mid x) = -\frac{1}{2\sigma^2} \sum_j \min(d_j, d_{\max})^2

    with the distance :math:`d_j` from a point of the pattern's contours to the nearest edge, or
    :math:`d_{\max}` where the directions of the two differ too much; :math:`d_{\max}` is 10 px.

    Parameters
    ----------
    field
        Distances to the edges of the picture.
    pattern
        Pattern with its contour points.
    poses : (m, 4)
        (x, y, θ, s), for instance of particles.
    sigma
        Standard deviation :math:`\sigma` of a distance, px.
    aligned
        Largest difference between the directions of a point and its edge, rad, below a right
        angle; any if not given.

    Raises
    ------
    ValueError
        If the poses are not (m, 4), sigma is not positive or the angle is out of its range.

    References
    ----------
    Section 1: "representing patterns with only contour information may produce ambiguous measures".
    """
    checks.instance("field", field, EdgeField)
    poses = checks.array("poses", poses, ("m", 4))
    distance, _, across = field.look(checks.instance("pattern", pattern, Pattern).seen(poses))
    if aligned is not None:
        aligned = checks.positive("aligned", aligned)
        if aligned >= np.pi / 2:
            raise ValueError(f"aligned must be below {np.pi / 2:.4g}, got {aligned:g}")
        turned = pattern.places[:, 2] + poses[:, 2, None]
        distance = np.where(np.abs(np.sin(across - turned)) <= np.sin(aligned), distance, FAR)
    shares = distance.astype(float) / checks.positive("sigma", sigma)
    return -0.5 * (shares**2).sum(axis=1)


def _along(
    pattern: Pattern, spacing: float = 3.0
) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, " n"]]:
    """Return points along a pattern's contours, and the direction of the normal at each, rad."""
    points, normals = [], []
    for piece in pattern.contours:
        at = piece.points(spacing)
        points.append(at)
        if isinstance(piece, Segment):
            du, dv = np.subtract(piece.end, piece.start)
            normals.append(np.full(len(at), np.arctan2(du, -dv)))
        else:
            normals.append(np.arctan2(*(at - piece.centre).T[::-1]))
    return np.concatenate(points), np.concatenate(normals)


def _corners(
    contours: Sequence[Segment | Arc], rules: RecognitionRules
) -> Float[np.ndarray, "n 4"]:
    """Return corners: position (u, v, px), direction in which they open, and opening (rad).

    Two segments that meet near their ends form a corner, unless they are within 25° of parallel. An
    arc and a segment near it form one, too: it lies at the centre of the arc and opens towards the
    foot of the perpendicular on the segment's line. In place of the opening stands -d / 100, with
    the distance d of that line in px; the sign tells the two kinds apart.
    """
    segments = [piece for piece in contours if isinstance(piece, Segment)]
    arcs = [piece for piece in contours if isinstance(piece, Arc)]
    found = np.empty((0, 4))
    if not segments:
        return found
    a, b = (np.array([getattr(s, end) for s in segments]) for end in ("start", "end"))
    unit = (b - a) / np.hypot(*(b - a).T)[:, None]
    i, j = np.triu_indices(len(segments), 1)
    cross = unit[i, 0] * unit[j, 1] - unit[i, 1] * unit[j, 0]
    bent = np.abs(cross) > np.sin(np.deg2rad(25))
    i, j, cross = i[bent], j[bent], cross[bent]
    if len(i):
        way = a[j] - a[i]
        t = (way[:, 0] * unit[j, 1] - way[:, 1] * unit[j, 0]) / cross
        meet = a[i] + t[:, None] * unit[i]
        arms, close = [], np.ones(len(i), bool)
        for k in (i, j):
            to_a, to_b = np.hypot(*(a[k] - meet).T), np.hypot(*(b[k] - meet).T)
            close &= np.minimum(to_a, to_b) <= rules.gap
            arms.append(np.where((to_a < to_b)[:, None], unit[k], -unit[k]))
        one, other = (np.arctan2(*arm[close].T[::-1]) for arm in arms)
        turn = wrap_angle(other - one)
        found = np.column_stack([meet[close], wrap_angle(one + turn / 2), np.abs(turn)])
    for arc in arcs:
        foot = a + ((arc.centre - a) * unit).sum(axis=1, keepdims=True) * unit
        way = foot - arc.centre
        away = np.hypot(*way.T)
        near = (away < 4 * arc.radius + rules.gap) & (away > 2 * rules.near)
        rows = [np.tile(arc.centre, (near.sum(), 1)), np.arctan2(way[near, 1], way[near, 0])]
        found = np.vstack([found, np.column_stack([*rows, -away[near] / 100])])
    return found


def _hypotheses(
    known: Float[np.ndarray, "k 4"], seen: Float[np.ndarray, "n 4"], rules: RecognitionRules
) -> Float[np.ndarray, "m 4"]:
    """Return the poses at which a corner of the pattern coincides with one of the picture."""
    poses = [np.empty((0, 4))]
    for scale in rules.scales:
        reach = np.where(known[:, 3] < 0, scale, 1.0) * known[:, 3]
        tolerance = np.where(known[:, 3] < 0, rules.near / 50, rules.opening)
        k, n = np.nonzero(np.abs(reach[:, None] - seen[:, 3]) <= tolerance[:, None])
        turn = wrap_angle(seen[n, 2] - known[k, 2])
        cos, sin = scale * np.cos(turn), scale * np.sin(turn)
        u, v = known[k, :2].T
        x, y = seen[n, 0] - cos * u + sin * v, seen[n, 1] - sin * u - cos * v
        poses.append(np.column_stack([x, y, turn, np.full(len(k), scale)]))
    return np.vstack(poses)


def _scores(
    points: Float[np.ndarray, "n 2"],
    normals: Float[np.ndarray, " n"],
    poses: Float[np.ndarray, "m 4"],
    field: EdgeField,
    rules: RecognitionRules,
) -> Float[np.ndarray, " m"]:
    """Return for each pose the share of contour points that lie on edges of their direction."""
    return _shares(
        points, normals, poses, field.distance, field.normal, rules.near, np.sin(rules.aligned)
    )


@no_type_check
@kernel()
def _shares(points, normals, poses, distance, normal, near, aligned):
    """Return for each pose the share of points near an edge whose normal is theirs, compiled."""
    height, width = distance.shape
    found = np.empty(len(poses))
    for i in range(len(poses)):
        x, y, theta, scale = poses[i]
        cos, sin = scale * np.cos(theta), scale * np.sin(theta)
        count = 0
        for j in range(len(points)):
            a, b = points[j]
            u, v = round(x + cos * a - sin * b), round(y + sin * a + cos * b)
            if 0 <= u < width and 0 <= v < height and distance[v, u] <= near:
                count += abs(np.sin(normal[v, u] - normals[j] - theta)) <= aligned
        found[i] = count / len(points)
    return found


def _refined(points, normals, pose, field, rules) -> Float[np.ndarray, " 4"]:
    """Return a pose after up to five Gauss-Newton steps on the distances to the nearest edges.

    Distances are taken along the normals of the edges. The scale stays.
    """
    pose = pose.copy()
    for reach in (3, 3, 2, 2, 1):
        at = placed(points, pose)
        distance, nearest, across = field.look(at)
        good = (distance <= reach * rules.near) & (distance < FAR)
        good &= np.abs(np.sin(across - normals - pose[2])) <= np.sin(rules.aligned)
        if good.sum() < 4:
            break
        normal = np.stack([np.cos(across[good]), np.sin(across[good])], axis=-1)
        arm = (at - pose[:2])[good]
        turn = arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0]
        J = np.column_stack([normal, turn])
        missing = ((nearest - at)[good] * normal).sum(axis=1)
        damped = J.T @ J + 1e-3 * np.diag([1.0, 1.0, 100.0])
        pose[:3] += np.linalg.solve(damped, J.T @ missing)
    return pose


def _distinct(poses, scores, pattern: Pattern, rules: RecognitionRules) -> list[int]:
    """Return the rows of poses, given best first, that are not the same as a better one."""
    kept: list[int] = []
    turn = rules.apart / (min(pattern.size) / 4)
    for k, pose in enumerate(poses):
        others = poses[kept]
        near = np.hypot(*(others[:, :2] - pose[:2]).T) < rules.apart
        if not (near & (np.abs(wrap_angle(others[:, 2] - pose[2])) < turn)).any():
            kept.append(k)
    return kept
