r"""Contours of a picture: chains of edge pixels, approximated by straight segments and arcs.

They are the first level of a pattern in section 3.2 of Ait Aider, Chateau and Lapresté, "Indoor
autonomous navigation using visual memory and pattern tracking". Points are (u, v), px; pixel
centres lie at whole numbers.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Bool, Float, Int32, UInt8

from robot_perception import checks
from robot_perception.extras import needing
from robot_perception.fields import Positive, checked, from_to, numbers, up_to
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = ["Arc", "ContourRules", "Edges", "Segment", "find_contours", "find_edges"]


MOST = 10**6
"""The most parts into which a segment or an arc is cut."""


def _steps(length: float, spacing: float) -> Float[np.ndarray, " n"]:
    """Return shares of a length from 0 to 1, whose points are at most a spacing apart."""
    parts = length / checks.positive("spacing", spacing)
    if not parts < MOST:
        raise ValueError(f"spacing must cut {length:g} px into {MOST} parts at most, got {spacing}")
    return np.linspace(0, 1, 2 + int(parts))


def _turn(name: str, value: float) -> float:
    """Return an angle, or raise ``ValueError`` if it is 0 or more than a full turn."""
    angle = checks.number(name, value)
    if not 0 < abs(angle) <= 2 * np.pi:
        raise ValueError(f"{name} must be a turn at most and not 0, got {angle:g}")
    return angle


@dataclass(frozen=True, slots=True)
class Segment:
    """A straight piece of a contour.

    Parameters
    ----------
    start, end : (2,)
        Ends of the segment, px.

    Raises
    ------
    ValueError
        If the ends are one point.
    """

    start: Annotated[tuple[float, float], numbers(2)]
    end: Annotated[tuple[float, float], numbers(2)]

    def __post_init__(self) -> None:
        checked(self)
        if self.start == self.end:
            raise ValueError(f"end must differ from start, got {self.start} twice")

    @property
    def length(self) -> float:
        """Length from end to end, px."""
        return float(np.hypot(*np.subtract(self.end, self.start)))

    def points(self, spacing: float) -> Float[np.ndarray, "n 2"]:
        """Return points along it, at most ``spacing`` px apart, its ends among them."""
        steps = _steps(self.length, spacing)
        return self.start + steps[:, None] * np.subtract(self.end, self.start)


@dataclass(frozen=True, slots=True)
class Arc:
    r"""A piece of a circle.

    Parameters
    ----------
    centre : (2,)
        Centre of the circle, px.
    radius
        Radius of the circle, px.
    start
        Direction from the centre to the arc's first point, rad.
    sweep
        Angle from there to its last point, rad, positive if it turns from the u axis to the v axis;
        from -2π to 2π, but not 0.
    """

    centre: Annotated[tuple[float, float], numbers(2)]
    radius: Positive
    start: float
    sweep: Annotated[float, _turn]
    __post_init__ = checked

    @property
    def length(self) -> float:
        """Length along the circle, px."""
        return abs(self.sweep) * self.radius

    def points(self, spacing: float) -> Float[np.ndarray, "n 2"]:
        """Return points along it, at most ``spacing`` px apart, its ends among them."""
        steps = _steps(self.length, spacing)
        angle = self.start + steps * self.sweep
        return self.centre + self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


@dataclass(frozen=True, slots=True)
class ContourRules:
    """Rules of contour detection. The paper names no numbers; all are ours.

    Parameters
    ----------
    smoothing
        Standard deviation of the Gaussian that smooths the picture before its gradient is taken,
        px.
    low, high
        Thresholds of Canny's detector, in grey values a pixel: an edge begins where the gradient
        is above ``high``, and goes on as long as it is above ``low``.
    shortest
        Least number of pixels in a chain. A segment must be at least half as long, px.
    tolerance
        Largest distance of a chain from its segments, px.
    roundness
        Largest distance of a chain from an arc, px.
    largest
        Largest radius of an arc, px; flatter curves are approximated by segments.

    Raises
    ------
    ValueError
        If ``high`` is below ``low``.
    """

    smoothing: Annotated[float, up_to(100)] = 1.0
    low: Positive = 4.0
    high: Positive = 10.0
    shortest: Annotated[int, from_to(3, 10**6)] = 12
    tolerance: Positive = 1.5
    roundness: Positive = 0.8
    largest: Positive = 60.0

    def __post_init__(self) -> None:
        checked(self)
        if self.high < self.low:
            raise ValueError(f"high must not be below low, got {self.high:g} below {self.low:g}")


@dataclass(frozen=True, eq=False, slots=True)
class Edges:
    """Edges of a picture and the gradient there.

    Parameters
    ----------
    mask : (height, width)
        Whether each pixel lies on an edge.
    gradient : (height, width, 2)
        Gradient of the smoothed picture along u and v, grey values a pixel.
    """

    mask: Bool[np.ndarray, "height width"]
    gradient: Float[np.ndarray, "height width 2"]
    __post_init__ = checked

    def directions(self, points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, " n"]:
        """Return the direction of the gradient at the pixel nearest to each point, rad.

        Parameters
        ----------
        points : (n, 2)
            Points, px; a point outside takes the nearest pixel of the border.

        Raises
        ------
        ValueError
            If the points are not (n, 2) and finite.
        """
        points = checks.array("points", points, ("n", 2))
        height, width = self.mask.shape
        u, v = np.clip(np.rint(points), 0, [width - 1, height - 1]).astype(int).T
        along_u, along_v = self.gradient[v, u].T
        return np.arctan2(along_v, along_u)


def picture(
    name: str, image: UInt8[np.ndarray, "height width"]
) -> UInt8[np.ndarray, "height width"]:
    """Return a grey picture unchanged, once it has been checked.

    Raises
    ------
    TypeError
        If it does not hold bytes.
    ValueError
        If it is not (height, width) or has no pixel.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        raise TypeError(f"{name} must be an array of bytes, got {checks.shown(image)}")
    checks.shaped(name, image, ("height", "width"))
    if not image.size:
        raise ValueError(f"{name} must have a pixel, got {image.shape}")
    return image


