"""The exercises of the chapter "Is it you?"."""

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

_FACES = np.array([[1.0, 2.0], [3.0, 2.0], [1.0, 6.0], [3.0, 6.0]])

EXERCISES = Sheet(
    {
        "tutor-eigen": Exercise(
            float(np.linalg.svd(_FACES - _FACES.mean(axis=0))[1][0] ** 2
                  / np.sum((_FACES - _FACES.mean(axis=0)) ** 2)),
            mistakes=(
                (0.5, "the two pixels do not vary alike: look at their spreads."),
                (2 / 3, "that is a ratio of deviations; variances go with their squares."),
            ),
            hint="Remove the mean face. Along which pixel do the faces vary more?",
            rtol=1e-3,
        ),
        "tutor-space": Exercise(
            5.0,
            mistakes=(
                (10.0, "what lies in the space and what is left are at right angles: Pythagoras."),
                (100.0, "that is its square before the square root of what is left."),
            ),
            hint="|Φ|² is the squared length in the space plus the squared distance from it.",
            rtol=1e-6,
        ),
        "tutor-window": Exercise(
            float(320 * 240 / (2 * (0.8 * 50 + 3 * 4)) ** 2),
            mistakes=(
                (320 * 240 / (2 * 0.8 * 50) ** 2, "add three standard deviations on each side."),
                (320 * 240 / (0.8 * 50 + 3 * 4) ** 2, "that is half of the window's side."),
            ),
            hint="The window reaches 0.8 sides and 3σ from the middle, to both sides.",
            rtol=0.01,
        ),
    }
)  # fmt: skip
check = EXERCISES.check
