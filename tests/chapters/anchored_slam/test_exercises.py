"""The exercises judge right and wrong answers, each wrong one with words of its own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot_perception.book.anchored_slam import EXERCISES


def heading_column(pose, point):
    """Return the derivative of what is seen, by SciPy's rotations."""
    away = np.append(point - pose[:2], 0.0)
    ahead, aside, _ = Rotation.from_euler("z", pose[2]).inv().apply(away)
    return np.array([aside, -ahead])


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        (
            "anchored-2",
            [heading_column],
            [
                lambda pose, point: -heading_column(pose, point),
                lambda pose, point: point,
                lambda pose, point: np.zeros(3),
                3.0,
            ],
        ),
        (
            "anchored-turn",
            [[-2, 2, 1, -4, 0], [1, -1, -0.5, 2, 0]],
            [[-2, 2, -1, -4, 0], [0, 0, 1, -2, -2], [1, 0, 0, 1, 0], [0] * 5, [1, 2], "north"],
        ),
    ],
)
def test_answers_are_judged_by_what_is_seen(key, right, wrong):
    exercise = EXERCISES[key]
    assert all(exercise.judge(answer)[0] == "right" for answer in right)
    judged = [exercise.judge(answer) for answer in wrong]
    assert {outcome for outcome, _ in judged} == {"wrong"}
    assert len({words for _, words in judged}) > len({words for _, words in exercise.mistakes})
    assert all(len(words) > 20 for _, words in judged)
