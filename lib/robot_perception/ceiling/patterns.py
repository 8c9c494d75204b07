r"""Patterns: interest windows of a picture, and the grey vectors across their contours.

Equation numbers are those of Ait Aider, Chateau and Lapresté, "Indoor autonomous navigation using
visual memory and pattern tracking"; sections 3.2 and 3.3.

The pose of a pattern in a picture is (x, y, θ, s): its centre, px, its angle, rad, and its scale.
A point p of the pattern, in px from the centre of its window, is seen at

.. math:: \begin{bmatrix} x \\ y \end{bmatrix} + s\, R(\theta)\, p .
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Float, Float32, Int, UInt8

from robot_perception import checks
from robot_perception.ceiling.contours import (
    Arc,
    ContourRules,
    Edges,
    Segment,
    find_contours,
    find_edges,
    picture,
    picture_size,
    segments_and_arcs,
)
from robot_perception.extras import needing
from robot_perception.fields import (
    NotNegative,
    Positive,
    Share,
    above_zero,
    checked,
    from_to,
    numbers,
    odd,
    one_of,
    wholes,
)
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = [
    "Decay",
    "Pattern",
    "PatternRules",
    "Window",
    "WindowRules",
    "autocorrelation",
    "correlations",
    "decay_in_picture",
    "deviations",
    "fit_decay",
    "grey_vectors",
    "interest_windows",
    "make_pattern",
]

MOST = 1000
"""The most points of a pattern."""
TINY = 1e-9
"""Tolerance at a picture's border, px: cos 90° is not quite 0 after rounding."""
FAST = {"reassoc", "contract", "arcp", "nsz"}
"""Fast mathematics that the compiler may use; not "nnan" and "ninf", as NaN has a meaning here."""


@dataclass(frozen=True, slots=True)
class PatternRules:
    r"""Rules of a pattern's second level: its points, their grey vectors and their decay.

    Parameters
    ----------
    samples
        :math:`N_s`, number of grey values in a vector; odd, so that the middle one lies on the
        contour. Our choice.
    step
        :math:`\delta`, distance between these samples, px; our choice.
    spacing
        Distance between points along a contour, px; our choice.
    most
        The most points that are kept; our choice.
    picked
        Rule by which they are picked. ``"slope"``: those whose correlation falls fastest, the
        criterion that section 3.3 hints at. ``"random"``: any of them.
    fall
        The function to which the decay is fitted. ``"padded"``: the autocorrelation as printed
        below eq. (4), with zeros beyond the vector. ``"picture"``: the correlation of the vector
        with shifted ones in the picture (see `decay_in_picture`), which is what a tracker will
        meet; our addition.
    curve
        Form of the decay :math:`1 - a \lambda^b`. ``"line"``: b = 1, the simplest of the paper;
        ``"parabola"``: b = 2; ``"power"``: b is fitted, too.
    own
        Whether each point has parameters of its own; else all have the mean.
    centred
        Whether means are removed before vectors are compared. In the paper's equation they stay.
    """

    samples: Annotated[int, odd(3, 101)] = 11
    step: Positive = 2.0
    spacing: Positive = 3.0
    most: Annotated[int, from_to(1, MOST)] = 120
    picked: Annotated[str, one_of("slope", "random")] = "slope"
    fall: Annotated[str, one_of("padded", "picture")] = "picture"
    curve: Annotated[str, one_of("line", "parabola", "power")] = "line"
    own: bool = True
    centred: bool = True
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Decay:
    r"""Parameters :math:`W` of eq. (4): how the correlation of a vector falls when it is shifted.

    .. math:: \tilde C(\lambda) = 1 - a\, \lambda^b

    with :math:`\lambda` the shift along the vector, in samples.

    Parameters
    ----------
    rate : (n,)
        a of each point.
    power : (n,)
        b of each point.
    """

    rate: Annotated[Float[np.ndarray, " n"], above_zero]
    power: Annotated[Float[np.ndarray, " n"], above_zero]
    __post_init__ = checked


def _not_many(name: str, points: Float[np.ndarray, "n _"]) -> Float[np.ndarray, "n _"]:
    """Return the points of a pattern, or raise ``ValueError`` if there are none or too many."""
    if not 1 <= len(points) <= MOST:
        raise ValueError(f"{name} must be of 1 to {MOST} points, got {len(points)}")
    return points


