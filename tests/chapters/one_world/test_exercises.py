"""The answers of the exercises are what the code says."""

import numpy as np

from robot_perception.book import one_world as page
from robot_perception.slam.planar import MapBelief
from tests.chapters.exercises import assert_judged, assert_told


def test_a_reading_is_let_in_above_the_answer():
    state = MapBelief(np.zeros(23), np.eye(23), np.arange(10))
    least = page.EXERCISES["world-worth"].answer
    n, C = state.mean.size, np.diag([0.1, 0.3])
    assert page.weight(0.999 * least * C, C, n) == 0
    assert page.weight(1.001 * least * C, C, n) > 0


def test_particles_keep_as_many_numbers_as_their_maps_hold():
    run = page.round_posts(page.USUAL, page.chance(1))
    ride = page.guessed(run, page.USUAL, 3, page.chance(2))
    rows = page.raced.one(0, "linear")
    most = dict(zip(rows["filter"], rows["numbers"], strict=True))
    assert most["200 particles"] == 200 * (4 + 5 * len(ride.names))
    assert len(ride.names) == 30
    assert page.EXERCISES["world-numbers"].answer == 500 * (4 + 5 * 50)


def test_the_solution_of_the_code_exercise_is_right_and_kalmans_update_is_hinted_at():
    inverse = np.linalg.inv

    def intersect(P, H, C, w):
        return inverse((1 - w) * inverse(P) + w * H.T @ inverse(C) @ H)

    exercise = page.EXERCISES["world-intersect"]
    assert_judged(exercise, intersect)
    kalman = lambda P, H, C, w: inverse(inverse(P) + H.T @ inverse(C) @ H)  # noqa: E731
    assert_told(exercise, kalman, "independent")


def test_a_soft_weight_does_as_well_as_the_gate_and_no_gate_is_told_apart():
    exercise = page.EXERCISES["world-trust"]
    assert_judged(exercise, lambda d: (1 + d / 15) ** 2)
    assert_told(exercise, np.ones_like, "take the path along")
    assert_told(exercise, lambda d: 1 + 5 * d, "with right names")
    assert exercise.judge(lambda d: np.where(d < 9.2, 1, np.inf))[0] == "wrong"


def test_the_filter_that_trusts_all_names_is_that_of_the_chapter():
    told = page.rough(0)[0]
    path = page.path_of("Kalman", told, page.ROUGH, 0)
    np.testing.assert_allclose(page.trusting(told, np.ones_like), path, atol=1e-9)
    gate = page.TRUSTS["a gate of five deviations"]
    told = page.rough(16)[0]
    path = page.path_of("Kalman, gate", told, page.ROUGH, 0)
    np.testing.assert_allclose(page.trusting(told, gate), path, atol=1e-6)
