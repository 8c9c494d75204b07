"""The exercises of the chapter "Two opinions, one belief"."""

import numpy as np

from robot_perception import fusion
from robot_perception.chapters.covariance_intersection.weights import sonar_and_camera
from robot_perception.teaching.exercises import Exercise, Sheet

_PAIR = sonar_and_camera()

EXERCISES = Sheet(
    {
        "ci-echo": Exercise(
            0.2 / np.sqrt(16),
            mistakes=(
                (0.2, "that is what the intersection states, and what is true."),
                (0.2 / 16, "the variance falls as 1/k, the deviation as its root."),
            ),
            hint="Information adds up. What is the inverse variance after sixteen readings?",
            rtol=1e-3,
        ),
        "ci-three": Exercise(
            3.0,
            mistakes=(
                (2.0, "that is the worst case of two."),
                (9.0, "the stated variance is a third, the true one is not three times as large."),
            ),
            hint="All three errors may be one and the same. What is stated, and what is true?",
            rtol=1e-6,
        ),
        "ci-weight": Exercise(
            float(fusion.omega_least_determinant(*_PAIR)),
            mistakes=(
                (
                    float(fusion.omega_determinants(*_PAIR)),
                    "that is eq. 4; it is not where the determinant is least.",
                ),
                (
                    1 - float(fusion.omega_least_determinant(*_PAIR)),
                    "ω is the weight of the second belief, here the camera.",
                ),
            ),
            hint="Both matrices are diagonal: the determinant of the information is a product of "
            "two factors that are linear in ω.",
            rtol=5e-3,
        ),
        "ci-hits": Exercise(
            5.0,
            mistakes=(
                (4.0, "four matches leave 0.6⁴ = 0.13 missing: the weight is still below 0.9."),
                (0.9 / 0.4, "each match adds a share of what is missing, not of 1."),
            ),
            hint="The gap to 1 is multiplied by 1 − α at each match.",
            rtol=1e-6,
        ),
    }
)
check = EXERCISES.check
