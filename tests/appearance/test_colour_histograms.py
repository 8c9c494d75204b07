"""Histograms, what two have in common, and their adaptation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robot_perception.appearance.colour_histograms import (
    adapt,
    box_histograms,
    histogram,
    intersection,
    intersection_of_shares,
    shares,
    two_views,
)
from tests.unchecked import unchecked

INDEX = np.random.default_rng(0).integers(0, 12, (20, 30), dtype=np.int32)
COUNTS = hnp.arrays(float, 6, elements=st.integers(0, 50)).filter(np.any)


@given(hnp.arrays(bool, INDEX.shape))
def test_a_histogram_counts_what_the_mask_shows(mask):
    expected = [np.count_nonzero(mask & (k == INDEX)) for k in range(15)]
    np.testing.assert_array_equal(histogram(INDEX, 15, mask), expected)
    assert histogram(INDEX, 15).sum() == INDEX.size


@given(st.data())
def test_boxes_are_counted_as_their_pixels(data):
    left, top = data.draw(st.integers(0, 29)), data.draw(st.integers(0, 19))
    width, height = data.draw(st.integers(1, 30 - left)), data.draw(st.integers(1, 20 - top))
    found = box_histograms(INDEX, np.array([[left, top, width, height], [0, 0, 30, 20]]), 13)
    part = INDEX[top : top + height, left : left + width]
    np.testing.assert_array_equal(found, [histogram(part, 13), histogram(INDEX, 13)])


@pytest.mark.parametrize("box", [(-1, 0, 3, 3), (28, 0, 3, 3), (0, 18, 3, 3), (0, 0, 0, 3)])
def test_boxes_beyond_the_image_are_refused(box):
    with pytest.raises(ValueError, match="boxes must lie within 30 x 20 px"):
        box_histograms(INDEX, np.array([[0, 0, 5, 5], box]), 12)


def test_intersection_by_hand():
    model, candidate = np.array([4.0, 0, 6]), np.array([2.0, 3, 15])
    assert intersection(candidate, model) == 8 / 20
    assert np.isclose(intersection_of_shares(candidate, shares(model)), 0.1 + 0.6)
    batch = np.array([candidate, model])
    np.testing.assert_array_equal(intersection(batch, model), [8 / 20, 1.0])


@given(COUNTS, COUNTS, st.integers(1, 9))
def test_laws_of_intersection(one, other, times):
    assert intersection(one, one) == 1
    assert 0 <= intersection(one, other) <= 1
    assert np.isclose(intersection(one, other) * one.sum(), intersection(other, one) * other.sum())
    by_share = intersection_of_shares(one, shares(other))
    assert np.isclose(intersection_of_shares(times * one, shares(other)), by_share)
    assert np.isclose(intersection_of_shares(other, shares(one)), by_share)


def test_the_printed_intersection_rewards_a_small_candidate_and_shares_do_not():
    model = np.array([600.0, 400.0])
    part = np.array([6.0, 0.0])
    assert intersection(part, model) == 1
    assert intersection_of_shares(part, shares(model)) == 0.6
    assert intersection_of_shares(0.9 * model, shares(model)) > 0.99


@given(COUNTS, COUNTS)
def test_each_of_two_views_matches_their_model_wholly(front, back):
    both = two_views(shares(front), shares(back))
    assert np.isclose(intersection_of_shares(front, both), 1)
    assert np.isclose(intersection_of_shares(back, both), 1)
    assert np.isclose(intersection(front, two_views(front, back)), 1)


@given(COUNTS, COUNTS, st.floats(0, 1))
def test_adaptation_goes_a_part_of_the_way(model, candidate, rate):
    adapted = adapt(model, candidate, rate)
    np.testing.assert_allclose(adapted - model, rate * (candidate - model), atol=1e-12)
    np.testing.assert_array_equal(adapt(model, candidate, 0.0), model)
    np.testing.assert_array_equal(adapt(model, candidate, 1.0), candidate)


def test_wrong_histograms_are_refused():
    good = np.array([1.0, 2.0])
    with unchecked():
        for both in (intersection, intersection_of_shares):
            with pytest.raises(ValueError, match="candidate must hold a pixel"):
                both(np.zeros(2), good)
            with pytest.raises(ValueError, match="model must not be negative, got -2"):
                both(good, -good)
            with pytest.raises(ValueError, match="same bins, got 2 and 3"):
                both(good, np.ones(3))
        with pytest.raises(ValueError, match="rate must be from 0 to 1"):
            adapt(good, good, 1.5)
        with pytest.raises(ValueError, match="model must be finite"):
            adapt(good * np.nan, good, 0.5)
        with pytest.raises(ValueError, match="index must be below 11, got 0 to 11"):
            histogram(INDEX, 11)
        with pytest.raises(ValueError, match="mask must be"):
            histogram(INDEX, 12, np.ones((3, 4), dtype=bool))
        with pytest.raises(TypeError, match="mask must be an array of booleans"):
            histogram(INDEX, 12, np.ones(INDEX.shape))
        with pytest.raises(ValueError, match="counts must hold a pixel"):
            shares(np.zeros(4))
