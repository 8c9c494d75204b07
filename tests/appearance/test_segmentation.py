"""Segmentations: the definition, OpenCV's pieces, scikit-image, Euler's formula, shapely."""

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from skimage import measure

from robot_perception.appearance import segmentation
from tests.appearance.shapes import MIDDLE, SHAPE, pear
from tests.unchecked import unchecked

masks = hnp.arrays(bool, hnp.array_shapes(min_dims=2, max_dims=2, max_side=12))


def holes_and_pieces(mask):
    """Return by OpenCV's labels how many holes and pieces there are."""
    wide = np.pad(mask, 1).astype(np.uint8)
    pieces = cv2.connectedComponents(wide, connectivity=8)[0] - 1
    return cv2.connectedComponents(1 - wide, connectivity=4)[0] - 2, pieces


def disc(middle, radius, shape=SHAPE):
    v, u = np.indices(shape)
    return np.hypot(u - middle[0], v - middle[1]) <= radius


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.uint8])
def test_pixels_are_kept_whose_colour_has_been_seen(kind):
    rng = np.random.default_rng(1)
    index = rng.integers(0, 50, (7, 9)).astype(kind)
    histogram = rng.integers(0, 3, 50).astype(float)
    found = segmentation.segment(index, histogram)
    assert found.dtype == bool
    np.testing.assert_array_equal(found, histogram[index] > 0)


@pytest.mark.parametrize("wrong", [-1, 5])
def test_numbers_of_no_bin_are_refused(wrong):
    index = np.zeros((3, 4), dtype=np.int32)
    index[2, 3] = wrong
    with pytest.raises(ValueError, match=r"index must be from 0 to 4.*got"):
        segmentation.segment(index, np.ones(5))


def test_what_is_no_segmentation_is_refused():
    with unchecked():
        with pytest.raises(TypeError, match="mask must be an array of True and False"):
            segmentation.clean(np.ones((3, 3)))
        with pytest.raises(ValueError, match=r"mask must be \(height, width\), got \(0, 3\)"):
            segmentation.boundary(np.ones((0, 3), dtype=bool))
        with pytest.raises(ValueError, match="index must be integers"):
            segmentation.segment(np.ones((2, 2)), np.ones(4))
        with pytest.raises(ValueError, match=r"index must be \(height, width\), got \(0, 2\)"):
            segmentation.segment(np.ones((0, 2), dtype=np.int32), np.ones(4))
        with pytest.raises(ValueError, match="histogram must not be negative, got -1"):
            segmentation.segment(np.ones((2, 2), dtype=np.int32), np.array([-1.0, 1.0]))
        with pytest.raises(ValueError, match="opening must be odd, got 4"):
            segmentation.clean(np.ones((3, 3), dtype=bool), opening=4)


@settings(deadline=None)
@given(masks)
def test_euler_number_is_pieces_less_holes(mask):
    holes, pieces = holes_and_pieces(mask)
    assert segmentation.euler_number(mask) == pieces - holes


@settings(deadline=None)
@given(masks)
def test_euler_number_is_scikit_images(mask):
    assert segmentation.euler_number(mask) == measure.euler_number(mask, connectivity=2)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_euler_number_of_many_pieces_and_holes(share):
    mask = np.random.default_rng(4).random((60, 70)) < share
    holes, pieces = holes_and_pieces(mask)
    assert segmentation.euler_number(mask) == pieces - holes


@settings(deadline=None)
@given(masks)
def test_euler_number_is_vertices_less_edges_plus_faces(mask):
    wide = np.pad(mask, 1)
    across, down = wide[:, 1:] | wide[:, :-1], wide[1:] | wide[:-1]
    vertices = across[1:] | across[:-1]
    euler = vertices.sum() - across.sum() - down.sum() + mask.sum()
    assert segmentation.euler_number(mask) == euler


def test_cleaning_drops_specks_and_closes_cracks_and_keeps_large_holes():
    mask = disc((60, 40), 25, (80, 120))
    mask[40, 60] = False  # a hole of one pixel
    mask &= ~disc((50, 40), 5, (80, 120))
    mask[10, 10] = True
    found = segmentation.clean(mask)
    assert not found[10, 10]
    assert found[40, 60]
    assert segmentation.euler_number(found) == 0
    assert (found ^ mask).sum() < 0.02 * mask.sum()
    np.testing.assert_array_equal(segmentation.clean(mask, 1, 1), mask)


def test_cleaning_leaves_alone_what_the_frame_of_the_image_cuts():
    mask = disc((0, 30), 20, (60, 80))
    found = segmentation.clean(mask, opening=1, closing=9)
    assert not (found & ~disc((0, 30), 20.7, (60, 80))).any()
    np.testing.assert_array_equal(segmentation.clean(mask, 1, 1), mask)


@pytest.mark.parametrize("reach", [1, 2, 4])
def test_the_boundary_lies_evenly_on_both_sides_and_not_on_the_frame(reach):
    mask = np.zeros((30, 40), dtype=bool)
    mask[:20, 10:25] = True
    found = segmentation.boundary(mask, reach)
    middle = np.zeros(40, dtype=bool)
    middle[[*range(10 - reach, 10 + reach), *range(25 - reach, 25 + reach)]] = True
    np.testing.assert_array_equal(found[5], middle)
    np.testing.assert_array_equal(np.flatnonzero(found[:, 17]), np.arange(20 - reach, 20 + reach))


