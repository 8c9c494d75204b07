"""The exercises of the chapter "A head by its colours"."""

from robot_perception.chapters.head_tracking.incremental import additions, savings
from robot_perception.teaching.exercises import Exercise, Sheet

_FULL, _CARRIED = additions(30, 8)

EXERCISES = Sheet(
    {
        "head-half": Exercise(
            1.0,
            mistakes=(
                (0.5, "eq. 28 divides by the pixels of the candidate, not of the model."),
                (0.25, "that is its area; eq. 28 asks which of its pixels the model has."),
            ),
            hint="Are there as many pixels of each colour in the model as in the candidate?",
            rtol=1e-6,
        ),
        "head-forget": Exercise(
            7,
            mistakes=(
                (5, "0.9⁵ = 0.59: more than half of the first frame is still there."),
                (10, "a = 0.1 does not mean that ten frames replace the model."),
            ),
            hint="After k frames (1 − a)ᵏ of the first one is left.",
        ),
        "head-saving": Exercise(
            _FULL / _CARRIED,
            mistakes=(
                (_CARRIED / _FULL, "that is what is left; what is the ratio the other way round?"),
                (
                    float(savings((30,), 0.0)[0]),
                    "that is the saving of one step alone; the first ellipse is counted in full.",
                ),
            ),
            hint="`incremental.additions(30, 8)` counts both.",
            rtol=0.01,
        ),
    }
)
check = EXERCISES.check