def segments_and_arcs(name: str, contours: Iterable[Segment | Arc]) -> tuple[Segment | Arc, ...]:
    """Return contours as a tuple, or raise ``TypeError`` if one is neither segment nor arc."""
    return checks.instances(name, contours, Segment, Arc)


def picture_size(name: str, size: tuple[int, int] | None) -> tuple[int, int] | None:
    """Return height and width of pictures, or ``None`` if they are not known.

    Raises
    ------
    ValueError
        If they are not two positive numbers.
    """
    if size is None:
        return None
    height, width = checks.integers(name, size, (2,), 1).tolist()
    return height, width


def check_size(
    name: str,
    shape: tuple[int, ...],
    size: tuple[int, int] | None,
    other: str = "the pictures before",
) -> None:
    """Raise ``ValueError`` if the size of other pictures is known and a picture has another one."""
    if size not in (None, shape):
        raise ValueError(f"{name} must be {size} as {other}, got {shape}")


def find_edges(
    image: UInt8[np.ndarray, "height width"], rules: ContourRules | None = None
) -> Edges:
    """Return the edges of a picture by Canny's detector.

    Parameters
    ----------
    image : (height, width)
        Grey values.
    rules
        Smoothing and thresholds; those of `ContourRules` if not given.

    Raises
    ------
    TypeError
        If the image does not hold bytes, or the rules are not `ContourRules`.
    ValueError
        If the image is not (height, width).

    References
    ----------
    Canny, "A computational approach to edge detection", IEEE Transactions on Pattern Analysis and
    Machine Intelligence 8(6), 1986.
    """
    image = picture("image", image)
    rules = _rules(rules)
    smooth = cv2.GaussianBlur(image, (0, 0), rules.smoothing, borderType=cv2.BORDER_REPLICATE)
    along_u, along_v = (
        cv2.Sobel(smooth, cv2.CV_16S, *axes, borderType=cv2.BORDER_REPLICATE)
        for axes in ((1, 0), (0, 1))
    )
    # for a gradient of one grey value a pixel Sobel's filter gives 8
    mask = cv2.Canny(along_u, along_v, 8 * rules.low, 8 * rules.high, L2gradient=True) > 0
    return Edges(mask, np.stack([along_u, along_v], axis=-1) / 8.0)


def find_contours(edges: Edges, rules: ContourRules | None = None) -> tuple[Segment | Arc, ...]:
    """Return the contours of a picture as straight segments and arcs.

    Edge pixels are linked to chains, and a chain is cut into segments at its corners. From its
    beginning on, an arc replaces three or more segments in a row as long as one circle fits all
    their pixels. Very short segments are dropped.

    Parameters
    ----------
    edges
        Edges of the picture.
    rules
        Tolerances; those of `ContourRules` if not given.

    Raises
    ------
    TypeError
        If an argument is of another type.

    References
    ----------
    Section 3.2: "contours polygonally approximated by straight line segments and arcs".
    """
    rules = _rules(rules)
    labels, order = _link(checks.instance("edges", edges, Edges).mask.astype(np.uint8))
    found: list[Segment | Arc] = []
    starts = np.flatnonzero(np.diff(labels, prepend=-1))
    for chain in np.split(order, starts[1:]) if len(order) else ():
        if len(chain) >= rules.shortest:
            found += _approximated(chain, rules)
    return tuple(found)


