r"""Cues of a particle: colours of patches and edges near a contour, of persons and of arms.

A state is :math:`x = [x, y, \theta, s]^\top`, the place (px), the turn (rad) and the scale (px a
unit) of a target's own frame; a point p of that frame lies in the picture at

.. math:: (x, y)^\top + s\, R(\theta)\, p

Equations are those of section V of Menezes, Lerasle and Dias, "Visual Tracking Modalities for a
Companion Robot", which section IV uses. Thresholds, the largest distance and how exact the distance
transform is are parameters: persons and arms have other ones.
"""

from typing import Any, no_type_check

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception import checks
from robot_perception.companion.boxes import grey_picture
from robot_perception.extras import needing
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = [
    "bhattacharyya",
    "contour_distances",
    "distance_transform",
    "edge_distances",
    "edge_picture",
    "patch_histograms",
    "patch_histograms_textbook",
    "patch_points",
    "sampled",
]

States = Float[np.ndarray, "m 4"]


def patch_points(
    states: States, patches: Float[np.ndarray, "p 4"], *, grid: int = 8
) -> Float[np.ndarray, "m p n 2"]:
    """Return the points of a grid on each patch where many states put it.

    Parameters
    ----------
    states : (m, 4)
        x, y, θ, s.
    patches : (p, 4)
        Left, top, width and height in the target's frame.
    grid
        Points along each side of a patch.

    Returns
    -------
    (m, p, grid², 2)
        Column and row, px.

    Raises
    ------
    ValueError
        If a scale or a patch has no size, or a number is out of range.
    """
    states, patches = _states(states), checks.array("patches", patches, ("p", 4))
    if not len(patches) or not patches[:, 2:].min() > 0:
        raise ValueError("patches must be one at least, with a width and a height")
    grid = checks.whole("grid", grid, 2, 256)
    found = np.empty((len(states), len(patches), grid**2, 2))
    _place(states, patches, grid, found)
    return found


def patch_histograms(
    picture: UInt8[np.ndarray, "height width channels"],
    points: Float[np.ndarray, "m p n 2"],
    visible: Bool[np.ndarray, "m p n"] | None = None,
    *,
    bins: int = 8,
) -> tuple[Float[np.ndarray, "m p channels bins"], Float[np.ndarray, "m p"]]:
    r"""Return the histograms of patches in a picture, channel by channel.

    .. math:: h_{j,x}^c = c_H \sum_{u \in B_x} \delta_j(b_u^c)

    The pixels u are those nearest to the points of the patch, so that the cost of a state does not
    depend on its scale.

    Parameters
    ----------
    picture : (height, width, channels)
        Colours, and what else there is of each pixel, such as its intensity.
    points : (m, p, n, 2)
        Of p patches in m states, column and row, px, as of `patch_points`.
    visible : (m, p, n), optional
        Which of them are seen; all, if left out.
    bins
        Of each channel.

    Returns
    -------
    (m, p, channels, bins)
        Shares; all 0 for a patch of which nothing is seen in the picture.
    (m, p)
        Which share of the patch's points is seen there.

    Raises
    ------
    TypeError
        If the picture does not hold bytes, or what is visible no truth values.
    ValueError
        If the shapes disagree, a patch has no point, or there are fewer than 2 bins or more than
        256.

    References
    ----------
    Section V, "Color cues".
    """
    picture, points, visible, bins = _checked(picture, points, visible, bins)
    shape = points.shape[:2]
    found, inside = np.zeros((*shape, picture.shape[2], bins)), np.zeros(shape)
    _count(picture, points, visible, found, inside)
    return found, inside


def patch_histograms_textbook(
    picture: UInt8[np.ndarray, "height width channels"],
    points: Float[np.ndarray, "m p n 2"],
    visible: Bool[np.ndarray, "m p n"] | None = None,
    *,
    bins: int = 8,
) -> tuple[Float[np.ndarray, "m p channels bins"], Float[np.ndarray, "m p"]]:
    """Return the same as `patch_histograms`, written as the equation is."""
    picture, points, visible, bins = _checked(picture, points, visible, bins)
    height, width, channels = picture.shape
    shape = points.shape[:2]
    found, inside = np.zeros((*shape, channels, bins)), np.zeros(shape)
    for at in np.ndindex(*shape):
        u, v = np.floor(points[at] + 0.5).T
        seen = visible[at] & (u >= 0) & (u < width) & (v >= 0) & (v < height)
        inside[at] = seen.mean()
        if seen.any():
            values = picture[v[seen].astype(int), u[seen].astype(int)].astype(int) * bins // 256
            for c in range(channels):
                found[at][c] = np.bincount(values[:, c], minlength=bins) / seen.sum()
    return found, inside


