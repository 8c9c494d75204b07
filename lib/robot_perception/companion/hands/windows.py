"""Windows of pictures for the training of a cascade: at random, and those that still deceive it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.companion.boxes import check_box, grey_picture
from robot_perception.companion.hands.cascade import Cascade, HandDetector
from robot_perception.companion.hands.features import SIZE, check_windows
from robot_perception.extras import needing

with needing():
    import cv2

__all__ = ["hard_windows", "random_window", "window_at"]

Grey = UInt8[np.ndarray, "height width"]
Window = UInt8[np.ndarray, "24 24"]

SCALE, STEP, EACH = 1.12, 1, 60
"""Density of the search for windows that deceive, and how many each picture gives at most."""


def window_at(image: Grey, box: Float[np.ndarray, " 4"]) -> Window:
    """Return a square of a picture, made as small as the detector's window.

    Parameters
    ----------
    image : (height, width)
        Grey values.
    box : (4,)
        Left, top and side of the square, rounded to whole pixels, so that it may leave the picture
        by one; its height is not asked.

    Raises
    ------
    TypeError, ValueError
        If the image is no grey picture, or the square lies outside of it.
    """
    grey_picture("image", image)
    left, top, side = np.rint(check_box("box", box)[:3]).astype(int)
    inside = image[max(top, 0) : top + side, max(left, 0) : left + side]
    if not inside.size:
        raise ValueError(f"box must reach into the picture of {image.shape[::-1]} px, got {box}")
    return cv2.resize(np.ascontiguousarray(inside), (SIZE, SIZE), interpolation=cv2.INTER_AREA)


def random_window(image: Grey, *, rng: np.random.Generator) -> Window:
    """Return a square of a picture at a random place, of a random size, even in its logarithm.

    Raises
    ------
    TypeError, ValueError
        If the image is no grey picture, or smaller than the detector's window.
    """
    size = np.array(_large("image", image).shape[::-1])
    checks.generator("rng", rng)
    side = round(float(np.exp(rng.uniform(np.log(SIZE), np.log(size.min())))))
    low = rng.integers(0, size - side + 1)
    return window_at(image, np.array([*low, side, side], dtype=float))


def hard_windows(
    cascade: Cascade | None,
    count: int,
    *,
    pictures: Sequence[UInt8[np.ndarray, "_ _"]],
    windows: UInt8[np.ndarray, "m 24 24"],
    rng: np.random.Generator,
) -> UInt8[np.ndarray, "k 24 24"]:
    """Return windows without a hand that a cascade lets pass, or any if there is none.

    Half of them are from the windows, if enough of these pass; the others are searched for in the
    pictures, one after the other in random order.

    Parameters
    ----------
    cascade
        So far; ``None`` before its first stage.
    count
        How many are wanted; there are fewer where no more are found.
    pictures
        Grey values, in which there is no hand.
    windows : (m, 24, 24)
        Of other things that look like hands.
    rng
        Source of the order.

    Raises
    ------
    TypeError, ValueError
        If there is no picture, or one of them is no grey picture of the detector's size at least.
    """
    if cascade is not None:
        checks.instance("cascade", cascade, Cascade)
    windows = check_windows(windows, "windows")
    count = checks.whole("count", count, 1, 10**6)
    checks.generator("rng", rng)
    if not len(checks.instance("pictures", pictures, Sequence)):
        raise ValueError("pictures must not be empty")
    for k, image in enumerate(pictures):
        _large(f"pictures[{k}]", image)
    if cascade is None:
        some = [
            random_window(pictures[rng.integers(len(pictures))], rng=rng) for _ in range(count // 2)
        ]
        seen = np.array(some, dtype=np.uint8).reshape(-1, SIZE, SIZE)
        return np.concatenate([seen, rng.permutation(windows)[: count - count // 2]])
    hard = windows[cascade.passed(windows) == len(cascade.stages)][: count // 2]
    wanted, found = count - len(hard), []
    detector = HandDetector(cascade, scale=SCALE, step=STEP, neighbours=0)
    for k in rng.permutation(len(pictures)):
        boxes = rng.permutation(detector.windows(pictures[k])[0])[:EACH]
        found += [window_at(pictures[k], box) for box in boxes]
        if len(found) >= wanted:
            break
    seen = np.array(found[:wanted], dtype=np.uint8).reshape(-1, SIZE, SIZE)
    return np.concatenate([seen[cascade.passed(seen) == len(cascade.stages)], hard])


def _large(name: str, image: Any) -> Grey:
    """Return a grey picture in which the detector's window has room, or raise an error."""
    if min(grey_picture(name, image).shape) < SIZE:
        raise ValueError(f"{name} must be of {SIZE} px at least, got {image.shape[::-1]}")
    return image
