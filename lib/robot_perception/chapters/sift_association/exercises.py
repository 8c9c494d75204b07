"""The exercises of the chapter "Which landmark is this?"."""

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

_FOCAL, _BASELINE, _DEPTH, _SIGMA = 280.0, 0.15, 5.0, 0.5
_SPREAD = _SIGMA * _DEPTH**2 / (_FOCAL * _BASELINE)
_P, _LENGTH = 5, 128
_STRANGER = _LENGTH * (1 + 1 / _P) * (_P - 1) / (_P - 3)

EXERCISES = Sheet(
    {
        "sift-depth": Exercise(
            np.sqrt(2) * _SPREAD,
            mistakes=(
                (_SPREAD, "a disparity is the difference of two columns, and both have noise."),
                (
                    np.sqrt(2) * _SPREAD / _DEPTH,
                    "the derivative of f b / d is f b / d², so the depth comes in squared.",
                ),
            ),
            hint="The depth is f b over the disparity. What is the derivative, and what is the "
            "standard deviation of the disparity?",
            rtol=0.02,
        ),
        "sift-law": Exercise(
            _STRANGER,
            mistakes=(
                (_LENGTH * (1 + 1 / _P), "that it would be with the variance known."),
                (_STRANGER / (1 + 1 / _P), "the mean of the class has an error, too: 1 + 1/p."),
                (float(_LENGTH), "that is the number of entries; mean and variance are estimates."),
            ),
            hint="The mean of an F variable with 1 and ν degrees of freedom is ν / (ν − 2).",
            rtol=1e-3,
        ),
        "sift-own": Exercise(
            (_P - 1) * _LENGTH / _P,
            mistakes=(
                (float(_LENGTH), "divide by p − 1 in the variance, and average over p."),
                (
                    _STRANGER,
                    "that is a new descriptor's; this one was among those that made the class.",
                ),
            ),
            hint="Add up L over the p descriptors: what is the sum of (d − mean)² over s²?",
            rtol=1e-3,
        ),
    }
)
check = EXERCISES.check
