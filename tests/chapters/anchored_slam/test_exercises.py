"""The exercises judge right and wrong answers, each wrong one with words of its own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot_perception.book.anchored_slam import (
    EXERCISES,
    SIGMA,
    circling,
    guarded,
    invented_by,
    rng,
)
from robot_perception.slam import planar
from tests.chapters.exercises import assert_judged, assert_told


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


def protected(H, N):
    return H - np.outer(H @ N, N) / (N @ N)


def test_a_jacobian_that_is_blind_to_the_turn_invents_nothing_and_loses_nothing():
    exercise = EXERCISES["anchored-protect"]
    assert_judged(exercise, protected)
    assert_told(exercise, lambda H, N: H, "claims more")
    assert_told(exercise, lambda H, N: 0 * H, "is lost")
    plain, own = invented_by(lambda H, N: H), invented_by(protected)
    assert round(plain[0]) == 102
    assert np.round([plain[2], own[2]], 2).tolist() == [0.2, 0.13]
    assert own[1] < 1.001


def test_the_filter_of_the_exercise_is_the_plain_one_if_nothing_is_protected():
    run = circling(rng(3))
    settings = planar.Settings(
        planar.CartesianSensor(SIGMA**2 * np.eye(2)), anchors={0: run.places[0]}
    )
    history = planar.run_filter(run.start, run.steps[:40], settings)
    off = history.belief.pose[:2] - run.path[40, :2]
    assert guarded(run, lambda H, N: H, 40)[1] == pytest.approx(np.hypot(*off), abs=1e-6)
