"""Haar-like features: the kernel against sums over pixels, the integral image against its law."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robot_perception.companion.hands.features import (
    SIZE,
    feature_pool,
    feature_values,
    feature_values_textbook,
    integral,
)
from tests.unchecked import unchecked

POOL = feature_pool(np.random.default_rng(0), 300)
WINDOWS = np.random.default_rng(1).integers(0, 256, (12, SIZE, SIZE), dtype=np.uint8)


def test_integral_images_are_sums_of_all_above_and_to_the_left():
    image = np.random.default_rng(2).integers(0, 256, (17, 23), dtype=np.uint8)
    total, squares = integral(image)
    for y, x in ((0, 0), (1, 1), (17, 23), (5, 11), (17, 3)):
        part = image[:y, :x].astype(int)
        assert total[y, x] == part.sum()
        assert squares[y, x] == (part**2).sum()


def test_the_kernel_is_the_textbook():
    theirs = feature_values_textbook(WINDOWS, POOL)
    np.testing.assert_allclose(feature_values(WINDOWS, POOL), theirs, rtol=1e-5, atol=1e-6)


def test_features_see_no_brightness_and_no_contrast():
    dim = (WINDOWS // 2 + 30).astype(np.uint8)
    same = feature_values((WINDOWS // 2 * 2).astype(np.uint8), POOL)
    np.testing.assert_allclose(feature_values(dim, POOL), same, atol=2e-3)


def test_flat_windows_hold_nothing():
    flat = np.full((2, SIZE, SIZE), 90, dtype=np.uint8)
    flat[1, 0, :12] = 92
    assert not feature_values(flat, POOL).any()
    assert not feature_values_textbook(flat, POOL).any()


def test_the_pool_has_different_features_of_every_kind_that_see_only_differences():
    assert len({tuple(f.ravel().tolist()) for f in POOL}) == 300
    weights = (POOL[..., 2] * POOL[..., 3] * POOL[..., 4]).sum(axis=1)
    assert not weights.any()
    kinds = {(int(f[1, 4]), bool(f[2, 2])) for f in POOL}
    assert kinds == {(2, False), (3, False), (2, True), (9, False)}
    low, high = POOL[..., :2], POOL[..., :2] + POOL[..., 2:4]
    assert low.min() >= 0
    assert high.max() <= SIZE
    again = feature_pool(np.random.default_rng(0), 300)
    np.testing.assert_array_equal(again, POOL)


def test_an_edge_is_found_by_the_feature_of_an_edge():
    window = np.full((1, SIZE, SIZE), 50, dtype=np.uint8)
    window[..., :12] = 150
    edge = np.zeros((1, 3, 5), dtype=np.int64)
    edge[0, 0], edge[0, 1] = (0, 0, 24, 24, -1), (0, 0, 12, 24, 2)
    # 2 · 150 - (150 + 50) over half of the pixels, in deviations of 50
    assert feature_values(window, edge)[0, 0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (lambda: integral(np.zeros((3, 3))), TypeError, "image must be a picture of bytes"),
        (lambda: integral(np.zeros((0, 3), np.uint8)), ValueError, "image must not be empty"),
        (lambda: feature_pool(np.random.default_rng(0), 0), ValueError, "count must be"),
        (lambda: feature_values(WINDOWS.astype(float), POOL), TypeError, "windows must be"),
        (lambda: feature_values(WINDOWS[:, 1:], POOL), ValueError, "windows must be"),
        (lambda: feature_values(WINDOWS, POOL + 5), ValueError, "features must lie within 24"),
        (lambda: feature_values(WINDOWS, heavy(10**7)), ValueError, "weights within 1000000, got"),
        (lambda: feature_values(WINDOWS, heavy(-(2**63))), ValueError, "weights within 1000000"),
    ],
)
def test_what_is_wrong_is_named(wrong, error, text):
    with unchecked(), pytest.raises(error, match=text):
        wrong()


def heavy(weight: int) -> np.ndarray:
    """Return a feature of one rectangle with a weight."""
    return np.array([[[0, 0, 24, 24, weight], *[[0] * 5] * 2]])


@given(st.integers(0, 1), st.integers(-(2**63), 2**63 - 1), st.integers(-(2**63), 2**63 - 1))
@example(0, 5 * 10**9, 2**63 - 4 * 10**9)  # their sum is too large for 64 bits, and negative
@example(1, 2**63 - 1, 1)
@example(0, 24, 0)
@example(0, 20, 5)
@example(1, 3, -1)
@example(0, 0, 25)
def test_a_rectangle_is_refused_exactly_where_it_leaves_the_window(axis, place, size):
    feature = heavy(1)
    feature[0, 0, axis], feature[0, 0, 2 + axis] = place, size
    if place >= 0 and 0 <= size <= 24 and place + size <= 24:
        assert feature_values(WINDOWS, feature).shape == (1, len(WINDOWS))
    else:
        with pytest.raises(ValueError, match="features must lie within 24 x 24 px, got rectangle"):
            feature_values(WINDOWS, feature)


def test_no_windows_have_no_values():
    assert feature_values(WINDOWS[:0], POOL).shape == (len(POOL), 0)


def test_parts_lie_in_the_whole_where_their_kind_has_them():
    """One of three in a row is the middle one; two of four in a square lie across."""
    middles = corners = 0
    for whole, part, other in POOL:
        centre = whole[:2] + whole[2:4] / 2
        if part[4] in (3, 9):
            np.testing.assert_allclose(part[:2] + part[2:4] / 2, centre)
            middles += 1
        if other[2]:
            np.testing.assert_array_equal(other[:2], part[:2] + part[2:4])
            np.testing.assert_array_equal(other[:2], centre)
            corners += 1
        assert whole[4] * whole[2] * whole[3] + sum(r[4] * r[2] * r[3] for r in (part, other)) == 0
    assert min(middles, corners) > 20


def test_no_feature_is_of_less_than_eight_pixels():
    wide, high = feature_pool(np.random.default_rng(9), 3000)[:, 0, 2:4].T
    assert (wide * high).min() == 8