def _odd_rows(name: str, vectors: Float[np.ndarray, "n _"]) -> Float[np.ndarray, "n _"]:
    """Return vectors, or raise ``ValueError`` if their number of samples is even or below three."""
    if vectors.shape[1] < 3 or vectors.shape[1] % 2 == 0:
        raise ValueError(f"{name} must have an odd number of samples, got {vectors.shape}")
    return vectors


@dataclass(frozen=True, eq=False, slots=True)
class Pattern:
    r"""A pattern, eq. (4): :math:`M = \{(U^{(j)}, V^{(j)}, W^{(j)})\}`.

    Parameters
    ----------
    places : (n, 3)
        U: two coordinates from the centre of the window, as shares of its width and height, and
        the direction of the gradient, rad.
    vectors : (n, samples)
        V: grey values along that direction.
    decay
        W: how the correlation of each vector falls when it is shifted.
    size : (2,)
        Width and height of the window, px.
    step
        Distance between samples, px.
    centred
        Whether means are removed before vectors are compared.
    contours
        The first level: segments and arcs in the window, px from its centre.
    picture : (height, width)
        Size of the picture that the pattern was taken from, px; ``None`` if it is not known. A
        tracker follows it in pictures of this size only.

    Raises
    ------
    ValueError
        If there is no point, the number of samples is even, or the decay is of other points.
    """

    places: Annotated[Float[np.ndarray, "n 3"], _not_many]
    vectors: Annotated[Float[np.ndarray, "n samples"], _odd_rows]
    decay: Decay
    size: Annotated[tuple[float, float], numbers(2, above_zero)]
    step: Positive = 1.0
    centred: bool = True
    contours: Annotated[tuple[Segment | Arc, ...], segments_and_arcs] = ()
    picture: Annotated[tuple[int, int] | None, picture_size] = None

    def __post_init__(self) -> None:
        checked(self)
        size = (len(self.places),)
        checks.shaped("decay.rate", self.decay.rate, size, beside="these places")

    @property
    def points(self) -> Float[np.ndarray, "n 2"]:
        """Points of the pattern, px from the centre of the window."""
        return self.places[:, :2] * self.size

    def seen(self, pose: Float[np.ndarray, "... 4"]) -> Float[np.ndarray, "... n 2"]:
        """Return where the points are seen in a picture, px; see `placed`.

        Parameters
        ----------
        pose : (…, 4)
            Pose of the pattern in the picture, (x, y, θ, s).

        Raises
        ------
        ValueError
            If the pose is not (…, 4) and finite.
        """
        return placed(self.points, pose)


def placed(
    points: Float[np.ndarray, "n 2"], pose: Float[np.ndarray, "... 4"]
) -> Float[np.ndarray, "... n 2"]:
    r"""Return where the points of a pattern are seen in a picture, px.

    .. math:: \begin{bmatrix} x \\ y \end{bmatrix} + s\, R(\theta)\, p

    Parameters
    ----------
    points : (n, 2)
        Points p, px from the centre of the window.
    pose : (…, 4)
        Pose of the pattern in the picture, (x, y, θ, s).

    Raises
    ------
    ValueError
        If the shapes do not fit or a number is not finite.
    """
    points, pose = checks.array("points", points, ("n", 2)), checks.array("pose", pose, (..., 4))
    cos, sin = (pose[..., 3, None] * f(pose[..., 2, None]) for f in (np.cos, np.sin))
    u, v = points.T
    turned = np.stack([cos * u - sin * v, sin * u + cos * v], axis=-1)
    return turned + pose[..., None, :2]


# Grey vectors ------------------------------------------------------------------------------------


def grey_vectors(
    image: UInt8[np.ndarray, "height width"],
    points: Float[np.ndarray, "n 2"],
    directions: Float[np.ndarray, " n"],
    *,
    samples: int = 11,
    step: float = 1.0,
) -> Float32[np.ndarray, "n samples"]:
    r"""Return the grey vector of each point: values along a line through it, bilinear.

    .. math:: g_l = I\big(m + (l - \tfrac{N_s - 1}{2})\, \delta\, (\cos\varphi, \sin\varphi)\big)

    Parameters
    ----------
    image : (height, width)
        Grey values.
    points : (n, 2)
        Points m, px.
    directions : (n,)
        Directions φ of the lines, rad.
    samples
        :math:`N_s`, number of samples, odd.
    step
        δ, distance between samples, px.

    Returns
    -------
    (n, samples)
        Grey values :math:`g_0, g_1, \dots`; all NaN if the line leaves the picture.

    Raises
    ------
    TypeError
        If the image does not hold bytes.
    ValueError
        If shapes do not fit or a number is out of its range.
    """
    image = picture("image", image)
    points = checks.array("points", points, ("n", 2))
    directions = checks.array("directions", directions, (len(points),), beside="these points")
    samples, step = checks.whole("samples", samples, 3, 101), checks.positive("step", step)
    if samples % 2 == 0:
        raise ValueError(f"samples must be odd, got {samples}")
    steps = step * np.stack([np.cos(directions), np.sin(directions)], axis=-1)
    return _sample(image.astype(np.float32), points, steps, samples)


