"""Colour spaces: bins against whole numbers, OpenCV and the standard library's conversions."""

import colorsys

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robot_perception.appearance.colour_spaces import SPACES, Binning, ColourSpace
from tests.unchecked import unchecked

COLOURS = hnp.arrays(np.uint8, (20, 3))
BINS = st.tuples(*[st.integers(1, 256)] * 3)


def every(step):
    """Return the colours of a grid that has 0 and 255 on each axis."""
    levels = np.unique([*range(0, 256, step), 255])
    grid = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1)
    return grid.reshape(-1, 3).astype(np.uint8)


def whole_numbers(name, colours, bins):
    """Return the bins along each coordinate, by divisions of whole numbers alone."""
    R, G, B = colours.astype(np.int64).T
    total, low, high = R + G + B, np.minimum(np.minimum(R, G), B), np.maximum(np.maximum(R, G), B)
    black = total == 0
    some, spread = np.where(black, 1, total), np.where(high > low, 6 * (high - low), 1)
    turn = np.select(
        [high == low, (high == R) & (G >= B), high == R, high == G],
        [0 * R, G - B, G - B + 6 * (high - low), 2 * (high - low) + B - R],
        4 * (high - low) + R - G,
    )
    tops, bottoms = {
        "RGB": ((R, G, B), (256, 256, 256)),
        "normalised rgb": (
            [np.where(black, 1, c) for c in (R, G, B)],
            [np.where(black, 3, total)] * 3,
        ),
        "HSI": ((turn, total - 3 * low, total), (spread, some, 766)),
        "opponent": ((B - G + 255, G - R + 255, total), (511, 511, 766)),
    }[name]
    return np.stack(
        [
            np.minimum(b * top // bottom, b - 1)
            for b, top, bottom in zip(bins, tops, bottoms, strict=True)
        ]
    )


@pytest.mark.parametrize("name", SPACES)
@pytest.mark.parametrize("bins", [None, (256, 256, 256), (7, 12, 18), (1, 73, 3), (6, 5, 9)])
def test_bins_are_those_of_whole_numbers(name, bins):
    binning, colours = Binning(name, bins), every(11)
    i, j, k = whole_numbers(name, colours, binning.bins)
    expected = (i * binning.bins[1] + j) * binning.bins[2] + k
    np.testing.assert_array_equal(binning.of(colours), expected)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPACES)
def test_bins_of_all_colours_are_exact(name):
    binning = Binning(name)
    other = np.stack(np.meshgrid(*[np.arange(256, dtype=np.uint8)] * 2), axis=-1).reshape(-1, 2)
    for red in range(256):
        colours = np.column_stack([np.full(len(other), red, dtype=np.uint8), other])
        i, j, k = whole_numbers(name, colours, binning.bins)
        np.testing.assert_array_equal(
            binning.of(colours), (i * binning.bins[1] + j) * binning.bins[2] + k
        )


@given(COLOURS, st.sampled_from(list(SPACES)), BINS)
def test_bytes_and_their_coordinates_have_the_same_bins(colours, name, bins):
    binning = Binning(name, bins)
    numbers = binning.of(colours)
    np.testing.assert_array_equal(binning.of(binning.space.coordinates(colours)), numbers)
    np.testing.assert_array_equal(binning.index(colours.reshape(4, 5, 3)).ravel(), numbers)
    assert numbers.min() >= 0
    assert numbers.max() < binning.count == np.prod(bins)


@given(COLOURS)
def test_hue_is_that_of_the_standard_library(colours):
    found = SPACES["HSI"].coordinates(colours)
    for colour, hue in zip(colours / 255, found[:, 0], strict=True):
        assert np.isclose(colorsys.rgb_to_hsv(*colour)[0], hue, rtol=0, atol=1e-12)


def test_hue_lies_near_the_angle():
    colours = every(15)
    red, green, blue = colours.astype(float).T
    there = colours.max(axis=1) > colours.min(axis=1)
    angle = np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue) / (2 * np.pi)
    apart = SPACES["HSI"].coordinates(colours)[:, 0] - angle
    assert np.abs((apart + 0.5) % 1 - 0.5)[there].max() < 1.2 / 360


def test_hue_and_saturation_of_greys():
    greys = np.repeat(np.array([[0], [1], [128], [255]], dtype=np.uint8), 3, axis=1)
    np.testing.assert_array_equal(SPACES["HSI"].coordinates(greys)[:, :2], np.zeros((4, 2)))
    np.testing.assert_allclose(SPACES["normalised rgb"].coordinates(greys), np.full((4, 3), 1 / 3))


def test_coordinates_by_hand():
    orange = np.array([[200, 100, 0]], dtype=np.uint8)
    expected = {
        "RGB": (200 / 256, 100 / 256, 0),
        "normalised rgb": (2 / 3, 1 / 3, 0),
        "HSI": (1 / 12, 1, 300 / 766),
        "opponent": (155 / 511, 155 / 511, 300 / 766),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(SPACES[name].coordinates(orange)[0], values, atol=1e-15)


def test_normalised_colours_do_not_depend_on_brightness():
    colours = every(40) // 2
    np.testing.assert_allclose(
        SPACES["normalised rgb"].coordinates(2 * colours),
        SPACES["normalised rgb"].coordinates(colours),
        atol=1e-15,
    )


def test_bins_of_bytes_are_those_of_opencv():
    image = np.random.default_rng(1).integers(0, 256, (30, 40, 3), dtype=np.uint8)
    binning = Binning("RGB", (8, 4, 16))
    counts = cv2.calcHist([image], [0, 1, 2], None, binning.bins, [0, 256] * 3)
    found = np.bincount(binning.index(image).ravel(), minlength=binning.count)
    np.testing.assert_array_equal(found, counts.ravel())


@pytest.mark.parametrize(
    ("image", "error"),
    [
        (np.zeros((4, 5), dtype=np.uint8), ValueError),
        (np.zeros((4, 5, 4), dtype=np.uint8), ValueError),
        (np.zeros((0, 5, 3), dtype=np.uint8), ValueError),
        (np.zeros((4, 5, 3)), TypeError),
        ("image.png", TypeError),
    ],
)
def test_what_is_no_colour_image_is_refused(image, error):
    with unchecked(), pytest.raises(error, match="image must"):
        Binning().index(image)


def test_what_is_no_space_or_colour_is_refused():
    with unchecked():
        with pytest.raises(ValueError, match="space must be one of"):
            Binning("CIE")
        with pytest.raises(ValueError, match="name must be one of"):
            ColourSpace("CIE")
        with pytest.raises(ValueError, match="bins must be from 1 to 256"):
            Binning("RGB", (8, 8, 257))
        with pytest.raises(ValueError, match=r"colours must be from 0 to 1, got 0 to 1.5"):
            Binning("RGB").of(np.array([[0, 0.5, 1.5]]))
        with pytest.raises(TypeError, match="colours must be bytes"):
            Binning("RGB").of(np.array([[0, 1, 1]]))