def test_dilation_reaches_by_the_radius_in_all_directions():
    mask = np.zeros((41, 41), dtype=bool)
    mask[20, 20] = True
    found = segmentation.dilate(mask, 6)
    v, u = np.nonzero(found)
    assert np.hypot(u - 20, v - 20).max() == pytest.approx(6, abs=0.8)
    assert (u.min(), u.max(), v.min(), v.max()) == (14, 26, 14, 26)
    np.testing.assert_array_equal(segmentation.dilate(mask, 0), mask)


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10**6))
def test_filled_holds_the_pixels_whose_centres_are_inside(seed):
    rng = np.random.default_rng(seed)
    outline = pear(12, 0.4) * rng.uniform(0.1, 0.4) + rng.uniform(-5, 45, 2)
    found = segmentation.filled(outline, (40, 50))
    v, u = np.indices((40, 50))
    inside = shapely.contains_xy(shapely.Polygon(outline), u, v)
    np.testing.assert_array_equal(found, inside)


def test_pixels_on_sides_belong_to_one_of_two_neighbours():
    square = np.array([[2.0, 2], [6, 2], [6, 6], [2, 6]])
    left, right = (segmentation.filled(np.add(square, [u, 0]), (10, 20)) for u in (0, 4))
    assert not (left & right).any()
    assert left.sum() == right.sum() == 16
    one_round_back = segmentation.filled(square[::-1], (10, 20))
    np.testing.assert_array_equal(one_round_back, left)


def test_the_blob_is_the_piece_that_the_predicted_outline_covers_most():
    small, large = disc((80, 120), 12), disc((230, 120), 40)
    mask = small | large
    near = pear() * 0.4 + [84, 122]
    found = segmentation.blob(mask, near)
    np.testing.assert_array_equal(found.mask, small)
    assert found.area == small.sum()
    assert found.overlap == (small & segmentation.filled(near, SHAPE)).sum() > 0


@given(masks, st.integers(0, 10**6))
def test_the_blob_is_that_of_opencvs_pieces_of_the_whole_image(mask, seed):
    near = np.random.default_rng(seed).random(mask.shape) < 0.4
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    pieces = [labels == k for k in range(1, count)]
    found = segmentation.blob(mask, near)
    if not pieces:
        assert found is None
        return
    assert any((found.mask == piece).all() for piece in pieces)
    most = max((piece & near).sum() for piece in pieces)
    assert found.overlap == (found.mask & near).sum() == most
    assert found.area == found.mask.sum()
    if not most:
        assert found.area == max(piece.sum() for piece in pieces)
    assert found.euler == segmentation.euler_number(found.mask)


def test_an_outline_and_the_mask_of_its_inside_give_one_blob():
    mask = disc((80, 120), 12) | disc((230, 120), 40)
    near = pear() * 0.4 + [84, 122]
    by_outline = segmentation.blob(mask, near)
    by_mask = segmentation.blob(mask, segmentation.filled(near, SHAPE))
    np.testing.assert_array_equal(by_outline.mask, by_mask.mask)
    assert by_outline.overlap == by_mask.overlap
    with (
        unchecked(),
        pytest.raises(ValueError, match=r"near must be as large as mask, \(240, 320\)"),
    ):
        segmentation.blob(mask, np.ones((9, 9), dtype=bool))


def test_without_an_outline_or_overlap_the_blob_is_the_largest_piece():
    mask = disc((80, 60), 12) | disc((230, 120), 40)
    beside = pear() * 0.2 + [150, 130]  # between the pieces
    for near in (None, np.add(pear() * 0.2, 20), np.add(pear(), [-300, 20]), beside):
        found = segmentation.blob(mask, near)
        np.testing.assert_array_equal(found.mask, disc((230, 120), 40))
        assert found.overlap == 0


def test_an_empty_segmentation_has_no_blob_and_a_pixel_is_one():
    empty = np.zeros(SHAPE, dtype=bool)
    assert segmentation.blob(empty) is None
    assert segmentation.blob(empty, pear() + MIDDLE) is None
    empty[3, 4] = True
    found = segmentation.blob(empty, pear() + MIDDLE)
    assert (found.area, found.euler, found.overlap) == (1, 1, 0)
    assert found.boundary().sum() == 5


def test_holes_and_corners_count_in_a_blob():
    mask = np.zeros((20, 30), dtype=bool)
    mask[2:6, 2:6] = mask[6:12, 6:12] = True  # two squares that meet in a corner are one piece
    mask[3, 3] = mask[8, 8] = False
    found = segmentation.blob(mask)
    assert found.area == 16 + 36 - 2
    assert found.euler == -1


def test_a_full_image_is_one_blob_without_edges():
    found = segmentation.blob(np.ones((5, 6), dtype=bool))
    assert (found.area, found.euler) == (30, 1)
    assert not found.boundary().any()
