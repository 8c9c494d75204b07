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


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e-3, 1e6])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (458_074.6, 5_429_380.2)])
def test_units_and_origins_of_a_map_make_no_homography_singular(unit, shift):
    """Millimetres in UTM: the points of the other picture are those of the local frame."""
    H = np.array([[0.9, 0.1, 3], [-0.1, 1.1, 5], [1e-4, 2e-4, 1]])
    local = np.array([[1.0, 2], [30, -7], [0, 0]])
    T_local_map = np.diag([1 / unit, 1 / unit, 1]) @ np.array(
        [[1, 0, -unit * shift[0]], [0, 1, -unit * shift[1]], [0, 0, 1]]
    )
    found = homographies.apply(H @ T_local_map, unit * (local + shift))
    np.testing.assert_allclose(found, homographies.apply(H, local), atol=1e-5)
    inverse = np.linalg.inv(H @ T_local_map)
    assert homographies.condition_number(inverse) < 1e9


SINGULAR = {
    "of one line": np.ones((3, 3)),
    "of one line in other units": np.diag([1e9, 1, 1e-9]) @ np.ones((3, 3)) @ np.diag([1, 1e6, 1]),
    "two rows alike": np.array([[1.0, 2, 3], [2, 4, 6], [0, 0, 1]]),
    "a row of nothing": np.diag([1.0, 0, 1]),
    "a column of nothing": np.array([[1.0, 2, 0], [3, 1, 0], [4, 1, 0]]),
    "nothing": np.zeros((3, 3)),
}


@pytest.mark.parametrize("H", SINGULAR.values(), ids=SINGULAR)
def test_a_singular_homography_is_singular_in_any_units(H):
    assert homographies.condition_number(H) > 1e15
    assert homographies.condition_number(np.stack([np.eye(3), H]))[0] == 1.0
    with pytest.raises(ValueError, match="homography must not be singular, its condition is"):
        homographies.apply(H, np.ones((1, 2)))


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
