"""The exercises of the chapter "A robot that remembers the ceiling"."""

import numpy as np

from robot_perception.chapters.ceiling_navigation.upto_scale import SERVO
from robot_perception.chapters.ceiling_navigation.world import MOUNT, SCALE
from robot_perception.geometry import se2
from robot_perception.teaching.exercises import Exercise, Sheet

KNOWN = np.array([1.0, 2.0, 0.3])
"""Pose of a known pattern in the mosaic, m and rad."""
SEEN_KNOWN, SEEN_NEW = np.array([200.0, 100.0, 0.5]), np.array([120.0, 150.0, 1.0])
"""Where it and a new one are seen: px, px and rad."""


def _placed(way: np.ndarray) -> np.ndarray:
    return se2.compose(KNOWN, way * [SCALE, SCALE, 1.0])


_RIGHT = _placed(se2.between(SEEN_KNOWN, SEEN_NEW))
_OVER = _placed(se2.compose(SEEN_NEW, se2.inverse(SEEN_KNOWN)))

EXERCISES = Sheet(
    {
        "nav-tilt": Exercise(
            100 * MOUNT.height * np.tan(np.deg2rad(2.0)),
            mistakes=(
                (
                    MOUNT.focal * np.tan(np.deg2rad(2.0)),
                    "that is in pixels; how far is it on the ceiling?",
                ),
                (MOUNT.height * np.tan(np.deg2rad(2.0)), "that is in metres."),
            ),
            hint="By how much does the point on the ceiling move that the optical axis meets?",
            rtol=0.01,
        ),
        "nav-pixels": Exercise(
            SERVO.gain_distance * SCALE,
            mistakes=(
                (
                    SERVO.gain_distance / SCALE,
                    "a pixel is less than a metre, and distances in pixels are large numbers.",
                ),
                (SERVO.gain_distance, "80 px ahead, this robot would race at 80 m/s."),
            ),
            hint="The speed must stay the same: k_ρ times the distance.",
            rtol=0.01,
        ),
        "nav-place": Exercise(
            _RIGHT,
            mistakes=((_OVER, "the inverse of the known sighting comes first, not last."),),
            hint="`se2.between` computes A⁻¹ B; its position is in pixels.",
            rtol=1e-3,
        ),
    }
)
check = EXERCISES.check
