"""Boxes against shapely, and what is cut out of a picture."""

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.companion.boxes import crop, overlap, overlap_in_pairs, within
from tests.unchecked import unchecked

COORDS = st.floats(-50, 50)
SIDES = st.floats(0.5, 60)
BOXES = st.tuples(COORDS, COORDS, SIDES, SIDES)


@given(st.lists(BOXES, min_size=1, max_size=4), st.lists(BOXES, min_size=1, max_size=4))
def test_overlap_is_that_of_polygons(one, other):
    found = overlap(np.array(one), np.array(other))
    for i, a in enumerate(one):
        for j, b in enumerate(other):
            p, q = (shapely.box(x, y, x + w, y + h) for x, y, w, h in (a, b))
            assert found[i, j] == pytest.approx(p.intersection(q).area / p.union(q).area, abs=1e-9)


@given(st.lists(st.tuples(BOXES, BOXES), min_size=1, max_size=4))
def test_overlap_in_pairs_is_the_diagonal_of_that_of_all_with_all(pairs):
    one, other = np.moveaxis(np.array(pairs), 1, 0)
    assert overlap_in_pairs(one, other).tolist() == np.diag(overlap(one, other)).tolist()


def test_pairs_need_as_many_boxes_of_each():
    box = np.array([[0.0, 0, 1, 1]])
    with unchecked(), pytest.raises(ValueError, match="must be in pairs, got 1 and 2 boxes"):
        overlap_in_pairs(box, np.concatenate([box, box]))


def test_no_boxes_overlap_with_nothing():
    assert overlap(np.zeros((0, 4)), np.array([[0.0, 0, 1, 1]])).shape == (0, 1)


@pytest.fixture
def ramp():
    return np.tile(np.arange(100, 220, dtype=np.uint8), (90, 1))


def test_a_box_of_the_size_asked_for_is_cut_out_as_it_is(ramp):
    found = crop(ramp, np.array([10.0, 20, 46, 56]), (56, 46), equalise=False)
    np.testing.assert_array_equal(found, ramp[20:76, 10:56] / 255)


def test_other_sizes_are_rescaled_and_keep_their_middle(ramp):
    for side in (23, 60, 80):
        box = np.array([60 - side / 2, 10, side, side])
        found = crop(ramp, box, (11, 11), equalise=False)
        assert found.shape == (11, 11)
        assert found[5, 5] * 255 == pytest.approx(100 + 60, abs=1.5)
        slope = np.diff(found[5]).mean() * 255
        assert slope == pytest.approx(side / 11, rel=0.1)


def test_what_shrinks_is_averaged_and_what_grows_is_interpolated():
    image = np.zeros((40, 40), dtype=np.uint8)
    image[:, ::4] = 200  # one column in four
    small = crop(image, np.array([0.0, 0, 40, 40]), (10, 10))
    np.testing.assert_allclose(small * 255, 50)
    step = np.zeros((4, 4), dtype=np.uint8)
    step[:, 2:] = 200
    large = crop(step, np.array([0.0, 0, 4, 4]), (4, 8))
    np.testing.assert_allclose(large[0] * 255, [0, 0, 0, 50, 150, 200, 200, 200])


def test_outside_the_picture_its_border_is_repeated(ramp):
    found = crop(ramp, np.array([-20.0, -20, 40, 40]), (40, 40), equalise=False)
    np.testing.assert_array_equal(found[:, :20], ramp[0, 0] / 255)
    np.testing.assert_array_equal(found[0, 20:], ramp[0, :20] / 255)


def test_equalised_crops_do_not_depend_on_brightness_and_contrast():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 200, (60, 60), dtype=np.uint8)
    box = np.array([5.0, 5, 46, 46])
    dim = (image // 2 + 10).astype(np.uint8)
    one, other = (crop(i, box, (46, 46), equalise=True) for i in (image, dim))
    assert np.abs(one - other).max() < 0.02
    np.testing.assert_allclose(one * 255, cv2.equalizeHist(image[5:51, 5:51]))


@pytest.mark.parametrize(
    ("image", "box", "error", "text"),
    [
        (np.zeros((9, 9, 3), np.uint8), [0, 0, 5, 5], ValueError, "must be made grey first"),
        (np.zeros((9, 9)), [0, 0, 5, 5], TypeError, "image"),
        (np.zeros((0, 9), np.uint8), [0, 0, 5, 5], ValueError, "image must be"),
        (np.zeros((9, 9), np.uint8), [0, 0, 0, 5], ValueError, "must have a width and a height"),
        (np.zeros((9, 9), np.uint8), [20, 0, 5, 5], ValueError, "box must reach into the picture"),
        (np.zeros((9, 9), np.uint8), [0, np.nan, 5, 5], ValueError, "box must be finite"),
    ],
)
def test_what_is_wrong_is_named(image, box, error, text):
    with unchecked(), pytest.raises(error, match=text):
        crop(image, np.array(box, dtype=float), (5, 5))


def test_a_crop_holds_the_pixels_of_its_rounded_box_also_at_the_right_of_a_wide_picture():
    image = np.random.default_rng(3).integers(0, 256, (40, 90), dtype=np.uint8)
    found = crop(image, np.array([60.4, 9.6, 20.4, 15.2]), (15, 21))
    np.testing.assert_array_equal(found, image[10:25, 60:81] / 255.0)
    beyond = crop(image, np.array([80.0, 30, 20, 20]), (20, 20))
    np.testing.assert_array_equal(beyond[:10, :10], image[30:, 80:] / 255.0)
    np.testing.assert_array_equal(beyond[:10, 10:], np.repeat(image[30:, 89:], 10, axis=1) / 255.0)


def test_a_window_takes_in_every_pixel_that_it_touches():
    image = np.arange(6 * 9, dtype=np.uint8).reshape(6, 9)
    part, corner = within(image, np.array([2.5, 1.2, 3.0, 2.9]))
    np.testing.assert_array_equal(part, image[1:5, 2:6])
    np.testing.assert_array_equal(corner, [2, 1])
    part, corner = within(image, np.array([-3.0, 4.5, 5.0, 9.0]))
    np.testing.assert_array_equal(part, image[4:, :2])
    np.testing.assert_array_equal(corner, [0, 4])
    assert within(image, None)[0] is image
