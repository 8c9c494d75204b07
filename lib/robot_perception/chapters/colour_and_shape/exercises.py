"""The exercises of the chapter "Colour and shape"."""

from robot_perception.teaching.exercises import Exercise, Sheet

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
