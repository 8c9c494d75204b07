"""The exercises of the chapter "Colour and shape"."""

from collections.abc import Callable

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

RATIOS = (0.2, 0.5, 1.0, 1.5, 4.0)
"""Of the area found to the one predicted, on which a score is tried."""


def _is(score: Callable[[float, float], float], right: Callable[[float], float]) -> bool:
    return all(np.isclose(score(300.0, 300.0 * r), right(r)) for r in RATIOS)


def _congruent(score: Callable[[float, float], float]) -> bool:
    return _is(score, lambda r: min(1, r) / max(1, r))


def _printed(score: Callable[[float, float], float]) -> bool:
    return _is(score, lambda r: abs(1 - r) / max(1, r))


def _ratio(score: Callable[[float, float], float]) -> bool:
    return _is(score, lambda r: r) or _is(score, lambda r: 1 / r)


EXERCISES = Sheet(
    {
        "shape-freedom": Exercise(
            6,
            mistakes=(
                (4, "and where the outline lies?"),
                (12, "one map serves all points."),
            ),
            hint="An affine map is a matrix of 2 × 2 and a shift.",
        ),
        "shape-score": Exercise(
            _congruent,
            mistakes=(
                (_printed, "this is the printed score, 0 where the area is right."),
                (_ratio, "areas may be too large and too small: no score is above 1."),
            ),
            hint="It is 1 where the areas agree, and one half for twice or half the area.",
        ),
        "shape-euler": Exercise(
            -2,
            mistakes=(
                (4, "holes are subtracted."),
                (2, "parts less holes, not holes less parts."),
            ),
            hint="The Euler number is the number of parts less that of the holes.",
        ),
        "shape-enough": Exercise(
            44,
            mistakes=(
                (10, "then one is expected, and in a third of the cases there is none."),
                (43, "0.9⁴³ = 0.0108 is still above one hundredth."),
            ),
            hint="With which probability are N independent samples all too far away?",
        ),
    }
)
check = EXERCISES.check
