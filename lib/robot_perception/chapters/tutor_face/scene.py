"""Seeds and numbers that this chapter shares with "Follow me", and pictures as both want them."""

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from robot_perception.companion.boxes import crop

CHOOSING = tuple(range(100, 140))
"""Seeds of the people and films on which numbers were chosen."""
SCORED = tuple(range(5000, 5400))
"""Seeds of the people and films on which they are scored."""
SAME = 0.4
"""A detection is of a face if it overlaps its box by that (intersection over union); ours."""
EIGENIMAGES = 20
"""Section III."""


def cut(image: UInt8[np.ndarray, "rows columns"], box: Float[np.ndarray, " 4"]) -> np.ndarray:
    """Return the face in a box, as the recogniser wants it."""
    return crop(image, box)


def grey(frame: UInt8[np.ndarray, "rows columns 3"]) -> UInt8[np.ndarray, "rows columns"]:
    """Return a picture without its colours."""
    return cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)
