r"""Segmentation by a histogram's colours: the mask of their pixels, and the object's blob.

Pixels of an object hang together over sides and corners, those of a hole over sides alone. How a
mask is cleaned, and how wide its boundary is, the paper leaves open: these are our choices.
"""

from dataclasses import dataclass
from typing import no_type_check

import numpy as np
from jaxtyping import Bool, Integer, Real

from robot_perception import checks
from robot_perception.appearance._masks import Mask, Outline, check_mask, check_outline
from robot_perception.extras import needing
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = ["Blob", "blob", "boundary", "clean", "dilate", "euler_number", "filled", "segment"]

# which 2 × 2 squares hold one pixel, three, or two across a corner; bits 1 2 / 4 8
QUADS = np.array([0, 1, 1, 0, 1, 0, -2, -1, 1, -2, 0, -1, 0, -1, -1, 0])


def segment(
    index: Integer[np.ndarray, "height width"], histogram: Real[np.ndarray, " bins"]
) -> Bool[np.ndarray, "height width"]:
    r"""Return where the colour of an image has been seen on the object.

    .. math:: S(u, v) = 1 \quad\text{where}\quad H(b(u, v)) > 0

    Parameters
    ----------
    index : (height, width)
        Number b of each pixel's bin.
    histogram : (bins,)
        Counts or shares H, none negative.

    Raises
    ------
    TypeError
        If the numbers of bins are not whole.
    ValueError
        If the image is empty, a number is that of no bin, or a count is negative or not finite.

    References
    ----------
    Andrade-Cetto, "Perception issues in mobile robotics", section 3.3. It counts bins by
    :math:`r - 1 < \mathcal R R \le r` and looks them up by :math:`\lfloor \mathcal R R \rfloor`,
    which are not the same; here one numbering serves both.
    """
    if not (isinstance(index, np.ndarray) and index.dtype == np.int32):
        index = checks.integers("index", index)
    if index.ndim != 2 or not index.size:
        raise ValueError(f"index must be (height, width), got {index.shape}")
    histogram = checks.array("histogram", histogram, ("bins",))
    if (histogram < 0).any():
        raise ValueError(f"histogram must not be negative, got {histogram.min():g}")
    found = np.empty(index.shape, dtype=bool)
    if not _look_up(index, histogram > 0, found):
        low, high = index.min(), index.max()
        raise ValueError(
            f"index must be from 0 to {len(histogram) - 1}, the bins of histogram, "
            f"got {low} to {high}"
        )
    return found


def clean(mask: Mask, opening: int = 3, closing: int = 5) -> Mask:
    """Return a mask without specks and cracks: opened, then closed, with discs.

    Parameters
    ----------
    mask : (height, width)
        True on the object.
    opening, closing
        Diameters of the discs, px, odd; 1 leaves that step out. What is narrower than the first
        goes, and so do gaps narrower than the second. Larger holes stay, since their number says
        how good a segmentation is.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If the mask is empty, or a diameter is even or out of its range.
    """
    found = check_mask("mask", mask).view(np.uint8)
    opening, closing = _diameter("opening", opening), _diameter("closing", closing)
    if opening > 1:
        found = cv2.morphologyEx(found, cv2.MORPH_OPEN, _disc(opening))
    if closing > 1:
        # with a margin, as otherwise what touches the frame of the image would grow along it
        wide = cv2.copyMakeBorder(found, *4 * (closing,), cv2.BORDER_CONSTANT, value=0)
        wide = cv2.morphologyEx(wide, cv2.MORPH_CLOSE, _disc(closing))
        found = wide[closing:-closing, closing:-closing]
    return found.astype(bool)


def dilate(mask: Mask, reach: int) -> Mask:
    """Return a mask that reaches so many pixels further to all sides.

    Parameters
    ----------
    mask : (height, width)
        What is made larger.
    reach
        Radius of the disc, px.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If the mask is empty or the reach out of its range.
    """
    reach = checks.whole("reach", reach, 0, 200)
    return cv2.dilate(check_mask("mask", mask).view(np.uint8), _disc(2 * reach + 1)).view(bool)


def boundary(mask: Mask, reach: int = 1) -> Mask:
    r"""Return the pixels near the border between a mask and the rest, :math:`\nabla S`.

    The band lies evenly on both sides: it is the mask dilated less the mask eroded. The frame of
    the image is no border.

    Parameters
    ----------
    mask : (height, width)
        True on the object.
    reach
        Pixels on each side of the border.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If the mask is empty or the reach out of its range.
    """
    reach = checks.whole("reach", reach, 1, 200)
    found = check_mask("mask", mask).view(np.uint8)
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    element = cross if reach == 1 else _disc(2 * reach + 1)
    return cv2.morphologyEx(found, cv2.MORPH_GRADIENT, element).view(bool)


def euler_number(mask: Mask) -> int:
    r"""Return how many pieces a mask has, less its holes, by counts of 2 × 2 squares.

    .. math:: E = \tfrac{1}{4} (Q_1 - Q_3 - 2 Q_D)

    where so many squares hold one pixel, three, or two that meet in a corner.

    Parameters
    ----------
    mask : (height, width)
        True on the object; pieces hang together over corners, holes do not.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If the mask is empty.

    References
    ----------
    Gray, "Local properties of binary images in two dimensions", IEEE Transactions on Computers
    C-20(5), 1971.
    """
    return _euler(check_mask("mask", mask), QUADS) // 4


