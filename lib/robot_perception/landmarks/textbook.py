"""The same as in a textbook: one feature, or one pair of descriptors, at a time.

`detect`, `Euclidean`, `Mahalanobis` and `match_stereo` are what everything else uses. Those of
pairs give the same as here; OpenCV's descriptors are, in the median, within 75 of a length of 512.
"""

import numpy as np
from jaxtyping import Float, Int, UInt8

from robot_perception import checks
from robot_perception.extras import needing
from robot_perception.landmarks.features import Features, check_grey
from robot_perception.landmarks.stereo import StereoRules, check_both

with needing():
    import cv2

SIDE = 16
"""Gradients along each side of the patch of a descriptor: 4 × 4 cells of 4 × 4 of them."""


def patch(
    image: UInt8[np.ndarray, "height width"],
    pixel: Float[np.ndarray, "2"],
    scale: float,
    angle: float,
) -> Float[np.ndarray, "18 18"]:
    """Return what lies round a feature, turned upright and brought to one size.

    The picture is blurred to the scale of the feature and sampled every 0.75 of it, so that a cell
    is three scales wide. One sample more on each side is for the gradients.

    Parameters
    ----------
    image : (height, width)
        Grey values; beyond its rim they are those of the rim.
    pixel : (2,)
        Column and row of the feature.
    scale
        Its σ, px, from 0.5 to 100.
    angle
        Its direction in the picture, clockwise from the columns, rad.

    Raises
    ------
    TypeError
        If the picture does not hold bytes.
    ValueError
        If it is not grey, the pixel lies outside it, or a number is out of its range.

    References
    ----------
    Lowe (2004), section 6.1; 3 scales a cell are OpenCV's.
    """
    image = check_grey("image", image)
    pixel = checks.vector("pixel", pixel, 2)
    if not ((pixel >= -0.5) & (pixel <= np.array(image.shape[::-1]) - 0.5)).all():
        raise ValueError(f"pixel must lie in {image.shape[::-1]} px, got {pixel.tolist()}")
    if not 0.5 <= checks.number("scale", scale) <= 100:
        raise ValueError(f"scale must be from 0.5 to 100 px, got {scale}")
    angle = checks.number("angle", angle)
    cos, sin = np.cos(angle), np.sin(angle)
    turned = 0.75 * scale * np.array([[cos, -sin], [sin, cos]])
    middle = (SIDE + 1) / 2
    to_image = np.column_stack([turned, pixel - turned @ [middle, middle]])
    blur = max(np.sqrt(scale**2 - 0.25), 0.1)  # half a pixel of blur comes with the picture
    blurred = cv2.GaussianBlur(image.astype(np.float32), (0, 0), blur)
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (SIDE + 2, SIDE + 2)
    found = cv2.warpAffine(blurred, to_image, size, flags=how, borderMode=cv2.BORDER_REPLICATE)
    return found.astype(float)


def describe(patch: Float[np.ndarray, "18 18"]) -> Float[np.ndarray, "128"]:
    r"""Return the descriptor of a patch: in each of 4 × 4 cells, gradients by direction in eighths.

    .. math:: h_{rcb} = \sum_{ij} m_{ij} \, \Lambda(y_{i} - r) \, \Lambda(x_{j} - c) \,
        \Lambda(\theta_{ij} - b), \qquad \Lambda(x) = \max(0, 1 - |x|)

    with the size m of a gradient, less the farther out, its place x, y in cells and its direction θ
    in eighths of a turn: each is shared by the cells and directions that it lies between.

    Parameters
    ----------
    patch : (18, 18)
        Grey values.

    Raises
    ------
    ValueError
        If a number is not finite, or the patch is of one grey.

    References
    ----------
    Lowe (2004), section 6.1.
    """
    patch = checks.array("patch", patch, (SIDE + 2, SIDE + 2))
    if not np.abs(patch).max() < 1e6 or np.ptp(patch) < 1 / checks.LARGEST:
        raise ValueError("patch must hold grey values that differ, below a million")
    along_u = (patch[1:-1, 2:] - patch[1:-1, :-2]) / 2
    along_v = (patch[2:, 1:-1] - patch[:-2, 1:-1]) / 2
    away = np.arange(SIDE) - (SIDE - 1) / 2
    size = np.hypot(along_u, along_v)
    size = size * np.exp(-(away[:, None] ** 2 + away**2) / (2 * 8.0**2))
    turn = np.arctan2(-along_v, along_u) / (2 * np.pi) * 8  # in eighths
    cell = away / 4 + 1.5  # 0 is the middle of the first
    h = np.empty((4, 4, 8))
    for r, c, b in np.ndindex(4, 4, 8):
        place = _tent(cell[:, None] - r) * _tent(cell - c)
        h[r, c, b] = (size * place * _tent((turn - b + 4) % 8 - 4)).sum()
    d = h.ravel() / np.linalg.norm(h)
    d = np.minimum(d, 0.2)  # one strong edge must not outshine all else
    return np.rint(512 * d / np.linalg.norm(d))


