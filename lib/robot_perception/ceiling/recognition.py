r"""A known pattern found anew in a picture, by its contours alone: section 3.2.

Corners of contours in the picture are laid on corners of the pattern; each such pair is a place of
the pattern. The places at which most of its contour points lie on edges of the same direction are
the candidates. Contours alone may fit several places, which is why candidates are returned with
their scores, and the grey vectors have the last word.
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
"""Distances to edges are cut off here, px."""


def _below(most: float) -> Callable[[str, float], float]:
    """Return the check of a positive number below another one."""

    def check(name: str, value: float) -> float:
        found = checks.positive(name, value)
        if found >= most:
            raise ValueError(f"{name} must be below {most:.4g}, got {found:g}")
        return found

    return check


def _scales(name: str, value: Sequence[float]) -> tuple[float, ...]:
    """Return positive numbers, one at least."""
    found = checks.array(name, value, ("n",))
    if not (len(found) and (found > 0).all()):
        raise ValueError(f"{name} must be positive, one at least, got {found.tolist()}")
    return tuple(found.tolist())


@dataclass(frozen=True, slots=True)
class RecognitionRules:
    """Rules of the search for candidates; all numbers are ours.

    Parameters
    ----------
    near
        A contour point lies on an edge that is no further away, px.
    aligned
        And whose direction differs by no more, rad.
    opening
        Two corners match if their openings differ by no more, rad.
    gap
        Two contours form a corner if their ends are no further from where they meet, px.
    scales
        Scales that are tried: 1 for a robot whose distance from the ceiling is constant.
    refined
        So many of the best places are refined by least squares.
    apart
        Places closer than that, px, and closer than this over a quarter of the window, rad, are one
        candidate.
    least
        Candidates of a lower score are dropped.

    Raises
    ------
    ValueError
        If ``near`` is not below the 10 px at which distances are cut off, ``aligned`` not below a
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
    """A place at which a pattern may be.

    Parameters
    ----------
    pose : (4,)
        (x, y, θ, s), px, px, rad and 1.
    score
        Share of the pattern's contour points that lie on edges of their direction.
    """

    pose: Float[np.ndarray, " 4"]
    score: float


class EdgeField:
    """The distance from each pixel to the nearest edge, and the direction of that edge.

    Parameters
    ----------
    edges
        Of a picture.

    Raises
    ------
    TypeError
        If they are none.
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
        """Return distance to the nearest edge, that edge's pixel and the direction across it.

        Parameters
        ----------
        points : (…, 2)
            px; one outside the picture is as far from any edge as the cut-off.

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
    """Return where a pattern may be in a picture by its contours, the best first.

    Parameters
    ----------
    pattern
        With its contours.
    field
        Of the edges of the picture.
    contours
        Of the picture.
    rules
        Those of `RecognitionRules` if not given.

    Returns
    -------
    tuple of Candidate
        Empty where nothing fits.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If the pattern has no contour.

    References
    ----------
    Section 3.2: "The contour representation is used to automatic generation and recognition and
    thus to the tracking initialization." How, it does not say; the procedure is ours.
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
    r"""Return the logarithm of a likelihood that knows contours alone, but for a constant.

    .. math:: -\frac{1}{2\sigma^2} \sum_j \min(d_j, d_{\max})^2

    with :math:`d_j` the distance from a model point to the nearest edge, or :math:`d_{\max}` where
    the directions of the two differ too much.

    Parameters
    ----------
    field
        Of the picture's edges.
    pattern
        Its points.
    poses : (m, 4)
        (x, y, θ, s), for instance of particles.
    sigma
        px.
    aligned
        A point lies on no edge whose direction differs by more, rad, below a right angle; on any if
        not given.

    Raises
    ------
    TypeError
        If an argument is of another type.
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
    """Return points along a pattern's contours and the direction across each, rad."""
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
    """Return corners: place (px), direction in which they open and by how much (rad).

    Two segments that meet near their ends make one. So do an arc and a segment near it: the corner
    lies in the centre and opens towards the nearest point of the segment's line, and its opening is
    minus the distance of that line in hundreds of px, so that it matches none of the first kind.
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
    """Return the places at which a corner of the pattern lies on one of the picture."""
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
    """Return the share of contour points that lie on edges of their direction."""
    return _shares(
        points, normals, poses, field.distance, field.normal, rules.near, np.sin(rules.aligned)
    )


@no_type_check
@kernel()
def _shares(points, normals, poses, distance, normal, near, aligned):
    """Return which share of points lies near an edge across which the direction is theirs."""
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
    """Return a place after a few steps of least squares on the distances across nearest edges."""
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
    """Return which places, best first, are not the same as a better one."""
    kept: list[int] = []
    turn = rules.apart / (min(pattern.size) / 4)
    for k, pose in enumerate(poses):
        others = poses[kept]
        near = np.hypot(*(others[:, :2] - pose[:2]).T) < rules.apart
        if not (near & (np.abs(wrap_angle(others[:, 2] - pose[2])) < turn)).any():
            kept.append(k)
    return kept
