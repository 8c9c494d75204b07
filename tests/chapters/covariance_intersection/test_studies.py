"""The studies: worst cases, weights, and what is drawn for them."""

import numpy as np
import pytest

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.covariance_intersection import consistency, weights
from robot_perception.chapters.covariance_intersection import figures as draw
from robot_perception.teaching.figures import figure

RNG = np.random.default_rng
FEW = 3


def single(belief, k):
    return Gaussian(belief.mean[k], belief.cov[k])


@pytest.mark.parametrize("name", list(consistency.RULES))
def test_worst_case_is_attained_and_never_passed_by_drawn_correlations(name):
    rule, rng = consistency.RULES[name], RNG(0)
    a, b = consistency.pairs(FEW, rng=rng)
    worst = consistency.worst_case(rule, a, b, directions=3600)
    for k in range(FEW):
        one, other = single(a, k), single(b, k)
        half = np.linalg.inv(np.linalg.cholesky(rule(one, other).cov))
        found = []
        for turn in np.linspace(0, 2 * np.pi, 91):
            c, s = np.cos(turn), np.sin(turn)
            for M in (np.array([[c, -s], [s, c]]), np.array([[c, s], [s, -c]])):
                true = consistency.true_cov(rule, one, other, M)
                found.append(np.linalg.eigvalsh(half @ true @ half.T)[-1])
        assert max(found) <= worst[k] * (1 + 1e-4)
        assert max(found) == pytest.approx(worst[k], rel=3e-3)


def test_gain_is_that_of_the_kalman_filter():
    a, b = consistency.pairs(FEW, rng=RNG(1))
    K = consistency.gain(fusion.kalman_fusion, a, b)
    np.testing.assert_allclose(K, a.cov @ np.linalg.inv(a.cov + b.cov), rtol=1e-9)


def test_independent_errors_leave_the_kalman_filter_honest():
    a, b = consistency.pairs(FEW, rng=RNG(2))
    worst = consistency.worst_case(fusion.kalman_fusion, a, b, reach=0.0)
    np.testing.assert_allclose(worst, 1, rtol=1e-9)


def test_axes_of_the_pairs_are_as_long_as_the_set_up_says():
    a, _ = consistency.pairs(4000, 0.5, rng=RNG(3))
    lengths = np.log(np.linalg.eigvalsh(a.cov)) / 2
    assert lengths.std() == pytest.approx(0.5, rel=0.05)
    assert abs(lengths.mean()) < 0.05


def test_worst_table_counts_the_overconfident_pairs():
    table = consistency.worst_table(consistency.run(consistency.Config(pairs=50), rng=RNG(4)))
    assert table["Kalman", "overconfident"].estimate == 1
    assert table["Kalman", "largest"] <= 2 + 1e-9
    for name in ("intersection, eq. 4", "intersection, best ω"):
        assert table[name, "overconfident"].estimate == 0
        assert table[name, "largest"] <= 1 + 1e-9


def test_sonar_knows_the_distance_and_the_camera_the_direction():
    sonar, camera = weights.sonar_and_camera()
    assert sonar.cov[0, 0] < camera.cov[0, 0]
    assert sonar.cov[1, 1] > camera.cov[1, 1]
    table = weights.pair_table()
    printed, best = (table[f"intersection, {name}", "ω"] for name in ("eq. 4", "best ω"))
    assert printed < best
    for column in ("distance (m)", "direction (°)"):
        assert table["Kalman", column] < min(
            table["sonar alone", column], table["camera alone", column]
        )
        low, high = sorted((table["sonar alone", column], table["camera alone", column]))
        assert low < table["intersection, best ω", column] < high


def test_compared_determinants_are_those_of_the_rules():
    a, b = consistency.pairs(FEW, rng=RNG(5))
    found = weights.compare(a, b, weights.Config(FEW))
    at_best = np.linalg.det(fusion.covariance_intersection(a, b, found.least).cov)
    at_4 = np.linalg.det(fusion.covariance_intersection(a, b, found.printed).cov)
    np.testing.assert_allclose(found.excess, at_4 / at_best)
    better = np.minimum(np.linalg.det(a.cov), np.linalg.det(b.cov))
    np.testing.assert_allclose(found.alone, at_4 / better)


def test_weight_of_a_hypothesis_is_drawn_against_its_thresholds():
    _, ax = figure()
    draw.certainty.on(ax, np.arange(3.0), np.array([0.1, 0.5, 0.2]), 0.4, 0.15)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), [0.1, 0.5, 0.2])
    assert [set(line.get_ydata()) for line in ax.lines[1:]] == [{0.4}, {0.15}]