def bhattacharyya(
    candidate: Float[np.ndarray, "... bins"], reference: Float[np.ndarray, "... bins"]
) -> Float[np.ndarray, "..."] | float:
    r"""Return the distance of histograms, from 0 (the same) to 1 (nothing in common).

    .. math:: D(h_x, h_\mathrm{ref}) = \left(1 - \sum_j \sqrt{h_{j,x}\, h_{j,\mathrm{ref}}}
        \right)^{1/2}

    Parameters
    ----------
    candidate, reference : (…, bins)
        Shares; leading axes broadcast. An empty histogram has nothing in common with any.

    Raises
    ------
    ValueError
        If the bins differ, leading axes do not broadcast, or a number is negative or not finite.

    References
    ----------
    Section V; the paper calls the sum the Bhattacharyya coefficient.
    """
    pair = []
    for name, value in (("candidate", candidate), ("reference", reference)):
        value = checks.array(name, value, (..., "bins"))
        if value.size and value.min() < 0:
            raise ValueError(f"{name} must not be negative, got {value.min():g}")
        pair.append(value)
    if pair[0].shape[-1] != pair[1].shape[-1]:
        raise ValueError(
            "candidate and reference must have the same bins,"
            f" got {pair[0].shape[-1]} and {pair[1].shape[-1]}"
        )
    checks.check_batches(candidate=pair[0].shape[:-1], reference=pair[1].shape[:-1])
    return np.sqrt(np.clip(1 - np.sqrt(pair[0] * pair[1]).sum(axis=-1), 0, 1))


def edge_distances(
    grey: UInt8[np.ndarray, "height width"],
    *,
    thresholds: tuple[float, float] = (60.0, 140.0),
    most: float = 20.0,
) -> Float[np.ndarray, "height width"]:
    """Return the distance of each pixel to the nearest edge, px.

    Parameters
    ----------
    grey : (height, width)
        Grey values.
    thresholds
        Of Canny's detector.
    most
        Larger distances are cut to it, so that one part of a contour that has no edge does not
        outweigh all others; ours.

    Raises
    ------
    TypeError
        If the picture does not hold bytes.
    ValueError
        If it is in colour, or a number is out of range.

    References
    ----------
    Section V, "Shape cues": the distance transform of the edges.
    """
    most = checks.positive("most", most)
    return distance_transform(edge_picture(grey, thresholds=thresholds), most=most, precise=False)


def edge_picture(
    grey: UInt8[np.ndarray, "height width"], *, thresholds: tuple[float, float]
) -> Bool[np.ndarray, "height width"]:
    """Return where edges are: those of Canny's detector on the blurred grey values.

    Parameters
    ----------
    grey : (height, width)
        Grey values.
    thresholds
        Of the detector.

    Raises
    ------
    TypeError
        If the picture does not hold bytes.
    ValueError
        If it is in colour, or the thresholds do not rise.
    """
    grey = grey_picture("grey", grey)
    low, high = checks.vector("thresholds", thresholds, 2).tolist()
    if not 0 <= low <= high:
        raise ValueError(f"thresholds must rise from 0 or more, got {low:g} and {high:g}")
    return cv2.Canny(cv2.GaussianBlur(grey, (0, 0), 1.0), low, high) > 0


def distance_transform(
    edges: Bool[np.ndarray, "height width"], *, most: float | None = None, precise: bool = True
) -> Float[np.ndarray, "height width"]:
    """Return the distance of each pixel to the nearest edge, px: I_DT.

    Parameters
    ----------
    edges : (height, width)
        Where they are.
    most
        Larger distances are cut to it; without it they are not, and infinite where there is no
        edge.
    precise
        Whether distances are exact, or summed along steps of a mask of 5 by 5 pixels.

    Raises
    ------
    TypeError
        If the edges are no truth values.
    ValueError
        If they are no picture, or the largest distance is not positive.

    References
    ----------
    Section V, "Shape cues".
    """
    edges = checks.instance("edges", edges, np.ndarray)
    if edges.dtype != bool:
        raise TypeError(f"edges must be truth values, got {edges.dtype}")
    if edges.ndim != 2 or not edges.size:
        raise ValueError(f"edges must be (height, width), got {edges.shape}")
    if edges.any():
        mask = cv2.DIST_MASK_PRECISE if checks.flag("precise", precise) else 5
        distance = cv2.distanceTransform(np.where(edges, np.uint8(0), np.uint8(255)), cv2.DIST_L2,
                                         mask)  # fmt: skip
    else:
        distance = np.full(edges.shape, np.inf, dtype=np.float32)
    if most is None:
        return distance
    return np.minimum(distance, np.float32(checks.positive("most", most)))


def sampled(
    distance: Float[np.ndarray, "height width"], points: Float[np.ndarray, "m n 2"], most: float
) -> Float[np.ndarray, "m n"]:
    """Return the distance at each point: that of the nearest pixel.

    Parameters
    ----------
    distance : (height, width)
        A distance transform, px.
    points : (m, n, 2)
        Column and row, px.
    most
        The distance outside of the picture.

    Raises
    ------
    ValueError
        If a distance is negative, or the shapes are others.
    """
    distance = np.ascontiguousarray(checks.reals("distance", distance))
    checks.shaped("distance", distance, ("height", "width"))
    if not distance.min(initial=0.0) >= 0:
        raise ValueError(f"distance must not be negative, got {distance.min():g}")
    points = checks.array("points", points, ("m", "n", 2), finite=False)
    found = np.empty(points.shape[:2])
    _gather(distance, points, checks.positive("most", most), found)
    return found


