"""Some of the pictures of the drive, kept on this computer: to show, not to compute with."""

from dataclasses import dataclass
from functools import cache
from itertools import islice

import numpy as np
from jaxtyping import UInt8

import data_synth
from robot_perception.chapters.visual_slam import frontend
from robot_perception.teaching.kept import kept

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


@cache
def film() -> Film:
    """Return some of the pictures of the drive."""
    return kept(record_film, Film, frontend.PAPER, EVERY, code=(data_synth,))


def record_film(config: frontend.Config, every: int) -> Film:
    """Render the drive and keep some pictures."""
    return Film(np.stack([pair.left for pair in islice(frontend.pictures(config), 0, None, every)]))
