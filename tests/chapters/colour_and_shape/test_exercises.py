"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.appearance.segmentation import euler_number
from robot_perception.appearance.shape_scores import log_weight
from robot_perception.book.colour_and_shape import EXERCISES


def test_a_piece_with_three_holes_has_the_number_of_the_exercise():
    mask = np.ones((5, 11), dtype=bool)
    mask[2, [2, 5, 8]] = False
    assert euler_number(mask) == EXERCISES["shape-euler"].answer


def test_samples_of_the_exercise_are_just_enough():
    enough = EXERCISES["shape-enough"].answer
    assert 0.9**enough <= 0.01 < 0.9 ** (enough - 1)


@pytest.mark.parametrize(
    ("score", "words"),
    [
        (lambda predicted, found: min(predicted, found) / max(predicted, found), "Right"),
        (lambda p, found: abs(p - found) / max(p, found), "the printed score"),
        (lambda p, found: found / p, "too large and too small"),
        (lambda p, found: p / found, "too large and too small"),
        (lambda p, found: 1.0, "one half"),
    ],
)
def test_scores_of_an_area_are_told_apart(score, words):
    assert words in EXERCISES["shape-score"].judge(score)[1]


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
