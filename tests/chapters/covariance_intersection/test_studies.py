"""What the chapter's studies compute: worst cases, weights and what they cost."""

import numpy as np
import pytest

from explorables.figures import figure
from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.book import covariance_intersection as ci
from robot_perception.chapters.covariance_intersection import figures as draw

RNG = np.random.default_rng
FEW = 3


def single(belief, k):
    return Gaussian(belief.mean[k], belief.cov[k])


@pytest.mark.parametrize("name", list(ci.RULES))
def test_worst_case_is_attained_and_never_passed_by_drawn_correlations(name):
    rule = ci.RULES[name]
    a, b = ci.random_pairs(FEW, RNG(0))
    worst = ci.worst_case(rule, a, b, directions=3600)
    for k in range(FEW):
        one, other = single(a, k), single(b, k)
        half = np.linalg.inv(np.linalg.cholesky(rule(one, other).cov))
        found = []
        for turn in np.linspace(0, 2 * np.pi, 91):
            c, s = np.cos(turn), np.sin(turn)
            for M in (np.array([[c, -s], [s, c]]), np.array([[c, s], [s, -c]])):
                true = ci.true_cov(rule, one, other, M)
                found.append(np.linalg.eigvalsh(half @ true @ half.T)[-1])
        assert max(found) <= worst[k] * (1 + 1e-4)
        assert max(found) == pytest.approx(worst[k], rel=3e-3)


def test_gain_is_that_of_the_kalman_filter():
    a, b = ci.random_pairs(FEW, RNG(1))
    K = ci.gain(fusion.kalman_fusion, a, b)
    np.testing.assert_allclose(K, a.cov @ np.linalg.inv(a.cov + b.cov), rtol=1e-9)


def test_independent_errors_leave_the_kalman_filter_honest():
    a, b = ci.random_pairs(FEW, RNG(2))
    worst = ci.worst_case(fusion.kalman_fusion, a, b, reach=0.0)
    np.testing.assert_allclose(worst, 1, rtol=1e-9)


def test_axes_of_the_pairs_are_as_long_as_the_set_up_says():
    a, _ = ci.random_pairs(4000, RNG(3))
    lengths = np.log(np.linalg.eigvalsh(a.cov)) / 2
    assert lengths.std() == pytest.approx(1, rel=0.05)
    assert abs(lengths.mean()) < 0.1


def test_with_a_correlation_of_a_half_at_most_the_kalman_filter_loses_a_half_at_most():
    """As the reader is told who tries it."""
    found = ci.worst.run(sample=1, rule="Kalman", pairs=200, reach=0.5).of("ratio")
    assert found.max() == pytest.approx(1.5, abs=1e-4)
    assert found.max() <= 1.5 + 1e-9


def test_worst_of_two_is_twice_and_no_more():
    ratio = ci.overlooked.rows().of("ratio")
    assert ratio.max() == pytest.approx(2, abs=1e-6)
    assert ratio.max() <= 2 + 1e-12


def test_sonar_knows_the_distance_and_the_camera_the_direction():
    sonar, camera = ci.sonar_and_camera()
    assert sonar.cov[0, 0] < camera.cov[0, 0]
    assert sonar.cov[1, 1] > camera.cov[1, 1]
    best, kalman = ci.best(sonar, camera).cov, fusion.kalman_fusion(sonar, camera).cov
    assert fusion.omega_determinants(sonar, camera) < fusion.omega_least_determinant(sonar, camera)
    for k in range(2):
        low, high = sorted((sonar.cov[k, k], camera.cov[k, k]))
        assert kalman[k, k] < low < best[k, k] < high


def test_compared_determinants_are_those_of_the_rules():
    found = ci.weighing.one(5, pairs=FEW)
    a, b = ci.random_pairs(FEW, RNG(5))
    weights = fusion.omega_determinants(a, b), fusion.omega_least_determinant(a, b)
    at_4, at_best = (ci.det(fusion.covariance_intersection(a, b, w).cov) for w in weights)
    np.testing.assert_allclose(found["excess"], at_4 / at_best)
    better = np.minimum(ci.det(a.cov), ci.det(b.cov))
    np.testing.assert_array_equal(found["worse"], at_4 > better)


def test_a_weight_at_an_end_makes_equation_4_worse_than_the_better_belief_alone():
    """Of the pairs with such a weight; of equal ones, which no draw gives, it is not so."""
    rows = ci.weighing.rows()
    assert rows.where(**{"one alone": True}).rate("worse").estimate > 0.99
    assert rows.where(**{"one alone": False}).rate("worse").estimate < 0.5


def test_the_error_that_is_left_is_that_of_drawn_errors():
    """The closed form against a million draws of independent errors of one pair.

    It is one of which the two weights make something different.
    """
    rng = RNG(3)
    a, b = ci.random_pairs(1, rng)
    weights = fusion.omega_determinants(a, b), fusion.omega_least_determinant(a, b)
    drawn = [rng.multivariate_normal([0, 0], one.cov[0], 10**6) for one in (a, b)]
    left = []
    for omega in weights:
        inverses = ((1 - omega) * np.linalg.inv(a.cov[0]), omega * np.linalg.inv(b.cov[0]))
        mean = sum(x @ inverse for x, inverse in zip(drawn, inverses, strict=True))
        mean = mean @ np.linalg.inv(sum(inverses))
        left.append(np.sqrt((mean**2).sum(axis=1).mean()))
    assert left[0] > 1.5 * left[1]
    for omega, expected in zip(weights, left, strict=True):
        assert ci.error(a, b, omega)[0] == pytest.approx(expected, rel=0.005)


def test_pairs_that_are_made_for_equation_4_are_so():
    for made in ("equal determinants", "the second case"):
        excess = ci.weighing.one(6, pairs=50, made=made)["excess"]
        np.testing.assert_allclose(excess, 1, rtol=1e-9)


def test_what_is_reduced_is_so_with_any_weight_but_by_another_share():
    rows = ci.reduced.rows()
    assert rows.of("exchanged").max() < 1
    gained = rows.of("share") / rows.of("exchanged")
    assert np.quantile(gained, 0.5) < 0.5
    assert np.quantile(gained, 0.95) < 1


def test_weight_of_a_hypothesis_is_drawn_against_its_thresholds():
    _, ax = figure()
    draw.certainty.on(ax, np.arange(3.0), np.array([0.1, 0.5, 0.2]), 0.4, 0.15)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), [0.1, 0.5, 0.2])
    assert [set(line.get_ydata()) for line in ax.lines[1:]] == [{0.4}, {0.15}]