def _rules(rules: ContourRules | None) -> ContourRules:
    """Return the rules, or the default ones if there are none."""
    return ContourRules() if rules is None else checks.instance("rules", rules, ContourRules)


def _approximated(chain: Int32[np.ndarray, "n 2"], rules: ContourRules) -> list[Segment | Arc]:
    """Return segments and arcs along a chain of pixels."""
    corners = _corners(chain, rules.tolerance)
    found: list[Segment | Arc] = []
    first = 0
    while first < len(corners) - 1:
        last, arc = first + 1, None
        # an arc takes three segments at least, and grows as long as one circle fits all pixels
        for end in range(first + 3, len(corners)):
            fitted = _arc(chain[corners[first] : corners[end] + 1], rules)
            if fitted is None:
                break
            last, arc = end, fitted
        a, b = chain[[corners[first], corners[last]]].astype(float)
        if arc is not None:
            found.append(arc)
        elif np.hypot(*(b - a)) >= rules.shortest / 2:
            found.append(Segment(tuple(a), tuple(b)))
        first = last
    return found


def _corners(chain: Int32[np.ndarray, "n 2"], tolerance: float) -> list[int]:
    """Return the numbers of the pixels at which a chain is cut into segments, its ends included."""
    kept = cv2.approxPolyDP(chain.reshape(-1, 1, 2), tolerance, closed=False)[:, 0]
    corners, at = [], 0
    for point in kept:
        at += int(np.flatnonzero((chain[at:] == point).all(axis=1))[0])
        corners.append(at)
    return corners


def _arc(points: Int32[np.ndarray, "n 2"], rules: ContourRules) -> Arc | None:
    """Return the arc nearest to points by Kåsa's least squares; ``None`` if one is too far off."""
    middle = points.mean(axis=0)
    u, v = (points - middle).T
    A = np.stack([u, v, np.ones_like(u)], axis=-1)
    (a, b, c), _, rank, _ = np.linalg.lstsq(A, u**2 + v**2, rcond=None)
    if rank < 3:
        return None
    centre = np.array([a, b]) / 2
    radius = np.sqrt(c + centre @ centre)
    away = np.stack([u, v], axis=-1) - centre
    if radius > rules.largest or np.abs(np.hypot(*away.T) - radius).max() > rules.roundness:
        return None
    angle = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
    sweep = float(np.clip(angle[-1] - angle[0], -2 * np.pi, 2 * np.pi))
    return Arc(tuple(centre + middle), radius, angle[0], sweep) if sweep else None


@no_type_check
@kernel()
def _link(mask):
    """Link edge pixels to chains; return the pixels in order, and the number of each one's chain.

    First each pixel with a single neighbour begins a chain, then any that is left, as on a closed
    contour. A chain goes on to a neighbour across a side of the pixel, else to one across a corner,
    and ends where no neighbour is left.
    """
    height, width = mask.shape
    left = mask.copy()
    total = 0
    for v in range(height):
        for u in range(width):
            total += mask[v, u]
    labels = np.empty(total, np.int32)
    order = np.empty((total, 2), np.int32)
    steps = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))
    count, chain = 0, 0
    for closed in (False, True):
        for v0 in range(height):
            for u0 in range(width):
                if not left[v0, u0]:
                    continue
                if not closed:
                    around = 0
                    for du, dv in steps:
                        u, v = u0 + du, v0 + dv
                        if 0 <= u < width and 0 <= v < height and left[v, u]:
                            around += 1
                    if around != 1:
                        continue
                u, v = u0, v0
                walking = True
                while walking:
                    left[v, u] = 0
                    labels[count], order[count, 0], order[count, 1] = chain, u, v
                    count += 1
                    walking = False
                    for du, dv in steps:
                        if 0 <= u + du < width and 0 <= v + dv < height and left[v + dv, u + du]:
                            u, v = u + du, v + dv
                            walking = True
                            break
                chain += 1
    return labels[:count], order[:count]
