"""The exercises of the chapter "Round the loop"."""

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

_BEND, _WAY, _FROZEN, _SIGMA = np.deg2rad(0.5), 88.3, 0.10, 0.03
_PLACE, _TURN, _AHEAD = 0.10, np.deg2rad(3.0), 4.0

EXERCISES = Sheet(
    {
        "loop-drift": Exercise(
            _BEND * np.sqrt(_WAY**3 / 3),
            mistakes=(
                (_BEND * np.sqrt(_WAY) * _WAY, "that is the last heading error held all the way."),
                (0.5 * np.sqrt(_WAY**3 / 3), "degrees: the heading must be in radians."),
                (
                    _BEND * np.sqrt(_WAY),
                    "that is the heading at the end, in radians, not the position.",
                ),
            ),
            hint="Each metre driven adds its own error of the heading, and it moves all that "
            "follows: add up σ² (L − s)² over the path s.",
            rtol=0.02,
        ),
        "loop-frozen": Exercise(
            (_FROZEN**2 + _SIGMA**2) / _SIGMA**2,
            mistakes=(
                (_FROZEN**2 / _SIGMA**2, "the measurement has an error, too."),
                (_SIGMA**2 / (_FROZEN**2 + _SIGMA**2), "upside down: real over claimed."),
                (1.0, "that it would be if the frozen place were right."),
            ),
            hint="The filter claims the variance of the measurement alone. What is the real one?",
            rtol=1e-3,
        ),
        "loop-start": Exercise(
            np.sqrt(_PLACE**2 + (_AHEAD * _TURN) ** 2 + _SIGMA**2) / _SIGMA,
            mistakes=(
                (
                    np.sqrt(_PLACE**2 + _SIGMA**2) / _SIGMA,
                    "the heading: 3° at 4 m move a landmark sideways, too.",
                ),
                (
                    (_PLACE + _AHEAD * _TURN + _SIGMA) / _SIGMA,
                    "independent errors add their variances, not their deviations.",
                ),
                (
                    np.sqrt(_PLACE**2 + (_AHEAD * 3.0) ** 2 + _SIGMA**2) / _SIGMA,
                    "degrees: the heading must be in radians.",
                ),
            ),
            hint="Three independent errors move the landmark sideways from an uncertain start; "
            "one is left from an exact one.",
            rtol=0.02,
        ),
    }
)
check = EXERCISES.check