def _tent(x: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """Return 1 at 0, 0 from 1 on, and straight lines between."""
    return np.maximum(0.0, 1 - np.abs(x))


def euclidean(d: Float[np.ndarray, " n"], mean: Float[np.ndarray, " n"]) -> float:
    r"""Return the squared Euclidean distance between two descriptors.

    .. math:: E = (d_i - d_j) (d_i - d_j)^\top

    Parameters
    ----------
    d, mean : (n,)
        The descriptors.

    Raises
    ------
    ValueError
        If the shapes disagree or a number is not finite.

    References
    ----------
    Gil et al. (2006), eq. (8).
    """
    d = checks.array("d", d, ("n",))
    mean = checks.array("mean", mean, d.shape, f"d {d.shape}")
    apart = d - mean
    return float(apart @ apart)


def mahalanobis(
    d: Float[np.ndarray, " n"], mean: Float[np.ndarray, " n"], variances: Float[np.ndarray, " n"]
) -> float:
    r"""Return the squared Mahalanobis distance from a descriptor to a class.

    .. math:: L = (d - \bar d_i) S_i^{-1} (d - \bar d_i)^\top

    Parameters
    ----------
    d : (n,)
        The descriptor.
    mean, variances : (n,)
        Mean and diagonal of the covariance of the class.

    Raises
    ------
    ValueError
        If the shapes disagree, a number is not finite or a variance not positive.

    References
    ----------
    Gil et al. (2006), eq. (9).
    """
    d = checks.array("d", d, ("n",))
    mean = checks.array("mean", mean, d.shape, f"d {d.shape}")
    variances = checks.array("variances", variances, d.shape, f"d {d.shape}")
    if variances.size and not variances.min() > 0:
        raise ValueError(f"variances must be positive, got {variances.min()}")
    apart = d - mean
    return float(np.sum(apart**2 / variances))


def match_stereo(left: Features, right: Features, rules: StereoRules) -> Int[np.ndarray, "pairs 2"]:
    """Return which features of a rectified pair are the same point, by all distances at once.

    Parameters
    ----------
    left, right
        Features of the two pictures.
    rules
        Rows, threshold and disparities.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If the descriptors of ``right`` are not of the same length as those of ``left``.

    References
    ----------
    Gil et al. (2006), §3.1.
    """
    check_both(left=left, right=right)
    least, most = checks.instance("rules", rules, StereoRules).disparities
    if not len(left) or not len(right):
        return np.empty((0, 2), dtype=int)
    disparity, offset = np.moveaxis(left.pixels[:, None] - right.pixels, -1, 0)
    apart = left.descriptors[:, None].astype(float) - right.descriptors
    distances = np.sqrt((apart**2).sum(axis=-1))
    distances[(np.abs(offset) > rules.rows) | (distances > rules.threshold)] = np.inf
    distances[(disparity < least) | (disparity > most)] = np.inf
    nearest, back = distances.argmin(axis=1), distances.argmin(axis=0)
    rows = np.arange(len(left))
    good = np.isfinite(distances[rows, nearest]) & (back[nearest] == rows)
    return np.stack([rows[good], nearest[good]], axis=1)
