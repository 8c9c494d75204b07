r"""Haar-like features: weighted sums of grey values over rectangles, by the integral image.

.. math::
    I(x, y) = \sum_{x' < x,\, y' < y} i(x', y'), \qquad
    f = \frac{1}{n \sigma} \sum_r w_r \bigl( I(x_r + a_r, y_r + b_r) - I(x_r, y_r + b_r)
        - I(x_r + a_r, y_r) + I(x_r, y_r) \bigr)

Rectangle r begins at column :math:`x_r` and row :math:`y_r`, is :math:`a_r` wide and :math:`b_r`
high, and has the weight :math:`w_r`. n is the number of pixels in the window, and :math:`\sigma`
the standard deviation of its grey values. The weights of a feature sum to 0 over its pixels, so
that brightness does not change f; the division by :math:`\sigma` takes contrast out.
"""

from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int, UInt8

from robot_perception import checks
from robot_perception.extras import needing
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = ["SIZE", "feature_pool", "feature_values", "feature_values_textbook", "integral"]

SIZE = 24
"""Side of the window, px; no smaller hand is found."""
HEAVIEST = 10**6
"""Largest weight of a rectangle, of either sign; sums over pixels stay far within 64 bits."""
FLAT = 2.0
"""Least standard deviation of grey values in a window that can hold a hand; our choice."""

Features = Int[np.ndarray, "n 3 5"]
Windows = UInt8[np.ndarray, "m 24 24"]