def filled(outline: Outline, shape: tuple[int, int]) -> Mask:
    """Return the pixels of an image whose centres lie inside an outline.

    Where an outline crosses itself, what it goes round twice is outside.

    Parameters
    ----------
    outline : (n, 2)
        Points (u, v), px; may reach beyond the image.
    shape
        Height and width of the image.

    Raises
    ------
    ValueError
        If the points lie on a line or are not finite, or the shape is none.
    """
    points = check_outline("outline", outline)
    height, width = checks.integers("shape", shape, (2,), 1).tolist()
    if max(height, width) > 2**14:
        raise ValueError(f"shape must be at most {2**14} px a side, got {(height, width)}")
    found = np.zeros((height, width), dtype=bool)
    _fill(points, found)
    return found


@dataclass(frozen=True, eq=False, slots=True)
class Blob:
    r"""One piece of a segmentation.

    Parameters
    ----------
    mask : (height, width)
        Its pixels.
    area
        Number of them.
    euler
        1 less the number of its holes.
    overlap
        How many of them lie inside the predicted outline; 0 if none does or none was given, and
        then this is the largest piece.
    """

    mask: Mask
    area: int
    euler: int
    overlap: int

    def boundary(self, reach: int = 1) -> Mask:
        r"""Return its edges :math:`\nabla S`, also those of its holes; see `boundary`.

        Parameters
        ----------
        reach
            Pixels on each side of the border.

        Raises
        ------
        ValueError
            If the reach is out of its range.
        """
        return boundary(self.mask, reach)


def blob(mask: Mask, near: Outline | Mask | None = None) -> Blob | None:
    """Return the piece of a mask that is taken for the object, ``None`` if there is no piece.

    It is the one with most pixels inside a predicted outline; where none has any, the largest.

    Parameters
    ----------
    mask : (height, width)
        A segmentation, cleaned.
    near : (n, 2) or (height, width)
        Outline (u, v) where the object is expected, px, or the mask of its inside.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If the mask is empty, the one of the inside has another shape, or the points of the outline
        lie on a line or are not finite.
    """
    mask = check_mask("mask", mask)
    expected = None if near is None else _expected(near, mask.shape)
    u, v, width, height = cv2.boundingRect(mask.view(np.uint8))
    if not width:
        return None
    some = np.s_[v : v + height, u : u + width]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        mask[some].view(np.uint8), connectivity=8
    )
    inside = np.zeros(count, dtype=int)
    if expected is not None:
        inside = np.bincount(labels[expected[some]], minlength=count)
        inside[0] = 0  # the background
    areas = stats[1:, cv2.CC_STAT_AREA]
    best = 1 + int(np.argmax(inside[1:] if inside.any() else areas))
    u, v, width, height, area = stats[best].tolist()
    piece = labels[v : v + height, u : u + width] == best
    own = np.zeros_like(mask)
    own[some][v : v + height, u : u + width] = piece
    return Blob(own, area, euler_number(piece), int(inside[best]))


def _expected(near: Outline | Mask, shape: tuple[int, int]) -> Mask:
    """Return the pixels where an object is expected."""
    if not (isinstance(near, np.ndarray) and near.dtype == bool):
        return filled(check_outline("near", near), shape)
    if check_mask("near", near).shape != shape:
        raise ValueError(f"near must be as large as mask, {shape}, got {near.shape}")
    return near


def _disc(diameter: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))


def _diameter(name: str, value: int) -> int:
    diameter = checks.whole(name, value, 1, 199)
    if diameter % 2 == 0:
        raise ValueError(f"{name} must be odd, got {diameter}")
    return diameter


@kernel()
@no_type_check
def _look_up(index, seen, found):  # pragma: no cover - compiled
    """Write whether each bin has been seen; tell whether all numbers are those of bins."""
    for v in range(index.shape[0]):
        for u in range(index.shape[1]):
            b = index[v, u]
            if b < 0 or b >= seen.size:
                return False
            found[v, u] = seen[b]
    return True


@kernel()
@no_type_check
def _euler(mask, quads):  # pragma: no cover - compiled
    """Return the sum of what the 2 × 2 squares count; beyond the frame nothing is."""
    height, width = mask.shape
    total = 0
    for v in range(height + 1):
        square = 0  # its left half
        for u in range(width + 1):
            above, here = v > 0 and u < width, v < height and u < width
            right = 2 * (above and mask[v - 1, u]) + 8 * (here and mask[v, u])
            total += quads[square + right]
            square = right >> 1
    return total


@kernel()
@no_type_check
def _fill(points, found):  # pragma: no cover - compiled
    """Write which pixel centres lie inside: those with an odd number of sides on their left."""
    height, width = found.shape
    for i in range(len(points)):
        u0, v0 = points[i - 1]
        u1, v1 = points[i]
        if v0 > v1:
            u0, v0, u1, v1 = u1, v1, u0, v0
        # half open, so that a corner counts once and a level side not at all
        first, end = max(0.0, np.ceil(v0)), min(float(height), max(0.0, np.ceil(v1)))
        for v in range(int(min(float(height), first)), int(end)):
            u = int(np.ceil(min(float(width), max(0.0, u0 + (v - v0) / (v1 - v0) * (u1 - u0)))))
            if u < width:
                found[v, u] = not found[v, u]
    for v in range(height):
        inside = False
        for u in range(width):
            inside ^= found[v, u]
            found[v, u] = inside
