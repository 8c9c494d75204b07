r"""Snakes: outlines that slide onto edges, in any shape or as affine maps of their start only.

A snake :math:`r = (r_1, \dots, r_n)` is a closed chain of points (u, v). Its energy is

.. math::
    E(r) = \tfrac12 \sum_i \Big( \alpha |r_{i+1} - r_i|^2 + \beta |r_{i+1} - 2 r_i + r_{i-1}|^2
        + \min\big(D(r_i), T\big)^2 \Big)

with D the distance to the nearest edge. Its last term pulls a point straight onto an edge closer
than the reach T, and does not move a point without one. T is large in the first steps, so that a
snake arrives from far away, and small in the last, so that a point without an edge of its own
follows its neighbours. Of the pull only the part across the snake counts: the part along it would
crowd points at the ends of partly hidden edges. The paper leaves the potential open; all this is
our choice.

D is known at pixels and interpolated between them. A point beyond the image takes the value at the
nearest point of its border.
"""

from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.appearance._masks import Mask, Outline, check_mask, check_outline
from robot_perception.extras import needing
from robot_perception.fields import checked, from_to, within
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = [
    "Affine",
    "SnakeFit",
    "SnakeRules",
    "affine_part",
    "affine_snake",
    "area",
    "free_snake",
    "image_edges",
    "resample",
    "step_by_step",
]

MOST_POINTS = 2000
"""The most points of a snake."""
TINY = 1e-300
"""Least length of a normal, so that one of length 0 can be divided by it."""
FAR = 1e30
"""Distance, px, written for pixels that lie beyond the reach of all edges."""


def _falling(name: str, value: tuple[float, float]) -> tuple[float, float]:
    """Return two positive numbers, the second no larger than the first."""
    first, last = checks.array(name, value, (2,)).tolist()
    if not 0 < last <= first:
        raise ValueError(f"{name} must fall and stay positive, got {(first, last)}")
    return first, last


@dataclass(frozen=True, slots=True)
class SnakeRules:
    r"""Stiffness of a snake and rules of its motion. All values are our choice.

    Parameters
    ----------
    elasticity, rigidity
        Weights α and β against stretching and bending; differences are taken from point to point,
        not for each pixel of length.
    damping
        Weight γ of a point's present place, at least 0.55. A step takes a point about 1 / γ of its
        distance to the edge; below one half it would overshoot more and more.
    reach
        T at the first and at the last step, px; from step to step it falls by a constant factor.
    steps
        Number of steps.
    """

    elasticity: Annotated[float, within(0, 1e6)] = 0.05
    rigidity: Annotated[float, within(0, 1e6)] = 0.05
    damping: Annotated[float, within(0.55, 1e6)] = 0.7
    reach: Annotated[tuple[float, float], _falling] = (20.0, 3.0)
    steps: Annotated[int, from_to(1, 10_000)] = 60
    __post_init__ = checked

    @property
    def reaches(self) -> Float[np.ndarray, " steps"]:
        """The reach T at each step, px."""
        return _reaches(self.reach, self.steps)


