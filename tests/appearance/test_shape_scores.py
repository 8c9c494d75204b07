"""Scores of shape: their definitions on cases of known value, and their laws."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.appearance import shape_scores
from tests.unchecked import unchecked

areas = st.floats(1e-3, 1e6)
scores = st.floats(0, 1)


def test_affine_similarity_counts_points_on_edges_at_the_nearest_pixel():
    boundary = np.zeros((5, 6), dtype=bool)
    boundary[2, 3] = boundary[4, 5] = True
    outline = np.array([[3.4, 1.6], [2.4, 2.0], [5.4, 4.4], [5.6, 4.0], [-3.0, 2.0]])
    assert shape_scores.affine_similarity(boundary, outline) == pytest.approx(2 / 5)
    both = shape_scores.affine_similarity(boundary, np.stack([outline, outline[[0, 0, 2, 2, 1]]]))
    np.testing.assert_allclose(both, [2 / 5, 4 / 5])


def test_points_beyond_the_image_are_on_no_edge():
    everywhere = np.ones((5, 6), dtype=bool)
    beyond = np.array([[-0.6, 0], [5.6, 0], [0, -0.6], [0, 4.6], [1e9, 1e9]])
    assert shape_scores.affine_similarity(everywhere, beyond) == 0


def test_the_predicted_area_goes_on_as_before_and_is_not_negative():
    assert shape_scores.predicted_area(110.0, 100.0) == 120
    assert shape_scores.predicted_area(110.0, 100.0, 0.5) == 115
    found = shape_scores.predicted_area(np.array([10.0, 5.0]), np.array([100.0, 5.0]))
    np.testing.assert_array_equal(found, [0, 5])


@given(areas, areas)
def test_area_congruence_is_the_smaller_over_the_larger(predicted, found):
    value = shape_scores.area_congruence(predicted, found)
    assert value == pytest.approx(min(predicted, found) / max(predicted, found), abs=1e-12)
    assert value == pytest.approx(shape_scores.area_congruence(found, predicted), abs=1e-12)
    assert value + shape_scores.area_difference(predicted, found) == pytest.approx(1)


def test_the_printed_sign_is_0_for_a_perfect_match_and_the_other_1():
    assert shape_scores.area_difference(500.0, 500.0) == 0
    assert shape_scores.area_congruence(500.0, 500.0) == 1
    assert shape_scores.area_congruence(500.0, 0.0) == 0


def test_quality_falls_by_a_slope_with_each_hole():
    np.testing.assert_allclose(
        shape_scores.quality(np.array([3, 1, 0, -1, -50]), 0.25), [1, 1, 0.75, 0.5, 0]
    )
    assert shape_scores.quality(1) == 1
    assert shape_scores.quality(0, 0.1) == pytest.approx(0.9)


@given(scores, scores, scores)
def test_rho_weighs_what_each_score_lacks(affine, area, quality):
    found = shape_scores.rho(affine, area, quality, (1.0, 2.0, 4.0))
    assert found == pytest.approx((1 - affine) + 2 * (1 - area) + 4 * (1 - quality))


def test_rho_takes_batches():
    found = shape_scores.rho(np.array([1.0, 0.5]), 1.0, np.array([[1.0], [0.0]]))
    np.testing.assert_allclose(found, [[0, 0.5], [1, 1.5]])


@given(st.floats(0, 10), st.floats(0.05, 10))
def test_a_weight_is_a_bell_of_rho(rho, sigma):
    found = shape_scores.weight(rho, sigma)
    assert found == pytest.approx(math.exp(-(rho**2) / (2 * sigma**2)), rel=1e-9, abs=1e-300)
    assert shape_scores.weight(0.0, sigma) == 1
    assert shape_scores.weight(sigma, sigma) == pytest.approx(math.exp(-0.5))


def test_weights_that_round_to_0_keep_their_logarithms():
    assert shape_scores.weight(100.0, 1.0) == 0
    assert shape_scores.log_weight(100.0, 1.0) == -5000


def test_bad_scores_are_refused():
    with unchecked():
        with pytest.raises(ValueError, match=r"area must be from 0 to 1, got 1\.5"):
            shape_scores.rho(1.0, 1.5, 1.0)
        with pytest.raises(ValueError, match="importance must be from 0"):
            shape_scores.rho(1.0, 1.0, 1.0, (1.0, -1.0, 1.0))
        with pytest.raises(ValueError, match="predicted or found must be positive, got 0"):
            shape_scores.area_difference(np.array([1.0, 0.0]), 0.0)
        with pytest.raises(ValueError, match="found must be an area, got -1"):
            shape_scores.area_congruence(1.0, -1.0)
        with pytest.raises(ValueError, match="leading axes must broadcast"):
            shape_scores.rho(np.ones(2), np.ones(3), 1.0)
        with pytest.raises(ValueError, match="rho must be within reach of sigma"):
            shape_scores.weight(1e90, 1e-99)
        with pytest.raises(ValueError, match="outline must have points"):
            shape_scores.affine_similarity(np.ones((2, 2), dtype=bool), np.zeros((0, 2)))
