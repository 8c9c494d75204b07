"""The exercises of the chapter "A map from two eyes"."""

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

_FOCAL, _BASELINE, _DEPTH, _SIGMA = 280.0, 0.15, 4.0, 0.5

EXERCISES = Sheet(
    {
        "slam-depth": Exercise(
            _DEPTH**2 / (_FOCAL * _BASELINE) * np.sqrt(2) * _SIGMA,
            mistakes=(
                (
                    _DEPTH**2 / (_FOCAL * _BASELINE) * _SIGMA,
                    "both columns err: the disparity has √2 times the deviation of one.",
                ),
                (
                    _DEPTH / (_FOCAL * _BASELINE) * np.sqrt(2) * _SIGMA,
                    "the derivative of 1/d brings the square of the depth.",
                ),
            ),
            hint="z = f b / d, so a small error of d moves z by z² / (f b) times that error.",
            rtol=0.02,
        ),
        "slam-number": Exercise(
            1 / (0.5**2 + 2 * 0.25**2),
            mistakes=(
                (1.0, "that is what the paper prints: the weights add up to one."),
                (0.5**2 + 2 * 0.25**2, "upside down."),
                (3.0, "they do not all count alike."),
            ),
            hint="One over the sum of the squares.",
            rtol=1e-3,
        ),
        "slam-one": Exercise(
            np.sqrt(2.0),
            mistakes=(
                (2.0, "variances add, not deviations."),
                (1.0, "the particle draws an error of its own on top of that of the wheels."),
            ),
            hint="The particle moves by what the wheels report, which errs, plus a draw of the "
            "same spread. The two are independent.",
            rtol=0.01,
        ),
    }
)
check = EXERCISES.check
