"""SIFT features of one picture: where they are, and what their neighbourhood looks like."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float, Float32, UInt8

from robot_perception import checks
from robot_perception.extras import needing
from robot_perception.fields import NotNegative, Positive, checked, from_to

with needing():
    import cv2

LEAST_SIDE = 16  # px; of smaller pictures nothing is left inside the detector's border
LENGTH = 128  # of a descriptor


def _blur(name: str, value: Any) -> float:
    if not 0.5 < (value := checks.number(name, value)) <= 16:
        raise ValueError(f"{name} must be above 0.5, a sharp picture's, to 16, got {value}")
    return value


def _single(name: str, value: np.ndarray) -> Float32[np.ndarray, "n d"]:
    """Return descriptors in single precision, which holds OpenCV's whole numbers exactly."""
    checks.moderate(name, value, float(np.finfo(np.float32).max))
    return value.astype(np.float32, copy=False)


@dataclass(frozen=True, slots=True)
class Sift:
    r"""Parameters of SIFT in OpenCV, with its default values.

    Parameters
    ----------
    most
        Keep so many of the strongest features, and those as strong as the last; 0 keeps all.
    layers
        Scales to an octave.
    contrast
        Least contrast of an extremum, of a picture whose values go from 0 to 1. OpenCV divides it
        by ``layers``: Lowe's 0.03 is its 0.09.
    edge
        Largest ratio of the two curvatures; along an edge it is larger.
    sigma
        Standard deviation of the blur of the first scale, px.

    Raises
    ------
    ValueError
        If a number is negative, or one that must be positive is 0.
    """

    most: Annotated[int, from_to(0, 10**6)] = 0
    layers: Annotated[int, from_to(1, 16)] = 3
    contrast: NotNegative = 0.04
    edge: Positive = 10.0
    sigma: Annotated[float, _blur] = 1.6
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Features:
    """Features of one picture.

    Parameters
    ----------
    pixels : (n, 2)
        u and v, px; a pixel's centre has whole numbers.
    descriptors : (n, d)
        Histograms of gradients: 128 numbers from 0 to 255 of OpenCV, whole, of length 512 or so.
    scales : (n,)
        Standard deviation of the blur at which each was found, px.
    angles : (n,)
        Main direction of the gradient, from u towards v, rad.

    Raises
    ------
    ValueError
        If the shapes disagree or a number is not finite.
    """

    pixels: Float[np.ndarray, "n 2"]
    descriptors: Annotated[Float[np.ndarray, "n d"], _single]
    scales: Float[np.ndarray, " n"]
    angles: Float[np.ndarray, " n"]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.pixels)

    def __getitem__(self, rows: slice | np.ndarray | list[int]) -> "Features":
        """Return some of the features: a slice, a mask or indices."""
        return Features(
            self.pixels[rows], self.descriptors[rows], self.scales[rows], self.angles[rows]
        )


SIFT = Sift()


def detect(image: UInt8[np.ndarray, "height width"], sift: Sift = SIFT) -> Features:
    """Find the SIFT features of a grey picture with OpenCV.

    A feature with two main directions is there twice. The first doubling of the picture is the one
    that leaves its pixels in place; OpenCV's default moves every feature by a quarter of a pixel. A
    picture has the same features each time, and on every processor of a kind: `same_code`.

    Parameters
    ----------
    image : (height, width)
        Grey values.
    sift
        What counts as a feature.

    Returns
    -------
    Features
        None where the picture has no texture.

    Raises
    ------
    TypeError
        If the picture does not hold bytes.
    ValueError
        If it is not grey or smaller than 16 px.

    References
    ----------
    Lowe, "Distinctive image features from scale-invariant keypoints", International Journal of
    Computer Vision 60(2), 2004. Gil et al. (2006), §2.
    """
    image = check_grey("image", image)
    checks.instance("sift", sift, Sift)
    finder = cv2.SIFT_create(
        sift.most, sift.layers, sift.contrast, sift.edge, sift.sigma, enable_precise_upscale=True
    )
    with same_code():
        found, descriptors = finder.detectAndCompute(image, None)
    if not found:
        return Features(
            np.empty((0, 2)), np.empty((0, LENGTH), np.float32), np.empty(0), np.empty(0)
        )
    return Features(
        cv2.KeyPoint.convert(found).astype(float),
        descriptors,
        np.array([point.size / 2 for point in found]),  # OpenCV's size is a diameter of 2σ
        np.deg2rad([point.angle for point in found]),
    )


@contextmanager
def same_code() -> Iterator[None]:
    """Let OpenCV run the code that all processors of a kind have, in one thread, for a while.

    By itself it takes the widest units that it finds, and they round otherwise: two descriptors in
    a hundred have an entry that differs by one. In several threads SIFT does not repeat itself: now
    and then it finds one feature more. The switches are OpenCV's own and hold for the process.
    """
    before = cv2.useOptimized(), cv2.ipp.useIPP(), cv2.getNumThreads()
    cv2.setUseOptimized(False)
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setUseOptimized(before[0])
        cv2.ipp.setUseIPP(before[1])
        cv2.setNumThreads(before[2])


def check_grey(name: str, image: np.ndarray) -> UInt8[np.ndarray, "height width"]:
    """Return a grey picture of bytes, or raise."""
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        kind = image.dtype if isinstance(image, np.ndarray) else checks.shown(image)
        raise TypeError(f"{name} must be a picture of bytes (uint8), got {kind}")
    if image.ndim != 2:
        raise ValueError(f"{name} must be grey, (height, width), got {image.shape}")
    if min(image.shape) < LEAST_SIDE:
        raise ValueError(
            f"{name} must be at least {LEAST_SIDE} px wide and high, got {image.shape}"
        )
    return image
