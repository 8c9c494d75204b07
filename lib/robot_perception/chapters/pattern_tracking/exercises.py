"""The exercises of the chapter "Tracking a pattern"."""

import numpy as np
from scipy.stats import norm

from robot_perception.teaching.exercises import Exercise, Sheet

_FIRST, _SECOND = np.array([10.0, 20.0, 60.0]), np.array([50.0, 60.0, 100.0])

EXERCISES = Sheet(
    {
        "pattern-offset": Exercise(
            float(_FIRST @ _SECOND / np.linalg.norm(_FIRST) / np.linalg.norm(_SECOND)),
            mistakes=(
                (1.0, "that is the correlation once the means are removed."),
                (float(_FIRST @ _SECOND), "divide by both norms."),
            ),
            hint="V · V' over the product of the norms, with the means left in.",
            rtol=1e-3,
        ),
        "pattern-deviation": Exercise(
            2.0,
            mistakes=(
                (0.4, "that is the loss of correlation; divide it by the slope."),
                (3.0, "the line starts at 1, not at 0."),
            ),
            hint="Solve 1 − a λ = 0.6.",
            rtol=1e-6,
        ),
        "pattern-draws": Exercise(
            float(200 * 2 * norm.sf(3)),
            mistakes=(
                (float(200 * norm.sf(3)), "that is one side only."),
                (float(2 * norm.sf(3)), "that is the share; there are 200 particles."),
            ),
            hint="`scipy.stats.norm.sf(3)` is the share beyond 3σ on one side.",
            rtol=0.02,
        ),
        "pattern-blur": Exercise(
            float(np.sqrt(3.0)),
            mistakes=(
                (2.0, "that takes a blur of one pixel beyond two: variances add."),
                (1.0, "deviations do not add, variances do."),
            ),
            hint="A blur of 1 px in the model is one of s px in a picture s times as large. What "
            "is missing from 1 px to s px?",
            rtol=1e-3,
        ),
    }
)
check = EXERCISES.check
