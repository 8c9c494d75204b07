"""Scene that notebook, recordings and tests share: the camera, the detector, the rules."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from data_synth.companion.hall import RobotCamera
from robot_perception.chapters.tutor_following.training import RENDERED, stored
from robot_perception.companion.boxes import overlap
from robot_perception.companion.hands.cascade import HandDetector
from robot_perception.companion.tutor import TutorRules

CAMERA = RobotCamera()
SAME = 0.4
"""A detection is at what it should be at if they overlap by that (intersection over union); ours"""
RULES = TutorRules(gate=0.3, whole_gate=0.4)
"""Rules of the tracker with several patches; the gates are chosen on the films to choose on."""
FREE = {"gate": 1.0, "whole_gate": 1.0}
"""Gates that let every picture be learnt."""


@lru_cache(maxsize=2)
def hands(name: str = RENDERED) -> HandDetector:
    """Return a detector of open hands that this book has trained."""
    return HandDetector(stored(name).cascade)


def at(boxes: Float[np.ndarray, "n 4"], truth: Float[np.ndarray, " 4"]) -> np.ndarray:
    """Tell which boxes are at something (n,); none is if it is not there."""
    if not len(boxes) or not np.isfinite(truth).all():
        return np.zeros(len(boxes), dtype=bool)
    return overlap(boxes, truth[None])[:, 0] >= SAME