def autocorrelation(
    vectors: Float[np.ndarray, "n samples"], *, centred: bool = False
) -> Float[np.ndarray, "n lags"]:
    r"""Return the autocorrelation of vectors as the paper prints it, with zeros beyond their ends.

    .. math:: C(\lambda) = \frac{1}{\lVert V \rVert^2} \sum_l G(l)\, G(l - \lambda)

    The zeros matter: a vector of equal greys has :math:`C = 1 - \lambda / N_s`, though a shift of
    a uniform surface changes nothing in the picture.

    Parameters
    ----------
    vectors : (n, samples)
        Grey values G.
    centred
        Whether the mean of each vector is removed first; beyond its ends stands this mean then.

    Returns
    -------
    (n, lags)
        C for λ = 0, 1, … up to half the samples; all 1 for a vector of zeros, as a uniform one is
        when its mean is removed.

    Raises
    ------
    ValueError
        If the vectors are not (n, samples) and finite.
    """
    V = checks.array("vectors", vectors, ("n", "samples"))
    if checks.flag("centred", centred):
        V = V - V.mean(axis=1, keepdims=True)
    count = V.shape[1]
    norm = (V * V).sum(axis=1)
    found = [(V[:, lag:] * V[:, : count - lag]).sum(axis=1) for lag in range(count // 2 + 1)]
    return np.where(norm > _flat(count), np.array(found) / np.maximum(norm, 1e-30), 1.0).T


def decay_in_picture(
    image: UInt8[np.ndarray, "height width"],
    points: Float[np.ndarray, "n 2"],
    directions: Float[np.ndarray, " n"],
    *,
    samples: int = 11,
    step: float = 1.0,
    centred: bool = True,
) -> Float[np.ndarray, "n lags"]:
    r"""Return how each vector correlates with shifted vectors of the same picture.

    .. math::
        C(\lambda) = \tfrac12 \sum_{\pm} \frac{V \cdot V_{\pm\lambda}}
        {\lVert V \rVert \lVert V_{\pm\lambda} \rVert}

    where :math:`V_{\lambda}` is sampled λ steps further along the direction of V. In place of the
    zeros of `autocorrelation` stand the greys of the picture. If one of the two shifted vectors
    leaves the picture, C is that of the other; if both do, the last value is repeated.

    Parameters, errors and lags are those of `grey_vectors` and `autocorrelation`.
    """
    checks.flag("centred", centred)
    points = checks.array("points", points, ("n", 2))
    directions = checks.array("directions", directions, (len(points),), beside="these points")
    V = grey_vectors(image, points, directions, samples=samples, step=step)
    steps = step * np.stack([np.cos(directions), np.sin(directions)], axis=-1)
    found = [np.ones(len(V))]
    for lag in range(1, samples // 2 + 1):
        beside = [
            _compared(V, grey_vectors(image, points + side * lag * steps, directions,
                                      samples=samples, step=step), centred)
            for side in (1, -1)
        ]  # fmt: skip
        inside = ~np.isnan(beside)
        mean = np.where(inside, beside, 0.0).sum(axis=0) / np.maximum(inside.sum(axis=0), 1)
        found.append(np.where(inside.any(axis=0), mean, found[-1]))
    return np.array(found).T


def fit_decay(
    falls: Float[np.ndarray, "n lags"], curve: str = "line", *, own: bool = True
) -> Decay:
    r"""Return the parameters of :math:`1 - a \lambda^b` that fit correlations by least squares.

    .. math::
        a = \frac{\sum_\lambda \lambda^b (1 - C(\lambda))}{\sum_\lambda \lambda^{2b}}

    For ``"power"`` a line is fitted to the logarithms,
    :math:`\log(1 - C) \approx \log a + b \log \lambda`, with b kept between ½ and 2.

    Parameters
    ----------
    falls : (n, lags)
        :math:`C(\lambda)` for λ = 0, 1, …, with C(0) = 1.
    curve
        ``"line"``, ``"parabola"`` or ``"power"``; see `PatternRules`.
    own
        Whether each point has parameters of its own; else all have the mean.

    Returns
    -------
    Decay
        Rates are at least a thousandth, so that `deviations` can divide by them.

    Raises
    ------
    ValueError
        If there is no function, there are fewer than three lags, a number is not finite, or the
        curve is unknown.
    """
    C = checks.array("falls", falls, ("n", "lags"))
    if C.shape[1] < 3 or not len(C):
        raise ValueError(f"falls must be one at least, of three lags or more, got {C.shape}")
    checks.one_of("curve", curve, ("line", "parabola", "power"))
    lags = np.arange(1, C.shape[1])
    lost = np.maximum(1 - C[:, 1:], LEAST)
    if curve == "power":
        logs = np.log(lags) - np.log(lags).mean()
        power = np.clip(np.log(lost) @ logs / (logs @ logs), 0.5, 2.0)
        rate = np.exp((np.log(lost) - power[:, None] * np.log(lags)).mean(axis=1))
    else:
        power = np.full(len(C), 1.0 if curve == "line" else 2.0)
        basis = lags ** power[0]
        rate = (1 - C[:, 1:]) @ basis / (basis @ basis)
    rate = np.maximum(rate, LEAST)
    if not checks.flag("own", own):
        rate, power = (np.full(len(C), value.mean()) for value in (rate, power))
    return Decay(rate, power)


LEAST = 1e-3
"""The smallest rate of a decay."""


def deviations(correlation: Float[np.ndarray, "... n"], decay: Decay) -> Float[np.ndarray, "... n"]:
    r"""Return the deviation of each vector from its place, judged by its correlation.

    .. math:: \lambda = \tilde C^{-1}(C) = \left(\frac{1 - C}{a}\right)^{1/b}

    Parameters
    ----------
    correlation : (…, n)
        C, from -1 to 1; NaN where a vector was not seen.
    decay
        Parameters a and b of the n points.

    Returns
    -------
    (…, n)
        λ in samples, not negative; infinite where a vector was not seen.

    Raises
    ------
    ValueError
        If the last axis is not n.

    References
    ----------
    Section 3.3, below eq. (5).
    """
    checks.instance("decay", decay, Decay)
    C = checks.array(
        "correlation", correlation, (..., len(decay.rate)), beside="this decay", finite=False
    )
    lost = np.maximum(1 - C, 0) / decay.rate
    if (decay.power != 1).any():
        lost **= 1 / decay.power
    return np.where(np.isnan(lost), np.inf, lost)


def correlations(
    layers: Float32[np.ndarray, "layers height width"],
    pattern: Pattern,
    poses: Float[np.ndarray, "m 4"],
    chosen: Int[np.ndarray, " m"] | None = None,
) -> Float32[np.ndarray, "m n"]:
    r"""Return the normalised correlation of each vector with the picture where a pose puts it.

    .. math:: C = \frac{V \cdot V_k}{\lVert V \rVert \lVert V_k \rVert}

    with :math:`V_k` the grey vector that the picture shows under pose k. The means of both are
    removed first if the pattern is `centred`.

    Parameters
    ----------
    layers : (layers, height, width)
        Copies of the picture, each smoothed by another width.
    pattern
        The pattern, of n points.
    poses : (m, 4)
        Poses (x, y, θ, s), for instance of particles.
    chosen : (m,)
        Number of the layer in which each pose is compared; the first if not given.

    Returns
    -------
    (m, n)
        C; NaN where a vector leaves the picture, 0 where one of the two is a vector of zeros.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If a shape does not fit, a scale is not positive, or there is no such layer.
    """
    if not isinstance(layers, np.ndarray) or layers.dtype != np.float32:
        raise TypeError(f"layers must be float32, got {checks.shown(layers)}")
    checks.shaped("layers", layers, ("layers", "height", "width"))
    checks.instance("pattern", pattern, Pattern)
    poses = checks.array("poses", poses, ("m", 4))
    if not (poses[:, 3] > 0).all():
        raise ValueError(f"poses must have a positive scale, got {poses[:, 3].min():g}")
    if chosen is None:
        chosen = np.zeros(len(poses), dtype=np.int64)
    chosen = checks.integers("chosen", chosen, (len(poses),), 0, beside="these poses")
    if chosen.size and chosen.max() >= len(layers):
        raise ValueError(f"chosen must be of {len(layers)} layers, got {chosen.max()}")
    return _correlate(layers, chosen, poses, *compiled(pattern))


def compiled(
    pattern: Pattern,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
    """Return points, steps, vectors of length 1 and `centred`, arguments of the compiled kernel."""
    phi = pattern.places[:, 2]
    steps = pattern.step * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    V = pattern.vectors - (pattern.vectors.mean(axis=1, keepdims=True) if pattern.centred else 0)
    norm = np.linalg.norm(V, axis=1, keepdims=True)
    flat = norm**2 <= _flat(V.shape[1])
    unit = np.where(flat, 0.0, V / np.where(flat, 1.0, norm)).astype(np.float32)
    return pattern.points, steps, unit, pattern.centred


def _flat(samples: int) -> float:
    """Return the squared length up to which a vector of so many samples counts as zeros."""
    return 1e-3 * samples


def _compared(one: np.ndarray, other: np.ndarray, centred: bool) -> np.ndarray:
    """Return the normalised correlation of vectors in pairs; NaN where one left the picture."""
    if centred:
        one, other = (v - v.mean(axis=1, keepdims=True) for v in (one, other))
    norms = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    product = (one * other).sum(axis=1)
    return np.where(norms > _flat(one.shape[1]), product / np.maximum(norms, 1e-30), 0 * product)


@no_type_check
@kernel()
def _sample(image, points, steps, samples):
    """Return grey values along lines; NaN where one leaves the picture."""
    height, width = image.shape
    half = samples // 2
    found = np.empty((len(points), samples), np.float32)
    for j in range(len(points)):
        du, dv = steps[j]
        u, v = points[j, 0] - half * du, points[j, 1] - half * dv
        if _leaves(u, v, du, dv, samples, width, height):
            found[j] = np.nan
            continue
        for k in range(samples):
            found[j, k] = _between(image, u + k * du, v + k * dv)
    return found


@no_type_check
@kernel(fastmath=FAST)
def _correlate(layers, chosen, poses, points, steps, vectors, centred):
    """Return the correlation of each vector at each pose."""
    height, width = layers.shape[1:]
    samples = vectors.shape[1]
    half, flat = samples // 2, np.float32(1e-3 * samples)
    found = np.empty((len(poses), len(points)), np.float32)
    for i in range(len(poses)):
        image = layers[chosen[i]]
        x, y, theta, scale = poses[i]
        cos, sin = scale * np.cos(theta), scale * np.sin(theta)
        for j in range(len(points)):
            a, b = points[j]
            p, q = steps[j]
            du, dv = cos * p - sin * q, sin * p + cos * q
            u = x + cos * a - sin * b - half * du
            v = y + sin * a + cos * b - half * dv
            if _leaves(u, v, du, dv, samples, width, height):
                found[i, j] = np.nan
                continue
            product = total = squares = np.float32(0)
            # greys are counted from the middle one, so that single precision keeps a small contrast
            base = _between(image, u + half * du, v + half * dv) if centred else np.float32(0)
            for k in range(samples):
                grey = _between(image, u, v) - base
                product += grey * vectors[j, k]
                total += grey
                squares += grey * grey
                u += du
                v += dv
            if centred:
                squares -= total * total / samples
            found[i, j] = product / np.sqrt(squares) if squares > flat else np.float32(0)
    return found


@no_type_check
@kernel(inline="always")
def _leaves(u, v, du, dv, samples, width, height):
    """Tell whether a line of samples leaves the picture; it does if one of its ends does."""
    end_u, end_v = u + (samples - 1) * du, v + (samples - 1) * dv
    return not (
        min(u, end_u) >= -TINY
        and max(u, end_u) <= width - 1 + TINY
        and min(v, end_v) >= -TINY
        and max(v, end_v) <= height - 1 + TINY
    )


@no_type_check
@kernel(fastmath=FAST, inline="always")
def _between(image, u, v):
    """Return the bilinear grey value at (u, v), a point of the picture."""
    height, width = image.shape
    column, row = min(int(u), width - 2), min(int(v), height - 2)
    right, down = np.float32(u - column), np.float32(v - row)
    above = image[row, column] + right * (image[row, column + 1] - image[row, column])
    below = image[row + 1, column] + right * (image[row + 1, column + 1] - image[row + 1, column])
    return above + down * (below - above)


# Building a pattern ------------------------------------------------------------------------------


def make_pattern(
    image: UInt8[np.ndarray, "height width"],
    centre: Sequence[float],
    size: Sequence[float] = (64, 64),
    rules: PatternRules | None = None,
    *,
    contours: ContourRules | None = None,
    rng: np.random.Generator | None = None,
) -> Pattern:
    """Return the pattern of a window of a picture, eq. (4).

    Parameters
    ----------
    image : (height, width)
        Grey values.
    centre : (2,)
        Centre of the window, px.
    size : (2,)
        Width and height of the window, px.
    rules
        Rules of points and vectors; those of `PatternRules` if not given.
    contours
        Rules by which contours are found; those of `ContourRules` if not given.
    rng
        Source of randomness; needed only if points are picked at random.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If the window leaves the picture or holds no contour with contrast, or if points are to be
        picked at random and there is no generator.
    """
    image = picture("image", image)
    if contours is not None:
        checks.instance("contours", contours, ContourRules)
    edges = find_edges(image, contours)
    return pattern_from(image, edges, find_contours(edges, contours), centre, size, rules, rng=rng)


def pattern_from(
    image: UInt8[np.ndarray, "height width"],
    edges: Edges,
    contours: Sequence[Segment | Arc],
    centre: Sequence[float],
    size: Sequence[float] = (64, 64),
    rules: PatternRules | None = None,
    *,
    rng: np.random.Generator | None = None,
) -> Pattern:
    """Return the pattern of a window of a picture whose edges and contours are known.

    Parameters and errors are those of `make_pattern`; ``edges`` and ``contours`` are those of the
    whole picture.
    """
    rules = PatternRules() if rules is None else checks.instance("rules", rules, PatternRules)
    middle = checks.array("centre", centre, (2,))
    wide = checks.array("size", size, (2,))
    height, width = picture("image", image).shape
    checks.shaped("edges.mask", checks.instance("edges", edges, Edges).mask, image.shape)
    low, high = middle - wide / 2, middle + wide / 2
    # pixels reach half a pixel beyond their centres
    if not (wide > 0).all() or (low < -0.5).any() or (high > [width - 0.5, height - 0.5]).any():
        raise ValueError(
            f"centre and size must be of a window in {width} × {height} px, "
            f"got {middle.tolist()} and {wide.tolist()}"
        )
    inside, points = [], []
    for piece in checks.instances("contours", contours, Segment, Arc):
        along = piece.points(rules.spacing)
        within = ((along >= low) & (along <= high)).all(axis=1)
        if within.any():
            points.append(along[within])
            inside += _clipped(piece, along, within, middle, rules.spacing)
    if not points:
        raise ValueError(f"image must show a contour there, got none round {middle.tolist()}")
    at = np.concatenate(points)
    # neighbouring pieces share an end; it counts once
    at = at[np.sort(np.unique(at, axis=0, return_index=True)[1])]
    phi = edges.directions(at)
    taken = {"samples": rules.samples, "step": rules.step}
    V = grey_vectors(image, at, phi, **taken)
    good = np.flatnonzero(V.var(axis=1) > _flat(1))  # False for NaN: beyond the picture
    if not len(good):
        raise ValueError(f"image must show contrast there, got none round {middle.tolist()}")
    at, phi, V = at[good], phi[good], V[good].astype(float)
    falls = (
        autocorrelation(V, centred=rules.centred)
        if rules.fall == "padded"
        else decay_in_picture(image, at, phi, centred=rules.centred, **taken)
    )
    kept = _picked(fit_decay(falls, "line").rate, rules, rng)
    places = np.column_stack([(at - middle) / wide, phi])[kept]
    decay = fit_decay(falls[kept], rules.curve, own=rules.own)
    return Pattern(
        places, V[kept], decay, tuple(wide), rules.step, rules.centred, tuple(inside), image.shape
    )


def _picked(
    rates: Float[np.ndarray, " n"], rules: PatternRules, rng: np.random.Generator | None
) -> Int[np.ndarray, " m"]:
    """Return the numbers of the points that are kept, in rising order."""
    if rules.picked == "random":
        if rng is None:
            raise ValueError("rng must be given where points are picked at random, got None")
        order = checks.generator("rng", rng).permutation(len(rates))
    else:
        order = np.argsort(-rates, kind="stable")
    return np.sort(order[: rules.most])


def _clipped(piece, along, within, middle, spacing) -> list[Segment | Arc]:
    """Return the parts of a contour inside a window, px from its middle, without tiny ones."""
    found: list[Segment | Arc] = []
    # a circle may leave the window and come back
    changes = np.flatnonzero(np.diff(within, prepend=False, append=False))
    for first, last in changes.reshape(-1, 2) - [0, 1]:
        share = (last - first) / (len(along) - 1)
        if share * piece.length < 2 * spacing:
            continue
        if isinstance(piece, Segment):
            found.append(Segment(*(tuple(along[k] - middle) for k in (first, last))))
        else:
            start = piece.start + piece.sweep * first / (len(along) - 1)
            centre = tuple(piece.centre - middle)
            found.append(Arc(centre, piece.radius, start, piece.sweep * share))
    return found


# Interest windows --------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class WindowRules:
    """Rules by which windows of a picture become patterns. The paper names none; all are ours.

    Parameters
    ----------
    size
        Width and height of a window, px.
    most
        The most windows that are chosen.
    margin
        Least distance of a window from the border of the picture, px.
    spacing
        Distance between the windows that are tried, and between counted contour points, px.
    strength
        Least strength of a window; see `interest_windows`.
    rival
        Correlation with another place of the picture above which a window counts as repeated.
    apart
        Least distance between the centres of chosen windows, px, those that are already there
        included. A window that was tried and refused keeps others away by a third of it.
    """

    size: Annotated[tuple[int, int], wholes(2, 8)] = (64, 64)
    most: Annotated[int, from_to(1, 10**4)] = 4
    margin: Annotated[int, from_to(0, 10**4)] = 12
    spacing: Annotated[int, from_to(1, 10**4)] = 4
    strength: NotNegative = 10.0
    rival: Share = 0.8
    apart: NotNegative = 48.0
    __post_init__ = checked


@dataclass(frozen=True, slots=True)
class Window:
    """A window that may become a pattern.

    Parameters
    ----------
    centre : (2,)
        Centre in the picture, px.
    size : (2,)
        Width and height, px.
    strength
        How well its contours hold the window against shifts and turns; see `interest_windows`.
    rival
        Correlation of its contours with those of the most similar other place of the picture.
    """

    centre: tuple[float, float]
    size: tuple[int, int]
    strength: float
    rival: float


def interest_windows(
    edges: Edges,
    contours: Sequence[Segment | Arc],
    rules: WindowRules | None = None,
    *,
    taken: Float[np.ndarray, "m 2"] | None = None,
) -> tuple[Window, ...]:
    r"""Return windows that are distinctive and not repeated in the picture, the strongest first.

    .. math::
        \text{strength} = \lambda_{\min} \sum_j \begin{bmatrix} \cos\varphi_j \\ \sin\varphi_j
        \end{bmatrix} \begin{bmatrix} \cos\varphi_j & \sin\varphi_j \end{bmatrix}

    over the contour points :math:`p_j` of the window, with :math:`\varphi_j` the direction of the
    gradient there. Lines of one direction alone have strength 0, as a window can be shifted along
    them unnoticed. A circle alone can be turned unnoticed; therefore the strength is at most

    .. math:: \min_c \sum_j \big(n_j \times (p_j - c)\big)^2 / r^2,
        \qquad n_j = (\cos\varphi_j, \sin\varphi_j),

    with r a quarter of the shorter side of the window.

    Parameters
    ----------
    edges, contours
        Edges and contours of the picture.
    rules
        Size, number and thresholds; those of `WindowRules` if not given.
    taken : (m, 2)
        Centres of windows that are patterns already, px.

    Returns
    -------
    tuple of Window
        Empty where nothing is distinctive, as on a blank ceiling.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If a shape does not fit.
    """
    rules = WindowRules() if rules is None else checks.instance("rules", rules, WindowRules)
    near = np.empty((0, 2)) if taken is None else checks.array("taken", taken, ("m", 2))
    contours = checks.instances("contours", contours, Segment, Arc)
    at, normals = _contour_points(checks.instance("edges", edges, Edges), contours, rules.spacing)
    (wide, high), (height, width) = rules.size, edges.mask.shape
    us = np.arange(rules.margin, width - wide - rules.margin + 1, rules.spacing)
    vs = np.arange(rules.margin, height - high - rules.margin + 1, rules.spacing)
    if not (len(us) and len(vs)):
        return ()
    sums = cv2.integral(_tensor_image(at, normals, edges.mask.shape))
    v, u = (grid.ravel() for grid in np.meshgrid(vs, us, indexing="ij"))
    uu, vv, uv = (sums[v + high, u + wide] - sums[v, u + wide] - sums[v + high, u] + sums[v, u]).T
    strength = (uu + vv) / 2 - np.hypot((uu - vv) / 2, uv)
    drawn = cv2.GaussianBlur(edges.mask.astype(np.float32), (0, 0), 1.5)
    chosen: list[Window] = []
    refused = np.empty((0, 2))
    for k in np.argsort(-strength, kind="stable"):
        if strength[k] < rules.strength or len(chosen) == rules.most:
            break
        corner = np.array([u[k], v[k]])
        centre = corner + (np.array(rules.size) - 1) / 2
        if _near(near, centre, rules.apart) or _near(refused, centre, rules.apart / 3):
            continue
        within = ((at >= corner) & (at < corner + rules.size)).all(axis=1)
        turning = _turning(at[within] - centre, normals[within], min(rules.size) / 4)
        rival = _rival(drawn, int(u[k]), int(v[k]), wide, high)
        if turning >= rules.strength and rival <= rules.rival:
            near = np.vstack([near, centre])
            held = min(float(strength[k]), turning)
            chosen.append(Window(tuple(centre.tolist()), rules.size, held, rival))
        else:
            refused = np.vstack([refused, centre])
    return tuple(chosen)


def _near(others: Float[np.ndarray, "n 2"], point: Float[np.ndarray, "2"], apart: float) -> bool:
    """Tell whether another point is closer to a point than some distance."""
    return bool((np.hypot(*(others - point).T) < apart).any())


def _contour_points(
    edges: Edges, contours: Sequence[Segment | Arc], spacing: float
) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n 2"]]:
    """Return the contour points inside the picture, and the unit gradient at each."""
    pieces = [piece.points(spacing) for piece in contours]
    at = np.rint(np.concatenate(pieces)) if pieces else np.empty((0, 2))
    high, wide = edges.mask.shape
    at = at[((at >= 0) & (at <= [wide - 1, high - 1])).all(axis=1)]
    phi = edges.directions(at)
    return at, np.stack([np.cos(phi), np.sin(phi)], axis=-1)


def _turning(
    points: Float[np.ndarray, "n 2"], normals: Float[np.ndarray, "n 2"], radius: float
) -> float:
    r"""Return how well contour points resist a turn about the point where they resist least.

    The minimum over c of :math:`\sum_j (n_j \times (p_j - c))^2 / r^2`, by least squares.
    """
    arm = points[:, 0] * normals[:, 1] - points[:, 1] * normals[:, 0]
    left = arm - normals @ np.linalg.lstsq(normals, arm, rcond=None)[0]
    return float(left @ left) / radius**2


def _tensor_image(
    at: Float[np.ndarray, "n 2"], normals: Float[np.ndarray, "n 2"], shape: tuple[int, int]
) -> Float[np.ndarray, "height width 3"]:
    """Return at each pixel the sum of (nu², nv², nu nv) over the contour points that lie there."""
    tensors = np.zeros((*shape, 3))
    u, v = at.astype(int).T
    cos, sin = normals.T
    np.add.at(tensors, (v, u), np.stack([cos * cos, sin * sin, cos * sin], axis=-1))
    return tensors


def _rival(contours: np.ndarray, u: int, v: int, wide: int, high: int) -> float:
    """Return the largest correlation of a window's contours with those elsewhere in the picture."""
    window = contours[v : v + high, u : u + wide]
    found = cv2.matchTemplate(contours, window, cv2.TM_CCOEFF_NORMED)
    sums = cv2.integral(contours)
    held = sums[high:, wide:] - sums[:-high, wide:] - sums[high:, :-wide] + sums[:-high, :-wide]
    found[held < 0.1 * held[v, u]] = 0  # too few contours there to compare
    reach_u, reach_v = wide // 4, high // 4
    found[max(v - reach_v, 0) : v + reach_v + 1, max(u - reach_u, 0) : u + reach_u + 1] = -1
    best = float(found.max())
    return best if np.isfinite(best) else 1.0
