"""Homographies against OpenCV and the laws of a group."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.geometry import homographies
from tests.unchecked import unchecked


@given(st.integers(0, 2**31))
def test_homographies_are_opencvs_and_compose(seed):
    rng = np.random.default_rng(seed)
    H, G = np.eye(3) + rng.uniform(-0.2, 0.2, (2, 3, 3))
    points = rng.uniform(-1, 1, (7, 2))
    image = homographies.apply(H, points)
    theirs = cv2.perspectiveTransform(points[:, None], H)[:, 0]
    np.testing.assert_allclose(image, theirs, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(homographies.apply(-3 * H, points), image, rtol=1e-9)
    np.testing.assert_allclose(homographies.apply(np.linalg.inv(H), image), points, atol=1e-9)
    both = homographies.apply(np.stack([H, G @ H]), points)
    np.testing.assert_allclose(both[0], image, rtol=1e-12)
    np.testing.assert_allclose(homographies.apply(G, image), both[1], rtol=1e-7, atol=1e-9)


HORIZON = np.array([[1.0, 0, 0], [0, 1, 0], [0.5, 0, -1]])


@pytest.mark.parametrize(
    ("H", "points", "message"),
    [
        (
            HORIZON,
            np.array([[2.0, 1], [0, 0]]),
            "points must not go to infinity, got 1 of 2 that do",
        ),
        (np.ones((3, 3)), np.ones((1, 2)), "homography must not be singular"),
        (np.eye(4), np.ones((1, 2)), r"homography must be \(…, 3, 3\), got \(4, 4\)"),
        (HORIZON, np.ones((1, 3)), r"points must be \(…, n, 2\), got \(1, 3\)"),
    ],
)
def test_bad_input_is_named(H, points, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        homographies.apply(H, points)
