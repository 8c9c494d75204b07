"""Two pictures of one thing, and where each point of the one is in the other."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception.datasets.logs import CorruptLog, as_path, to_numbers
from robot_perception.datasets.pictures import CorruptImage, read_image
from robot_perception.geometry.homographies import condition_number


@dataclass(frozen=True, eq=False, slots=True)
class PlanePair:
    r"""A plane photographed twice.

    .. math:: (u', v', 1)^\top \propto H\, (u, v, 1)^\top

    Parameters
    ----------
    first, second : (height, width)
        Grey pictures.
    homography : (3, 3)
        H, which takes pixels of the first to pixels of the second.
    """

    first: UInt8[np.ndarray, "height width"]
    second: UInt8[np.ndarray, "height_2 width_2"]
    homography: Float[np.ndarray, "3 3"]


@dataclass(frozen=True, eq=False, slots=True)
class DepthPair:
    """A rectified stereo pair with its disparities.

    Parameters
    ----------
    left, right : (height, width)
        Grey pictures.
    disparity : (height, width)
        How much farther left each point of the left picture is in the right one, px; 0 where
        nobody knows.
    """

    left: UInt8[np.ndarray, "height width"]
    right: UInt8[np.ndarray, "height width"]
    disparity: Float[np.ndarray, "height width"]

    @property
    def known(self) -> Bool[np.ndarray, "height width"]:
        """Mask of the pixels whose disparity is known."""
        return self.disparity > 0


def read_plane_pair(folder: str | Path) -> PlanePair:
    """Read the wall of graffiti: ``graf1.png``, ``graf3.png`` and ``H1to3p.xml``.

    Raises
    ------
    CorruptImage
        If a picture is damaged.
    CorruptLog
        If the homography is not nine numbers, or singular.
    FileNotFoundError
        If a file is missing.

    References
    ----------
    Mikolajczyk et al., "A comparison of affine region detectors", International Journal of Computer
    Vision 65, 2005.
    """
    folder = as_path(folder, "folder")
    pictures = (read_image(folder / name) for name in ("graf1.png", "graf3.png"))
    return PlanePair(*pictures, _homography(folder / "H1to3p.xml"))


def read_depth_pair(folder: str | Path) -> DepthPair:
    """Read the pair of the aloe: ``aloeL.jpg``, ``aloeR.jpg`` and ``aloeGT.png``.

    Raises
    ------
    CorruptImage
        If a picture is damaged, or the three are not of one size.
    FileNotFoundError
        If a file is missing.

    References
    ----------
    Scharstein and Pal, "Learning conditional random fields for stereo", CVPR 2007.
    """
    folder = as_path(folder, "folder")
    names = ("aloeL.jpg", "aloeR.jpg", "aloeGT.png")
    left, right, disparity = (read_image(folder / name) for name in names)
    for name, picture in zip(names[1:], (right, disparity), strict=True):
        if picture.shape != left.shape:
            raise CorruptImage(f"{folder / name}: {picture.shape}, but {names[0]} is {left.shape}")
    return DepthPair(left, right, disparity.astype(float))


def _homography(path: Path) -> Float[np.ndarray, "3 3"]:
    """Return a matrix that OpenCV has stored."""
    try:
        words = ElementTree.fromstring(path.read_bytes()).findtext(".//data").encode().split()
        numbers = to_numbers(words)
    except (ElementTree.ParseError, AttributeError, ValueError) as error:
        raise CorruptLog(f"{path}: no matrix as OpenCV stores one ({error})") from error
    if numbers.size != 9 or not np.isfinite(numbers).all():
        raise CorruptLog(f"{path}: a homography is nine finite numbers, got {numbers.size}")
    H = numbers.reshape(3, 3)
    if condition_number(H) > 1e12:
        raise CorruptLog(f"{path}: the homography is singular")
    return H
