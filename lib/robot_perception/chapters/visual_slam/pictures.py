"""Some of the pictures of the drive, kept on this computer: to show, not to compute with."""

from dataclasses import dataclass
from itertools import islice

import numpy as np
from jaxtyping import UInt8

from robot_perception.chapters.visual_slam import frontend
from robot_perception.teaching.results import kept

EVERY = 10
"""Frames from one picture to the next."""


@dataclass(frozen=True, eq=False, slots=True)
class Film:
    """Pictures of the left camera: every tenth of the drive.

    Parameters
    ----------
    left : (pictures, height, width)
        Grey values.
    """

    left: UInt8[np.ndarray, "pictures height width"]


@kept
def film() -> Film:
    """Render the drive and return some of the pictures."""
    return Film(
        np.stack([pair.left for pair in islice(frontend.pictures(frontend.PAPER), 0, None, EVERY)])
    )