def contour_distances(
    distance: Float[np.ndarray, "height width"],
    states: States,
    contour: Float[np.ndarray, "n 2"],
) -> Float[np.ndarray, " m"]:
    r"""Return how far the points of a contour are from edges, root mean square, px.

    .. math:: D = \left( \frac{1}{N_p} \sum_j I_{DT}(j)^2 \right)^{1/2}

    The paper's text speaks of the sum of the squared distances, its eq. (2) of the square of their
    sum. Either grows with the number of points; the mean does not, so that its deviation is one in
    pixels. A point outside of the picture is as far as the picture's largest distance.

    Parameters
    ----------
    distance : (height, width)
        Of each pixel to the nearest edge, as of `edge_distances`.
    states : (m, 4)
        x, y, θ, s.
    contour : (n, 2)
        Points in the target's frame.

    Raises
    ------
    ValueError
        If the contour is empty, a scale is not positive, or a number is not finite.

    References
    ----------
    Eq. (2).
    """
    distance = checks.array("distance", distance, ("height", "width"))
    contour = checks.array("contour", contour, ("n", 2))
    states = _states(states)
    if not distance.size or not len(contour):
        raise ValueError("distance and contour must not be empty")
    points = np.empty((len(states), len(contour), 2))
    _put(states, contour, points)
    far = sampled(distance, points, float(distance.max()))
    return np.sqrt(np.add.accumulate(far * far, axis=1)[:, -1] / len(contour))


def _states(states: Any) -> np.ndarray:
    """Return states with a scale."""
    states = checks.array("states", states, ("m", 4))
    checks.moderate("states", states, 1e6)
    if states.size and not states[:, 3].min() > 0:
        raise ValueError(f"states must have a positive scale, got {states[:, 3].min():g}")
    return states


def _checked(picture: Any, points: Any, visible: Any, bins: Any) -> tuple:
    picture = checks.instance("picture", picture, np.ndarray)
    if picture.dtype != np.uint8:
        raise TypeError(f"picture must hold bytes (uint8), got {picture.dtype}")
    if picture.ndim != 3 or not picture.size:
        raise ValueError(f"picture must be (height, width, channels), got {picture.shape}")
    points = checks.array("points", points, ("m", "p", "n", 2), finite=False)
    if not points.shape[2]:
        raise ValueError(f"points must be one at least in a patch, got {points.shape}")
    visible = np.ones(points.shape[:3], bool) if visible is None else np.asarray(visible)
    if visible.dtype != bool:
        raise TypeError(f"visible must be truth values, got {visible.dtype}")
    checks.shaped("visible", visible, points.shape[:3], beside=f"points {points.shape}")
    return picture, points, visible, checks.whole("bins", bins, 2, 256)


@no_type_check
@kernel()
def _place(states, patches, grid, found):  # pragma: no cover - compiled
    for i in range(len(states)):
        x, y, theta, s = states[i]
        cos, sin = s * np.cos(theta), s * np.sin(theta)
        for k in range(len(patches)):
            left, top, wide, high = patches[k]
            for a in range(grid):
                q = top + high * (a + 0.5) / grid
                for b in range(grid):
                    p = left + wide * (b + 0.5) / grid
                    found[i, k, a * grid + b, 0] = cos * p - sin * q + x
                    found[i, k, a * grid + b, 1] = sin * p + cos * q + y


@no_type_check
@kernel()
def _count(picture, points, visible, found, inside):  # pragma: no cover - compiled
    height, width, channels = picture.shape
    bins, count = found.shape[3], points.shape[2]
    for i in range(points.shape[0]):
        for k in range(points.shape[1]):
            seen = 0
            for g in range(count):
                u, v = np.floor(points[i, k, g, 0] + 0.5), np.floor(points[i, k, g, 1] + 0.5)
                if not (visible[i, k, g] and 0 <= u < width and 0 <= v < height):
                    continue
                seen += 1
                for c in range(channels):
                    found[i, k, c, picture[int(v), int(u), c] * bins // 256] += 1
            inside[i, k] = seen / count
            if seen:
                for c in range(channels):
                    for j in range(bins):
                        found[i, k, c, j] /= seen


@no_type_check
@kernel()
def _put(states, contour, found):  # pragma: no cover - compiled
    for i in range(len(states)):
        x, y, theta, s = states[i]
        cos, sin = s * np.cos(theta), s * np.sin(theta)
        for j in range(len(contour)):
            p, q = contour[j]
            found[i, j, 0] = cos * p - sin * q + x
            found[i, j, 1] = sin * p + cos * q + y


@no_type_check
@kernel()
def _gather(distance, points, most, found):  # pragma: no cover - compiled
    height, width = distance.shape
    for i in range(points.shape[0]):
        for j in range(points.shape[1]):
            u, v = points[i, j]
            inside = -0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5
            found[i, j] = distance[int(v + 0.5), int(u + 0.5)] if inside else most
