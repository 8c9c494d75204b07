"""The exercises of the chapter "Two arms, one camera"."""

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

EXERCISES = Sheet(
    {
        "arms-depth": Exercise(
            float(np.degrees(np.arccos(0.9))),
            mistakes=(
                (90 - float(np.degrees(np.arccos(0.9))), "measured from the picture's plane."),
                (10.0, "the length in the picture falls with the cosine, not in proportion."),
            ),
            hint="What remains in the picture is the length times the cosine of the angle.",
            rtol=0.01,
        ),
        "arms-grid": Exercise(
            float(10**8),
            mistakes=(
                (80.0, "each angle multiplies the number of cells."),
                (float(8**10), "it is ten to the power of eight, not eight to that of ten."),
            ),
            hint="Ten values of the first angle, for each of them ten of the second, and so on.",
            rtol=1e-6,
        ),
        "arms-weights": Exercise(
            0.5,
            mistakes=(
                (2.0, "upside down: divide by what the particle was drawn by."),
                (0.1, "the likelihood is divided by the look ahead, not multiplied."),
            ),
            hint="Likelihood after the motion, over what the look ahead gave it.",
            rtol=1e-6,
        ),
    }
)
check = EXERCISES.check
