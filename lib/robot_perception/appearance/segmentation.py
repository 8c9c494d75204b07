r"""Segmentation by colour: the mask of pixels with colours of a histogram, and the object's blob.

Pixels of an object are connected across sides and corners (8-connected), those of the background
and of holes across sides alone (4-connected). The paper does not say how a mask is cleaned or how
wide its boundary is; both are our choice.
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

# Weight of each 2 × 2 square in 4 E: 1 with one pixel, -1 with three, -2 with two across a corner.
# The number of a square is the sum of its pixels: 1 and 2 in the upper row, 4 and 8 in the lower.
QUADS = np.array([0, 1, 1, 0, 1, 0, -2, -1, 1, -2, 0, -1, 0, -1, -1, 0])


def segment(
    index: Integer[np.ndarray, "height width"], histogram: Real[np.ndarray, " bins"]
) -> Bool[np.ndarray, "height width"]:
    r"""Return the mask of the pixels whose colour the histogram of the object holds.

    .. math:: S(u, v) = 1 \quad\text{where}\quad H(b(u, v)) > 0

    Parameters
    ----------
    index : (height, width)
        Bin b of each pixel's colour.
    histogram : (bins,)
        Counts or shares H of the bins, not negative.

    Raises
    ------
    TypeError
        If the bins are not whole numbers.
    ValueError
        If the image is empty, a bin is not one of the histogram's, or a count is negative or not
        finite.

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
    """Return a mask without specks and cracks: opened with a disc, then closed with another.

    Opening removes what is narrower than its disc, closing fills gaps narrower than its disc.
    Larger holes stay, since their number tells how good a segmentation is.

    Parameters
    ----------
    mask : (height, width)
        True on the object.
    opening, closing
        Diameters of the discs, px, odd; 1 leaves that step out.

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
        # without a margin, a blob that touches the border of the image would grow along it
        wide = cv2.copyMakeBorder(found, *4 * (closing,), cv2.BORDER_CONSTANT, value=0)
        wide = cv2.morphologyEx(wide, cv2.MORPH_CLOSE, _disc(closing))
        found = wide[closing:-closing, closing:-closing]
    return found.astype(bool)


def dilate(mask: Mask, reach: int) -> Mask:
    """Return a mask dilated by a disc.

    Parameters
    ----------
    mask : (height, width)
        The mask.
    reach
        Radius of the disc, px; 0 to 200.

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
    r"""Return the band of pixels along the border of a mask, :math:`\nabla S`.

    The band is the dilated mask without the eroded mask, and so lies evenly on both sides. Where
    the mask meets the edge of the image there is no border.

    Parameters
    ----------
    mask : (height, width)
        True on the object.
    reach
        Width of the band on each side of the border, px; 1 to 200.

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
    r"""Return the Euler number of a mask: its pieces minus its holes.

    .. math:: E = \tfrac{1}{4} (Q_1 - Q_3 - 2 Q_D)

    Of all 2 × 2 squares, :math:`Q_1` hold one pixel of the mask, :math:`Q_3` three, and
    :math:`Q_D` two that meet in a corner only.

    Parameters
    ----------
    mask : (height, width)
        True on the object; pieces are 8-connected, holes 4-connected.

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

    The rule is even-odd: a part that a crossing outline goes round twice is outside.

    Parameters
    ----------
    outline : (n, 2)
        Points (u, v), px; they may lie beyond the image.
    shape
        Height and width of the image, px.

    Raises
    ------
    ValueError
        If the points lie on a line or are not finite, or the shape is not that of an image.
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
    r"""A connected piece of a segmentation.

    Parameters
    ----------
    mask : (height, width)
        True on the piece.
    area
        Number of its pixels.
    euler
        Its Euler number: 1 minus the number of its holes.
    overlap
        Number of its pixels inside the predicted outline; 0 if there are none, or no outline was
        given. Then it is the largest piece.
    """

    mask: Mask
    area: int
    euler: int
    overlap: int

    def boundary(self, reach: int = 1) -> Mask:
        r"""Return the band along the borders of the piece and of its holes; see `boundary`.

        Parameters
        ----------
        reach
            Width of the band on each side of a border, px.

        Raises
        ------
        ValueError
            If the reach is out of its range.
        """
        return boundary(self.mask, reach)


def blob(mask: Mask, near: Outline | Mask | None = None) -> Blob | None:
    """Return the piece of a mask that counts as the object, or ``None`` if nothing is in the mask.

    It is the piece with most pixels inside the predicted outline. If no piece has a pixel there, it
    is the largest piece.

    Parameters
    ----------
    mask : (height, width)
        A segmentation, cleaned.
    near : (n, 2) or (height, width)
        Predicted outline (u, v) of the object, px, or the mask of its inside.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If a mask has no pixels, the two masks differ in shape, or the points of the outline lie on
        a line or are not finite.
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
    """Return the mask of the pixels where an object is expected, from an outline or a mask."""
    if not (isinstance(near, np.ndarray) and near.dtype == bool):
        return filled(check_outline("near", near), shape)
    if check_mask("near", near).shape != shape:
        raise ValueError(f"near must be as large as mask, {shape}, got {near.shape}")
    return near


def _disc(diameter: int) -> np.ndarray:
    """Return a disc as OpenCV's morphology takes it."""
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))


def _diameter(name: str, value: int) -> int:
    """Return a diameter, or raise ``ValueError`` if it is even or out of its range."""
    diameter = checks.whole(name, value, 1, 199)
    if diameter % 2 == 0:
        raise ValueError(f"{name} must be odd, got {diameter}")
    return diameter


@kernel()
@no_type_check
def _look_up(index, seen, found):  # pragma: no cover - compiled
    """Write for each pixel whether its bin has been seen; return False if a bin does not exist."""
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
    """Return the sum of the weights of all 2 × 2 squares; beyond the image pixels are False."""
    height, width = mask.shape
    total = 0
    for v in range(height + 1):
        square = 0  # so far its first column, bits 1 and 4
        for u in range(width + 1):
            above, here = v > 0 and u < width, v < height and u < width
            right = 2 * (above and mask[v - 1, u]) + 8 * (here and mask[v, u])
            total += quads[square + right]
            square = right >> 1
    return total


@kernel()
@no_type_check
def _fill(points, found):  # pragma: no cover - compiled
    """Write which pixel centres lie inside: an odd number of sides lies left of them in their row.

    First each side toggles the first pixel to its right in each row; then a row is summed up.
    """
    height, width = found.shape
    for i in range(len(points)):
        u0, v0 = points[i - 1]
        u1, v1 = points[i]
        if v0 > v1:
            u0, v0, u1, v1 = u1, v1, u0, v0
        # rows from v0 on, without v1: a corner counts once, and a level side not at all
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
