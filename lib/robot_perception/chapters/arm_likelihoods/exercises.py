"""The exercises of the chapter "What a likelihood looks like"."""

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

EXERCISES = Sheet(
    {
        "likelihoods-sums": Exercise(
            2.0,
            mistakes=(
                (4.0, "so much larger is D²; but σ is squared, too."),
                (float(np.sqrt(2)), "that would do for the sum of the squares."),
                (1.0, "that is the mean: it does not see how many points there are."),
            ),
            hint="Twice as many points: D is twice as large. What keeps D² / σ² as it was?",
            rtol=1e-6,
        ),
        "likelihoods-gain": Exercise(
            2.0,
            mistakes=(
                (4.0, "half of the distance to the moving edge is smaller than that."),
                (1.5, "the smaller one of 4 and half of 4."),
            ),
            hint="Compare 4 with 0.5 · 4.",
            rtol=1e-6,
        ),
        "likelihoods-coefficient": Exercise(
            float(1 - np.sqrt(1 / 8)),
            mistakes=(
                (float(np.sqrt(1 / 8)), "that is the sum; D² is one less it."),
                (1 - 1 / 8, "the square root of the product is missing."),
                (float(np.sqrt(1 - np.sqrt(1 / 8))), "that is D, not D²."),
            ),
            hint="Only one bin contributes: the root of 1 times 1/8.",
            rtol=1e-3,
        ),
    }
)
check = EXERCISES.check