@dataclass(frozen=True, eq=False, slots=True)
class Affine:
    r"""An affine map of the image, :math:`p \mapsto M (p - c) + c + t`.

    Parameters
    ----------
    matrix : (2, 2)
        M.
    shift : (2,)
        t, px.
    centre : (2,)
        c, the mean of the points of the outline that is mapped, px.
    """

    matrix: Float[np.ndarray, "2 2"]
    shift: Float[np.ndarray, "2"]
    centre: Float[np.ndarray, "2"]
    __post_init__ = checked

    def apply(self, points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Return where the map takes points.

        Parameters
        ----------
        points : (n, 2)
            Points (u, v), px.

        Raises
        ------
        ValueError
            If they are not of this shape or not finite.
        """
        points = checks.array("points", points, ("n", 2))
        return (points - self.centre) @ self.matrix.T + self.centre + self.shift


@dataclass(frozen=True, eq=False, slots=True)
class SnakeFit:
    """Result of a fit: a snake at the start and after each step.

    Parameters
    ----------
    iterates : (steps + 1, n, 2)
        Points of the snake, px; the start comes first.
    """

    iterates: Float[np.ndarray, "k n 2"]

    @property
    def outline(self) -> Outline:
        """Points after the last step, px."""
        return self.iterates[-1]

    @property
    def affine(self) -> Affine:
        """Affine map of the start that comes nearest to the outline."""
        return _affine_part(self.iterates[0], self.outline)[0]

    @property
    def residual(self) -> float:
        """Root mean square distance of the outline from the nearest affine map of the start, px."""
        nearest = _affine_part(self.iterates[0], self.outline)[1]
        return float(np.sqrt(np.mean(np.sum((self.outline - nearest) ** 2, axis=-1))))


def area(outline: Outline) -> float:
    r"""Return the area inside an outline, whichever way round its points run.

    .. math:: \tfrac12 \left| \sum_i u_i v_{i+1} - u_{i+1} v_i \right|

    Parameters
    ----------
    outline : (n, 2)
        Points (u, v), px, at least three.

    Raises
    ------
    ValueError
        If the points are fewer or not finite.
    """
    points = checks.array("outline", outline, ("n", 2))
    if len(points) < 3:
        raise ValueError(f"outline must have 3 points at least, got {len(points)}")
    u, v = (points - points.mean(axis=0)).T
    return float(abs(u @ np.roll(v, -1) - v @ np.roll(u, -1)) / 2)


def resample(outline: Outline, count: int = 80) -> Float[np.ndarray, "count 2"]:
    """Return points evenly spaced along an outline, the first where it begins.

    Parameters
    ----------
    outline : (n, 2)
        Points (u, v), px; the last is joined to the first.
    count
        Number of points, 3 to 2000.

    Raises
    ------
    ValueError
        If the points lie on a line or are not finite, or the count is out of its range.
    """
    points = check_outline("outline", outline)
    count = checks.whole("count", count, 3, MOST_POINTS)
    closed = np.vstack([points, points[:1]])
    along = np.r_[0.0, np.hypot(*np.diff(closed, axis=0).T).cumsum()]
    wanted = along[-1] * np.arange(count) / count
    return np.stack([np.interp(wanted, along, axis) for axis in closed.T], axis=-1)


def affine_part(start: Outline, outline: Outline) -> tuple[Affine, Outline]:
    r"""Return the affine map that takes a start nearest to an outline, and the mapped start.

    .. math:: \min_{M, t} \sum_i |M (r^0_i - c) + c + t - r_i|^2

    with c the mean of the start.

    Parameters
    ----------
    start : (n, 2)
        Points :math:`r^0`, px.
    outline : (n, 2)
        Points r, px; point i belongs to point i of the start.

    Raises
    ------
    ValueError
        If the points of the start lie on a line, the numbers of points differ, or one is not
        finite.
    """
    start = check_outline("start", start)
    points = checks.array("outline", outline, start.shape, beside="start")
    return _affine_part(start, points)


def image_edges(
    image: UInt8[np.ndarray, "height width *colours"], within: Mask, share: float
) -> Mask:
    r"""Return the ridges of an image's gradient inside a mask, :math:`\nabla I^*`.

    .. math:: \nabla I^* = \nabla I \cdot \operatorname{dil}(\nabla S)

    A pixel lies on a ridge if the gradient there is larger than at its two neighbours along the
    gradient (Canny's rule), and at least a share of the largest gradient in the mask. In a colour
    image the channel with the largest gradient counts at each pixel. Ridges are found before the
    mask is applied, so that the rim of the mask makes none.

    Parameters
    ----------
    image : (height, width) or (height, width, 3)
        Grey or colour image, bytes.
    within : (height, width)
        Mask in which edges count, :math:`\operatorname{dil}(\nabla S)`.
    share
        Least gradient, as a share of the largest, between 0 and 1. Our choice; the paper uses the
        gradient itself.

    Raises
    ------
    TypeError
        If the image does not hold bytes, or the mask does not hold True and False.
    ValueError
        If image and mask differ in size, or the share is not between 0 and 1.

    References
    ----------
    Andrade-Cetto, "Perception issues in mobile robotics", section 3.3, contour updating.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        raise TypeError(f"image must hold bytes, got {checks.shown(image)}")
    within, share = check_mask("within", within), checks.level("share", share)
    if image.shape not in (within.shape, (*within.shape, 3)):
        raise ValueError(f"image must be as large as within, {within.shape}, got {image.shape}")
    along_u, along_v = (
        cv2.Sobel(image, cv2.CV_16S, *order, borderType=cv2.BORDER_REPLICATE)
        for order in ((1, 0), (0, 1))
    )
    if image.ndim == 3:
        strongest = (np.abs(along_u) + np.abs(along_v)).argmax(axis=2)[..., None]
        along_u, along_v = (
            np.take_along_axis(a, strongest, axis=2)[..., 0] for a in (along_u, along_v)
        )
    size = np.hypot(along_u, along_v, dtype=np.float32)
    least = max(share * float(size.max(where=within, initial=0.0)), 1.0)
    along_u, along_v = np.ascontiguousarray(along_u), np.ascontiguousarray(along_v)
    ridges = cv2.Canny(along_u, along_v, least, least, L2gradient=True)
    return (ridges > 0) & within


def affine_snake(start: Outline, edges: Mask, rules: SnakeRules | None = None) -> SnakeFit:
    r"""Return the fit of a snake that stays an affine map of its start.

    Each step is one of the free snake (see `free_snake`), after which the points are replaced by
    the nearest affine map of the start, in the sense of least squares:

    .. math::
        r \leftarrow B B^+ (A + \gamma I)^{-1} (\gamma r - n n^\top D \nabla D),
        \qquad B = \begin{pmatrix} 1 & u^0 & v^0 \end{pmatrix}

    with :math:`u^0` and :math:`v^0` the columns of coordinates of the start.

    Parameters
    ----------
    start : (n, 2)
        Points :math:`r_{t-1}` (u, v), px; not on a line.
    edges : (height, width)
        True on edges.
    rules
        Stiffness and motion; `SnakeRules` if not given.

    Raises
    ------
    TypeError
        If the edges are no mask, or the rules of another type.
    ValueError
        If the points lie on a line or are not finite, or there is no edge.

    References
    ----------
    Andrade-Cetto, "Perception issues in mobile robotics", section 3.3.
    """
    return _fit(start, edges, rules, affine=True)


def free_snake(start: Outline, edges: Mask, rules: SnakeRules | None = None) -> SnakeFit:
    r"""Return the fit of a snake that may take any shape.

    .. math:: r \leftarrow (A + \gamma I)^{-1} (\gamma r - n n^\top D \nabla D)

    The last term is 0 at points farther from an edge than the reach T. n is the unit normal of the
    snake at each point. A is the circulant matrix of stretching and bending, with entries
    :math:`\beta,\, -\alpha - 4\beta,\, 2\alpha + 6\beta,\, -\alpha - 4\beta,\, \beta` about the
    diagonal of each row.

    Parameters
    ----------
    start : (n, 2)
        Points (u, v), px; not on a line.
    edges : (height, width)
        True on edges.
    rules
        Stiffness and motion; `SnakeRules` if not given.

    Raises
    ------
    TypeError
        If the edges are no mask, or the rules of another type.
    ValueError
        If the points lie on a line or are not finite, or there is no edge.

    References
    ----------
    Kass, Witkin and Terzopoulos, "Snakes: active contour models", International Journal of Computer
    Vision 1(4), 1988, appendix A.
    """
    return _fit(start, edges, rules, affine=False)


def step_by_step(
    start: Outline, edges: Mask, rules: SnakeRules | None = None, *, affine: bool = True
) -> SnakeFit:
    """Return the fit of `affine_snake` or of `free_snake`, computed without compiled kernels.

    Parameters
    ----------
    start, edges, rules
        As for these.
    affine
        Whether the fit is that of `affine_snake`.

    Raises
    ------
    TypeError
        If the edges are no mask, or an argument is of another type.
    ValueError
        If the points lie on a line or are not finite, or there is no edge.
    """
    start, edges, rules = _checked(start, edges, rules)
    distance = cv2.distanceTransform((~edges).view(np.uint8), cv2.DIST_L2, 5)
    stiff = _smoothing(len(start), rules.elasticity, rules.rigidity, rules.damping)
    family = _family(start) if checks.flag("affine", affine) else None
    iterates = [start]
    for reach in rules.reaches:
        r = iterates[-1]
        far, slope = _sampled(distance, r)
        normal = (np.roll(r, -1, axis=0) - np.roll(r, 1, axis=0)) @ [[0.0, -1.0], [1.0, 0.0]]
        normal /= np.maximum(np.hypot(*normal.T), TINY)[:, None]
        size = np.where(far < reach, far, 0.0) * np.sum(slope * normal, axis=1)
        pull = size[:, None] * normal
        r = stiff @ (rules.damping * r - pull)
        iterates.append(r if family is None else family @ (family.T @ r))
    return SnakeFit(np.array(iterates))


def _fit(start: Outline, edges: Mask, rules: SnakeRules | None, *, affine: bool) -> SnakeFit:
    """Return the fit of a snake, affine or free, by the compiled kernel."""
    start, edges, rules = _checked(start, edges, rules)
    distance = _distance(edges, rules.reach[0])
    stiff = len(start), rules.elasticity, rules.rigidity, rules.damping
    iterates = np.empty((rules.steps + 1, 2, len(start)))
    iterates[0] = start.T
    onto, basis = _moves(start.tobytes() if affine else b"", *stiff)
    _slide(distance, onto, basis, rules.damping, rules.reaches, iterates)
    return SnakeFit(iterates.transpose(0, 2, 1))


def _checked(
    start: Outline, edges: Mask, rules: SnakeRules | None
) -> tuple[Outline, Mask, SnakeRules]:
    """Return the arguments of a fit, or raise an error if one is wrong."""
    start, edges = check_outline("start", start), check_mask("edges", edges)
    if len(start) > MOST_POINTS:
        raise ValueError(f"start must have {MOST_POINTS} points at most, got {len(start)}")
    if min(edges.shape) < 2:
        raise ValueError(f"edges must be 2 px a side at least, got {edges.shape}")
    if not edges.any():
        raise ValueError("edges must hold an edge, got none")
    rules = SnakeRules() if rules is None else checks.instance("rules", rules, SnakeRules)
    return start, edges, rules


def _distance(edges: Mask, reach: float) -> Float[np.ndarray, "h w"]:
    """Return the distance of each pixel to the nearest edge.

    Pixels farther than the reach from the box around all edges pull no point; they get `FAR`.
    """
    u, v, width, height = cv2.boundingRect(edges.view(np.uint8))
    margin = int(min(reach, max(edges.shape))) + 3
    near = np.s_[max(v - margin, 0) : v + height + margin, max(u - margin, 0) : u + width + margin]
    distance = np.full(edges.shape, np.float32(FAR))
    distance[near] = cv2.distanceTransform((~edges[near]).view(np.uint8), cv2.DIST_L2, 5)
    return distance


def _affine_part(start: Outline, outline: Outline) -> tuple[Affine, Outline]:
    """Return what `affine_part` returns, for checked arguments."""
    centre, mean = start.mean(axis=0), outline.mean(axis=0)
    spread = start - centre
    # once both are centred, the shift is that of the means, and M is a linear least-squares fit
    with checks.computable("start"):
        matrix = np.linalg.solve(spread.T @ spread, spread.T @ (outline - mean)).T
    return Affine(matrix, mean - centre, centre), spread @ matrix.T + mean


def _family(start: Outline) -> Float[np.ndarray, "n 3"]:
    """Return an orthonormal basis of the columns (1, u, v) of an outline."""
    spread = start - start.mean(axis=0)
    ones = np.ones((len(start), 1))
    return np.linalg.qr(np.hstack([ones, spread / np.abs(spread).max()]))[0]


@lru_cache(maxsize=16)
def _moves(
    start: bytes, n: int, *weights: float
) -> tuple[Float[np.ndarray, "rows n"], Float[np.ndarray, "columns n"]]:
    """Return the matrix that takes pulled points to new ones, and the basis of its results.

    For an affine snake its results are coefficients in the basis; for a free one, given by an empty
    start, they are the new points, and the basis is empty. Both are kept, as the snakes of a frame
    share their start.
    """
    stiff = _smoothing(n, *weights)
    if not start:
        return stiff, np.empty((0, n))
    basis = np.ascontiguousarray(_family(np.frombuffer(start).reshape(n, 2)).T)
    return basis @ stiff, basis


@cache
def _reaches(reach: tuple[float, float], steps: int) -> Float[np.ndarray, " steps"]:
    """Return the reach T at each step: a geometric sequence, px."""
    falling = np.geomspace(*reach, steps)
    falling.setflags(write=False)
    return falling


@cache
def _smoothing(
    n: int, elasticity: float, rigidity: float, damping: float
) -> Float[np.ndarray, "n n"]:
    """Return the inverse of the circulant matrix A + γ I, by the Fourier transform."""
    wave = 2 - 2 * np.cos(2 * np.pi * np.arange(n) / n)
    row = np.fft.ifft(1 / (damping + elasticity * wave + rigidity * wave**2)).real
    inverse = row[(np.arange(n)[:, None] - np.arange(n)) % n]
    inverse.setflags(write=False)
    return inverse


def _sampled(
    distance: Float[np.ndarray, "h w"], points: Outline
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n 2"]]:
    """Return distance and gradient at points, interpolated bilinearly between four pixels."""
    height, width = distance.shape
    u, v = np.clip(points, 0, [width - 1, height - 1]).T
    column = np.minimum(u.astype(int), width - 2)
    row = np.minimum(v.astype(int), height - 2)
    x, y = u - column, v - row
    corner, right, below, across = (
        distance[row + i, column + j].astype(float) for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))
    )
    far = (1 - y) * ((1 - x) * corner + x * right) + y * ((1 - x) * below + x * across)
    along_u = (1 - y) * (right - corner) + y * (across - below)
    along_v = (1 - x) * (below - corner) + x * (across - right)
    return far, np.stack([along_u, along_v], axis=-1)


@kernel()
@no_type_check
def _slide(distance, onto, basis, damping, reaches, iterates):  # pragma: no cover - compiled
    """Write the points after each step; ``iterates`` holds u in the first row and v in the second.

    ``onto`` and ``basis`` are those of `_moves`. The interpolation is that of `_sampled`.
    """
    height, width = distance.shape
    n = onto.shape[1]
    pulled, found = np.empty((2, n)), np.empty((2, len(onto)))
    for k in range(reaches.size):
        r, new = iterates[k], iterates[k + 1]
        for i in range(n):
            u = min(width - 1.0, max(0.0, r[0, i]))  # in this order NaN becomes 0
            v = min(height - 1.0, max(0.0, r[1, i]))
            column, row = min(int(u), width - 2), min(int(v), height - 2)
            x, y = u - column, v - row
            corner, right = float(distance[row, column]), float(distance[row, column + 1])
            below, across = float(distance[row + 1, column]), float(distance[row + 1, column + 1])
            far = (1 - y) * ((1 - x) * corner + x * right) + y * ((1 - x) * below + x * across)
            along_u = (1 - y) * (right - corner) + y * (across - below)
            along_v = (1 - x) * (below - corner) + x * (across - right)
            after = i + 1 if i + 1 < n else 0
            normal_u, normal_v = r[1, after] - r[1, i - 1], r[0, i - 1] - r[0, after]
            length = max(np.hypot(normal_u, normal_v), TINY)
            normal_u, normal_v = normal_u / length, normal_v / length
            pull = far * (along_u * normal_u + along_v * normal_v) if far < reaches[k] else 0.0
            pulled[0, i] = damping * r[0, i] - pull * normal_u
            pulled[1, i] = damping * r[1, i] - pull * normal_v
        _times(onto, pulled, found)
        if len(basis):
            _times(basis.T, found, new)
        else:
            new[:] = found


@kernel()
@no_type_check
def _times(matrix, columns, products):  # pragma: no cover - compiled
    """Write the products of a matrix with two vectors, which are the rows of ``columns``."""
    for i in range(matrix.shape[0]):
        u, v = 0.0, 0.0
        for j in range(matrix.shape[1]):
            u += matrix[i, j] * columns[0, j]
            v += matrix[i, j] * columns[1, j]
        products[0, i], products[1, i] = u, v
