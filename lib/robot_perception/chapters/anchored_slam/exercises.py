"""The exercises of the chapter "Anchored SLAM"."""

from functools import partial

import numpy as np

from robot_perception.geometry import rotation
from robot_perception.slam.observability import Anchor, Landmarks, see
from robot_perception.teaching.exercises import Exercise, Sheet


def _is_heading_column(answer: object, sign: float = 1.0) -> bool:
    """Return whether a function of pose and point is ``sign`` times ∂h/∂φ of h = Rᵀ(p − t)."""
    if not callable(answer):
        return False
    for pose, point in (((0.3, -1.2, 0.7), (2.0, 1.5)), ((-4.0, 2.0, -2.6), (0.5, 3.0))):
        pose, point = np.array(pose), np.array(point)
        x, y = rotation(pose[2]).T @ (point - pose[:2])
        column = np.asarray(answer(pose, point), dtype=float)
        if column.shape != (2,) or not np.allclose(column, [sign * y, -sign * x]):
            return False
    return True


def _is_unseen(answer: object, of_it: tuple[float, ...] = (1, 1, 1, 1, 1)) -> bool:
    """Return whether the measurements of anchor and landmark stay the same along a direction."""
    direction = np.asarray(answer, dtype=float)
    if direction.shape != (5,) or not direction.any():
        return False
    _, H = see([Landmarks(), Anchor(1.0, 0.0)], np.array([3.0, 2.0, 0.0, 1.0, 4.0]))
    return bool(np.abs(H @ (of_it * direction)).max() < 1e-9 * np.abs(direction).max())


EXERCISES = Sheet(
    {
        "anchored-1": Exercise(
            1 / (0.03 + 0.01),
            mistakes=(
                (100, "that is the measurement of the landmark alone; from where was it taken?"),
                (1 / 0.03, "that is what the measurement of the anchor tells about the robot."),
                (1 / 0.03 + 1 / 0.01, "two measurements in a row add variances, not weights."),
            ),
            hint="The difference of the two is landmark minus anchor. What is its variance?",
            rtol=1e-6,
        ),
        "anchored-2": Exercise(
            _is_heading_column,
            mistakes=(
                (partial(_is_heading_column, sign=-1.0), "the sign: to whom does the world turn?"),
            ),
            hint="It must return two numbers: turn the robot a little to the left, and a point "
            "seen straight ahead moves to the right.",
        ),
        "anchored-turn": Exercise(
            _is_unseen,
            mistakes=(
                (partial(_is_unseen, of_it=(1, 1, -1, 1, 1)), "the heading: to which side?"),
                (
                    (0, 0, 1, -2, -2),
                    "that turns the world about the robot, and the anchor with it.",
                ),
                ((1, 0, 0, 1, 0), "a shift: the anchor cannot follow, so it is seen elsewhere."),
                ((0, 1, 0, 0, 1), "a shift: the anchor cannot follow, so it is seen elsewhere."),
            ),
            hint="Five numbers: J (t - a), then 1, then J (p - a), where J turns by a quarter.",
        ),
    }
)
check = EXERCISES.check
