"""The descriptor as a textbook writes it: laws, and OpenCV's beside it."""

import numpy as np
import pytest

from robot_perception.landmarks import detect, textbook
from tests.landmarks.worlds import texture
from tests.unchecked import unchecked

UP = np.mgrid[:18, :18][0].astype(float)


def shares(d):
    """Return which part of a descriptor points in each of the eight directions."""
    by = d.reshape(16, 8).sum(axis=0)
    return by / by.sum()


@pytest.mark.parametrize("quarter", range(4))
def test_a_ramp_has_one_direction(quarter):
    """Brighter downwards is a quarter turn clockwise; with the patch the direction turns."""
    found = textbook.describe(np.rot90(UP, quarter))
    assert shares(found)[(6 + 2 * quarter) % 8] == pytest.approx(1)


def test_a_direction_between_two_is_shared():
    """A ramp at an angle of three sixteenths of a turn, on the tenth of an eighth."""
    angle = 2 * np.pi * (3 + 0.1) / 8
    rows, columns = np.mgrid[:18, :18]
    found = textbook.describe(np.cos(angle) * columns - np.sin(angle) * rows)
    np.testing.assert_allclose(shares(found)[3:5], [0.9, 0.1], atol=0.05)


def test_light_changes_nothing():
    image = np.random.default_rng(0).uniform(50, 100, (18, 18))
    np.testing.assert_array_equal(textbook.describe(image), textbook.describe(2.5 * image - 20))


def test_what_stands_left_is_in_the_left_cells():
    step = np.zeros((18, 18))
    step[:, :5] = 100.0
    left = textbook.describe(step).reshape(4, 4, 8)
    assert left[:, :2].sum() > 0.99 * left.sum()


def test_an_upright_feature_of_scale_4_3_is_cut_out_of_the_picture():
    """Samples are then a pixel apart."""
    image = texture(1)
    cut = textbook.patch(image, np.array([100.0, 80.0]), 4 / 3, 0.0)
    blurred = textbook.cv2.GaussianBlur(image.astype(np.float32), (0, 0), np.sqrt(16 / 9 - 0.25))
    halves = blurred[71:90, 91:110]
    mean = (halves[:-1, :-1] + halves[1:, :-1] + halves[:-1, 1:] + halves[1:, 1:]) / 4
    np.testing.assert_allclose(cut, mean, atol=1e-3)


def test_opencvs_descriptors_are_near():
    """Its samples are the pixels of an octave, turned; ours lie on a turned grid."""
    image = texture(0)
    found = detect(image)
    ours = np.array(
        [
            textbook.describe(textbook.patch(image, pixel, float(scale), float(angle)))
            for pixel, scale, angle in zip(found.pixels, found.scales, found.angles, strict=True)
        ]
    )
    apart = np.linalg.norm(ours - found.descriptors, axis=1)
    assert len(found) > 100
    assert np.median(apart) < 75
    others = np.linalg.norm(ours - np.roll(found.descriptors, 1, axis=0), axis=1)
    assert np.median(others) > 5 * np.median(apart)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("pixel", ([900.0, 10.0], 2.0, 0.0)),
        ("scale", ([10.0, 10.0], 0.1, 0.0)),
        ("scale", ([10.0, 10.0], np.nan, 0.0)),
        ("angle", ([10.0, 10.0], 2.0, np.inf)),
    ],
)
def test_bad_features_are_refused(name, arguments):
    pixel, scale, angle = arguments
    with unchecked(), pytest.raises(ValueError, match=name):
        textbook.patch(texture(0), np.array(pixel), scale, angle)


def test_a_patch_of_one_grey_has_no_descriptor():
    with pytest.raises(ValueError, match="differ"):
        textbook.describe(np.full((18, 18), 7.0))
