"""The exercises of the chapter."""

from itertools import count

import numpy as np

from robot_perception.chapters.monobot.rail import GOLDEN, limit
from robot_perception.kalman import fisher_information, scale_free_rank
from robot_perception.slam.monobot import sensor_matrix, settled
from robot_perception.teaching.exercises import Exercise, Sheet


def _landmarks_for(share: float) -> int:
    """Return the least n whose landmark variance is within a share of the floor, P0 = V = W = 1."""
    return next(n for n in count(1) if limit(n).landmark_variance <= 1 + share)


def _restores_rank(row: object) -> bool:
    """Return whether one more row makes the information of two landmarks regular."""
    extra = np.asarray(row, dtype=float)
    if extra.shape != (3,):
        return False
    matrix = np.vstack([extra, sensor_matrix(2)])
    return bool(scale_free_rank(fisher_information(matrix, np.eye(3)[None])[-1]) == 3)


EXERCISES = Sheet(
    {
        "monobot-1": Exercise(
            1 / GOLDEN,
            mistakes=(
                (GOLDEN, "that is the variance before the measurement; ask for the one after it."),
                (GOLDEN**-2, "that is the pole, by which errors shrink."),
                (1.0, "that is the variance after the very first measurement; it still shrinks."),
            ),
            hint="After a move and a measurement p becomes (p + 1) / (p + 2). Where does it stay?",
            rtol=1e-4,
        ),
        "monobot-2": Exercise(
            _restores_rank,
            mistakes=(
                (
                    lambda row: np.allclose(np.sum(row), 0),
                    "its entries add up to zero, so it cannot feel a shift of the world either.",
                ),
            ),
            hint="It must be a row of three numbers: vehicle, first landmark, second landmark.",
        ),
        "monobot-3": Exercise(
            settled(
                4, start_variance=0.25, motion_variance=1, measurement_variance=1
            ).landmark_variance,
            mistakes=(
                (limit(1).landmark_variance, "that is one landmark and P0 = 1."),
                (0.25, "that is the floor; four landmarks do not reach it."),
            ),
            hint="P0 + W/n · a/(a + W), with a = (nV + √(n²V² + 4nVW))/2.",
            rtol=1e-4,
        ),
        "monobot-4": Exercise(
            _landmarks_for(0.01),
            mistakes=(
                (_landmarks_for(0.01) - 1, "one more is needed: within means at most."),
                (_landmarks_for(0.1), "that is ten per cent."),
            ),
            hint="Ask `settled` for its landmark_variance and raise n until it is at most 1.01.",
        ),
    }
)
check = EXERCISES.check
