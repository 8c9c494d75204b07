"""Painting: shares of pixels are areas, strokes have their width, nothing goes beyond the image."""

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.coloured import canvas
from data_synth.coloured.sequences import HEIGHT, WIDTH

SQUARE = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
IMAGE = shapely.box(-0.5, -0.5, WIDTH - 0.5, HEIGHT - 0.5)


def whole(box, cover):
    image = np.zeros((HEIGHT, WIDTH), dtype=np.float32)
    image[box] = cover
    return image


@st.composite
def shapes(draw):
    """Irregular outlines anywhere near the image."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    count = draw(st.integers(3, 12))
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(0, 0.4, count)) / count
    radius = rng.uniform(2, 30, count)
    middle = rng.uniform((-20, -20), (WIDTH + 20, HEIGHT + 20))
    return middle + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@given(shapes())
@settings(max_examples=40)
def test_shares_of_pixels_are_the_areas_that_an_outline_has_in_them(outline):
    shape = shapely.Polygon(outline)
    image = whole(*canvas.inside(outline))
    rim = shape.length
    assert image.sum() == pytest.approx(shape.intersection(IMAGE).area, abs=0.02 * rim + 0.05)
    rows, columns = np.nonzero(image)
    for row, column in list(zip(rows, columns, strict=True))[::37]:
        pixel = shapely.box(column - 0.5, row - 0.5, column + 0.5, row + 0.5)
        assert image[row, column] == pytest.approx(pixel.intersection(shape).area, abs=0.26)


def test_a_square_between_pixels_covers_half_and_quarter_pixels_exactly():
    image = whole(*canvas.inside(SQUARE * 5.0 + (50.0, 60.0)))  # edges through middles of pixels
    assert image.sum() == pytest.approx(100)
    assert image[60, 45] == pytest.approx(0.5)
    assert image[55, 45] == pytest.approx(0.25)
    assert image[60, 46] == 1
    assert image[60, 44] == 0


def test_pixels_inside_are_those_of_a_polygon_fill():
    outline = 40 * canvas.round_outline(4, 0.2, rng=np.random.default_rng(3)) + (150.3, 110.7)
    filled = np.zeros((HEIGHT * 8, WIDTH * 8), dtype=np.uint8)
    fine = np.rint((outline + 0.5) * 8 * 16 - 8).astype(np.int32)  # sixteenths of fine pixels
    cv2.fillPoly(filled, [fine], 255, shift=4)
    expected = cv2.resize(filled, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA) > 127
    found = canvas.covered(outline)
    assert (found & expected).sum() / (found | expected).sum() > 0.995


def test_an_outline_that_goes_round_twice_counts_once():
    once = canvas.inside(SQUARE * 6 + 40)[1]
    twice = canvas.inside(np.concatenate([SQUARE, SQUARE]) * 6 + 40)[1]
    np.testing.assert_allclose(once, twice)


@pytest.mark.parametrize("middle", [(-99.0, 50.0), (50.0, -99.0), (999.0, 50.0), (50.0, 999.0)])
def test_what_lies_beyond_the_image_leaves_it_alone(middle):
    for box, cover in (
        canvas.inside(SQUARE * 9 + middle),
        canvas.stroke(SQUARE * 9 + middle, np.full(4, 5.0)),
    ):
        assert not cover.size
        image = np.zeros((HEIGHT, WIDTH, 3))
        canvas.lay(image, box, cover, np.ones(3))
        assert not image.any()


@given(st.integers(0, 2**32))
@settings(max_examples=15)
def test_a_stroke_is_a_line_with_its_width(seed):
    rng = np.random.default_rng(seed)
    points, width = rng.uniform((-10, -10), (WIDTH, HEIGHT), (3, 2)), rng.uniform(2, 9)
    expected = shapely.LineString(points).buffer(width / 2).intersection(IMAGE)
    image = whole(*canvas.stroke(points, np.full(3, width)))
    assert image.sum() == pytest.approx(expected.area, rel=0.03, abs=1.0)
    for row, column in list(zip(*np.nonzero(image > 0.99), strict=True))[::50]:
        assert expected.distance(shapely.Point(column, row)) < 1e-6


def test_a_stroke_tapers_from_one_width_to_the_next():
    image = whole(*canvas.stroke(np.array([[50.0, 60], [150, 60]]), np.array([12.0, 4.0])))
    assert [image[:, column].sum() for column in (50, 100, 150)] == pytest.approx(
        [12, 8, 4], abs=0.2
    )


def test_laying_mixes_by_shares_and_keeps_to_the_box():
    image = np.full((HEIGHT, WIDTH, 3), 0.2)
    canvas.lay(image, (slice(3, 5), slice(7, 9)), np.full((2, 2), 0.25), np.array([1.0, 0.6, 0.2]))
    np.testing.assert_allclose(image[3, 7], [0.4, 0.3, 0.2])
    image[3:5, 7:9] = 0.2
    assert (image == 0.2).all()


def test_a_shadow_takes_its_share_where_it_falls():
    low = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    canvas.shadow(low, SQUARE * 20 + (100, 100), np.array([15.0, -5]), 1.0, 0.7)
    assert low[95, 115] == pytest.approx(0.3, abs=1e-5)
    assert low[95, 140] == 1
    assert low[122, 98] == 1
    assert 1 - low.mean() == pytest.approx(0.7 * 1600 / low.size, rel=1e-3)


def test_a_shifted_image_moves_right_and_down_and_nothing_comes_in():
    image = np.zeros((20, 30), dtype=np.float32)
    image[5, 7] = image[19, 29] = 1
    moved = canvas.shifted(image, np.array([2.0, 3.0]))
    assert moved[8, 9] == 1
    assert moved.sum() == 1


def test_textures_have_mean_0_and_deviation_1_and_cells_of_their_size():
    coarse, fine = (canvas.texture(c, 1, rng=np.random.default_rng(1)) for c in (40.0, 4.0))
    for image in (coarse, fine):
        assert image.shape == (HEIGHT, WIDTH)
        assert image.mean() == pytest.approx(0, abs=1e-4)
        assert image.std() == pytest.approx(1, rel=1e-4)
    steps = [np.abs(np.diff(image, axis=1)).mean() for image in (coarse, fine)]
    assert steps[1] > 5 * steps[0]


def test_turning_goes_from_right_to_down_and_keeps_lengths():
    np.testing.assert_allclose(canvas.turn(np.array([[2.0, 0]]), np.pi / 2), [[0, 2]], atol=1e-12)
    placed = canvas.place_at(SQUARE, 0.3, np.array([7.0, 9]))
    np.testing.assert_allclose(np.hypot(*(placed - (7, 9)).T), np.sqrt(2))


def test_leaves_and_stones_have_their_size():
    leaf = shapely.Polygon(canvas.leaf_outline(40.0, 12.0))
    assert leaf.is_valid
    assert leaf.bounds == pytest.approx((-20, -6, 20, 6), abs=0.6)
    stone = shapely.Polygon(canvas.round_outline(4, 0.1, rng=np.random.default_rng(2)))
    assert stone.is_valid
    assert stone.area == pytest.approx(np.pi, rel=0.1)
