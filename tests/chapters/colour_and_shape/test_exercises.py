"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.appearance.segmentation import euler_number
from robot_perception.appearance.shape_scores import log_weight
from robot_perception.book.colour_and_shape import EXERCISES, overlap_by


def test_a_piece_with_three_holes_has_the_number_of_the_exercise():
    mask = np.ones((5, 11), dtype=bool)
    mask[2, [2, 5, 8]] = False
    assert euler_number(mask) == EXERCISES["shape-euler"].answer


def test_samples_of_the_exercise_are_just_enough():
    enough = EXERCISES["shape-enough"].answer
    assert 0.9**enough <= 0.01 < 0.9 ** (enough - 1)


def test_three_points_fix_an_affine_map_and_two_do_not():
    points = np.random.default_rng(0).standard_normal((4, 3))
    points[:, 2] = 1.0
    answer = EXERCISES["shape-freedom"].answer
    assert np.linalg.matrix_rank(points[:answer]) == 3 > np.linalg.matrix_rank(points[: answer - 1])


def test_cells_are_told_by_shares_of_inside_and_around():
    """The page's own rule, and one that compares numbers, lose a beetle."""
    judge = EXERCISES["shape-belongs"].judge
    assert judge(lambda inside, around: inside / inside.sum() > around / around.sum())[0] == "right"
    assert judge(lambda inside, around: inside > around)[0] == "wrong"
    assert overlap_by(lambda inside, around: inside > 0, 4101) < 0.1


def heavy(rho, sigma):
    """Return the library's weights, of a sample without a piece 0."""
    return np.append(np.exp(log_weight(rho[:-1], sigma)), 0.0)


@pytest.mark.parametrize(
    ("weigh", "words"),
    [
        (lambda rho, sigma: heavy(rho, sigma) / heavy(rho, sigma).sum(), "Right"),
        (lambda rho, sigma: heavy(rho, sigma), "their sum is 1"),
        (lambda rho, sigma: np.ones(4) / 4, "exp(−ρ²/2σ²)"),
    ],
)
def test_weights_are_those_of_the_library_with_sum_1(weigh, words):
    assert words in EXERCISES["shape-weights"].judge(weigh)[1]
