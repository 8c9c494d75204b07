"""The law of eq. (9) against samples."""

import numpy as np
import pytest

from robot_perception.book import sift_association as law
from robot_perception.book.sift_association import classes_of, decide
from robot_perception.landmarks import Mahalanobis

RNG = np.random.default_rng


@pytest.mark.parametrize("p", [8, 12, 30])
def test_expected_distance_is_the_mean_of_many(p):
    rng = RNG(p)
    stacks = rng.standard_normal((4000, p, law.LENGTH))
    found = rng.standard_normal((4000, law.LENGTH))
    apart = (found - stacks.mean(axis=1)) ** 2 / stacks.var(axis=1, ddof=1)
    values = apart.sum(axis=1)
    error = values.std() / np.sqrt(len(values))
    assert abs(values.mean() - law.expected_distance(p)) < 5 * error


def test_expected_distance_is_infinite_up_to_three_frames_and_that_of_known_variances_in_the_end():
    assert law.expected_distance(2) == law.expected_distance(3) == np.inf
    assert law.expected_distance(10**6) == pytest.approx(law.LENGTH, rel=1e-4)


@pytest.mark.parametrize("p", [3, 10])
def test_spread_is_that_of_many_variances(p):
    sample = RNG(1).standard_normal((200_000, p)).var(axis=1, ddof=1)
    assert sample.std() == pytest.approx(law.variance_spread(p), rel=0.02)


def test_estimated_variances_cost_right_answers_and_known_ones_do_not():
    """Of a class of p frames and 200 rivals, 10 away; all entries have the variance 1."""
    shares = {}
    for p in (3, 10):
        rng, won = RNG(2), np.zeros(2)
        for _ in range(100):
            away = rng.standard_normal((201, law.LENGTH))
            away *= 10 / np.linalg.norm(away, axis=1, keepdims=True)
            away[0] = 0
            classes = classes_of(away[:, None] + rng.standard_normal((201, p, law.LENGTH)))
            found = rng.standard_normal((1, law.LENGTH))
            known = Mahalanobis(classes.means, np.ones_like(classes.means))
            for k, model in enumerate((decide("raw", classes), known)):
                won[k] += model.two_nearest(found).classes[0, 0] == 0
        shares[p] = won / 100
    assert shares[3][0] < shares[10][0] <= 1.0
    assert shares[3][1] > shares[3][0] + 0.2