def integral(image: UInt8[np.ndarray, "height width"]) -> tuple[np.ndarray, np.ndarray]:
    """Return the integral images (height + 1, width + 1) of grey values and of their squares.

    Parameters
    ----------
    image : (height, width)
        Grey values, bytes.

    Raises
    ------
    TypeError
        If the picture does not hold bytes.
    ValueError
        If it is in colour or empty.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        raise TypeError(f"image must be a picture of bytes, got {checks.shown(image)}")
    checks.shaped("image", image, ("height", "width"))
    if not image.size:
        raise ValueError("image must not be empty")
    total, squares = cv2.integral2(image, sdepth=cv2.CV_32S, sqdepth=cv2.CV_64F)
    return total, squares


def feature_pool(rng: np.random.Generator, count: int = 4000) -> Features:
    """Return distinct features of random kind, size and place.

    There are six kinds: two rectangles beside or above each other, three in a row or in a column,
    four in a square, and one surrounded by another. Each covers 8 pixels at least.

    Parameters
    ----------
    rng
        Source of kinds, sizes and places.
    count
        Number of features, 1 to 20 000.

    Returns
    -------
    (count, 3, 5)
        Column, row, width, height and weight of up to three rectangles; all 0 for one that is not
        used.

    References
    ----------
    Viola and Jones, CVPR 2001; the surrounded rectangle is of Lienhart and Maydt, ICIP 2002.
    """
    checks.generator("rng", rng)
    count = checks.whole("count", count, 1, 20_000)
    found: dict[tuple, np.ndarray] = {}
    while len(found) < count:
        feature = _drawn(rng)
        found.setdefault(tuple(feature.ravel().tolist()), feature)
    return np.array(list(found.values()))


def _drawn(rng: np.random.Generator) -> np.ndarray:
    """Return a random feature: its whole area with weight -1, and parts that balance it."""
    kind = int(rng.integers(6))
    across, down = ((2, 1), (1, 2), (3, 1), (1, 3), (2, 2), (3, 3))[kind]
    while True:
        w, h = (int(n) for n in rng.integers(1, SIZE // np.array([across, down]) + 1))
        if across * down * w * h >= 8:
            break
    left = int(rng.integers(0, SIZE - across * w + 1))
    top = int(rng.integers(0, SIZE - down * h + 1))
    feature = np.zeros((3, 5), dtype=np.int64)
    feature[0] = left, top, across * w, down * h, -1
    if kind < 2:
        feature[1] = left, top, w, h, 2
    elif kind < 4:
        feature[1] = left + w * (across == 3), top + h * (down == 3), w, h, 3
    elif kind == 4:
        feature[1] = left, top, w, h, 2
        feature[2] = left + w, top + h, w, h, 2
    else:
        feature[1] = left + w, top + h, w, h, 9
    return feature


def feature_values(windows: Windows, features: Features) -> Float[np.ndarray, "n m"]:
    """Return the value of each feature on each window.

    Parameters
    ----------
    windows : (m, 24, 24)
        Grey values.
    features : (n, 3, 5)
        Features as `feature_pool` returns them.

    Returns
    -------
    (n, m)
        Values f; all 0 on a window with a standard deviation of grey values below 2.

    Raises
    ------
    TypeError
        If the windows do not hold bytes.
    ValueError
        If they are of another size, or a rectangle leaves the window.
    """
    windows, features = check_windows(windows), check_features(features)
    found = np.empty((len(features), len(windows)), dtype=np.float32)
    totals = np.zeros((len(windows), SIZE + 1, SIZE + 1), dtype=np.int32)
    np.cumsum(windows, axis=1, dtype=np.int32, out=totals[:, 1:, 1:])
    np.cumsum(totals[:, 1:, 1:], axis=2, out=totals[:, 1:, 1:])
    spread = deviations(windows)
    scale = np.where(spread < FLAT, 0.0, 1 / np.maximum(spread, FLAT)) / SIZE**2
    _evaluate(totals, scale, features, found)
    return found.astype(float)


def feature_values_textbook(windows: Windows, features: Features) -> Float[np.ndarray, "n m"]:
    """Return the result of `feature_values`, by sums over pixels without integral images."""
    windows, features = check_windows(windows), check_features(features)
    found = np.zeros((len(features), len(windows)))
    for j, window in enumerate(windows.astype(float)):
        spread = window.std()
        if spread < FLAT:
            continue
        for i, feature in enumerate(features):
            total = sum(w * window[y : y + b, x : x + a].sum() for x, y, a, b, w in feature)
            found[i, j] = total / (spread * window.size)
    return found


def deviations(windows: Windows) -> Float[np.ndarray, " m"]:
    """Return the standard deviation of the grey values of each window."""
    return windows.reshape(len(windows), SIZE**2).std(axis=1)


def check_windows(windows: Windows, name: str = "windows") -> np.ndarray:
    """Return windows of bytes of the right size, or raise an error."""
    if not isinstance(windows, np.ndarray) or windows.dtype != np.uint8:
        raise TypeError(f"{name} must be pictures of bytes, got {checks.shown(windows)}")
    checks.shaped(name, windows, ("m", SIZE, SIZE))
    return windows


def check_features(features: Features) -> np.ndarray:
    """Return features whose rectangles lie in the window, or raise an error."""
    return in_window("features", checks.integers("features", features, ("n", 3, 5)))


def in_window(name: str, found: np.ndarray) -> np.ndarray:
    """Return an array of features whose rectangles lie in the window, or raise an error."""
    places, sizes = found[..., :2], found[..., 2:4]
    within = (sizes >= 0) & (sizes <= SIZE) & (places >= 0)
    within &= places <= SIZE - np.where(within, sizes, 0)  # places + sizes could overflow
    if not within.all():
        wrong = found[~within.all(axis=-1)][0].tolist()
        raise ValueError(f"{name} must lie within {SIZE} x {SIZE} px, got rectangle {wrong}")
    for weight in (found[..., 4].min(initial=0), found[..., 4].max(initial=0)):
        if not -HEAVIEST <= weight <= HEAVIEST:
            raise ValueError(f"{name} must have weights within {HEAVIEST}, got {weight}")
    return found


@no_type_check
@kernel()
def _evaluate(totals, scale, features, found):  # pragma: no cover - compiled
    """Write the value of each feature on each window, by four corners of a rectangle."""
    for i in range(len(features)):
        for j in range(len(totals)):
            total, value = totals[j], 0
            for r in range(3):
                x, y, w, h, weight = features[i, r]
                if w > 0:
                    value += weight * (
                        total[y + h, x + w] - total[y, x + w] - total[y + h, x] + total[y, x]
                    )
            found[i, j] = value * scale[j]
