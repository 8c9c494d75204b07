"""The exercises judge right and wrong answers, each wrong one with words of its own."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot_perception.chapters.anchored_slam.exercises import EXERCISES


def seen(pose, point):
    """Return the point in the frame of the robot, by SciPy's rotations."""
    away = np.append(point - pose[:2], 0.0)
    return Rotation.from_euler("z", pose[2]).inv().apply(away)[:2]


def heading_column(pose, point):
    ahead, aside = seen(pose, point)
    return np.array([aside, -ahead])


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("anchored-1", 25, [100, 1 / 0.03, 1 / 0.03 + 100, 7]),
        (
            "anchored-2",
            heading_column,
            [
                lambda pose, point: -heading_column(pose, point),
                lambda pose, point: point,
                lambda pose, point: np.zeros(3),
                3.0,
            ],
        ),
    ],
)
def test_exercises_judge_right_and_wrong(key, right, wrong):
    exercise = EXERCISES[key]
    assert exercise.judge(right)[0] == "right"
    assert exercise.judge(...)[0] == "not yet"
    for answer in wrong:
        outcome, words = exercise.judge(answer)
        assert outcome == "wrong"
        assert len(words) > 20


def test_typical_mistakes_have_hints_of_their_own():
    words = {EXERCISES["anchored-1"].judge(w)[1] for w in (100, 1 / 0.03, 1 / 0.03 + 100, 7)}
    assert len(words) == 4
    turned = EXERCISES["anchored-2"].judge(lambda *given: -heading_column(*given))[1]
    assert "sign" in turned


def test_turn_about_the_anchor_is_judged_by_what_is_seen():
    exercise = EXERCISES["anchored-turn"]
    assert exercise.judge([-2, 2, 1, -4, 0])[0] == "right"
    assert exercise.judge([1, -1, -0.5, 2, 0])[0] == "right"
    hints = {
        exercise.judge(answer)[1]
        for answer in ([-2, 2, -1, -4, 0], [0, 0, 1, -2, -2], [1, 0, 0, 1, 0], [0] * 5, [1, 2])
    }
    assert len(hints) == 4  # the last two get the general hint
    assert all(exercise.judge(answer)[0] == "wrong" for answer in ([0] * 5, [1, 2], "north"))


def test_chapter_asks_each_exercise_once():
    notebook = Path(__file__).parents[3] / "book" / "anchored_slam.ipynb"
    asked = re.findall(r'check\(\\"(.+?)\\",', notebook.read_text(encoding="utf-8"))
    assert sorted(asked) == sorted(EXERCISES)
