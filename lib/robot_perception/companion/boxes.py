"""Boxes in pictures: left, top, width and height in pixels."""

import math
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.extras import needing

with needing():
    import cv2

__all__ = ["crop", "overlap", "overlap_in_pairs"]

Box = Float[np.ndarray, " 4"]
Boxes = Float[np.ndarray, "n 4"]
Grey = UInt8[np.ndarray, "height width"]


def overlap(
    one: Float[np.ndarray, "n 4"], other: Float[np.ndarray, "m 4"]
) -> Float[np.ndarray, "n m"]:
    """Return the area that boxes share over the area that either covers (intersection over union).

    Parameters
    ----------
    one, other : (n, 4), (m, 4)
        Boxes.

    Raises
    ------
    ValueError
        If a box has no area or is not finite.
    """
    one, other = check_boxes("one", one), check_boxes("other", other)
    return _overlap(one[:, None], other[None])


def overlap_in_pairs(
    one: Float[np.ndarray, "n 4"], other: Float[np.ndarray, "n 4"]
) -> Float[np.ndarray, " n"]:
    """Return the `overlap` of each box with the one that has its number.

    Parameters
    ----------
    one, other : (n, 4)
        Boxes, for instance those that were found in n pictures, and the true ones.

    Raises
    ------
    ValueError
        If there are not as many of each, or a box has no area or is not finite.
    """
    one, other = check_boxes("one", one), check_boxes("other", other)
    if len(one) != len(other):
        raise ValueError(f"one and other must be in pairs, got {len(one)} and {len(other)} boxes")
    return _overlap(one, other)


def _overlap(
    one: Float[np.ndarray, "... 4"], other: Float[np.ndarray, "... 4"]
) -> Float[np.ndarray, "..."]:
    low = np.maximum(one[..., :2], other[..., :2])
    high = np.minimum(one[..., :2] + one[..., 2:], other[..., :2] + other[..., 2:])
    common = np.prod(np.clip(high - low, 0, None), axis=-1)
    return common / (one[..., 2:].prod(axis=-1) + other[..., 2:].prod(axis=-1) - common)


def crop(
    image: Grey, box: Box, size: tuple[int, int] = (56, 46), *, equalise: bool = False
) -> Float[np.ndarray, "rows columns"]:
    """Return what lies in a box, rescaled to the size that a recogniser asks for.

    Parameters
    ----------
    image : (height, width)
        Grey values.
    box : (4,)
        Rounded to whole pixels; where it leaves the picture the border is repeated.
    size
        Rows and columns of the result.
    equalise
        Whether the grey values are spread evenly (histogram equalisation), so that a dim picture of
        a face is like a bright one. Ours: the paper does not speak of light.

    Returns
    -------
    (rows, columns)
        From 0 to 1.

    Raises
    ------
    TypeError
        If the image is no grey picture of bytes.
    ValueError
        If the box is not of four finite numbers, has no area or lies outside of the picture.
    """
    image, box = grey_picture("image", image), check_box("box", box)
    equalise = checks.flag("equalise", equalise)
    rows, columns = checks.integers("size", size, (2,), 1).tolist()
    low = np.rint(box[:2]).astype(int)
    high = np.maximum(np.rint(box[:2] + box[2:]).astype(int), low + 1)
    if (low >= image.shape[::-1]).any() or (high <= 0).any():
        raise ValueError(f"box must reach into the picture of {image.shape[::-1]} px, got {box}")
    u = np.clip(np.arange(low[0], high[0]), 0, image.shape[1] - 1)
    v = np.clip(np.arange(low[1], high[1]), 0, image.shape[0] - 1)
    inside = np.ascontiguousarray(image[np.ix_(v, u)])
    shrinks = len(u) > columns
    found = cv2.resize(
        inside, (columns, rows), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    )
    return (cv2.equalizeHist(found) if equalise else found) / 255.0


def grey_picture(name: str, image: Any) -> Grey:
    """Return a grey picture of bytes.

    Raises
    ------
    TypeError
        If it is none.
    ValueError
        If it is in colour, or empty.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        raise TypeError(f"{name} must be a picture of bytes, got {checks.shown(image)}")
    if image.ndim != 2 or not image.size:
        more = "; a picture in colour must be made grey first" if image.ndim == 3 else ""
        raise ValueError(f"{name} must be (height, width), got {image.shape}{more}")
    return image


def colour_picture(name: str, image: Any) -> UInt8[np.ndarray, "height width 3"]:
    """Return a picture of red, green and blue bytes.

    Raises
    ------
    TypeError
        If it is none.
    ValueError
        If it is grey, or empty.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        raise TypeError(f"{name} must be a picture of bytes, got {checks.shown(image)}")
    checks.shaped(name, image, ("height", "width", 3))
    if not image.size:
        raise ValueError(f"{name} must not be empty")
    return image


def check_box(name: str, box: Any) -> Box:
    """Return a box with an area, or raise a `ValueError`."""
    return check_boxes(name, checks.array(name, box, (4,))[None])[0]


def check_reach(name: str, box: Box, image: np.ndarray) -> Box:
    """Return a box of which something lies in a picture, or raise a `ValueError`."""
    box, size = check_box(name, box), image.shape[1::-1]
    if (box[:2] >= size).any() or (box[:2] + box[2:] <= 0).any():
        raise ValueError(f"{name} must reach into the picture of {size} px, got {box}")
    return box


def check_boxes(name: str, boxes: Any) -> Boxes:
    """Return boxes with an area, or raise a `ValueError`."""
    found = checks.array(name, boxes, ("n", 4))
    checks.moderate(name, found, 1e6)
    if found.size and not found[:, 2:].min() > 0:
        raise ValueError(f"{name} must have a width and a height, got {found[:, 2:].min():g}")
    return found


def known_sides(sides: Any, least: int, most: int) -> tuple[int, int]:
    """Return the smallest and the largest side to look for, within those that a detector has.

    Raises
    ------
    ValueError
        If the sides are not two positive numbers that rise.
    """
    if sides is None:
        return least, most
    low, high = (checks.positive("sides", side) for side in checks.vector("sides", sides, 2))
    if low > high:
        raise ValueError(f"sides must rise, got {low:g} before {high:g}")
    return max(least, math.floor(low)), max(least, min(most, math.ceil(high)))


def within(image: Grey, window: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of a picture that lies in a window, and its first column and row.

    Raises
    ------
    ValueError
        If the window has no area.
    """
    if window is None:
        return image, np.zeros(2)
    box, size = check_box("window", window), np.array(image.shape[::-1])
    low = np.clip(np.floor(box[:2]).astype(int), 0, size)
    end = np.clip(np.ceil(box[:2] + box[2:]).astype(int), low, size)
    return image[low[1] : end[1], low[0] : end[0]], low.astype(float)
